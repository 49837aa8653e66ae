"""Linear moving least squares in closed form."""

import numpy as np

from parisph.kernels.jit import inlined
from parisph.kernels.moments import PIVOT_FLOOR


@inlined
def moment_count(axes: tuple[int, ...]) -> int:
    """Return the number of moments up to the second: 6 in 2D, 10 in 3D."""
    dim = len(axes)
    return 1 + dim + dim * (dim + 1) // 2


@inlined
def linear_fit(fit: np.ndarray, moments: np.ndarray, at: np.ndarray, points: int, axes: tuple[int, ...]) -> int:
    """Write the coefficients of the shape functions at some points; return at how many of them the fit is linear.

    The value at a point p of the weighted linear fit is sum_k Phi_k f_k with Phi_k = (w_k/W) [1 - (x_k - mean) . C^-1
    (mean - p)], where W = sum w, mean = sum w x / W and C = sum w x x^T / W - mean mean^T. Here Phi_k = w_k (fit[0] +
    sum_a fit[1 + a] x_k[a]). Where the neighbours do not span the plane (3D: space), only the constant is kept
    (Shepard). The test uses the pivots of a Cholesky factor of C, which are ratios of its leading minors.

    fit : (1 + dim, points) output
    moments : (moment_count, points), sums of w, w x_a, and w x_a x_b in the order 00, 10, 11, ..., lengths in units of
        the radius of the weight
    at : (dim, points)
    """
    dim, linear = len(axes), 0
    for q in range(points):
        # the fit is zero if all weights are
        inverse = 1.0 / moments[0, q] if moments[0, q] > 0.0 else 0.0
        mx, my = moments[1, q] * inverse, moments[2, q] * inverse
        cxx = moments[dim + 1, q] * inverse - mx * mx
        cxy = moments[dim + 2, q] * inverse - mx * my
        cyy = moments[dim + 3, q] * inverse - my * my
        ax, ay = mx - at[0, q], my - at[1, q]
        minor = cxx * cyy - cxy * cxy
        spans = (cxx > PIVOT_FLOOR) & (minor > PIVOT_FLOOR * cxx)
        if dim == 2:
            scale = inverse / minor if spans else 0.0
            gx, gy = (cyy * ax - cxy * ay) * scale, (cxx * ay - cxy * ax) * scale
            fit[0, q] = inverse + mx * gx + my * gy
        else:
            mz = moments[3, q] * inverse
            cxz = moments[7, q] * inverse - mx * mz
            cyz = moments[8, q] * inverse - my * mz
            czz = moments[9, q] * inverse - mz * mz
            az = mz - at[2, q]
            dxx, dxy, dxz = cyy * czz - cyz * cyz, cxz * cyz - cxy * czz, cxy * cyz - cxz * cyy
            dyy, dyz = cxx * czz - cxz * cxz, cxy * cxz - cxx * cyz
            det = cxx * dxx + cxy * dxy + cxz * dxz
            spans &= det > PIVOT_FLOOR * minor
            scale = inverse / det if spans else 0.0
            gx = (dxx * ax + dxy * ay + dxz * az) * scale
            gy = (dxy * ax + dyy * ay + dyz * az) * scale
            gz = (dxz * ax + dyz * ay + minor * az) * scale
            fit[0, q] = inverse + mx * gx + my * gy + mz * gz
            fit[3, q] = -gz
        fit[1, q], fit[2, q] = -gx, -gy
        linear += spans
    return linear
