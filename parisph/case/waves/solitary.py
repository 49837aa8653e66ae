"""The solitary wave: exact, or by a theory for low waves.

Grimshaw (1971), The solitary wave in water of variable depth, Part 2, J. Fluid Mech. 46, 611-622, to the third order.
Boussinesq's wave is Z17 Eq 34; its velocity here is uniform over the depth and carries the exact flux.
"""

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.case.waves import babenko
from parisph.case.waves.wavefield import Depth, Gravity, Leftward, Place, Travelling, no_higher

P: Callable[..., Any] = np.polynomial.polynomial.polyval
HIGHEST = {"exact": babenko.HIGHEST, "grimshaw": 0.6, "boussinesq": 0.8}    # over the depth


def _grimshaw(e: float, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Return elevation, slope and area ahead of x of a wave of height e, in depths."""
    alpha = _grimshaw_rate(e)
    s, t = 1.0 / np.cosh(alpha * x), np.tanh(alpha * x)
    a, b, c = e, -0.75 * e**2 + 0.625 * e**3, -101.0 / 80.0 * e**3
    eta = a * s**2 + b * s**2 * t**2 + c * s**4 * t**2
    slope = 2.0 * alpha * s**2 * t * (-a + b * (s**2 - t**2) + c * s**2 * (s**2 - 2.0 * t**2))
    left = 1.0 - t    # the integrals of powers of s and t, from x on
    cubes, fifths = (1.0 - t**3) / 3.0, (1.0 - t**5) / 5.0
    return eta, slope, (a * left + b * cubes + c * (cubes - fifths)) / alpha


def _grimshaw_rate(e: float) -> float:
    return float(np.sqrt(0.75 * e)) * (1.0 - 0.625 * e + 71.0 / 128.0 * e**2)


def _grimshaw_velocity(e: float, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return u and v over sqrt(g d); x, y in depths."""
    alpha = _grimshaw_rate(e)
    q, t, Y = 1.0 / np.cosh(alpha * x) ** 2, np.tanh(alpha * x), y**2
    u = (
        e * q
        - e**2 * (P(q, (0, -1 / 4, 1)) + Y * P(q, (0, 3 / 2, -9 / 4)))
        - e**3
        * (
            P(q, (0, 19 / 40, 1 / 5, -6 / 5))
            + Y * P(q, (0, -3 / 2, -15 / 4, 15 / 2))
            + Y**2 * P(q, (0, -3 / 8, 45 / 16, -45 / 16))
        )
    )
    v = (
        e * q
        - e**2 * (P(q, (0, 3 / 8, 2)) + Y * P(q, (0, 1 / 2, -3 / 2)))
        - e**3
        * (
            P(q, (0, 49 / 640, -17 / 20, -18 / 5))
            + Y * P(q, (0, -13 / 16, -25 / 16, 15 / 2))
            + Y**2 * P(q, (0, -3 / 40, 9 / 8, -27 / 16))
        )
    )
    return u, np.sqrt(3.0 * e) * y * t * v


def _boussinesq(e: float, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Return elevation, slope and area ahead of x of a wave of height e, in depths."""
    rate = np.sqrt(0.75 * e)
    s, t = 1.0 / np.cosh(rate * x), np.tanh(rate * x)
    return e * s**2, -2.0 * e * rate * s**2 * t, e * (1.0 - t) / rate


class SolitaryWave(Travelling):
    """A solitary wave of given height and depth [m], with its crest `at` x [m] when t = 0.

    theory : "exact", the steady solution of the full equations, to about 1e-9; "grimshaw", of third order: the error of
        the profile is 0.2 % at height/depth = 0.2 and 3 % at 0.6; "boussinesq", sech^2: 5 and 7 %

    >>> wave = SolitaryWave(height=0.05, depth=0.25, at=2.0)
    >>> print(f"{wave.celerity:.3f} m/s, {wave.elevation(2.0, 0.0):.3f} m")
    1.714 m/s, 0.050 m
    """

    kind: Literal["solitary"] = Field(default="solitary", init=False)
    height: Annotated[float, Field(gt=0, description="height of the crest above the still surface [m]")]
    depth: Depth
    theory: Annotated[Literal["exact", "grimshaw", "boussinesq"], Field(description="theory")] = "exact"
    at: Place = 0.0
    leftward: Leftward = False
    g: Gravity = 9.81

    @model_validator(mode="after")
    def _exists(self) -> "SolitaryWave":
        most = HIGHEST[self.theory]
        no_higher(self.height, most * self.depth, f"{most:g} depths for theory = {self.theory}", "use a lower one")
        return self

    @property
    def relative(self) -> float:
        """Height over depth."""
        return self.height / self.depth

    @property
    def celerity(self) -> float:
        """Speed of the crest [m/s]."""
        return self._froude * float(np.sqrt(self.g * self.depth))

    @property
    def rate(self) -> float:
        """Decay rate m [1/m] of the elevation far from the crest, exp(-m x)."""
        e = self.relative
        if self.theory == "exact":
            return babenko.solitary(e).decay / self.depth
        return float(2.0 * (_grimshaw_rate(e) if self.theory == "grimshaw" else np.sqrt(0.75 * e))) / self.depth

    @property
    def area(self) -> float:
        """Area of the wave above the still surface [m2]."""
        return 2.0 * float(self.shape(0.0)[2])

    def shape(self, ahead: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Return elevation [m], slope, and the area [m2] of the wave ahead, at a distance [m] ahead of the crest."""
        x, d = np.asarray(ahead, dtype=float) / self.depth, self.depth
        if self.theory == "exact":
            eta, slope, area = (
                values.reshape(x.shape) for values in babenko.solitary(self.relative).surface(x.ravel())
            )
        else:
            eta, slope, area = (_grimshaw if self.theory == "grimshaw" else _boussinesq)(self.relative, x)
        return d * eta, slope, d * d * area

    @property
    def _froude(self) -> float:
        e = self.relative
        if self.theory == "exact":
            return babenko.solitary(e).F
        return float(np.sqrt(1.0 + e - e * e / 20.0 - 3.0 * e**3 / 70.0 if self.theory == "grimshaw" else 1.0 + e))

    def _profile(self, ahead: Floats) -> Floats:
        return self.shape(ahead)[0]

    def _flow(self, ahead: Floats, y: Floats) -> tuple[Floats, Floats]:
        scale, d = np.sqrt(self.g * self.depth), self.depth
        if self.theory == "exact":
            found = babenko.solitary(self.relative).velocity((ahead / d).ravel(), (y / d).ravel())
            u, v = (values.reshape(ahead.shape) for values in found)
        elif self.theory == "grimshaw":
            u, v = _grimshaw_velocity(self.relative, ahead / d, y / d)
        else:
            eta, slope, _ = _boussinesq(self.relative, ahead / d)
            u = self._froude * eta / (1.0 + eta)
            v = -(y / d) * self._froude * slope / (1.0 + eta) ** 2
        return scale * u, scale * v
