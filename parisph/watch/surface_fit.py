"""The height of a free surface between its particles, by a local quadratic fit (3D)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from parisph.base.arrays import Flags, Floats

# Lengths in spacings.
RADIUS = 2.6    # of the particles that count
SLOPE = 2.0     # largest slope of a smooth surface
LAYER = 0.5     # particles deeper below the fit are not on the surface
ROUGH = 0.25    # largest mean distance of the particles of a smooth surface from the fit
SINGULAR = 1e-6  # least share of the smallest eigenvalue of the moments in the largest

Mirror = tuple[int, float]    # axis, place on it [m]


class _Fit(NamedTuple):
    """A fit: height [m] and slope at the place, distances (n,) [m] of the particles above it, and their weights."""

    height: float
    slope: float
    off: Floats
    weight: Floats


def fitted_height(place: Floats, x: Floats, top: float, column: float, spacing: float,
                  mirrors: Sequence[Mirror] = ()) -> float:
    """Return the height [m] of the free surface above a place (2,), from the particles on it.

    If the surface is smooth and single-valued there, this is a quadratic polynomial fitted to the particles within
    RADIUS, with the weight (1 - r^2/radius^2)^2. It is exact for such a surface, of fourth order for others, and
    continuous when particles come and go. At vertical walls the particles are mirrored. Where the surface is steeper
    than SLOPE, or rough, or has no particles on one side, it is `top`.

    x : (n, 3) particles on the surface, in any order [m]
    top : highest water within the distance `column` [m] of the place [m]; mirrors : vertical walls
    """
    for axis, wall in mirrors:
        image = x.copy()
        image[:, axis] = 2.0 * wall - image[:, axis]
        x = np.concatenate([x, image])
    d, z = x[:, :2] - place, x[:, 2]
    away = np.hypot(d[:, 0], d[:, 1])
    # without spray: points that a surface of at most SLOPE can reach from the top near the place
    own = (away < RADIUS * spacing) & (z - top <= SLOPE * np.maximum(away - column, 0.0))
    d, z = d[own], z[own]
    d, z = d[~(hidden := _covered(d, z, spacing))], z[~hidden]
    for _ in range(2):    # the second time without particles below the surface
        fit = _fitted(d, z, RADIUS * spacing) if _around(d) else None
        if fit is None or not len(deep := np.flatnonzero(fit.off < -LAYER * spacing)):
            break
        d, z = np.delete(d, deep, axis=0), np.delete(z, deep)
    if fit is None or fit.slope > SLOPE:
        return top
    rough = np.sqrt((fit.weight @ fit.off**2) / fit.weight.sum())
    return top if rough > ROUGH * spacing else fit.height


def _covered(d: Floats, z: Floats, spacing: float) -> Flags:
    """Return whether another point is above each (n,), too near for a surface of at most SLOPE."""
    away = np.linalg.norm(d[:, None] - d, axis=2)
    above = z - z[:, None]
    found: Flags = ((away < spacing) & (above > SLOPE * np.maximum(away, 0.5 * spacing))).any(axis=1)
    return found


def _around(d: Floats) -> bool:
    """Return whether points at d (n, 2) from a place lie on all sides of it."""
    if (np.abs(d).sum(axis=1) == 0.0).any():
        return len(d) > 2
    angle = np.sort(np.arctan2(d[:, 1], d[:, 0]))
    return len(d) > 2 and bool(np.diff(angle, append=angle[0] + 2.0 * np.pi).max() <= np.pi)


def _fitted(d: Floats, z: Floats, radius: float) -> _Fit | None:
    """Return the quadratic fit to heights z (n,) at d (n, 2), a plane if they do not determine it, or None."""
    u = d / radius
    weight = np.clip(1.0 - (u**2).sum(axis=1), 0.0, None) ** 2
    basis = np.column_stack([np.ones(len(u)), u, u[:, 0] ** 2, u[:, 0] * u[:, 1], u[:, 1] ** 2])
    for size in (6, 3):
        part = basis[:, :size]
        moments = part.T @ (weight[:, None] * part)
        least, *_, most = np.linalg.eigvalsh(moments)
        if least > SINGULAR * most:
            found = np.linalg.solve(moments, part.T @ (weight * (z - z.mean())))
            return _Fit(float(found[0] + z.mean()), float(np.hypot(found[1], found[2])) / radius,
                        z - z.mean() - part @ found, weight)
    return None
