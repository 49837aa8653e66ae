"""Surface particles that stand for half a cell: p = 0 is at their centres, else half a layer outside."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from parisph import Box, Case, Fluid, Numerics, Obstacle, Polygon, StillWater, Tank
from parisph.base.fields import DRY, FLUID, SURFACE, WALL, WET
from parisph.kernels import wetness
from parisph.kernels.surface_rows import FULL, HALF
from parisph.methods import filling
from parisph.methods.boundary import Boundary
from parisph.methods.surfaces import classify
from tests.pools import filled
from tests.scenes import simulated

S = 0.05
SLOPE = Obstacle(Polygon([(0.9, 0.0), (1.5, 0.0), (1.5, 0.5)]))


def surface_of(shape, *walls):
    """Return places (n, 2) and cells (n,) of the surface particles of a shape at its start."""
    case = Case(title="half cells", fluid=Fluid(shape, density=1000.0), walls=[Tank(1.5, 1.0), *walls],
                gravity=(0.0, -9.81), numerics=Numerics(spacing=S), end_time=1.0)
    s = simulated(case)
    p, flow = s.particles, s.method.flow
    surface = (p.kind == FLUID) & (p.role == SURFACE)
    return p.x[surface], flow.walls.cells(flow)[:p.n_owned][surface]


@pytest.mark.parametrize("walls", [(), (SLOPE,)])
def test_level_water_has_halves_up_to_its_walls(walls):
    """Also the last particle before a slope, which has the tip of the water as well."""
    x, cells = surface_of(StillWater(0.4), *walls)
    assert (cells < HALF).all() and len(x) > 20


@pytest.mark.parametrize("walls", [(), (SLOPE,)])
def test_a_column_has_full_cells_down_to_its_foot(walls):
    """Its sides are half a spacing outside the last particles. With p = 0 at those of the foot it gains energy."""
    x, cells = surface_of(Polygon([(0.475, 0.0), (0.725, 0.0), (0.725, 0.6), (0.475, 0.6)]), *walls)
    side = x[:, 1] < 0.5
    assert (cells[side] > FULL).all() and np.count_nonzero(side) > 15


def on_lattice(cells, level):
    """Return a flow of water up to a layer of a tank of so many cells, as far as half cells need it, and its pool."""
    pool = filled(cells, level)
    pool.role[(pool.kind == WALL) & (pool.index[:, -1] >= level)] = DRY
    top, s = np.array(cells), pool.spacing
    wide = 1.0 + 0.5 * (pool.index == 1) + 0.5 * (pool.index == top - 1)
    wide[:, -1] = np.where(pool.index[:, -1] == level, 0.5, np.where(pool.index[:, -1] == 1, 1.5, 1.0))
    flat = pool.index == 0
    flat[:, :-1] |= pool.index[:, :-1] == top[:-1]
    weight = 0.5 ** flat.sum(axis=1)
    covered = np.empty(pool.n)
    wetness.covered_walls(covered, pool.cloud)
    p = SimpleNamespace(kind_all=pool.kind, role_all=pool.role, x_all=pool.x, x=pool.x, n_owned=pool.n, n_all=pool.n,
                        dim=pool.dim, weight_all=weight, covered_all=covered, edge_all=0, share_all=np.ones(pool.n),
                        half=np.zeros(pool.n, np.int8), beside=np.full(pool.n, np.nan))
    claimed = partial(Boundary.claimed_at_start, None)
    flow = SimpleNamespace(particles=p, spacing=s, half_cells=True, cloud=pool.cloud,
                           cells=np.where(pool.fluid, wide.prod(axis=1), 0.0),
                           domain=SimpleNamespace(update=lambda *names: None),
                           walls=SimpleNamespace(cover=lambda flow: (), claimed_at_start=claimed))
    return flow, pool


@pytest.mark.parametrize("cells", [(6, 8), (6, 5, 8), (2, 2, 8)])
def test_level_water_in_a_tank_has_halves_in_its_corners_too(cells):
    """In a corner of 3D a particle has 9/8 of a cell, in a tank two cells wide 2: all on the level are halves."""
    flow, pool = on_lattice(cells, 5)
    surface = pool.fluid & (pool.role == SURFACE)
    assert flow.cells[surface].max() == pytest.approx({2: 0.75, 3: 2.0 if cells[0] == 2 else 1.125}[len(cells)])
    filling.halve_on_lattice(flow)
    np.testing.assert_array_equal(flow.particles.half == 1, surface)
    # what each represents at walls is remembered: all but its own cell, at the water line nothing
    expected = np.where(surface, 0.0, flow.cells - 1.0)
    np.testing.assert_allclose(flow.particles.beside, np.where(pool.fluid, expected, 0.0), atol=1e-6)


@pytest.mark.parametrize(("breadth", "near"), [(None, 0.002), (0.6, 0.003)])
def test_fluid_is_as_dense_as_water_with_the_half_cells_of_its_walls_or_half_a_spacing_nearer_without(breadth, near):
    """One spacing from a wall as at the start, half a spacing from it where no fluid represents the half cells."""
    case = Case(title="half cells", fluid=Fluid(Box(0.6, 0.6, breadth=breadth), density=1000.0), end_time=1.0,
                walls=Tank(0.6, 1.0, breadth=breadth), gravity=(0.0, -9.81), numerics=Numerics(spacing=0.1))
    s = simulated(case)
    p, flow, up, fluid = s.particles, s.method.flow, s.particles.dim - 1, s.particles.kind == FLUID
    middle = fluid & (np.abs(p.x[:, :up] - 0.3) < 0.05).all(axis=1) & (p.x[:, up] < 0.35)
    for lower in (0.0, 0.05):
        p.x[fluid, up] -= lower
        if lower:
            p.beside[:] = 0.0
        s.domain.refresh()
        flow.step.force = np.zeros_like(p.x_all)
        flow.step.force[:, up] = -9.81
        classify(flow, s.method.parts.surface, 1e-3)
        ratio = np.full(p.n_owned, np.nan)
        slope = flow.walls.density(ratio, flow, wetness.FREE)
        np.testing.assert_allclose(ratio[middle], 1.0, atol=near)
        np.testing.assert_allclose(0.1 * slope[middle], 0.0, atol=2.0 * near)
    assert np.count_nonzero(middle) == 3


@pytest.mark.parametrize("gap", [0.3, 1.0, 1.4])
def test_fluid_represents_no_half_cells_of_a_lid_above_it(gap):
    """They are air, though the lid is covered: it is nearer than the end of the first layer."""
    layers = 10 - int(np.ceil(gap))
    water = Fluid(Box(1.0, 0.1 * layers), density=1000.0, elevation=0.1 * (10 - layers - gap))
    case = Case(title="half cells", fluid=water, walls=Tank(1.0, 1.0, True), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=0.1), end_time=1.0)
    p = simulated(case).particles
    top = (p.kind == FLUID) & (p.role == SURFACE) & (np.abs(p.x[:, 0] - 0.5) < 0.35)
    assert np.count_nonzero(top) > 5 and np.abs(p.beside[top]).max() < 1e-12
    wet = int(np.ceil(10 - gap)) - 1    # nodes of each side below the surface
    assert p.beside.sum() == pytest.approx(0.5 * 9 + 0.25 * 2 + 0.5 * 2 * wet, rel=1e-6 if gap == 1.0 else 0.03)


def test_fluid_takes_up_half_cells_of_a_dry_bed_but_not_of_a_lid_that_it_does_not_touch():
    case = Case(title="half cells", fluid=Fluid(Box(0.5, 0.9), density=1000.0), walls=Tank(1.0, 1.0, True),
                gravity=(0.0, -9.81), numerics=Numerics(spacing=0.1), end_time=1.0)
    s = simulated(case)
    s.solve_start()
    p, claimed = s.particles, s.method.flow.walls.claimed(s.method.flow)[:s.particles.n_owned]
    lid = (p.kind == WALL) & (p.x[:, 1] == 1.0)
    assert np.all(p.role[lid] != WET) and not claimed[lid & ~on_sides(p.x)].any()
    bed = (p.kind == WALL) & (p.x[:, 1] == 0.0)
    assert np.any(p.role[bed] == DRY)
    np.testing.assert_array_equal(claimed[bed], p.weight[bed])


def on_sides(x):
    return (x[:, 0] == 0.0) | (x[:, 0] == 1.0)


def test_packed_water_carries_hardly_any_half_cells_at_its_start():
    """Not one on a slope either: the steps measure what is beside walls as the start did."""
    case = Case(title="half cells", fluid=Fluid(StillWater(0.4), density=1000.0), walls=[Tank(1.5, 1.0), SLOPE],
                gravity=(0.0, -9.81), numerics=Numerics(spacing=S), end_time=1.0)
    s = simulated(case)
    s.solve_start()
    p = s.particles
    wet = (p.kind == WALL) & (p.role == WET)
    assert p.spare.sum() < 0.03 * p.beside.sum()
    assert p.share[wet].mean() == pytest.approx(1.0, abs=0.02) and np.count_nonzero(wet) > 30
