"""A tank that moves, computed twice: seen from the tank, and in the room with walls that move."""

import numpy as np
from mpi4py import MPI

from parisph import PressureTap, Roll, Sway, Tank
from parisph.base.fields import FLUID, SURFACE
from parisph.case.waves import angular_frequency
from parisph.driver import Simulation
from parisph.watch import instruments
from parisph.watch.gauges import COLUMN
from parisph.watch.probes.surface_gauge import surface_height
from tests.scenes import water

G = 9.81
SERIES = ("left gauge", "right gauge", "left pressure", "right pressure", "left level", "right level")
STRIP = 4.0    # spacings: width of the water whose mean depth is the level at an end

LENGTH, HEIGHT, DEPTH = 1.0, 0.8, 0.4    # of a tank that moves gently [m]
SLOW = 0.8 * angular_frequency(np.pi / LENGTH, DEPTH, G)
THREE_PERIODS = 3.0 * 2.0 * np.pi / SLOW
GENTLE = {"sway": Sway(amplitude=0.005, frequency=SLOW), "roll": Roll(angle=0.01, frequency=SLOW, centre=(0.5, 0.0))}

# that of cases/violent_sloshing.py; its water first hits the left wall at 1.35 s, in the roll at 1.75 s
PERIOD = 1.5
VIOLENT = {"sway": Sway(amplitude=0.05, frequency=2.0 * np.pi / PERIOD),
           "roll": Roll(angle=0.12, frequency=2.0 * np.pi / PERIOD, centre=(0.3, 0.0))}
IMPACT = {"sway": 1.3, "roll": 1.7}    # [s], before it


def gentle(kind, moving, spacing, step=0.1):
    """Return the Case of a gentle motion over three periods, of the tank as the frame or of its walls.

    step : time step over sqrt(s/g)
    """
    return tank_case(GENTLE[kind], moving, (LENGTH, HEIGHT, DEPTH), THREE_PERIODS, spacing=spacing, preset="gentle",
                     time_step=step * np.sqrt(spacing / G))


def violent(kind, moving, spacing):
    """Return the Case of a violent motion until just before the first impact."""
    return tank_case(VIOLENT[kind], moving, (0.6, 0.3, 0.12), IMPACT[kind], spacing=spacing, preset="violent",
                     time_step=0.18 * spacing)


def tank_case(motion, moving, size, end_time, **numerics):
    """Return the Case of an oblong tank. size : its length and height, and the depth of its water [m]"""
    length, height, depth = size
    tank = Tank(length, height, lid=True)
    return water((length, depth), tank.model_copy(update={"motion": motion}) if moving else tank, numerics,
                 gravity=(0.0, -G), end_time=end_time, **({} if moving else {"frame": motion}),
                 probes=[PressureTap("left", at=(0.0, 0.5 * depth)), PressureTap("right", at=(length, 0.5 * depth))])


def histories(case):
    """Run a case and return times (n,) [s] and SERIES (6, n), as seen from the tank.

    At both ends: the surface at the wall [m], which is that of one particle; the pressure [Pa]; and the mean level over
    a strip [m].
    """
    sim, tank, rows = Simulation(case, MPI.COMM_SELF), case.walls, []
    taps = instruments.build(case, sim.comm)
    while not sim.finished():
        sim.advance()
        found, move = sim.gather("x", "role", "kind", "volume"), tank.motion
        x = move.seen(found["x"] - move.placed(np.zeros((1, 2)), sim.time), sim.time)
        fluid = found["kind"] == FLUID
        water, surface = x[fluid], x[fluid & (found["role"] == SURFACE)]
        pressures = instruments.sample_all(taps, sim.particles, sim.domain, sim.time)
        ends, spacing = (0.0, tank.width), case.numerics.spacing
        rows.append([sim.time, *(_at_wall(water, surface, end, spacing) for end in ends),
                     *(pressures[name][0] for name in ("left", "right")),
                     *(_level(water, found["volume"][fluid], end, spacing) for end in ends)])
    sim.destroy()
    return np.array(rows)[:, 0], np.array(rows)[:, 1:].T


def _level(water, volume, at, spacing):
    """Return the mean depth [m] over STRIP at an end of fluid (n, 2) with volumes (n,) [m^2]; that of a particle is
    spread over a spacing."""
    width = STRIP * spacing
    inside = np.clip((width - np.abs(water[:, 0] - at)) / spacing + 0.5, 0.0, 1.0)
    return volume @ inside / width


def _at_wall(water, surface, at, spacing):
    """Return the surface [m] at an end of the tank of fluid and surface particles, (n, 2) each; 0 where it is dry."""
    top = water[np.abs(water[:, 0] - at) <= COLUMN * spacing, 1].max(initial=0.0)
    return surface_height(at, *surface.T, top, spacing, [at])


def differences(walls, frame):
    """Return {name: relative L2 difference} of two histories with the same times, over the change since the start."""
    assert np.array_equal(walls[0], frame[0])
    return {name: np.linalg.norm(mine - due) / np.linalg.norm(due - due[0])
            for name, mine, due in zip(SERIES, walls[1], frame[1])}
