"""The solution of Babenko's equation for a solitary wave of a given height, by Newton's method.

The unknowns are the harmonics of the even elevation and the speed F. GMRES finds each step: Saad & Schultz (1986),
GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear systems, SIAM J. Sci. Stat. Comput. 7,
856-869. Division by the linear part of the equation, F^2 C - 1, makes its convergence independent of the grid.
Petviashvili's iteration finds the same wave, but for 0.75 depths in about a thousand times as many steps.
"""

from collections.abc import Callable

import numpy as np

from parisph.base.arrays import Floats

CLOSE = 1e-13    # change of the elevation in the last step, whose error is its square
STEPS = 20    # of Newton's method, at most
LEFT = 1e-6    # of the residual, by GMRES
DIRECTIONS = 80    # of GMRES, at most
FIRST, NEXT = 0.4, 0.1    # height of the wave found from sech^2, and largest increment to the next one
COARSE, FINEST = 256, 16384    # intervals between crest and end
NOTHING = 1e-14    # limit of the last eighth of harmonics on a sufficient grid


def solve(height: float, F: float, half: float, decay: float) -> tuple[float, Floats] | None:
    """Return the speed F and the elevation over alpha (2 n,), from the crest on, in units of depth and gravity.

    None if there is no such wave, or it needs more than FINEST intervals.
    height : over depth; F, decay : approximate speed and decay rate of the wave; half : half the period
    """
    n, heights = COARSE, [*np.arange(FIRST, height, NEXT), height]
    alpha = np.arange(2 * n) * half / n
    values = heights[0] / np.cosh(0.5 * decay * np.minimum(alpha, 2.0 * half - alpha)) ** 2
    found: tuple[float, Floats] | None = (F, np.fft.rfft(values).real)
    for step in heights:
        found = found and _newton(step, half, *found)
    while found is not None:
        F, a = found
        if np.abs(a[-n // 8 :]).max() < NOTHING * 2 * n:
            return F, np.fft.irfft(a, 2 * n)
        n *= 2
        if n > FINEST:
            break
        found = _newton(height, half, F, np.concatenate([2.0 * a, np.zeros(n // 2)]))
    return None


def _newton(height: float, half: float, F: float, a: Floats) -> tuple[float, Floats] | None:
    """Return F and the harmonics a (n + 1,) of the wave of a height, from those of a similar wave, or None."""
    n = len(a) - 1
    k = np.arange(n + 1) * np.pi / half
    C = np.concatenate([[1.0], k[1:] / np.tanh(k[1:])])

    def values(harmonics: Floats) -> Floats:
        return np.fft.irfft(harmonics, 2 * n)

    def product(one: Floats, other: Floats) -> Floats:
        return np.fft.rfft(one * other).real

    for _ in range(STEPS):
        linear = F * F * C - 1.0
        eta, bent = values(a), values(C * a)
        residual = linear * a - product(eta, bent) - 0.5 * C * product(eta, eta)

        def changed(by: Floats, F: float = F, a: Floats = a, linear: Floats = linear, eta: Floats = eta,
                    bent: Floats = bent) -> Floats:
            """Return the derivative of the equations along a change of harmonics and F."""
            v = by[:-1]
            d_eta = values(v)
            d_residual = linear * v - product(d_eta, bent) - product(eta, values(C * v)) - C * product(eta, d_eta)
            return np.append((d_residual + 2.0 * F * by[-1] * C * a) / linear, n * d_eta[0])

        step = gmres(changed, -np.append(residual / linear, n * (eta[0] - height)), LEFT, DIRECTIONS)
        a, F = a + step[:-1], F + float(step[-1])
        if not (np.isfinite(F) and F > 1.0):
            return None
        if np.abs(values(step[:-1])).max() < CLOSE:
            return F, a
    return None


def gmres(apply: Callable[[Floats], Floats], right: Floats, left: float, most: int) -> Floats:
    """Return x (n,) with apply(x) = right, to a residual of `left` times the norm of right, or with `most` directions.

    apply : a linear function of vectors (n,)
    """
    size = float(np.linalg.norm(right))
    if size == 0.0:
        return np.zeros_like(right)
    basis, H, y = [right / size], np.zeros((most + 1, most)), np.zeros(0)
    for m in range(most):
        w = apply(basis[m])
        for _ in range(2):    # again, against round-off
            for i, b in enumerate(basis):
                share = b @ w
                H[i, m] += share
                w = w - share * b
        H[m + 1, m] = np.linalg.norm(w)
        part, target = H[: m + 2, : m + 1], np.append(size, np.zeros(m + 1))
        y = np.linalg.lstsq(part, target, rcond=None)[0]
        if np.linalg.norm(target - part @ y) < left * size or H[m + 1, m] < np.finfo(float).eps:
            break
        basis.append(w / H[m + 1, m])
    found: Floats = y @ np.array(basis[: len(y)])
    return found
