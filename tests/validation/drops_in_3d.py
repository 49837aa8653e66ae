"""Free drops with three half axes, R/s = 10, against the exact solution: in a straining flow, and with a force."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.case.waves import ellipsoid_half_axes
from tests.scenes import free, sampled, scene, simulated
from tests.validation.record import Row, said

SPACING = 0.1      # over R
SETTLED = 0.02     # [s]: the pressure of the start is not that of a step
FLOWS = {          # stiffness of the central force [1/s], rates of strain at the start [1/s], end [s]
    "straining flow": (0.0, (0.5, 0.5, -1.0), 1.0),
    "central force": (1.0, (0.4, -0.1, -0.3), 4.0),
}


def rows(bench):
    """Return the largest errors of half axes, energy and central pressure, for two starts each."""
    found = []
    for name, (stiffness, rates, end) in FLOWS.items():
        for jitter in (0.0, 0.4):
            axes, energy, pressure = _errors(stiffness, rates, end, jitter)
            what = f"drop in 3D, {name}, jitter {jitter:g}, until {end:g} s"
            found += said([
                *(Row(f"{what}: error of half axis {axis}", worst, 0.015) for axis, worst in zip("abc", axes)),
                Row(f"{what}: change of the energy", energy, 0.015),
                Row(f"{what}: error of the pressure in the centre", pressure, 0.1)])
    return found


def _errors(stiffness, rates, end, jitter):
    """Return the largest relative errors of the half axes (3,), of the energy, and of the pressure in the centre."""
    s = simulated(scene("drop_3d", spacing=SPACING, stiffness=stiffness, jitter=jitter, seed=1, end_time=end))
    p, time, found = s.particles, [], []
    for values, _ in sampled(s):
        fluid = p.kind == FLUID
        x, u, volume = p.x[fluid], p.u[fluid], p.volume[fluid]
        energy = 0.5 * volume @ ((u**2).sum(axis=1) + stiffness**2 * (x**2).sum(axis=1))
        time.append(s.time)
        found.append((*np.sqrt(volume @ x**2), energy, values["centre"][-1]))
    free()
    time, found = np.array(time), np.array(found)
    exact, _, pressure = ellipsoid_half_axes(time, (1.0, 1.0, 1.0), rates, stiffness)
    later = time > SETTLED
    axes = np.abs(found[:, :3] / found[0, :3] / exact - 1.0).max(axis=0)
    wrong = np.abs(found[later, 4] / 1000.0 / pressure[later] - 1.0).max()
    return axes, np.abs(found[:, 3] / found[0, 3] - 1.0).max(), wrong
