"""Irregular waves: a sum of linear waves with the energies of a JONSWAP spectrum.

Hasselmann et al. (1973), Measurements of wind-wave growth and swell decay during the Joint North Sea Wave Project,
Deutsche Hydrographische Zeitschrift A8(12).
"""

from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.case.waves.airy import transfer
from parisph.case.waves.linear import wave_number
from parisph.case.waves.wavefield import Depth, Gravity, Leftward, WaveField, no_higher, steepest

LOWEST, HIGHEST = 0.5, 4.0    # frequencies of the spectrum, over that of the peak
POINTS = 20_000    # of its integration


def density(ratio: Floats, gamma: float) -> Floats:
    """Return the spectral density over frequency/peak frequency (any scale): ratio^-5 exp(-5/4 ratio^-4) gamma^r."""
    width = np.where(ratio <= 1.0, 0.07, 0.09)
    peak: Floats = gamma ** np.exp(-0.5 * ((ratio - 1.0) / width) ** 2)
    energy: Floats = ratio**-5.0 * np.exp(-1.25 * ratio**-4.0) * peak
    return energy


def _edges(gamma: float, components: int, bands: str) -> tuple[Floats, Floats, Floats]:
    """Return the edges of the bands, over the peak frequency, a grid, and the share of the energy below its points."""
    grid = np.linspace(LOWEST, HIGHEST, POINTS)
    energy = density(grid, gamma)
    below = np.concatenate([[0.0], np.cumsum(0.5 * (energy[1:] + energy[:-1]))])
    below /= below[-1]
    if bands == "energy":
        return np.interp(np.linspace(0.0, 1.0, components + 1), below, grid), grid, below
    return np.linspace(LOWEST, HIGHEST, components + 1), grid, below


@lru_cache(maxsize=16)
def components_of(wave: "Jonswap") -> tuple[Floats, Floats, Floats, Floats]:
    """Return amplitude [m], frequency [rad/s], wave number [1/m] and phase [rad] of the components, (n,) each."""
    edges, grid, below = _edges(wave.gamma, wave.components, wave.bands)
    rng = np.random.default_rng(wave.seed)
    phase = 2.0 * np.pi * rng.random(wave.components)
    share = np.diff(np.interp(edges, grid, below))
    # within its band: at half of its energy, or random, so that equal bands do not repeat the series
    if wave.bands == "energy":
        ratio = np.interp((np.arange(wave.components) + 0.5) / wave.components, below, grid)
    else:
        ratio = edges[:-1] + np.diff(edges) * rng.random(wave.components)
    omega = 2.0 * np.pi / wave.period * ratio
    k = np.array([float(wave_number(value, wave.depth, wave.g)) for value in omega])
    # the variance is (height/4)^2, that of a component half its squared amplitude
    return wave.height / 4.0 * np.sqrt(2.0 * share), omega, k, phase


class Jonswap(WaveField):
    """Irregular waves of significant height [m], peak period [s] and depth [m], of linear theory.

    gamma : peak enhancement; 1 for the spectrum of Pierson and Moskowitz
    seed : of the phases; the same number gives the same waves
    components : number of waves in the sum
    bands : "energy" for components of equal energy, each at the frequency that halves the energy of its band, so the
        series does not repeat; "frequency" for bands of equal width, with a random frequency in each

    Frequencies are from 0.5 to 4 times that of the peak. Velocities are those at the same relative depth (Wheeler),
    because under long crests those of the shortest waves would grow without limit.

    >>> sea = Jonswap(height=0.06, period=1.5, depth=0.5, seed=3)
    >>> sea.elevation(0.0, [0.0, 0.5, 1.0]).shape
    (3,)
    """

    kind: Literal["jonswap"] = Field(default="jonswap", init=False)
    height: Annotated[float, Field(gt=0, description="significant height [m]")]
    period: Annotated[float, Field(gt=0, description="period of the peak of the spectrum [s]")]
    depth: Depth
    gamma: Annotated[float, Field(ge=1, le=20, description="peak enhancement")] = 3.3
    seed: Annotated[int, Field(ge=0, description="seed of the phases")] = 0
    components: Annotated[int, Field(ge=2, le=2000, description="number of waves in the sum")] = 200
    bands: Annotated[Literal["energy", "frequency"], Field(description="quantity that all bands share")] = "energy"
    leftward: Leftward = False
    g: Gravity = 9.81

    @model_validator(mode="after")
    def _is_possible(self) -> "Jonswap":
        length = 2.0 * np.pi / float(wave_number(2.0 * np.pi / self.period, self.depth, self.g))
        no_higher(
            self.height,
            0.6 * steepest(self.depth, length),
            "0.6 of the highest steady wave of the peak period",
            "use a lower or a longer one",
        )
        return self

    def elevation(self, x: ArrayLike, t: ArrayLike) -> Floats:
        x, t = np.broadcast_arrays(self._sign * np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        eta = np.zeros(x.shape)
        for amplitude, omega, k, phase in zip(*components_of(self)):
            eta += amplitude * np.cos(k * x - omega * t + phase)
        return eta

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
        x, y, t = np.broadcast_arrays(
            np.asarray(x, dtype=float), np.asarray(y, dtype=float), np.asarray(t, dtype=float)
        )
        y = y * self.depth / (self.depth + self.elevation(x, t))
        u, v = np.zeros(x.shape), np.zeros(x.shape)
        for amplitude, omega, k, phase in zip(*components_of(self)):
            cosh, sinh = transfer(k, y, self.depth)
            theta = k * self._sign * x - omega * t + phase
            u += self._sign * amplitude * omega * cosh * np.cos(theta)
            v += amplitude * omega * sinh * np.sin(theta)
        return u, v

    @property
    def _sign(self) -> float:
        return -1.0 if self.leftward else 1.0
