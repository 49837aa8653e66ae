"""Dam breaks against obstacles: a box, and a trapezoidal sill."""

from functools import partial

import numpy as np

from parisph.case.schema import Case
from parisph.geometry.build import scene_mesh
from parisph.geometry.distance import signed_distance
from tests.hard.flow import Bench, Measured, fluid
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.scenes import scene

RISE = 1e-3     # of the energy over its start, at most
NEAR = 1.0      # spacings from a solid, within which distances are measured
# The column against the box has hit it at 0.2 s and the far wall at 0.35 s, and falls back over both until 0.9 s.
# The water comes to the sill at 1.7 s, passes over it, strikes the end of the flume, and meets its own bore at 4 s.
END = {"box": 1.0, "sill": 4.5}      # [s]
AREA = {"box": 0.146 * 0.292, "sill": 4.65 * 0.25}      # of the water at the start [m^2]


def dam(obstacle: str, particles: int, jitter: float, seed: int = 0, end: float | None = None) -> Case:
    """Return the dam break of cases/ against an obstacle, with about so many particles."""
    return scene(f"dam_break_{obstacle}", spacing=float(np.sqrt(AREA[obstacle] / particles)), jitter=jitter, seed=seed,
                 end_time=END[obstacle] if end is None else end)


def against(bench: Bench, obstacle: str, particles: int, jitter: float, end: float | None = None) -> list[Line]:
    """The distance of fluid from solids, its energy and its number, in every step."""
    case, watch = dam(obstacle, particles, jitter, bench.seed, end), Measured()
    corners, spacing = scene_mesh(case).corners(), case.numerics.spacing
    apart, energy, count, away = [], [], [], 0
    for s in bench.flow(case):
        apart.append(signed_distance(s.particles.x[fluid(s)], corners, NEAR * spacing).min())
        energy.append(watch(s)[2] + s.left.energy)
        count.append(fluid(s).sum())
        away = s.left.particles
    energy = np.array(energy) / energy[0]
    return [Line("least distance of fluid from a solid / s", min(apart) / spacing, 0.0, least=True),
            Line("largest rise of the energy above its start", energy.max() - 1.0, RISE),
            Line("largest rise of the energy above what it was before, over its start",
                 (energy - np.minimum.accumulate(energy)).max(), RISE),
            Line("fluid particles lost", float(count[0] - count[-1]), 0.0),
            Line("of these over the rim", float(away)),
            Line("energy at the end over its start", energy[-1])]


def _scene(obstacle, particles, jitter, end=None):
    return Scene(f"dam break against a {obstacle}, {particles} particles, jitter {jitter:g}, "
                 f"to {END[obstacle] if end is None else end:g} s",
                 partial(against, obstacle=obstacle, particles=particles, jitter=jitter, end=end), jittered=True)


SCENES = {f"{obstacle}-{particles}-jitter-{jitter:g}": _scene(obstacle, particles, jitter)
          for obstacle in END for particles in (800, 3200) for jitter in (0.2, 0.4, 0.8)}
QUICK = {"box-800-jitter-0.4": _scene("box", 800, 0.4, 0.25)}
