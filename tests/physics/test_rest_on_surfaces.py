"""Water at rest above and around Surfaces stays at rest."""

import numpy as np
import pytest

from parisph import Case, Fluid, Numerics, StillWater, Surface, Tank
from parisph.base.fields import FLUID
from tests.scenes import simulated
from tests.triangles import LIBRARIES, sheet, sphere, write_stl

for name in LIBRARIES:
    pytest.importorskip(name, reason=f"{name} is not installed: pip install 'parisph[surfaces]'")

DEPTH, G = 0.6, 9.81
SURFACES = {
    "bed": (sheet(lambda x, y: 0.25 + 0.15 * np.sin(3.0 * x) * np.cos(2.0 * y), (0.0, 0.0), (1.2, 0.8), (24, 16)), 1.2),
    "rock": (sphere(4, 0.2, (0.4, 0.4, 0.1)), 0.8),    # and the width of the tank [m]
}


@pytest.mark.parametrize(("name", "preset"), [("bed", "violent"), ("rock", "gentle")])
def test_water_stays_at_rest(tmp_path, name, preset):
    surface, width = SURFACES[name]
    case = Case(
        title="Rest", fluid=Fluid(StillWater(level=DEPTH), 1000.0), gravity=(0.0, -G), end_time=10.0,
        walls=[Tank(width=width, height=0.8, breadth=0.8),
               Surface(file=str(write_stl(tmp_path / "a.stl", surface)))],
        numerics=Numerics(spacing=0.1, preset=preset, jitter=0.4, rtol=1e-12))
    s = simulated(case)
    s.solve_start()
    for _ in range(10):
        s.advance()
    p = s.particles
    fluid = p.kind == FLUID
    assert np.abs(p.u[fluid]).max() < 1e-9 * np.sqrt(G * DEPTH)
    exact = 1000.0 * G * (DEPTH - p.x[fluid, 2])
    np.testing.assert_allclose(p.p[fluid], exact, rtol=0.0, atol=1e-8 * 1000.0 * G * DEPTH)
    assert exact.max() > 0.5 * 1000.0 * G * DEPTH
