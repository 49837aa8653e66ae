"""Drops: in a straining flow without walls, on a floor, into a pool."""

from functools import partial

import numpy as np

from parisph.base.fields import INNER
from parisph.case.schema import Case, Disc, Fluid, Numerics, Polygon, Tank
from parisph.case.waves import drop_half_axes
from parisph.geometry.build import build
from tests.hard.flow import Bench, History
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.scenes import scene

STRETCH = 2.0     # of the half axis, up to which the free drop is judged
DEEP = 1.5        # spacings inside the exact ellipse, where particles must be inner ones
SETTLED = 0.02    # [s]: the pressure of the start is not that of a step
MIDDLE = 6        # particles whose mean pressure is that of the centre
RADIUS = 0.1      # [m] of the drops that fall


def free(bench: Bench, jitter: float, cfl: float) -> list[Line]:
    """The drop of cases/free_drop.py, R/s = 20, until its half axis has doubled, against the exact solution."""
    case = scene("free_drop", {"cfl": cfl}, spacing=0.05, jitter=jitter, seed=bench.seed, time_step="none")
    times = np.linspace(0.0, 1.0, 2001)
    axes = np.column_stack(drop_half_axes(times, 1.0, 1.0))
    end = float(np.interp(STRETCH, axes[:, 0], times))
    found, start, inner = [], None, build(case)["role"] == INNER
    for s in bench.flow(case, until=end):
        exact = np.array([np.interp(s.time, times, axis) for axis in axes.T])
        p = s.particles
        moments = p.volume @ p.x**2, 0.5 * p.volume @ (p.u**2).sum(axis=1)
        start = start or moments
        pressure = abs(_centre(p, exact) / exact_centre(*exact) - 1.0) if s.time > SETTLED else 0.0
        found.append([*np.abs(np.sqrt(moments[0] / start[0]) / exact - 1.0), abs(moments[1] / start[1] - 1.0), pressure,
                      *_astray(p, exact, DEEP * 0.05, inner[p.id])])
    worst = np.max(found, axis=0)
    return [Line("error of the long half axis", worst[0], 0.015, 0.01),
            Line("error of the short half axis", worst[1], 0.015, 0.01),
            Line("error of the kinetic energy", worst[2], 0.015, 0.01),
            Line("error of the centre pressure", worst[3], 0.1, 0.05),
            Line(f"inner particles of the start, {DEEP:g} s inside the ellipse, that lose their role", worst[4], 0),
            Line("particles of the start's surface that come as deep and are none of them", worst[5])]


def _centre(p, axes):
    """The centre's pressure by the particles nearest to it: pressure is a paraboloid that vanishes on the ellipse."""
    near = np.argsort((p.x**2).sum(axis=1))[:MIDDLE]
    return np.mean(p.p[near] / (1.0 - ((p.x[near] / axes) ** 2).sum(axis=1)))


def exact_centre(a: float, b: float) -> float:
    """Return the pressure [Pa] in the centre of the drop with half axes a and b [m], for R = 1 m and a rate of 1/s.

    It is rho s^2 a^2 b^2/(a^2 + b^2), where s^2 = 2/(a^2 + b^2) as the kinetic energy is constant.
    """
    return 1000.0 * 2.0 * (a * b) ** 2 / (a**2 + b**2) ** 2


def _astray(p, axes, depth, inner):
    """Return how many particles in the ellipse are no inner ones: of those that were at the start, and of others."""
    deep = ((p.x / (axes - depth)) ** 2).sum(axis=1) < 1.0
    astray = deep & (p.role != INNER)
    return np.count_nonzero(astray & inner), np.count_nonzero(astray & ~inner)


def falling(resolution: int, speed: float) -> Case:
    """Return a drop two spacings above the bed of a dry tank with a lid. resolution : R/s; speed : downwards [m/s]"""
    s = RADIUS / resolution
    disc = Disc(radius=RADIUS, at=(5 * RADIUS, RADIUS + 2 * s))
    return Case(title="drop on a floor", fluid=Fluid(disc, density=1000.0, velocity=(0.0, -speed)),
                walls=Tank(width=10 * RADIUS, height=5 * RADIUS, lid=True), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=s), end_time=2.0 * (RADIUS + 2 * s) / speed)


def on_floor(bench: Bench, resolution: int, speed: float) -> list[Line]:
    """Energy, of which an ideal drop loses none, when the drop would have sunk by half and by a whole radius."""
    found = History.of(bench, falling(resolution, speed))
    gap = 2.0 * RADIUS / resolution
    times = {part: (gap + part * RADIUS) / speed for part in (0.5, 1.0)}
    return [*(Line(f"energy over its start at t U = gap + {part:g} R", found.at("total", time) / found.total[0])
              for part, time in times.items()),
            Line("energy over its start at the end, t U = 2 (gap + R)", found.total[-1] / found.total[0]),
            Line("largest rise of the energy above its start", found.energy_rise())]


def into_pool(bench: Bench, s: float = 0.01) -> list[Line]:
    """A drop of ten spacings radius that falls into a pool at 3 m/s, until the crater closes."""
    width, depth = 1.2, 0.3
    x, y = 0.5 * width + 0.5 * s, depth + RADIUS + 4 * s    # the bridge between the bodies lies between lattice lines
    angle = -0.5 * np.pi + 2.0 * np.pi * np.arange(1, 64) / 64
    round_ = [(x + RADIUS * np.cos(a), y + RADIUS * np.sin(a)) for a in angle]
    foot = (x, y - RADIUS)
    bridge = (x, depth)
    shape = Polygon(((0.0, 0.0), (width, 0.0), (width, depth), bridge, foot, *round_, foot, bridge, (0.0, depth)))
    fluid = Fluid(shape, density=1000.0, velocity=(0.0, f"where(y > {depth + 2 * s}, -3, 0)"))
    case = Case(title="drop into a pool", fluid=fluid, walls=Tank(width=width, height=1.0, lid=True),
                gravity=(0.0, -9.81), numerics=Numerics(spacing=s), end_time=0.5)
    found = History.of(bench, case)
    return [*found.volume_lines(), Line("largest rise of the energy above its start", found.energy_rise()),
            Line("energy over its start at 0.5 s", found.total[-1] / found.total[0])]


FALLS = ((20, 0.5), (10, 2.0), (20, 2.0), (40, 2.0), (20, 8.0))    # R/s, speed [m/s]
SCENES = {
    **{f"drop-{'jitter' if jitter else 'lattice'}-cfl-{cfl:g}": Scene(
        f"free drop, R/s = 20, {f'jitter {jitter:g}' if jitter else 'lattice'}, cfl {cfl:g}, until it is twice as long",
        partial(free, jitter=jitter, cfl=cfl), jittered=jitter > 0.0)
       for jitter in (0.0, 0.4) for cfl in (0.4, 0.1, 0.025)},
    **{f"floor-{resolution}-speed-{speed:g}": Scene(
        f"round drop on a floor, R/s = {resolution}, {speed:g} m/s",
        partial(on_floor, resolution=resolution, speed=speed)) for resolution, speed in FALLS},
    "pool": Scene("round drop into a pool, 3 m/s, 0.5 s", into_pool),
}
