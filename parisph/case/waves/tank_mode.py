"""The linear standing waves of a rectangular tank, with a number of half waves along it and one across."""

from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.waves.airy import transfer
from parisph.case.waves.linear import angular_frequency
from parisph.case.waves.wavefield import Depth, Gravity, WaveField

Halves = Annotated[int, Field(ge=0, le=1000, description="number of half waves")]


class TankMode(WaveField):
    """A linear standing wave in a 3D tank: eta = amplitude cos(kx (x - x0)) cos(ky (y - y0)) sin(omega t + phase).

    modes : (m, n), numbers of half waves along the tank and across it: kx = m pi/length, ky = n pi/breadth
    amplitude, length, breadth, depth [m]; at : the corner (x0, y0) of the tank [m]

    omega^2 = g k tanh(k depth) with k^2 = kx^2 + ky^2. With phase = 0 the surface is flat at the start, with phase =
    pi/2 the water is at rest.

    >>> wave = TankMode(amplitude=0.002, modes=(1, 1), length=1.0, breadth=0.8, depth=0.5, phase=pi / 2)
    >>> print(f"{wave.omega:.4f} rad/s, {wave.surface(1.0, 0.8, 0.0):.3f} m")
    6.9780 rad/s, 0.002 m
    """

    kind: Literal["mode"] = Field(default="mode", init=False)
    amplitude: Annotated[float, Field(gt=0, description="amplitude of the elevation [m]")]
    modes: Annotated[tuple[Halves, Halves], Field(description="numbers (m, n) of half waves along and across")]
    length: Annotated[float, Field(gt=0, description="length of the tank [m]")]
    breadth: Annotated[float, Field(gt=0, description="breadth of the tank [m]")]
    depth: Depth
    phase: Annotated[float, Field(description="phase at the start [rad]")] = 0.0
    at: Annotated[tuple[float, float], Field(description="corner (x, y) of the tank [m]")] = (0.0, 0.0)
    g: Gravity = 9.81

    @model_validator(mode="after")
    def _is_a_wave(self) -> "TankMode":
        if self.modes == (0, 0):
            raise ValueError("modes = (0, 0): is level water; give at least one half wave, for example (1, 0)")
        if self.direction is not None:
            raise ValueError(f"direction = {shown(self.direction)}: a TankMode has two numbers of half waves instead; "
                             "leave it out")
        return self

    @property
    def varies_across(self) -> bool:
        return self.modes[1] > 0

    @property
    def k(self) -> float:
        """Wave number [1/m]."""
        return float(np.hypot(*self._parts))

    @property
    def wavelength(self) -> float:
        """Length 2 pi/k [m] of a plane wave of this frequency."""
        return 2.0 * np.pi / self.k

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s]."""
        return float(angular_frequency(self.k, self.depth, self.g))

    def elevation(self, x: ArrayLike, t: ArrayLike) -> Floats:
        """Return the elevation [m] at x [m] along the wall at y0, and t [s], which broadcast."""
        return self.surface(x, None, t)

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return the velocity (u, w) [m/s] at x [m] along the wall at y0, heights y [m] and t [s], which broadcast."""
        u, _, w = self._velocity(x, self.at[1], y, t)
        return u, w

    def surface(self, x: ArrayLike, y: ArrayLike | None, t: ArrayLike) -> Floats:
        kx, ky = self._parts
        along = np.cos(kx * (np.asarray(x, dtype=float) - self.at[0]))
        across = 1.0 if y is None else np.cos(ky * (np.asarray(y, dtype=float) - self.at[1]))
        eta: Floats = self.amplitude * along * across * np.sin(self.omega * np.asarray(t) + self.phase)
        return eta

    def flow(self, x: Floats, bed: float, t: float) -> Floats:
        return np.stack(self._velocity(x[:, 0], x[:, 1], x[:, 2] - bed, t), axis=1)

    @property
    def _parts(self) -> tuple[float, float]:
        """Wave numbers (kx, ky) [1/m]."""
        return self.modes[0] * np.pi / self.length, self.modes[1] * np.pi / self.breadth

    def _velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Return the velocity (u, v, w) [m/s] at x, y [m], heights z [m] above the bed, and t [s]."""
        x, y, z, t = np.broadcast_arrays(np.asarray(x, dtype=float), y, np.asarray(z, dtype=float), t)
        (kx, ky), k = self._parts, self.k
        cosh, sinh = transfer(k, z, self.depth)
        scale = self.amplitude * self.omega * np.cos(self.omega * t + self.phase)
        along, across = kx * (x - self.at[0]), ky * (y - self.at[1])
        level = -scale * cosh / k
        return (kx * level * np.sin(along) * np.cos(across), ky * level * np.cos(along) * np.sin(across),
                scale * sinh * np.cos(along) * np.cos(across))
