"""Steady waves of any length by Fourier series of the stream function.

Rienecker & Fenton (1981), A Fourier approximation method for steady water waves, J. Fluid Mech. 104, 119-137. In the
frame of the wave, with lengths in depths and speeds in sqrt(g depth),

    psi(x, y) = -U y + sum_j B_j sinh(j k y)/cosh(j k) cos(j k x),

psi = -q on the surface, with Bernoulli's equation at points from crest to trough.
"""

from functools import lru_cache
from typing import Annotated, Any, Literal, cast

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Array, Floats
from parisph.base.text import shown
from parisph.case.waves.linear import wave_number
from parisph.case.waves.wavefield import (
    Depth,
    Gravity,
    Height,
    Leftward,
    Period,
    Place,
    Travelling,
    no_higher,
    steepest,
)

CONVERGED = 1e-11    # of the residuals
FIRST = 0.1    # height over the highest: first wave of the continuation, and largest increment


def _ratios(n: Any, k: Any, y: Any) -> tuple[Any, Any]:
    """Return cosh(n k y)/cosh(n k) and sinh(n k y)/cosh(n k); also for complex arguments, without overflow."""
    up, down, scale = np.exp(n * k * (y - 1.0)), np.exp(-n * k * (y + 1.0)), 1.0 + np.exp(-2.0 * n * k)
    return (up + down) / scale, (up - down) / scale


class _Equations:
    """The equations of a wave in units of depth and gravity, for elevations, B, U, q, Bernoulli's constant and k."""

    def __init__(self, order: int, period: float, closed: bool) -> None:
        self.order, self.period, self.closed = order, period, closed
        self.j = np.arange(1, order + 1)[:, None]
        self.places = np.arange(order + 1) * np.pi / order    # k x of the points from crest to trough
        self.cos, self.sin = np.cos(self.j * self.places), np.sin(self.j * self.places)

    def split(self, state: Array) -> tuple[Any, ...]:
        """Return eta (order + 1,), B (order,), U, q, R and k."""
        n = self.order
        return state[: n + 1], state[n + 1 : 2 * n + 1], *state[2 * n + 1 :]

    def celerity(self, U: Any, q: Any) -> Any:
        """Return the celerity for zero mean flux if closed, else for zero mean Eulerian current."""
        return q if self.closed else U

    def residuals(self, state: Array, height: float) -> Array:
        eta, B, U, q, R, k = self.split(state)
        cosh, sinh = _ratios(self.j, k, 1.0 + eta)
        psi = -U * (1.0 + eta) + B @ (sinh * self.cos)
        u = -U + (self.j[:, 0] * k * B) @ (cosh * self.cos)
        v = (self.j[:, 0] * k * B) @ (sinh * self.sin)
        mean = 0.5 * (eta[0] + eta[-1]) + eta[1:-1].sum()
        return np.concatenate(
            [
                psi + q,
                0.5 * (u * u + v * v) + eta - R,
                [mean, eta[0] - eta[-1] - height, k * self.celerity(U, q) * self.period - 2.0 * np.pi],
            ]
        )

    def jacobian(self, state: Floats, height: float) -> Floats:
        """Return the derivatives of the residuals, exact by complex steps."""
        found = np.empty((len(state), len(state)))
        for column in range(len(state)):
            moved = state.astype(complex)
            moved[column] += 1e-30j
            found[:, column] = self.residuals(moved, height).imag * 1e30
        return found

    def linear(self, height: float) -> Floats:
        """Return the state of a linear wave."""
        k = float(wave_number(2.0 * np.pi / self.period, 1.0, 1.0))
        U = np.sqrt(np.tanh(k) / k)
        B = np.zeros(self.order)
        B[0] = 0.5 * height / np.tanh(k) * U
        return np.concatenate([0.5 * height * np.cos(self.places), B, [U, U, 0.5 * U * U, k]])

    def newton(self, state: Floats, height: float) -> Floats | None:
        """Return the solution near a state, or None."""
        for _ in range(30):
            f = self.residuals(state, height)
            if not np.all(np.isfinite(f)):
                return None
            if np.abs(f).max() < CONVERGED:
                return state
            try:
                state = state - np.linalg.solve(self.jacobian(state, height), f)
            except np.linalg.LinAlgError:
                return None
        return None


@lru_cache(maxsize=32)
def solve(height: float, period: float, order: int, closed: bool) -> tuple[Any, ...] | None:
    """Return eta, its cosine amplitudes (order + 1,), B (order,), celerity, U, k and the largest residual.

    None without a solution.
    height, period : in units of depth and gravity; the solution is continued from low waves to this height
    """
    equations = _Equations(order, period, closed)
    length = 2.0 * np.pi / float(wave_number(2.0 * np.pi / period, 1.0, 1.0))
    heights = np.linspace(0.0, height, 1 + max(2, int(np.ceil(height / (FIRST * steepest(1.0, length))))))[1:]
    state = before = equations.linear(heights[0])
    for number, step in enumerate(heights):
        guess = state if number < 2 else 2.0 * state - before
        with np.errstate(all="ignore"):
            found = equations.newton(guess, step)
        if found is None:
            return None
        before, state = state, found
    eta, B, U, q, _, k = equations.split(state)
    if not (k > 0.0 and eta[0] == eta.max()):
        return None
    weights = np.full(order + 1, 2.0 / order)
    weights[[0, -1]] /= 2.0
    amplitudes = np.array([weights * eta @ np.cos(n * equations.places) for n in range(order + 1)])
    amplitudes[-1] /= 2.0
    residual = float(np.abs(equations.residuals(state, height)).max())
    return eta, amplitudes, B, float(equations.celerity(U, q)), float(U), float(k), residual


class StreamFunction(Travelling):
    """A regular wave of any length by stream-function theory: height [m], period [s] and depth [m].

    order : number of terms; long and high waves need more
    closed : whether the mean flux is zero, as in a closed flume; else the mean Eulerian current is zero

    >>> wave = StreamFunction(height=0.1, period=3.0, depth=0.3)
    >>> crest, trough = wave.elevation(0.0, 0.0), wave.elevation(0.0, 1.5)
    >>> print(f"height {crest - trough:.3f} m, crest {crest:.3f} m")
    height 0.100 m, crest 0.078 m
    """

    kind: Literal["stream_function"] = Field(default="stream_function", init=False)
    height: Height
    period: Period
    depth: Depth
    order: Annotated[int, Field(ge=3, le=60, description="number of terms of the series")] = 20
    closed: Annotated[bool, Field(description="whether the mean flux is zero, as in a closed flume")] = False
    at: Place = 0.0
    leftward: Leftward = False
    g: Gravity = 9.81

    @model_validator(mode="after")
    def _exists(self) -> "StreamFunction":
        length = 2.0 * np.pi / float(wave_number(2.0 * np.pi / self.period, self.depth, self.g))
        no_higher(
            self.height,
            1.1 * steepest(self.depth, length),
            "that of the highest steady wave",
            "use a lower or a longer one",
        )
        if self._solved() is None:
            raise ValueError(
                f"height = {shown(self.height)}: no steady wave of this period and depth was found with "
                f"order = {self.order}; "
                "use a lower wave, or another order"
            )
        return self

    @property
    def _solution(self) -> tuple[Any, ...]:
        return cast(tuple[Any, ...], self._solved())    # checked by _exists

    def _solved(self) -> tuple[Any, ...] | None:
        return solve(
            self.height / self.depth, self.period * float(np.sqrt(self.g / self.depth)), self.order, self.closed
        )

    @property
    def k(self) -> float:
        """Wave number [1/m]."""
        return float(self._solution[5]) / self.depth

    @property
    def length(self) -> float:
        """Length of the wave [m]."""
        return 2.0 * np.pi / self.k

    @property
    def celerity(self) -> float:
        """Speed of the crests [m/s]."""
        return float(self._solution[3]) * float(np.sqrt(self.g * self.depth))

    def _profile(self, ahead: Floats) -> Floats:
        theta = self.k * ahead
        eta: Floats = self.depth * sum(value * np.cos(n * theta) for n, value in enumerate(self._solution[1]))
        return eta

    def _flow(self, ahead: Floats, y: Floats) -> tuple[Floats, Floats]:
        _, _, B, celerity, U, k, _ = self._solution
        theta, y = k * ahead / self.depth, y / self.depth
        u, v = np.full(np.shape(theta), celerity - U), np.zeros(np.shape(theta))
        for n, value in enumerate(B, start=1):
            cosh, sinh = _ratios(n, k, y)
            u += n * k * value * cosh * np.cos(n * theta)
            v += n * k * value * sinh * np.sin(n * theta)
        speed = np.sqrt(self.g * self.depth)
        return speed * u, speed * v
