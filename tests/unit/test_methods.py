"""Methods: their names, and every choice of the step at work in a short fall of water."""

from types import SimpleNamespace

import numpy as np
import pytest

from parisph import Sway
from parisph.base import vocabulary
from parisph.base.fields import FLUID, INNER
from parisph.case.methods import METHODS
from parisph.case.schema import Box, Fluid, Numerics
from parisph.methods import parts as known
from parisph.methods import regularising, sources
from parisph.methods.catalogue import Parts
from parisph.methods.stepping import STEPPINGS
from parisph.methods.surfaces import classify
from tests.scenes import simulated, water


def test_every_method_that_a_case_may_ask_for_is_known():
    assert next(iter(METHODS)) == "ISPH_R", "the default"
    for name in METHODS:
        parts = Parts.of(Numerics(spacing=0.1, method=name).resolved())
        assert parts.reach >= 2.6 and parts.stages(closed=False)


def test_the_words_of_cases_are_those_of_the_parts():
    for registry in (known.LAPLACIANS, known.DIVERGENCES, known.GRADIENTS, known.SURFACE_GRADIENTS, known.WALL_ROWS,
                     known.SURFACES, known.SOURCES, known.FORCES, known.REGULARISERS):
        assert set(vocabulary.known(registry.what)) == set(registry)
    assert set(vocabulary.known("stepping")) == set(STEPPINGS)


def dam(**numerics):
    s = 0.05
    return water((0.5, 0.5), (1.5, 1.0, True), dict(spacing=s, **{"time_step": 0.004, **numerics}))


VARIANTS = [
    {}, {"method": "ISPH"}, {"method": "ISPH_R_printed"}, {"surface_rule": "auxiliary"}, {"surface_rule": "density"},
    {"gradient": "mixed"}, {"wall_rows": "harmonic", "surface_gradient": "harmonic"}, {"gamma": 0.01},
    {"gradient": "cubic", "surface_gradient": "same"}, {"regularisers": ("irrotational", "wall_guard", "shift_even")},
    {"zeta_time": 0.02}, {"stepping": "start"}, {"stepping": "predicted"}, {"stepping": "symplectic"},
    {"time_step": None}, {"kappa": 0.0, "shift": 0.0, "collision_distance": 0.0, "wall_guard": 0.0, "strain": 0.0},
]


@pytest.mark.parametrize("numerics", VARIANTS, ids=str)
def test_every_choice_makes_a_column_fall_freely_at_its_side(numerics):
    """Ten steps: water leaves the column, nothing sinks through the bed, and energy is about kept."""
    simulation = simulated(dam(**numerics))
    p = simulation.particles
    fluid = p.kind == FLUID
    energy = 9.81 * p.x[fluid, 1].sum()
    for _ in range(10):
        report = simulation.advance()
    fluid = p.kind == FLUID
    assert report.reason >= 0 and report.fallback == ""
    # symplectic Euler goes a dt^2 n (n + 1)/2 in n steps
    assert 0.0 < p.x[fluid, 0].max() - 0.5 < 9.81 * simulation.time * (simulation.time + simulation.dt)
    assert p.x[fluid, 1].min() > 0.0125 - 1e-12     # the wall guard of the preset, .25 s
    after = 0.5 * (p.u[fluid] ** 2).sum() + 9.81 * p.x[fluid, 1].sum()
    assert abs(after / energy - 1.0) < 0.01
    assert np.nanmax(p.p) < 1.05 * 9810.0 * 0.5


def test_relaxation_time_weakens_the_source_by_dt_over_it():
    pressures = []
    for numerics in ({}, {"zeta_time": 0.016}):
        simulation = simulated(dam(strain=0.0, **numerics))
        p = simulation.particles
        simulation.domain.refresh()
        p.u[:] = np.where((p.kind == FLUID)[:, None], -p.x, 0.0)
        simulation.method._predict(0.0, 0.004)
        simulation.domain.refresh()
        b = assembled(simulation, np.zeros_like(p.x_all), 0.004)
        pressures.append(b[p.role == INNER])
    np.testing.assert_allclose(pressures[1], 0.25 * pressures[0], rtol=1e-12)


def test_errors_of_opposite_signs_compensate_and_others_add_up(monkeypatch):
    """|e| d - |d| e beside div u* (Khayyer and Gotoh 2011): a density error that the divergence reduces is left alone.
    """
    e, before = np.array([0.1, -0.1, 0.1, -0.1]), np.array([0.5, 0.5, -0.5, -0.5])
    monkeypatch.setattr(sources, "compression", lambda flow: flow.particles.alpha - 1.0)
    flow = SimpleNamespace(density=1000.0, particles=SimpleNamespace(alpha=1.0 + e, n_owned=4, u_all=None),
                           rows=SimpleNamespace(div=np.full(4, 0.3), divergence=lambda out, u: np.copyto(out, before)))
    target = known.SOURCES["compensating"].target(flow, 0.01)
    np.testing.assert_allclose(target * 0.01 / 1000.0, [0.3, 0.4, 0.2, 0.3])


def test_weakly_compressible_fluid_follows_a_force_that_grows_evenly():
    """In free flight, velocity Verlet is exact: it takes the force at both ends of the step."""
    s = simulated(water((0.5, 0.5), None, dict(spacing=0.1, method="SPH"), gravity=("0", "-40*t")), 5)
    np.testing.assert_allclose(s.particles.u, np.tile([0.0, -20.0 * s.time**2], (s.particles.n_owned, 1)), rtol=1e-9)


def assembled(simulation, force, dt):
    """Return the right-hand side of a step of dt with a body force (n_all, dim)."""
    method = simulation.method
    method.flow.step.force = method.flow.step.body_force = force
    classify(method.flow, method.parts.surface, dt)
    return method._assemble(dt)[1]


def source(velocity, dt, residual_strain, force=0.0, strain=0.0):
    """Return the right-hand sides of inner particles over 1/dt, for a velocity (x) -> (n, dim) of the fluid in a column
    at rest."""
    simulation = simulated(dam(strain=strain, residual_strain=residual_strain))
    p, method = simulation.particles, simulation.method
    simulation.domain.refresh()
    p.u[:] = np.where((p.kind == FLUID)[:, None], velocity(p.x), 0.0)
    method._predict(0.0, 0.0)
    simulation.domain.refresh()
    b = assembled(simulation, force * p.x_all, dt)
    deep = (p.role == INNER) & (np.abs(p.x - [0.25, 0.25]).max(axis=1) < 0.13)
    return dt * b[deep]


def test_a_short_step_removes_the_residual_divergence_in_proportion_to_its_strain():
    """u = -x turns over at the rate 2: 1 % of it per step removes all of the residual, a tenth of that a tenth."""
    whole = source(lambda x: -x, 0.005, 0.0)
    assert np.abs(whole).min() > 0.0
    np.testing.assert_allclose(source(lambda x: -x, 0.02, 100.0), whole, rtol=1e-9)
    # and what the flow has done to its volume since the last step, dt tr(G^2)
    short = source(lambda x: -x, 0.0005, 100.0)
    np.testing.assert_allclose(short, (0.1 + 0.9 * 0.0005) * whole, rtol=1e-9)


def test_what_a_force_and_the_flow_itself_do_is_removed_at_once():
    forced = [source(lambda x: 0.0 * x, 1e-4, most, force=-1.0) for most in (0.0, 10.0)]
    np.testing.assert_allclose(forced[1], forced[0], rtol=1e-9)

    def strained(x):
        # at the middle of a step of 1e-3 with straight lines, of a flow that had the divergence of the strain source
        # before
        g = np.array([[1.0, 0.0], [0.0, -1.0]])
        return x @ (g - 0.5e-3 * np.eye(2)).T
    flows = [source(strained, 1e-3, most, strain=1.0) for most in (0.0, 10.0)]
    np.testing.assert_allclose(flows[1], flows[0], rtol=2e-3)


def test_particles_remember_the_volume_that_they_have_made_where_a_case_asks_for_it():
    simulation = simulated(dam(volume_time=20.0), 2)
    expansion, left = simulation.particles.expansion, simulation.particles.left
    assert np.any(expansion != 0.0) and np.abs(expansion).max() < 0.01 and np.any(left != 0.0)
    # of fluid at rest, .3 % in 20 sqrt(s/g), in four long steps at least
    flow, inner = simulation.method.flow, simulation.particles.role == INNER
    simulation.particles.u_all[:] = 0.0
    left[:] = 0.0
    flow.rows.fill(simulation.particles.u_all, flow.cloud, flow.cells)
    for dt, time in ((1e-6, 20.0 * np.sqrt(0.05 / 9.81)), (10.0, 40.0)):
        found = []
        for start in (0.0, 0.003):
            expansion[:] = start
            found.append(simulation.method.parts.source.target(flow, dt))
        np.testing.assert_allclose((found[1] - found[0])[inner] * dt / 1000.0, 0.003 / time, rtol=1e-6)
    assert not {"expansion", "left"} & set(Parts.of(Numerics(spacing=0.1).resolved()).fields)


@pytest.mark.parametrize("changes", [{}, {"frame": Sway(0.1, 2.0)}, {"gravity": ("-x*t", -9.81)},
                                     {"gravity": ("x", "-9.81*cos(t)"), "frame": Sway(0.1, 2.0)}], ids=str)
def test_particles_feel_the_body_force_of_the_case(changes):
    case = dam().changed(**changes)
    simulation = simulated(case)
    x = np.array([[0.1, 0.2], [0.4, 0.3], [0.2, 0.9]])
    for t in (0.0, 0.7):
        found = simulation.method.flow.body(x, t)
        assert found.shape == x.shape
        np.testing.assert_allclose(found, case.body_force(x, t), rtol=1e-14)


def test_position_projection_spreads_what_is_too_dense():
    simulation = simulated(dam(kappa=1.0, shift=0.0, wall_guard=0.0, time_step=0.001))
    p = simulation.particles
    simulation.advance()
    middle = (p.kind == FLUID) & (np.abs(p.x - [0.25, 0.25]).max(axis=1) < 0.13)
    p.x[middle] += 0.12 * ([0.25, 0.25] - p.x[middle])
    p.u[:] = 0.0
    simulation.domain.refresh()
    flow, parts = simulation.method.flow, simulation.method.parts
    assembled(simulation, np.zeros_like(p.x_all), 0.001)
    before = p.alpha.copy()
    simulation.method.start(0.0)
    flow.step.strained, flow.step.rapid = np.ones((2, p.n_owned))
    regularising.prepare(flow, parts.position_regularisers, 0.001)
    regularising.change(flow, parts.position_regularisers, 0.001)
    simulation.domain.refresh()
    classify(flow, parts.surface, 0.001)
    inner = middle & (before > 1.02)
    assert inner.sum() > 4
    assert (p.alpha[inner] - 1.0).mean() < 0.6 * (before[inner] - 1.0).mean()
    assert np.all(p.u == 0.0)


@pytest.mark.parametrize("closed", [False, True])
def test_a_method_sets_what_it_says_unless_the_case_does(closed):
    for name, method in METHODS.items():
        case = dam(method=name, restitution=0.7)
        if closed:
            case = case.changed(fluid=Fluid(Box(width=1.5, height=1.0), density=1000.0))
        found = case.complete_numerics()
        due = {**method.values, **({"surface_rule": "none"} if closed else {})}
        assert {key: getattr(found, key) for key in due} == due and found.restitution == 0.7, name
