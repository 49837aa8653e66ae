"""A tank whose walls are sticky and whose lid moves: what a case may say, and the wall particles that follow."""

import numpy as np
import pytest

from parisph import Case, CaseError, Lid, Tank
from parisph.base.fields import WALL
from parisph.geometry import build as geometry
from tests.scenes import water

S = 0.1


def cavity(**walls):
    """Return the Case of a full tank of 1 m x 1 m."""
    return water((1.0, 1.0), Tank(width=1.0, height=1.0, **walls), dict(preset="closed", spacing=S), density=1.0,
                 viscosity=0.01, gravity=(0.0, 0.0))


def walls(**options):
    """Return x (n, 2), no_slip (n,) and wall_u (n, 2) of the wall particles."""
    arrays = geometry.build(cavity(**options), 0, 1)
    wall = arrays["kind"] == WALL
    return arrays["x"][wall], arrays["no_slip"][wall], arrays["wall_u"][wall]


@pytest.mark.parametrize("options", [
    dict(lid=Lid(1.5), no_slip=True), dict(lid=Lid(velocity=-2.0), no_slip=("bottom", "left")),
    dict(lid=True, no_slip=False), dict(lid=Lid(0.0), no_slip=()),
])
def test_json_gives_the_same_tank_back(options):
    case = cavity(**options)
    again = Case.model_validate_json(case.model_dump_json())
    assert again == case and again.model_dump_json() == case.model_dump_json()
    assert type(again.walls.lid) is type(case.walls.lid) and again.closed


@pytest.mark.parametrize(("make", "message"), [
    (lambda: Tank(1.0, 1.0, lid=True, no_slip=("floor",)), r"Tank.no_slip.*floor"),
    (lambda: Tank(1.0, 1.0, lid=True, no_slip="left"), r"Tank.no_slip"),
    (lambda: Lid(), "Lid.velocity is missing"),
    (lambda: Lid("fast"), "Lid.velocity"),
    (lambda: Lid(float("nan")), "Lid.velocity"),
])
def test_what_a_tank_cannot_have(make, message):
    with pytest.raises(CaseError, match=message):
        make()


def test_a_lid_closes_a_tank_whatever_its_speed():
    assert Tank(1.0, 1.0, lid=Lid(0.0)).closed and Tank(1.0, 1.0, lid=True).closed and not Tank(1.0, 1.0).closed
    assert Tank(1.0, 1.0, no_slip=True).sticky == ("left", "right", "bottom", "top")
    assert Tank(1.0, 1.0, no_slip=("top",)).sticky == ("top",) and Tank(1.0, 1.0).sticky == ()


def test_the_ends_of_the_lid_rest_with_the_side_walls():
    x, no_slip, u = walls(lid=Lid(1.5), no_slip=True)
    lid = (x[:, 1] > 1.0 - 1e-9) & (x[:, 0] > 1e-9) & (x[:, 0] < 1.0 - 1e-9)
    assert np.count_nonzero(lid) == 9 and no_slip.all()
    np.testing.assert_array_equal(u[lid], [[1.5, 0.0]] * 9)
    assert not u[~lid].any()


def test_fluid_sticks_to_the_walls_that_are_named_and_to_their_corners():
    x, no_slip, u = walls(lid=True, no_slip=("bottom", "left"))
    named = (x[:, 0] < 1e-9) | (x[:, 1] < 1e-9)
    np.testing.assert_array_equal(no_slip == 1, named)
    assert not u.any()
    assert not walls(lid=True)[1].any()
