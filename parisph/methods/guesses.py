"""Initial guesses for the pressure solve, from the pressures of the last steps."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.kernels import extrapolation
from parisph.parallel.particles import Particles


class Guesses:
    """The pressure of the last step, and extrapolations in time along the paths of particles.

    The solve keeps the last pressure if its residual is within the tolerance, as at rest. Otherwise it starts from the
    guess with the least residual; an extrapolation within the tolerance is still refined (pressure.system.CLOSER). In
    waves the quadratic guess saves a third of the iterations from the last pressure, the cubic one a sixth of the rest.
    In violent flow pressures come and go: the best guess, linear or quadratic, changes by step and saves a fifth.

    waves : whether the last extrapolations are quadratic and cubic

    Attributes
    ----------
    fields : needed by particles, with further ones for waves
    times : [s] of the stored pressures, the last first; at most three, or four
    """

    fields, of_waves = ("p_before", "p_earlier"), ("p_earliest",)

    def __init__(self, waves: bool = False) -> None:
        self.most = 4 if waves else 3
        self.times: list[float] = []

    def at(self, particles: Particles, time: float) -> Floats:
        """Return the guesses of the pressure at a time [s]: (1 to 3, n_owned) [Pa]. Not collective."""
        p = particles
        orders = [order for order in range(2, len(self.times) + 1) if len(set(self.times[:order])) == order][-2:]
        weights = np.zeros((1 + len(orders), 4))
        weights[0, 0] = 1.0
        for own, order in zip(weights[1:], orders):
            own[:order] = _weights(self.times[:order], time)
        found = np.empty((len(weights), p.n_owned))
        extrapolation.combine(found, weights, p.p, p.p_before, p.p_earlier, self._earliest(p))
        return found

    def remember(self, particles: Particles, time: float) -> None:
        """Store the pressure of the particles before they get that of `time` [s]. Not collective."""
        p = particles
        self._earliest(p)[:] = p.p_earlier
        p.p_earlier[:] = p.p_before
        p.p_before[:] = p.p
        self.times = [time, *self.times[:self.most - 1]]

    def _earliest(self, particles: Particles) -> Floats:
        return particles.p_earliest if self.most == 4 else particles.p_earlier

    def restart(self, time: float) -> None:
        """Forget all pressures except the current one, of `time` [s]."""
        self.times = [time]


def _weights(times: list[float], time: float) -> list[float]:
    """Return Lagrange's weights of values at some times for the value at another.

    They are rounded: with equal steps they are integers despite rounding errors of the times.
    """
    found = []
    for own in times:
        weight = 1.0
        for other in times:
            if other != own:
                weight *= (time - other) / (own - other)
        found.append(round(weight, 9))
    return found
