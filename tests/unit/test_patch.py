"""Operators on fields with known derivatives: what is exact, known orders, solutions, and the papers' norms."""

import numpy as np
import pytest

from parisph.base.errors import CaseError
from parisph.base.fields import SURFACE, WET
from parisph.methods.parts import GRADIENTS, LAPLACIANS
from parisph.patch import arrangement, derivatives
from parisph.patch.analytic import FIELD_OF, AnalyticField
from parisph.patch.solution import solution
from parisph.truth import norms

LINEAR = AnalyticField("linear", lambda x: 2.0 - x[:, 0] + 3.0 * x[:, 1], lambda x: np.tile([-1.0, 3.0], (len(x), 1)),
                       lambda x: np.zeros(len(x)))
OUTSIDE_LAPLACIANS = [name for name in LAPLACIANS if LAPLACIANS[name].linear]


def inside(a, margin=0.2):
    return a.inside & np.all(np.abs(a.x - 0.5) < 0.5 - margin, axis=1)


# -- fields -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", list(FIELD_OF))
def test_derivatives_of_the_fields_are_theirs(name, dim):
    FIELD_OF[name].check(dim, ("gradient", "laplacian"))


@pytest.mark.parametrize(("fields", "says"), [
    (dict(gradient=lambda x: x), "its gradient is not that of its value"),
    (dict(laplacian=lambda x: np.full(len(x), 5.0)), "its laplacian is not that of its value: 5.0 instead of"),
    (dict(laplacian=lambda x: 4.0), "returns an array of shape ()"),
    (dict(laplacian=lambda x: x[:, 7]), "its laplacian fails: IndexError"),
    (dict(laplacian=lambda x: np.full(len(x), np.nan)), "is not finite"),
    (dict(), "has no laplacian=: give the function"),
])
def test_a_wrong_field_is_one_clear_error(fields, says):
    field = AnalyticField("mine", lambda x: (x**2).sum(axis=1), **fields)
    with pytest.raises(CaseError) as error:
        field.check(2, tuple(fields) or ("laplacian",))
    assert says in str(error.value) and "'mine'" in str(error.value) and "\n" not in str(error.value)


# -- arrangements -----------------------------------------------------------------------------------------


def test_disorder_is_that_of_the_papers():
    lattice, moved = arrangement.block(10, 0.0, 1), arrangement.block(10, 0.8, 1)
    assert len(lattice.x) == 100
    assert np.allclose(lattice.x.min(axis=0), 0.05) and np.allclose(lattice.x.max(axis=0), 0.95)
    shift = (moved.x - lattice.x) / 0.1
    assert np.abs(shift).max() <= 0.4 and np.abs(shift).max() > 0.35 and abs(shift.mean()) < 0.05
    assert not np.array_equal(moved.x, arrangement.block(10, 0.8, 2).x)


def test_layers_around_the_square_are_known_and_no_unknowns():
    a = arrangement.block(8, 0.0, 1, layers=3, centred=False)
    assert len(a.x) == 15**2 and a.inside.sum() == 7**2 and np.all(a.role[~a.inside] == SURFACE)


# -- exactness and order ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "jitter", "field", "due"), [
    *((name, 0.8, LINEAR, 0.0) for name in OUTSIDE_LAPLACIANS),
    *((name, 1.2, FIELD_OF["parabola"], 4.0) for name in ("gfd", "fatehi"))])
def test_laplacian_of_a_linear_field_and_of_a_parabola_are_exact_on_disordered_particles(name, jitter, field, due):
    a = arrangement.block(20, jitter, 3)
    found = derivatives.discrete(a, name).derivative(field.values(a.x))[inside(a)]
    np.testing.assert_allclose(found, due, rtol=1e-8, atol=0.0 if due else 1e-9 * 20**2)


@pytest.mark.parametrize("name", [name for name in GRADIENTS if name != "symmetric"])
def test_gradient_of_a_linear_field_is_exact_in_the_order_of_the_arrangement(name):
    a = arrangement.block(20, 0.8, 3)
    found = derivatives.gradient(a, LINEAR.values(a.x), name)
    np.testing.assert_allclose(found[inside(a, 0.1)], np.tile([-1.0, 3.0], (inside(a, 0.1).sum(), 1)), atol=1e-11)


def test_symmetric_gradient_of_a_linear_field_is_not_exact():
    a = arrangement.block(20, 0.8, 3)
    assert np.abs(derivatives.gradient(a, LINEAR.values(a.x), "symmetric") - [-1.0, 3.0])[inside(a)].max() > 1.0


def test_laplacian_of_the_wave_is_of_second_order_on_the_lattice():
    field, errors = FIELD_OF["wave"], []
    for cells in (30, 60):
        a = arrangement.block(cells, 0.0, 1)
        found = derivatives.discrete(a, "rankine").derivative(field.values(a.x))[inside(a)]
        errors.append(norms.relative_l2_linf(found, field.laplacians(a.x)[inside(a)])[0])
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_walls_and_particles_without_neighbours_have_no_gradient():
    a = arrangement.tank([8, 8], 0.0, 1, spacing=1.0 / 8)
    found = derivatives.gradient(a, FIELD_OF["parabola"].values(a.x), "mixed", "harmonic")
    assert np.isfinite(found[a.kind == 0]).all() and np.isnan(found[a.kind == 1]).all()


# -- solutions --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lid", [False, True])
@pytest.mark.parametrize("jitter", [0.0, 0.8])
def test_solution_between_walls_is_exact_for_a_linear_field(lid, jitter):
    a = arrangement.tank([12, 12], jitter, 5, lid, spacing=1.0 / 12)
    f = LINEAR.values(a.x)
    p = solution(derivatives.discrete(a, "rankine", "sfdi"), f, LINEAR.laplacians(a.x), LINEAR.gradients(a.x))
    error = (p - f)[a.inside | (a.role == WET)]
    assert np.ptp(error) < 1e-6 and (lid or np.abs(error).max() < 1e-6)


def test_solution_with_harmonic_walls_is_of_second_order_for_harmonic_pressure():
    field, errors = FIELD_OF["harmonic"], []
    for cells in (20, 40):
        a = arrangement.tank([cells, cells], 0.0, 1, spacing=1.0 / cells)
        f = field.values(a.x)
        p = solution(derivatives.discrete(a, "gfd", "harmonic"), f, field.laplacians(a.x), field.gradients(a.x))
        errors.append(norms.relative_l2_linf(p[a.inside], f[a.inside])[0])
    assert np.log2(errors[0] / errors[1]) > 1.8 and errors[1] < 2e-4


# -- norms ------------------------------------------------------------------------------------------------


def test_norms_of_the_papers():
    error = np.full(3600, 0.3)
    assert norms.z14_er(error, 2.0, 1e-4) == pytest.approx(0.15 * 0.6), "the window has an area of 0.36"
    assert norms.z14_er_max(np.array([-3.0, 1.0]), 2.0) == 1.5
    assert norms.z17_er(error) == pytest.approx(0.3 / 60.0), "it falls with the number of particles"
    l2, largest = norms.relative_l2_linf(np.array([[3.0, 4.0], [0.0, 0.0]]), np.array([[3.0, 0.0], [0.0, 5.0]]))
    assert l2 == pytest.approx(np.sqrt((16.0 + 25.0) / (9.0 + 25.0))) and largest == pytest.approx(1.0)
