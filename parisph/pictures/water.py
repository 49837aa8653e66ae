"""The water of a 3D flow as a closed surface around its particles, and values on it."""

from functools import cache
from importlib import import_module
from types import ModuleType

import numpy as np

from parisph.base.arrays import Floats, Ints

# Of the reconstruction; chosen by eye, for pictures only: no result depends on them.
SMOOTH = 2.0    # smoothing length in radii of particles, which are half a spacing
CUBE = 0.7      # cubes of the grid, in radii
LEVEL = 0.6     # of the colour function on the surface; it is 1 inside and .3 at a particle alone
TURNS = 12      # of the smoothing of the surface
NEAR = 6        # particles whose values make that of a point


@cache
def library() -> ModuleType | None:
    """Return the library pysplashsurf, None without it."""
    try:
        return import_module("pysplashsurf")
    except ImportError:
        return None


def surface(x: Floats, spacing: float, box: tuple[Floats, Floats] | None) -> tuple[Floats, Ints] | None:
    """Return points (n, 3) [m] and triangles (m, 3) around particles, None without the library.

    x : (k, 3) [m], of fluid and of wet walls; spacing [m]; box : lower and upper ends (3,) [m] of the surface, or None
    """
    found = library()
    if found is None:
        return None
    if not len(x):
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    made, _ = found.reconstruction_pipeline(
        np.ascontiguousarray(x, dtype=float), particle_radius=0.5 * spacing, smoothing_length=SMOOTH, cube_size=CUBE,
        iso_surface_threshold=LEVEL, mesh_cleanup=True, mesh_smoothing_iters=TURNS)
    mesh = made.mesh
    points = np.asarray(mesh.vertices, float)
    return points if box is None else np.clip(points, *box), np.asarray(mesh.triangles).astype(np.int64)


def spread(points: Floats, x: Floats, values: Floats) -> Floats:
    """Return values (n,) at points (n, 3) [m]: means over near particles at x (k, 3) [m], weighted by distance^-2."""
    from scipy.spatial import cKDTree

    if not len(x):
        return np.zeros(len(points))
    many = min(NEAR, len(x))
    away, near = cKDTree(x).query(points, k=np.arange(1, many + 1))
    weights = 1.0 / np.maximum(away, 1e-9 * np.max(away, initial=1.0)) ** 2
    found: Floats = np.sum(weights * values[near], axis=1) / np.sum(weights, axis=1)
    return found
