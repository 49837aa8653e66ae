"""The geometry of wall elements, in 2D (segments) and 3D (triangles): shapes, normals, nearest points, crossings.

Elements have current `corners` (M, dim, dim) [m], ordered as in `records.Walls`.
"""

import math

import numpy as np

from parisph.kernels.jit import axes_of, inlined, kernel
from parisph.kernels.records import Shapes, Walls

SLACK = 1e-9     # margin of an element over its size, so that lines cannot pass between two elements


def shapes_of(corners: np.ndarray, number: np.ndarray) -> Shapes:
    """Return the Shapes of elements (M, dim, dim) [m] with these numbers of their planes (M,) int."""
    count, dim = corners.shape[:2]
    shapes = Shapes(np.empty((count, dim)), np.empty(count), np.empty((count, dim + 1)), number)
    _measure(shapes, corners, axes_of(dim))
    return shapes


@kernel
def _measure(shapes: Shapes, corners: np.ndarray, axes: tuple[int, ...]) -> None:
    """Write all but the numbers."""
    middle, size, plane, _ = shapes
    dim, n = len(axes), np.empty(len(axes))
    for e in range(len(corners)):
        element_normal(n, e, corners, axes)
        plane[e, dim] = 0.0
        for a in range(dim):
            plane[e, a] = n[a]
            plane[e, dim] += n[a] * corners[e, 0, a]
            middle[e, a] = 0.0
            for c in range(dim):
                middle[e, a] += corners[e, c, a] / dim
        size2 = 0.0
        for c in range(dim):
            apart2 = 0.0
            for a in range(dim):
                apart2 += (corners[e, c, a] - middle[e, a]) ** 2
            size2 = max(size2, apart2)
        size[e] = math.sqrt(size2)


def plane_numbers(corners: np.ndarray, motion: np.ndarray, spacing: float) -> np.ndarray:
    """Return numbers (M,) that are equal for elements (M, dim, dim) [m] in one plane with one motion (M,), so forever.

    Elements that differ by rounding may have different numbers. spacing : [m]
    """
    if len(corners) == 0:
        return np.zeros(0, np.int64)
    plane = shapes_of(corners, np.zeros(len(corners), np.int64)).plane
    plane[:, -1] /= spacing
    keys = np.column_stack([np.round(plane / SLACK).astype(np.int64), motion])
    numbers: np.ndarray = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    return numbers


@inlined
def element_normal(n: np.ndarray, e: int, corners: np.ndarray, axes: tuple[int, ...]) -> float:
    """Write the unit normal of an element, into the fluid; return its measure [m^(dim-1)]."""
    if len(axes) == 2:
        nx, ny = corners[e, 0, 1] - corners[e, 1, 1], corners[e, 1, 0] - corners[e, 0, 0]
        size = math.sqrt(nx * nx + ny * ny)
        n[0], n[1] = nx / size, ny / size
        return size
    ax, ay, az = corners[e, 0, 0], corners[e, 0, 1], corners[e, 0, 2]
    ux, uy, uz = corners[e, 1, 0] - ax, corners[e, 1, 1] - ay, corners[e, 1, 2] - az
    vx, vy, vz = corners[e, 2, 0] - ax, corners[e, 2, 1] - ay, corners[e, 2, 2] - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    n[0], n[1], n[2] = nx / size, ny / size, nz / size
    return 0.5 * size


@inlined
def nearest_point(foot: np.ndarray, p: np.ndarray, e: int, corners: np.ndarray, axes: tuple[int, ...]) -> bool:
    """Write the point of element e nearest to p; return whether it is inside the element, not on its edge."""
    if len(axes) == 2:
        return _nearest_on_side(foot, p, e, 0, 1, corners, axes)
    return _nearest_on_triangle(foot, p, e, corners, axes)


@inlined
def _nearest_on_side(foot, p, e, first, second, corners, axes):
    along, length2 = 0.0, 0.0
    for a in range(len(axes)):
        d = corners[e, second, a] - corners[e, first, a]
        along += (p[a] - corners[e, first, a]) * d
        length2 += d * d
    t = min(max(along / length2, 0.0), 1.0)
    for a in range(len(axes)):
        foot[a] = corners[e, first, a] + t * (corners[e, second, a] - corners[e, first, a])
    return 0.0 <= along <= length2


@inlined
def _nearest_on_triangle(foot, p, e, corners, axes):
    uu, uv, vv, up, vp = 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(3):
        u, v = corners[e, 1, a] - corners[e, 0, a], corners[e, 2, a] - corners[e, 0, a]
        w = p[a] - corners[e, 0, a]
        uu, uv, vv, up, vp = uu + u * u, uv + u * v, vv + v * v, up + u * w, vp + v * w
    det = uu * vv - uv * uv
    b, c = (vv * up - uv * vp) / det, (uu * vp - uv * up) / det
    if b >= -SLACK and c >= -SLACK and b + c <= 1.0 + SLACK:    # above an edge, one of the two must qualify
        for a in range(3):
            foot[a] = (1.0 - b - c) * corners[e, 0, a] + b * corners[e, 1, a] + c * corners[e, 2, a]
        return True
    best, side = math.inf, 0
    for k in range(3):
        _nearest_on_side(foot, p, e, k, (k + 1) % 3, corners, axes)
        apart2 = square_distance(foot, p, axes)
        if apart2 < best:
            best, side = apart2, k
    _nearest_on_side(foot, p, e, side, (side + 1) % 3, corners, axes)
    return False


@inlined
def is_within(p: np.ndarray, e: int, foot: np.ndarray, radius: float, walls: Walls, axes: tuple[int, ...]) -> bool:
    """Return whether element e is within the radius [m] of p.

    foot : (dim,) scratch, the nearest point where it is needed
    """
    apart2, shapes = 0.0, walls.shapes
    for a in range(len(axes)):
        apart2 += (shapes.middle[e, a] - p[a]) ** 2
    if apart2 <= radius * radius:
        return True
    if apart2 > (radius + shapes.size[e]) ** 2 * (1.0 + SLACK):
        return False
    nearest_point(foot, p, e, walls.corners, axes)
    return square_distance(foot, p, axes) <= radius * radius


@inlined
def square_distance(p: np.ndarray, q: np.ndarray, axes: tuple[int, ...]) -> float:
    """Return the square of the distance of two points [m^2]."""
    total = 0.0
    for a in range(len(axes)):
        total += (p[a] - q[a]) ** 2
    return total


@inlined
def crosses(p: np.ndarray, q: np.ndarray, e: int, corners: np.ndarray, axes: tuple[int, ...]) -> bool:
    """Return whether the line from p to q crosses element e."""
    if len(axes) == 2:
        ex, ey = corners[e, 1, 0] - corners[e, 0, 0], corners[e, 1, 1] - corners[e, 0, 1]
        px, py = p[0] - corners[e, 0, 0], p[1] - corners[e, 0, 1]
        dx, dy = q[0] - p[0], q[1] - p[1]
        before = ex * py - ey * px
        slant = ex * dy - ey * dx
        if (before > 0.0) == (before + slant > 0.0):
            return False
        u = (px * dy - py * dx) / slant
        return -SLACK <= u <= 1.0 + SLACK
    return _crosses_triangle(p, q, e, corners)


@inlined
def _crosses_triangle(p, q, e, corners):
    ax, ay, az = corners[e, 0, 0], corners[e, 0, 1], corners[e, 0, 2]
    ux, uy, uz = corners[e, 1, 0] - ax, corners[e, 1, 1] - ay, corners[e, 1, 2] - az
    vx, vy, vz = corners[e, 2, 0] - ax, corners[e, 2, 1] - ay, corners[e, 2, 2] - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    px, py, pz = p[0] - ax, p[1] - ay, p[2] - az
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    before, slant = nx * px + ny * py + nz * pz, nx * dx + ny * dy + nz * dz
    if (before > 0.0) == (before + slant > 0.0):
        return False
    # p + t d = corner + b u + c v (Moller & Trumbore 1997)
    wx, wy, wz = py * dz - pz * dy, pz * dx - px * dz, px * dy - py * dx
    b = -(vx * wx + vy * wy + vz * wz) / slant
    c = (ux * wx + uy * wy + uz * wz) / slant
    return b >= -SLACK and c >= -SLACK and b + c <= 1.0 + SLACK
