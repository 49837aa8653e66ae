"""A drop in 3D: an ellipsoid of fluid, its sections, particles and volumes."""

import numpy as np
import pytest

from parisph import Box, Case, CaseError, Ellipsoid, Fluid, Numerics, Tank
from parisph.base.fields import SURFACE
from parisph.case.sections import section
from parisph.case.stored import from_json, to_json
from parisph.driver.sketch import sketch
from parisph.geometry import build

DROP = Ellipsoid(axes=(0.5, 0.4, 0.3), at=(1.0, 0.5, 0.6))


def scene(fluid, walls=None, spacing=0.1):
    return Case(title="drop", fluid=fluid, walls=walls, gravity=(0.0, 0.0, -9.81 if walls else 0.0),
                numerics=Numerics(spacing=spacing), end_time=0.1)


def test_its_numbers():
    assert DROP.volume == pytest.approx(4.0 / 3.0 * np.pi * 0.06, rel=1e-15)
    assert DROP.extent == pytest.approx((0.1, 0.9))
    np.testing.assert_allclose(DROP.bounds, [(0.5, 0.1, 0.3), (1.5, 0.9, 0.9)])
    ends = np.array(DROP.at) + np.diag(DROP.axes)
    assert DROP.inside(ends * (1.0 - 1e-12), 0.0).all() and not DROP.inside(ends + 1e-9, 0.0).any()
    assert DROP.inside(ends + 1e-9, 1e-8).all() and not DROP.inside(ends, -1.0).any()
    half = DROP.section(0.5 + 0.4 * 0.6)    # where the section has 0.8 of the half axes
    assert half.axes == pytest.approx((0.4, 0.24)) and half.at == (1.0, 0.6)
    assert DROP.slice_area(0.1, 0.9) == pytest.approx(DROP.area) == pytest.approx(DROP.volume / 0.8)


@pytest.mark.parametrize("axes, spacing", [((1.0, 1.0, 1.0), 0.2), ((1.0, 0.8, 0.53), 0.15)])
def test_a_drop_alone_makes_a_scene_3d_and_is_filled_about_its_centre(axes, spacing):
    case = scene(Fluid(Ellipsoid(axes=axes, at=(0.3, -0.2, 0.7)), 1000.0, velocity=("x", "y", "-2*z")), None, spacing)
    assert case.dim == 3 and case.breadth == pytest.approx((-0.2 - axes[1], -0.2 + axes[1]))
    found, shape = build.build(case), case.fluids[0].shape
    x = found["x"]
    np.testing.assert_allclose(x.mean(axis=0), shape.at, atol=1e-12)
    assert shape.inside(x, 0.02 * spacing).all()
    assert len(x) == pytest.approx(shape.volume / spacing**3, rel=0.05)
    np.testing.assert_allclose(found["u"], x * [1.0, 1.0, -2.0])
    deep = shape.inside(x, -1.1 * spacing)
    assert deep.any() and not (found["role"][deep] == SURFACE).any()
    assert build.volume(case) == pytest.approx(shape.volume, rel=1e-7)
    low, high = build.domain(case)
    total = sum(volume.sum() for _, volume in build.samples(case, low - 1.0, high + 1.0))
    assert total == pytest.approx(shape.volume, rel=1e-7)
    parts = [build.build(case, rank, 3)["x"] for rank in range(3)]
    np.testing.assert_array_equal(np.concatenate(parts), x)


def test_a_drop_over_water_in_a_tank():
    tank = Tank(width=2.0, height=1.2, breadth=1.0)
    case = scene((Fluid(Box(2.0, 0.2), 1000.0), Fluid(DROP, 1000.0)), tank)
    assert build.volume(case) == pytest.approx(0.4 + DROP.volume, rel=1e-7)
    assert section(case, 0.3, 0.3).fluids[1].shape == DROP.section(0.3)
    assert from_json(to_json(case)) == case
    assert "alike" not in sketch(case)


@pytest.mark.parametrize("make, message", [
    (lambda: Ellipsoid(axes=(1.0, 0.0, 1.0)), "greater than 0"),
    (lambda: scene(Fluid(DROP, 1000.0), Tank(2.0, 1.2)), "an Ellipsoid is for a 3D scene"),
    (lambda: scene(Fluid(DROP, 1000.0), Tank(2.0, 1.2, breadth=0.8)), "must lie within the scene"),
])
def test_refused(make, message):
    with pytest.raises(CaseError, match=message):
        make()
