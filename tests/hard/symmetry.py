"""Pairs of flows that are one by a symmetry: scale, density, mirror, moving frame, free fall; and the three methods."""

from functools import partial

import numpy as np

from parisph.base.fields import FLUID
from parisph.case.methods import METHODS
from parisph.case.schema import Box, Case, Fluid, Numerics, Tank
from tests.hard.dam import broken
from tests.hard.flow import Bench, History
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.scenes import scene

G = 9.81
TIGHT = 1e-13             # of the pressure solve: nothing but rounding may differ
SAME = 1e-9               # after FEW steps, as between ranks
FEW, MANY = 20, 200       # steps; after MANY the difference is only reported: rounding has grown by then


def dam(height: float = 1.0, density: float = 1000.0, right: bool = False, resolution: int = 20) -> Case:
    """Return a dam break of any size [m] and density [kg/m3], at the left or the right wall; resolution : H/s."""
    s, width = height / resolution, 2.0 * height
    unit = np.sqrt(height / G)
    box = Box(width=0.5 * height, height=height, at=(width - 0.5 * height if right else 0.0, 0.0))
    return Case(title="dam break", fluid=Fluid(box, density=density),
                walls=Tank(width=width, height=2.0 * height, lid=True), gravity=(0.0, -G),
                numerics=Numerics(spacing=s, time_step=0.008 * unit, rtol=TIGHT), end_time=10.0 * unit)


def states(bench: Bench, case: Case, steps: tuple[int, ...]) -> list[np.ndarray]:
    """Return positions of the fluid (n, 2) [m] after these numbers of steps, in the order of the lattice."""
    found = []
    for s in bench.flow(case, most=max(steps)):
        if s.steps in steps:
            p = s.particles
            found.append(p.x[np.argsort(p.id)][np.sort(p.id[p.kind == FLUID])].copy())
    return found


def compared(one: list[np.ndarray], other: list[np.ndarray], steps: tuple[int, ...], way: list[float]) -> list[Line]:
    """Return a line for each number of steps. way : how far the fluid has moved [m]; differences are over it"""
    return [Line(f"difference after {n} steps / way", float(np.abs(a - b).max() / moved), SAME if n == FEW else None)
            for n, a, b, moved in zip(steps, one, other, way)]


def scaled(bench: Bench, height: float = 1.0, density: float = 1000.0, steps=(FEW, MANY)) -> list[Line]:
    """Another size or density: the same flow in units of the height."""
    one, other = states(bench, dam(), (0, *steps)), states(bench, dam(height, density), (0, *steps))
    return compared([x / height for x in other[1:]], one[1:], steps, _ways(one))


def mirrored(bench: Bench, steps=(FEW, MANY), resolution: int = 20) -> list[Line]:
    """The column at the other wall: the mirror image. Its particles have other numbers."""
    one, other = (states(bench, dam(right=right, resolution=resolution), (0, *steps)) for right in (False, True))
    # the lattice runs along x first: its mirror image in another order
    pairs = _matching(one[0], _mirror(other[0]))
    return compared([_mirror(x)[pairs] for x in other[1:]], one[1:], steps, _ways(one))


def _mirror(x):
    return np.column_stack([2.0 - x[:, 0], x[:, 1]])


def _matching(x, y):
    """Return the order of the points y in which they are the points x."""
    order = np.empty(len(x), int)
    order[_along(x)] = _along(y)
    assert np.allclose(x, y[order], atol=1e-9)
    return order


def _along(x):
    return np.lexsort(np.round(x / x.max() * 1e6).T)


def _ways(states_):
    return [np.abs(x - states_[0]).max() for x in states_[1:]]


def drop(**changes) -> Case:
    """Return the free drop of cases/ with fixed steps, and with parts of the Case changed."""
    case = scene("free_drop", {"rtol": TIGHT}, spacing=0.1, jitter=0.4, time_step=0.01, end_time=10.0)
    return case.changed(**changes)


def moving(bench: Bench, steps=(FEW, MANY), velocity=(3.0, -2.0)) -> list[Line]:
    """The free drop as seen from a frame in uniform motion (Galilei)."""
    boosted = tuple(f"{u} + ({v})" for u, v in zip(drop().fluid.velocity, velocity))
    start = (0, *steps)
    one, other = states(bench, drop(), start), states(bench, drop(**{"fluid.velocity": boosted}), start)
    back = [x - 0.01 * n * np.array(velocity) for n, x in zip(steps, other[1:])]
    return compared(back, one[1:], steps, _ways(one))


def fall(bench: Bench, steps=(FEW, MANY)) -> list[Line]:
    """The free drop that falls, less the fall: as without gravity."""
    one, other = states(bench, drop(), (0, *steps)), states(bench, drop(gravity=(0.0, -G)), (0, *steps))
    back = [x + np.array([0.0, 0.5 * G * (0.01 * n) ** 2]) for n, x in zip(steps, other[1:])]
    return compared(back, one[1:], steps, _ways(one))


def method(bench: Bench, name: str) -> list[Line]:
    """The dam break to t* = 3 with one of the methods."""
    found = History.of(bench, broken(0.025, 3.0, seed=bench.seed, method=name))
    return [*found.volume_lines(), Line("largest rise of the energy above its start", found.energy_rise()),
            Line("energy at t* = 2 over its start", found.at("total", 2.0 / np.sqrt(G)) / found.total[0])]


SCENES = {
    "scale-mm": Scene("dam break, H = 1 mm, and 1 m", partial(scaled, height=1e-3)),
    "scale-km": Scene("dam break, H = 1 km, and 1 m", partial(scaled, height=1e3)),
    "density-1": Scene("dam break, 1 kg/m3, and 1000", partial(scaled, density=1.0)),
    "density-13600": Scene("dam break, 13600 kg/m3, and 1000", partial(scaled, density=13600.0)),
    "mirror": Scene("dam break at the right wall, and at the left", mirrored),
    "galilei": Scene("free drop in a moving frame, and in one at rest", moving),
    "fall": Scene("free drop that falls, and without gravity", fall),
    **{f"method-{name}": Scene(f"dam break, H/s = 40, {name}, to t* = 3", partial(method, name=name),
                               may_stop=True, jittered=True) for name in METHODS},
}
QUICK = {
    "scale-mm": Scene("dam break, H = 1 mm, and 1 m, 20 steps", partial(scaled, height=1e-3, steps=(FEW,))),
    "density-13600": Scene("dam break, 13600 kg/m3, and 1000, 20 steps",
                           partial(scaled, density=13600.0, steps=(FEW,))),
    "mirror": Scene("dam break at the right wall, and at the left, 20 steps", partial(mirrored, steps=(FEW,))),
    "galilei": Scene("free drop in a moving frame, 20 steps", partial(moving, steps=(FEW,))),
    "fall": Scene("free drop that falls, and without gravity, 20 steps", partial(fall, steps=(FEW,))),
}
