"""Observed orders of the pressure gradients, of the wall rows and of the flux divergence."""

from functools import lru_cache

import numpy as np
import pytest

from parisph.base.fields import INNER, SURFACE, WET
from parisph.kernels import gradient, rankine, walls
from parisph.kernels.circle import Circle
from parisph.kernels.near import SPLINE, SPLINE_SLOPE, Form
from parisph.methods.lengths import CIRCLE, MLS, SPH, WALL
from tests.manufactured import orders
from tests.pools import Rows, block, nowhere, tank

CELLS = (20, 40, 80)

# weight, radius in spacings and floor of the least-squares gradients: Zheng et al. (2017), Eqs. 29, 28, 28 with
# the cubic spline, and 26
LEAST_SQUARES = {"sfdi": (2, MLS, 0.2), "mixed": (0, WALL, 0.05),
                 "mixed_spline": (SPLINE, 2.0 * SPH, 0.05), "corrected": (SPLINE_SLOPE, 2.0 * SPH, 0.05)}


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def rates(errors):
    """Return the observed orders between successive resolutions."""
    return orders(1.0 / np.array(CELLS), errors)


def rate(errors):
    """Return the observed order from the first to the last resolution: on disordered particles a mean."""
    return float(orders(1.0 / np.array(CELLS)[[0, -1]], np.asarray(errors)[[0, -1]])[0])


def middle(x):
    """Return which points lie well inside the unit square, whatever the resolution."""
    return np.abs(x - 0.5).max(axis=1) < 0.29


# -- gradients of exp(2x + 3y) ------------------------------------------------------------------------


def exponential(x):
    f = np.exp(2.0 * x[:, 0] + 3.0 * x[:, 1])
    return f, f[:, None] * [2.0, 3.0]


@lru_cache(maxsize=None)
def gradient_errors(name, jitter, where="inside"):
    """Return the relative rms error of a gradient of the unit square's particles, one for each resolution."""
    found = []
    for cells in CELLS:
        s = 1.0 / cells
        pool = block(2, cells + 1, jitter, s, reach=3.6)
        f, exact = exponential(pool.x)
        out, sound = np.empty_like(pool.x), True
        if name == "symmetric":
            gradient.symmetric_gradient(out, pool.cloud, f, SPH * s, s * s)
        else:
            power, radius, floor = LEAST_SQUARES[name]
            gradient.least_squares_gradient(out, nowhere(out), pool.cloud, f, Form(radius * s, power, floor))
            if jitter > 1.0:    # below the floor the slope is damped: no order
                sound = pool.quality(radius * s, max(power, 0)) >= floor
        chosen = (middle(pool.x) if where == "inside" else ~pool.far_inside(1)) & (pool.role == INNER) & sound
        found.append(rms(out[chosen] - exact[chosen]) / rms(exact[chosen]))
    return np.array(found)


@pytest.mark.parametrize("name", list(LEAST_SQUARES))
def test_least_squares_gradients_inside(name):
    # symmetric neighbourhoods cancel the second derivatives; disorder leaves the first order
    assert np.all(rates(gradient_errors(name, 0.0)) >= 1.9)
    for k in (0.4, 0.8, 1.2):
        assert rate(gradient_errors(name, k)) >= 0.9
        assert gradient_errors(name, k)[-1] < 0.01


@pytest.mark.parametrize("name", list(LEAST_SQUARES))
def test_least_squares_gradients_at_the_rim(name):
    for k in (0.0, 0.8):
        assert rate(gradient_errors(name, k, "rim")) >= 0.9


def test_symmetric_gradient_does_not_converge_on_disordered_particles():
    # Zheng et al. 2017, Fig. 3: it grows as the spacing shrinks, for p_i sum grad W is not zero
    lattice, disordered = gradient_errors("symmetric", 0.0), gradient_errors("symmetric", 0.8)
    assert lattice[-1] < 0.02 and np.all(rates(disordered) < -0.8)
    assert np.all(disordered > 20.0 * gradient_errors("sfdi", 0.8))


def test_sfdi_has_the_smallest_error_on_the_lattice():
    for name in ("mixed", "mixed_spline", "corrected"):
        assert gradient_errors("sfdi", 0.0)[-1] < gradient_errors(name, 0.0)[-1]


# -- derivatives of a harmonic pressure at walls and surface --------------------------------------------


def harmonic_pressure(x):
    f = np.exp(2.0 * x[:, 1]) * np.cos(2.0 * x[:, 0] + 0.3)
    return f, np.stack([-2.0 * np.exp(2.0 * x[:, 1]) * np.sin(2.0 * x[:, 0] + 0.3), 2.0 * f], axis=1)


@lru_cache(maxsize=None)
def wall_errors(kind, jitter):
    """Return the rms errors of n . grad p at the walls and in the corners, over rms |grad p|: (2, resolutions)."""
    found = []
    for cells in CELLS:
        s = 1.0 / cells
        pool = tank((cells, cells), lid=True, jitter=jitter, spacing=s)
        rows = Rows(pool)
        walls.sfdi_rows(rows.matrix, pool.cloud, WALL * s)
        if kind == "harmonic":
            walls.harmonic_rows(rows.matrix, pool.cloud, WALL * s, np.inf)
        f, grad = harmonic_pressure(pool.x)
        wet = pool.role == WET
        error = rows.applied(f)[wet] / -rows.measure[wet] - (pool.normal * grad).sum(axis=1)[wet]
        corner = pool.corner[wet] == 1
        found.append([rms(error[~corner]), rms(error[corner])] / np.array(rms(np.linalg.norm(grad[wet], axis=1))))
    return np.array(found).T


@pytest.mark.parametrize(("kind", "order"), [("sfdi", 1.0), ("harmonic", 2.0)])
@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_order_of_wall_rows(kind, order, jitter):
    for errors in wall_errors(kind, jitter):
        assert rate(errors) >= order - 0.1


@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_harmonic_wall_rows_are_more_accurate(jitter):
    assert np.all(wall_errors("harmonic", jitter)[:, -1] < 0.2 * wall_errors("sfdi", jitter)[:, -1])


@lru_cache(maxsize=None)
def surface_errors(jitter, harmonic):
    found = []
    for cells in CELLS:
        s = 1.0 / cells
        pool = tank((cells, cells), jitter=jitter, spacing=s)
        f, exact = harmonic_pressure(pool.x)
        out = np.empty_like(pool.x)
        gradient.least_squares_gradient(out, nowhere(out), pool.cloud, f, Form(WALL * s, 0, 0.05))
        if harmonic:
            gradient.harmonic_gradient(out, pool.cloud, f, WALL * s, np.inf, np.inf)
        surface = pool.role == SURFACE
        found.append(rms(out[surface] - exact[surface]) / rms(exact[surface]))
    return np.array(found)


@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_order_of_the_surface_gradient(jitter):
    first, second = surface_errors(jitter, False), surface_errors(jitter, True)
    assert rate(first) == pytest.approx(1.0, abs=0.1) and rate(second) >= 1.9
    assert second[-1] < 0.2 * first[-1]


# -- flux divergence ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("jitter", "order"), [(0.0, 1.9), (0.4, 0.9), (0.8, 0.9)])
def test_order_of_the_flux_divergence(jitter, order):
    found = []
    for cells in CELLS:
        s = 1.0 / cells
        pool = block(2, cells + 1, jitter, s)
        u = np.stack([np.sin(3.0 * pool.x[:, 0] + pool.x[:, 1]), np.cos(pool.x[:, 0] * 2.0 - pool.x[:, 1])], axis=1)
        exact = 3.0 * np.cos(3.0 * pool.x[:, 0] + pool.x[:, 1]) + np.sin(pool.x[:, 0] * 2.0 - pool.x[:, 1])
        rows = Rows(pool)
        rankine.rankine_rows(rows.matrix, rows.flux, pool.cloud, u,
                             Circle(rankine.directions(2), CIRCLE * s, MLS * s), True)
        found.append(rms((rows.div - exact)[middle(pool.x)]))
    assert rate(found) >= order
