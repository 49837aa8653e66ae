"""Columns one to twelve particles wide, and a layer three particles deep."""

from functools import partial

import numpy as np

from parisph import Box, Case, Fluid, Numerics, Polygon, SurfaceGauge, Tank
from parisph.watch import instruments
from tests.hard import flow
from tests.hard.flow import Bench, Measured, nearest
from tests.hard.scene import Scene
from tests.hard.table import Line

S, HEIGHT, GRAVITY = 0.05, 1.0, (0.0, -9.81)
WHERE = {"wall": "standing at a wall", "middle": "standing in the middle", "falling": "falling in the middle"}
RISE = 1e-3     # of the energy, at most
# The half cell that a column of two leaves at the wall is a third of its first layer, and moves out all at once.
RISE_OF_TWO = 3e-3
APART = 0.3     # spacings, at least
DEPTH, LENGTH = 3 * S, 40 * S    # of the layer


def column(width: int, where: str, end: float = 2.0, seed: int = 1) -> Case:
    """Return a column `width` particles wide and 1 m high in a tank with a lid, at a place of WHERE.

    seed : 1 for a start on the lattice, where particles fall on each other; others are jittered by 0.2
    """
    return Case(title=f"column of {width}", fluid=Fluid(_shape(width, where), density=1000.0), gravity=GRAVITY,
                walls=Tank(width=1.0, height=2.0, lid=True), end_time=end,
                numerics=Numerics(spacing=S, jitter=0.0 if seed == 1 else 0.2, jitter_surface=True, seed=seed))


def _shape(width, where):
    if where == "wall":
        return Box(width=width * S, height=HEIGHT)
    # a box of `width` lattice lines has one spacing less; this polygon has half a spacing more on either side
    left, low = 0.5 - (width // 2 + 0.5) * S, 0.5 if where == "falling" else 0.0
    right = left + width * S
    return Polygon(((left, low), (right, low), (right, low + HEIGHT), (left, low + HEIGHT)))


def collapse(bench: Bench, width: int, where: str, most: int | None = None) -> list[Line]:
    """The fall of a column: its energy and the distances of its particles."""
    energy, apart, continuous, watch, rows = [], [], [], Measured(), None
    for s in bench.flow(column(width, where, seed=bench.seed), most=most):
        energy.append(watch(s)[2])
        apart.append(nearest(s))
        if where == "wall" and width > 1:
            rows = rows_of(s, width) if rows is None else rows
            continuous.append(energy_between(s, rows))
    rise, measure = max(energy) / energy[0] - 1.0, "largest rise of the energy above its start"
    if continuous:    # the first measure would also rise in the exact flow
        found = [Line(f"{measure}, one velocity for each volume", rise),
                 Line(f"{measure}, velocity linear between neighbours", max(continuous) / continuous[0] - 1.0,
                      RISE_OF_TWO if width == 2 else RISE, RISE)]
    else:
        found = [Line(measure, rise, RISE)]
    return [*found,
            Line("least distance of two particles / s", min(apart), APART, least=True),
            Line("share of the steps with a distance below that", float(np.mean(np.array(apart) < APART))),
            Line("energy at the end over its start", energy[-1] / energy[0])]


def rows_of(s, width: int) -> np.ndarray:
    """Return the ids of a column at a wall at its start, row by row from the wall outwards: (rows, width)."""
    p, mine = s.particles, flow.fluid(s)
    cell = np.round(p.x[mine] / S).astype(int)
    return p.id[mine][np.lexsort((cell[:, 0], cell[:, 1]))].reshape(-1, width)


def energy_between(s, rows: np.ndarray) -> float:
    """Return the energy over the density of a column at a wall, with a velocity that is linear between neighbours in a
    row.

    One velocity for each particle's volume overrates a velocity that grows from zero at the wall: the first
    particle stands for 3/2 cells, and the last one, on the surface, for the half cell on its slow side. Of a column
    of two, that is 31 % of the kinetic energy of spreading, and 11 % and 5 % for three and four: where exact flow
    keeps its energy, that measure rises. Fluid keeps its place between its neighbours of the start as long as it does
    not mix, until long after the highest energy.
    """
    p = s.particles
    at = np.argsort(p.id)[np.searchsorted(np.sort(p.id), rows)]
    u, volume = p.u[at], p.volume[at]
    height = volume[:, -1] / (0.5 * S)
    nodes = np.concatenate([u[:, :1] * (0.0, 1.0), u], axis=1)    # the wall has no velocity into it
    a, b = nodes[:, :-1], nodes[:, 1:]
    kinetic = height @ (a * a + a * b + b * b).sum(axis=(1, 2)) * S / 6.0
    return float(kinetic - GRAVITY[1] * (volume * p.x[at][..., 1]).sum())


def layer(bench: Bench) -> list[Line]:
    """Water three particles deep that sloshes gently; its volume is the mean height of the surface.

    No particle is deep enough inside for the mean Voronoi cell of the probe Volume.
    """
    fluid = Fluid(Box(width=LENGTH, height=DEPTH), density=1000.0, velocity=(f"0.3*sin(pi*x/{LENGTH})", 0.0))
    case = Case(title="layer of 3", fluid=fluid, walls=Tank(width=LENGTH, height=1.0), gravity=GRAVITY,
                numerics=Numerics(spacing=S), end_time=10.0)
    gauges = tuple(SurfaceGauge(name=f"gauge{k}", at=(k + 0.5) * S) for k in range(round(LENGTH / S)))
    levels, samplers = [], None
    for s in bench.flow(case):
        samplers = samplers or instruments.build(case.model_copy(update={"probes": gauges}), s.comm)
        seen = instruments.sample_all(samplers, s.particles, s.domain, s.time)
        levels.append((np.mean([height for height, in seen.values()]), s.particles.x[flow.fluid(s), 1].mean()))
    levels = np.array(levels) / levels[0]
    error, late = np.abs(levels[:, 0] - 1.0), slice(-len(levels) // 10, None)
    return [Line("largest error of the mean surface height", float(error.max()), 0.05),
            Line("error of the mean surface height, mean of the last tenth", abs(levels[late, 0].mean() - 1.0), 0.05),
            Line("mean height of the particles over its start, mean of the last tenth", levels[late, 1].mean())]


SCENES = {
    **{f"columns-{width}-{where}": Scene(f"column {width} wide, {words}", partial(collapse, width=width, where=where),
                                         jittered=True) for width in (1, 2, 3, 4) for where, words in WHERE.items()},
    **{f"columns-{width}-middle": Scene(f"column {width} wide, {WHERE['middle']}",
                                        partial(collapse, width=width, where="middle"), jittered=True)
       for width in (6, 8, 12)},
    "layer": Scene("layer of three particles, gently sloshing, 10 s", layer),
}
QUICK = {f"columns-{width}-{where}": Scene(f"column {width} wide, {WHERE[where]}, 100 steps",
                                           partial(collapse, width=width, where=where, most=100))
         for width, where in ((1, "wall"), (2, "wall"), (1, "falling"), (2, "falling"), (2, "middle"))}
