"""Viscous acceleration div(nu grad u), with no-slip and free-slip walls.

The walls are one layer of particles on the wall itself, so a particle beside one has neighbours on one side
only. The form of Morris fills the other side with mirror images. The corrected form is a quadratic fit, to which a
no-slip wall gives its velocity as data; only free-slip walls need images there. With the mean viscosity of a pair,
a Laplacian of nu_ij (u_j - u_i) is div(nu grad u), exact for linear nu and linear u if the Laplacian is exact for
quadratics.
"""

import math

import numpy as np

from parisph.base.fields import FLUID, INNER, WALL
from parisph.kernels.jit import inlined, kernel, subkernel
from parisph.kernels.moments import cholesky, cholesky_solve
from parisph.kernels.moving_mirrors import Solids, gather_moving
from parisph.kernels.near import room_for
from parisph.kernels.smoothing import cubic_spline_slope, quartic_weight

# Largest nu dt/s^2 of an explicit step of either form, with nu the largest viscosity, h = 1.3 s and radius = 2.6 s.
# Eigenvalues between no-slip walls allow, in 2D (3D), 0.6 (0.57) for morris and 0.83 (0.7) for corrected on a lattice,
# and 0.47 and 0.62 in 2D with jitter 1.2.
STABLE = 0.4

STRETCH = 3.0       # of squares in units of the radius, so that they are about as large as the coordinates


@kernel
def morris(out: np.ndarray, u: np.ndarray, nu: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray,
           normal: np.ndarray, no_slip: np.ndarray, h: float, volume: float, solids: Solids, indptr: np.ndarray,
           indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Viscous acceleration of owned fluid by the form of Morris et al. (1997, Eq. 22), at one density.

    a_i = sum_j V (nu_i + nu_j) (r_ij . grad_i W_ij)/(r_ij^2 + 0.01 h^2) (u_i - u_j)

    j runs over fluid, walls and images. The image of fluid in a no-slip wall moves with 2 u_wall - u_j, in a
    free-slip wall with the mirrored velocity. Between fluid particles, momentum is conserved.

    out : (n_owned, dim) output [m/s^2]; 0 for walls
    u : (n_all, dim) [m/s], of a no-slip wall its own velocity, of a free-slip wall that of `gradient.wall_velocity`
    nu : (n_all,) [m^2/s], of walls that of the fluid there
    x, normal : (n_all, dim); kind, corner : (n_all,); kind ABSENT is left out
    no_slip : (n_all,) of walls 1 for no-slip, 0 for free-slip; a corner of both is no-slip
    h : smoothing length [m] of the cubic spline, with support 2 h; volume : of a particle [m^dim]
    solids : of walls of any shape; corner is then 1 for nodes on convex edges, too
    """
    dim = len(axes)
    room = room_for(indptr) * 2**dim
    near, du, speed = np.empty((dim, room)), np.empty((dim, room)), np.empty((dim, dim))
    member, slips, image, mirror = np.empty(dim, np.int64), np.empty(dim, np.bool_), np.empty(dim), np.empty(dim)
    for i in range(len(indptr) - 1):
        out[i, :] = 0.0
        if kind[i] != FLUID:
            continue
        n = gather_moving(near, du, speed, member, image, mirror, slips, i, u, nu, x, kind, corner, normal, no_slip,
                          h, True, solids, indptr, indices, axes)
        _morris_sum(out, i, near, du, n, h, volume, axes)


@kernel
def corrected(out: np.ndarray, u: np.ndarray, nu: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray,
              normal: np.ndarray, role: np.ndarray, no_slip: np.ndarray, radius: float, h: float, volume: float,
              solids: Solids, indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Viscous acceleration of owned fluid by a quadratic fit (generalised finite differences).

    The Laplacian is exact for quadratic velocities on any set of particles, also beside walls. Where the
    neighbours do not span the quadratics, and at particles that are not INNER, it is the form of `morris`, because a
    one-sided fit has no condition there. `surface_stress.stress_free` gives surface particles one.

    role : (n_all,); radius : of the quartic weight of the fit [m]; the others as in `morris`
    """
    dim = len(axes)
    size = dim + dim * (dim + 1) // 2
    room = room_for(indptr) * 2**dim
    near, du, speed = np.empty((dim, room)), np.empty((dim, room)), np.empty((dim, dim))
    member, slips, image, mirror = np.empty(dim, np.int64), np.empty(dim, np.bool_), np.empty(dim), np.empty(dim)
    weight, basis = np.empty(room), np.empty((size, room))
    work, pick = np.empty((size, size)), np.empty(size)
    for i in range(len(indptr) - 1):
        out[i, :] = 0.0
        if kind[i] != FLUID:
            continue
        if role[i] == INNER:
            n = gather_moving(near, du, speed, member, image, mirror, slips, i, u, nu, x, kind, corner, normal, no_slip,
                              radius, False, solids, indptr, indices, axes)
            if _fit_laplacian(out, i, near, du, weight, basis, work, pick, n, radius, axes):
                continue
        n = gather_moving(near, du, speed, member, image, mirror, slips, i, u, nu, x, kind, corner, normal, no_slip,
                          h, True, solids, indptr, indices, axes)
        _morris_sum(out, i, near, du, n, h, volume, axes)


@subkernel
def _morris_sum(out, i, near, du, n, h, volume, axes):
    """Add the pairs of `morris`; near in units of h, du = nu_ij (u_j - u_i)."""
    dim = len(axes)
    for k in range(n):
        q2 = 0.0
        for a in range(dim):
            q2 += near[a, k] ** 2
        c = -2.0 * volume * cubic_spline_slope(h * math.sqrt(q2), h, dim) * q2 / (q2 + 0.01)
        for a in range(dim):
            out[i, a] += c * du[a, k]


@subkernel
def factor_quadratics(work: np.ndarray, basis: np.ndarray, weight: np.ndarray, near: np.ndarray, n: int,
                      axes: tuple[int, ...]) -> bool:
    """Write the basis and weight of n neighbours, and the factor of M = sum_k w_k b_k b_k^T; False if degenerate.

    basis : X_a, then STRETCH X_a X_b in the order 00, 10, 11, 20, 21, 22, (size, columns)
    near : (dim, columns), in units of the radius of the weight; weight : (columns,); work : (size, size)
    """
    size = len(work)
    for k in range(n):
        _fill_basis(basis, near, weight, k, axes)
    for r in range(size):
        for c in range(r + 1):
            total = 0.0
            for k in range(n):
                total += weight[k] * basis[r, k] * basis[c, k]
            work[r, c] = total
    return n >= size and cholesky(work, size)


@subkernel
def _fit_laplacian(out, i, near, du, weight, basis, work, pick, n, radius, axes):
    """Add the Laplacian of the weighted quadratic fit through 0 at i; near in units of the radius.

    The fit has the coefficients M^-1 sum_j w_j b_j du_j, and the Laplacian is twice the sum of those of the
    squares: one system M y = pick gives the coefficients w_j b_j . y of all components. Returns False,
    with nothing added, if M is degenerate.
    """
    dim, size = len(axes), len(work)
    if not factor_quadratics(work, basis, weight, near, n, axes):
        return False
    pick[:] = 0.0
    row = dim
    for a in range(dim):
        row += a
        pick[row] = 2.0 * STRETCH / radius**2
        row += 1
    cholesky_solve(work, pick, size)
    for k in range(n):
        c = 0.0
        for r in range(size):
            c += pick[r] * basis[r, k]
        for a in range(dim):
            out[i, a] += weight[k] * c * du[a, k]
    return True


@inlined
def _fill_basis(basis, near, weight, k, axes):
    """Write X_a, then STRETCH X_a X_b in the order 00, 10, 11, 20, 21, 22, and the quartic weight of column k."""
    row, q2 = len(axes), 0.0
    for a in range(len(axes)):
        q2 += near[a, k] ** 2
        basis[a, k] = near[a, k]
        for b in range(a + 1):
            basis[row, k] = STRETCH * near[a, k] * near[b, k]
            row += 1
    weight[k] = quartic_weight(q2, 1.0)


@kernel
def continue_to_walls(a: np.ndarray, x: np.ndarray, kind: np.ndarray, corner: np.ndarray, normal: np.ndarray,
                      radius: float, indptr: np.ndarray, indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Continue the normal part of an acceleration from the fluid to the walls, for n . (nu lap u) of Eq. 25.

    (Zheng, Ma & Duan 2014.) A wall takes the value at y = 0 of a linear fit over the distance y from it, with
    radius^2/10 added to the variance of y, as in `gradient.wall_velocity`. Corners, and walls without fluid in the
    radius, get zero.

    a : (n_all, dim) [m/s^2], of fluid given, rows of owned walls are written
    """
    dim, radius2 = len(axes), radius * radius
    for i in range(len(indptr) - 1):
        if kind[i] != WALL:
            continue
        a[i, :] = 0.0
        if corner[i]:
            continue
        s0, s1, s2, v0, v1 = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if kind[j] != FLUID:
                continue
            r2, y, value = 0.0, 0.0, 0.0
            for c in range(dim):
                d = x[j, c] - x[i, c]
                r2, y, value = r2 + d * d, y + d * normal[i, c], value + a[j, c] * normal[i, c]
            w = quartic_weight(r2, radius2)
            s0, s1, s2 = s0 + w, s1 + w * y, s2 + w * y * y
            v0, v1 = v0 + w * value, v1 + w * y * value
        if s0 > 0.0:
            mean = s1 / s0
            variance = s2 / s0 - mean * mean + 0.1 * radius2
            at_wall = v0 / s0 - mean * (v1 - mean * v0) / (s0 * variance)
            for c in range(dim):
                a[i, c] = at_wall * normal[i, c]
