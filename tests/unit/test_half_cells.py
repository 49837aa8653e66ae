"""Surface particles that stand for half a cell: p = 0 is at their centres, else half a layer outside."""

import numpy as np
import pytest

from parisph import Case, Fluid, Numerics, Obstacle, Polygon, StillWater, Tank
from parisph.base.fields import FLUID, SURFACE
from parisph.kernels.surface_rows import FULL, HALF
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
