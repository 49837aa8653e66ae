"""Energy budget of a step: the gain of the fluid by each part."""

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.kernels.energy import energy_sums
from parisph.parallel.particles import Particles


class Budget:
    """Measures the energy of the fluid between the parts of a step.

    The energy is that of the probe Energy: kinetic and potential in a uniform, constant body force, with the initial
    volume of each particle. Only differences count, so the potential needs no datum.

    Parameters
    ----------
    density : [kg/m^3]
    gravity : (dim,) [m/s^2], zero for a force without a potential
    causes : of energy changes; the first, pressure, includes prediction, pressure and movement, and the exchange of
        kinetic and potential energy between them
    """

    def __init__(self, density: float, gravity: Floats, causes: tuple[str, ...]) -> None:
        self._density, self._gravity, self.causes = density, gravity, causes
        self._gains, self._last = np.zeros(len(causes)), 0.0

    def begin(self, particles: Particles) -> None:
        """Begin a step. Not collective."""
        self._gains[:] = 0.0
        self._last = self._energy(particles)

    def mark(self, particles: Particles, cause: str) -> None:
        """Attribute the change of energy since the last mark to `cause`. Not collective.

        Particles may change ranks in between: only the sum over ranks has a meaning.
        """
        now = self._energy(particles)
        self._gains[self.causes.index(cause)] += now - self._last
        self._last = now

    def move(self, cause: str, other: str, gain: float) -> None:
        """Move an attributed gain [J, in 2D J/m] from one cause to another. Not collective."""
        self._gains[self.causes.index(cause)] -= gain
        self._gains[self.causes.index(other)] += gain

    def works(self, comm: MPI.Comm) -> dict[str, float]:
        """Return {"work_" + cause: energy gained in the step [J, in 2D J/m]}, the same on all ranks. Collective."""
        gains = self._gains.copy()
        if comm.size > 1:
            comm.Allreduce(MPI.IN_PLACE, gains, op=MPI.SUM)
        return {f"work_{cause}": float(gain) for cause, gain in zip(self.causes, gains)}

    def _energy(self, p: Particles) -> float:
        """Return the energy of owned fluid [J, in 2D J/m]; walls have no volume."""
        kinetic, potential, _ = energy_sums(p.volume, p.x, p.u, self._gravity, np.zeros(p.dim))
        found: float = self._density * (kinetic + potential)
        return found


class NoBudget:
    """A Budget that does nothing, for runs without one."""

    causes: tuple[str, ...] = ()

    def begin(self, particles: Particles) -> None:
        """Do nothing."""

    def mark(self, particles: Particles, cause: str) -> None:
        """Do nothing."""

    def move(self, cause: str, other: str, gain: float) -> None:
        """Do nothing."""

    def works(self, comm: MPI.Comm) -> None:
        """Return None."""
