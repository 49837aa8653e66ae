"""Free drops with three half axes, R/s = 10, against the exact solution: in a straining flow, and with a force."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.case.waves import ellipsoid_half_axes
from tests.scenes import free, sampled, scene, simulated
from tests.validation.record import Row, said

SPACING = 0.1      # over R
SETTLED = 0.02     # [s]: the pressure of the start is not that of a step
# Stiffness of the central force [1/s], rates of strain at the start [1/s], and times until which it is judged [s]. The
# straining flow has then flattened the ball to half of its height, and to a third, which is seven particles.
FLOWS = {
    "straining flow": (0.0, (0.5, 0.5, -1.0), (0.6, 1.0)),
    "central force": (1.0, (0.4, -0.1, -0.3), (4.0,)),
}
MEASURES = {"half axis a": 0.015, "half axis b": 0.015, "half axis c": 0.015, "energy": 0.015,
            "pressure in the centre": 0.1}    # and the relative error that is allowed


def rows(bench):
    """Return the largest errors of half axes, energy and central pressure, for two starts each."""
    found = []
    for name, (stiffness, rates, ends) in FLOWS.items():
        for jitter in (0.0, 0.4):
            time, errors = history(stiffness, rates, ends[-1], jitter)
            for end in ends:
                worst = errors[time <= end * (1.0 + 1e-9)].max(axis=0)
                run = f"drop in 3D, {name}, jitter {jitter:g}, until {end:g} s"
                found += said(Row(f"{run}: error of {what}", value, must)
                              for (what, must), value in zip(MEASURES.items(), worst))
    return found


def history(stiffness, rates, end, jitter):
    """Return times (n,) [s] and the relative errors (n, 5) of MEASURES of a drop, by the moments of its particles."""
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
    axes, _, pressure = ellipsoid_half_axes(time, (1.0, 1.0, 1.0), rates, stiffness)
    moments = found[:, :4] / found[0, :4] / np.column_stack([axes, np.ones(len(time))])
    central = np.where(time > SETTLED, found[:, 4] / (1000.0 * pressure), 1.0)
    return time, np.abs(np.column_stack([moments, central]) - 1.0)
