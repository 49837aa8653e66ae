"""Dam breaks against a box and a trapezoidal sill, and over a sill in a long flume."""

from functools import partial

import numpy as np

from parisph.case.schema import Case, Obstacle, Polygon, Tank
from parisph.geometry.build import scene_mesh
from tests.distances import signed_distance
from tests.hard.flow import Bench, Measured, fluid
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.scenes import scene

RISE = 1e-3     # of the energy over its start, at most
# A column of L x 2 L falls against a box or a sill twice as far away as it is wide. It hits it at 0.2 s and the far
# wall at 0.35 s, and has fallen back over both at 0.9 s. The water of the flume comes to its sill at 1.7 s, passes over
# it, and strikes the end at 3 s.
L, SIDE, END = 0.146, 0.024, {"box": 1.0, "sill": 1.0, "flume": 3.5}      # [m], [s]
SILL = Polygon([(2 * L, 0.0), (2 * L + 2 * SIDE, 2 * SIDE), (2 * L + 4 * SIDE, 2 * SIDE), (2 * L + 6 * SIDE, 0.0)])


def dam(where: str, particles: int, jitter: float, seed: int = 0, end: float | None = None) -> Case:
    """Return a dam break with about so many particles: of cases/dam_break_box.py, the same with a sill of 45 degrees,
    or of cases/dam_break_sill.py."""
    sets = {"jitter": jitter, "seed": seed, "end_time": END[where] if end is None else end}
    if where == "flume":
        return scene("dam_break_sill", spacing=float(np.sqrt(4.65 * 0.25 / particles)), **sets)
    case = scene("dam_break_box", spacing=float(L * np.sqrt(2.0 / particles)), **sets)
    tank = next(wall for wall in case.walls if isinstance(wall, Tank))
    return case if where == "box" else case.changed(walls=(tank, Obstacle(SILL, name="sill")), probes=())


def against(bench: Bench, where: str, particles: int, jitter: float, end: float | None = None) -> list[Line]:
    """The distance of fluid from solids, its energy and its number, in every step.

    The water of the flume is 7 or 13 particles deep, and lifted by more than pressure pays for: that its energy does
    not rise is an aim.
    """
    case, watch = dam(where, particles, jitter, bench.seed, end), Measured()
    corners, spacing = scene_mesh(case).corners(), case.numerics.spacing
    apart, energy, count, away = [], [], [], 0
    for s in bench.flow(case):
        apart.append(signed_distance(s.particles.x[fluid(s)], corners).min())
        energy.append(watch(s)[2] + s.left.energy)
        count.append(fluid(s).sum())
        away = s.left.particles
    energy = np.array(energy) / energy[0]
    return [Line("least distance of fluid from a solid / s", min(apart) / spacing, 0.0, least=True),
            Line("fluid particles lost", float(count[0] - count[-1]), 0.0),
            Line("of these over the rim", float(away)),
            Line("largest rise of the energy above its start", energy.max() - 1.0, None if where == "flume" else RISE,
                 RISE),
            Line("largest rise of the energy above what it was before, over its start",
                 (energy - np.minimum.accumulate(energy)).max(), None, RISE),
            Line("energy at the end over its start", energy[-1])]


def _scene(where, particles, jitter, end=None):
    what = f"dam break {'over a sill in a flume' if where == 'flume' else f'against a {where}'}"
    return Scene(f"{what}, {particles} particles, jitter {jitter:g}, to {END[where] if end is None else end:g} s",
                 partial(against, where=where, particles=particles, jitter=jitter, end=end), limit=1200.0,
                 jittered=True)


SCENES = {f"{where}-{particles}-jitter-{jitter:g}": _scene(where, particles, jitter)
          for where in ("box", "sill") for particles in (800, 3200) for jitter in (0.2, 0.4, 0.8)}
SCENES |= {f"flume-{particles}-jitter-0.4": _scene("flume", particles, 0.4) for particles in (800, 3200)}
QUICK = {f"{where}-800-jitter-0.4": _scene(where, 800, 0.4, 0.2) for where in ("box", "sill")}
