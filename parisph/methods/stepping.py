"""Steppings: where operators are evaluated in a step, and how particles move."""

from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Floats
from parisph.kernels import movement
from parisph.parallel.particles import Particles

SHARE = 1.0 / 12.0    # part of dt^2 a by which a kick is evaluated ahead for a frequency of fourth order
FADES = 0.75          # tuned 0.375 to 0.95: step over sqrt(s/g) beyond which the share falls, as power -4; judged
# A shorter step has no stored acceleration and no own mean of pressures on walls. Steps that share the time to the end
# (driver.schedule) are longer than half the usual one, so only the very last can be shorter.
SHORT = 0.5           # part of the usual step


@dataclass(frozen=True)
class Stepping:
    """Where operators are evaluated, and how particles move.

    ahead : part of the step by which particles move before the operators
    new : whether they move by the new velocity, else by the mean of both (Z14 Eq 16)
    corrected : whether `Accelerations` corrects the positions of operators
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
    """Accelerations of the last steps, which correct the positions of operators.

    The midpoint stepping is a leapfrog (drift, kick, drift): it raises the frequency w of a wave by a part (w dt)^2/24.
    A kick evaluated dt^2/12 a further along, with the acceleration a of its own step, leaves an error of fourth order
    (Takahashi & Imada 1984, Rowlands 1991). Here a is extrapolated from the last two steps, which damps waves by a part
    (w dt)^5/24 in a time 1/w.

    The extrapolation amplifies waves with w dt > 1.41. The shortest deep-water wave on a lattice has w = 1.77
    sqrt(g/s), so the correction fades beyond a step of .75 sqrt(s/g): this wave is damped up to .95 sqrt(s/g). Waves of
    the rows are slower. The acceleration of a step shortened to meet a time is not stored: it removes the whole
    residual divergence and does not resemble that of the next step.

    Attributes
    ----------
    fields : needed by particles
    times : [s] of the stored accelerations, the last first; at most two
    """

    fields = ("acceleration", "acceleration_before")

    def __init__(self) -> None:
        self.times: list[float] = []

    def ahead(self, particles: Particles, time: float, dt: float, wave_time: float) -> Floats:
        """Return the correction (n_owned, dim) [m] of operators in a step of dt [s] with its middle at `time` [s].

        Values at walls have no meaning. wave_time : sqrt(s/g) [s]. Not collective.
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
        """Store the acceleration (n_owned, dim) [m/s^2] of fluid at a time [s], in the middle of a step of dt [s].

        usual : length of the step [s] if it were not shortened to meet a time. Not collective.
        """
        p = particles
        if dt < SHORT * usual:
            return
        p.acceleration_before[:] = p.acceleration
        movement.give_to_fluid(p.acceleration, acceleration, p.kind)
        self.times = [time, *self.times[:1]]


def share(dt: float, wave_time: float) -> float:
    """Return the part of dt^2 a by which operators are moved ahead in a step of dt [s]. wave_time : sqrt(s/g) [s]"""
    return SHARE * min(1.0, FADES * wave_time / dt) ** 4
