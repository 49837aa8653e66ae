"""The steppings: where operators are evaluated in a step, and how particles move."""

from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Floats
from parisph.kernels import movement
from parisph.parallel.particles import Particles

SHARE = 1.0 / 12.0    # of dt^2 a, by which a kick must be evaluated ahead for a frequency of fourth order
FADES = 0.75          # tuned 0.375 to 0.95: step over sqrt(s/g) beyond which the share falls, as power -4; judged
# The acceleration of a shorter step is not remembered, and its pressure on walls has no mean of its own.
SHORT = 0.5           # tuned 0.25 to 1: part of the usual step, below which a step is a short one; judged


@dataclass(frozen=True)
class Stepping:
    """Where operators are evaluated, and how particles move.

    ahead : part of the step by which particles are moved before
    new : whether they move by the new velocity, else by the mean of both (Z14 Eq 16)
    corrected : whether operators are evaluated where `Accelerations` says
    """

    ahead: float
    new: bool = False
    corrected: bool = False

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields that particles need."""
        return Accelerations.fields if self.corrected else ()


# midpoint: r^n + dt/2 u^n is neutral for waves
STEPPINGS = {"midpoint": Stepping(0.5), "corrected": Stepping(0.5, corrected=True), "start": Stepping(0.0),
             "predicted": Stepping(1.0), "symplectic": Stepping(0.0, new=True)}


class Accelerations:
    """Accelerations of the last steps, and how far they correct the place of operators.

    The midpoint stepping is a leapfrog, drift, kick and drift: it makes the frequency w of a wave too high, by
    (w dt)^2/24 of itself. A kick that is evaluated dt^2/12 a further along, with the acceleration a of its own step,
    leaves an error of fourth order (Takahashi & Imada 1984, Rowlands 1991). Here a is extrapolated from the last two
    steps, which damps waves, in 1/w by a part (w dt)^5/24.

    The extrapolation drives waves with w dt > 1.41. The shortest deep-water wave on a lattice has w = 1.77 sqrt(g/s),
    so the correction fades beyond a step of .75 sqrt(s/g): that wave is damped until .95 sqrt(s/g). Those of the rows
    are slower. In a step shortened to meet a time, the divergence that earlier steps have left is removed as in any
    other, by an acceleration that says nothing of the next step: it is forgotten.

    Attributes
    ----------
    fields : that particles need
    times : [s] of the accelerations that particles have, the last first; at most two
    """

    fields = ("acceleration", "acceleration_before")

    def __init__(self) -> None:
        self.times: list[float] = []

    def ahead(self, particles: Particles, time: float, dt: float, wave_time: float) -> Floats:
        """Return by how much operators of a step of dt [s], its middle at `time` [s], are evaluated ahead: (n_owned,
        dim) [m], of any size for walls. Not collective.

        wave_time : sqrt(s/g) [s]
        """
        p = particles
        if not self.times:
            return np.zeros_like(p.u)
        weight = share(dt, wave_time) * dt**2
        if len(self.times) == 1:
            return weight * p.acceleration
        last, before = self.times
        beyond = min(1.0, (time - last) / (last - before)) if last > before else 0.0
        return weight * (1.0 + beyond) * p.acceleration - weight * beyond * p.acceleration_before

    def remember(self, particles: Particles, acceleration: Floats, time: float, dt: float, usual: float) -> None:
        """Keep the acceleration (n_owned, dim) [m/s^2] of fluid at a time [s], in the middle of a step of dt [s].

        usual : length of a step that is not shortened to meet a time [s]. Not collective.
        """
        p = particles
        if dt < SHORT * usual:
            return
        p.acceleration_before[:] = p.acceleration
        movement.give_to_fluid(p.acceleration, acceleration, p.kind)
        self.times = [time, *self.times[:1]]


def share(dt: float, wave_time: float) -> float:
    """Return the part of dt^2 a by which operators are evaluated ahead in a step of dt [s].

    wave_time : sqrt(s/g) [s]
    """
    return SHARE * min(1.0, FADES * wave_time / dt) ** 4
