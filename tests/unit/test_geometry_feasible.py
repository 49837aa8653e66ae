"""Scenes that will not work, and what is said about them."""

import numpy as np
import pytest

from parisph import Box, Disc, Polygon, Tank
from parisph.case.bodies import Obstacle, Plate, Profile, StillWater
from parisph.geometry.feasible import faults, thinnest_gap, warnings
from parisph.geometry.mesh import wall_mesh
from parisph.geometry.polygons import joined
from parisph.geometry.solid import solid_of

S = 0.05
TANK = Tank(3.0, 1.0)


def findings(walls, fluids):
    walls = tuple(walls)
    found = faults(walls, fluids, S, [()] * len(fluids), [f"fluid[{number}]" for number in range(len(fluids))])
    return [*found, *(warnings(walls, fluids, S) if walls and "inside another" not in "".join(found) else [])]


@pytest.mark.parametrize(("walls", "fluids"), [
    ([TANK], [Box(1.0, 0.5)]),
    ([Tank(3.0, 1.0, lid=True)], [StillWater(0.7)]),
    ([TANK, Obstacle(Polygon([(1.0, 0.0), (1.2, 0.2), (1.8, 0.2), (2.0, 0.0)]))], [Box(0.8, 0.5)]),
    ([Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (3.0, 1.1)])], [StillWater(0.8)]),
    ([TANK, Obstacle(Disc(0.2, at=(1.5, 0.5))), Plate([(2.2, 0.0), (2.2, 0.6)])], [StillWater(0.8)]),
    ([TANK, Obstacle(Box(0.5, 0.3, at=(1.0, -0.1))), Obstacle(Box(0.3, 0.5, at=(1.1, 0.0)))], [StillWater(0.8)]),
    *(([Profile([(0.0, 1.0), (0.0, 0.0), (foot, 0.0), (foot + 1.0 / np.tan(np.pi / 12.0), 1.0)])], [StillWater(0.8)])
      for foot in (1.0, 1.5, 2.1)),    # wedges of 15 degrees, but for rounding
    ([], [Disc(0.5)]),
])
def test_sound_scenes_have_no_findings(walls, fluids):
    assert findings(walls, fluids) == []


@pytest.mark.parametrize(("walls", "fluids", "words"), [
    ([TANK, Obstacle(Box(0.5, 0.3, at=(1.0, 0.08)), name="box")], [StillWater(0.8)],
     ["gap between", "box", "tank", "0.08 m, 1.6 spacings", "at most 0.04"]),
    ([TANK, Obstacle(Polygon([(0.2, 0.0), (0.6, 0.0), (2.0, 0.3), (0.2, 0.3)]), name="ledge")], [StillWater(0.8)],
     ["at (0.6, 0) the fluid ends in a wedge of 12.1 degrees; below 15"]),
    ([Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (4.0, 0.7), (0.5, 0.8), (0.5, 1.0)], side="left", name="cave")],
     [StillWater(0.3)], ["cave: at (4, 0.7) the fluid ends in a wedge of 14.8 degrees"]),
    ([Profile([(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (2.0, 0.3)], name="bed")], [StillWater(0.8)],
     ["bed: it ends in the fluid at (2, 0.3), 0.5 m below its top"]),
    ([TANK, Obstacle(Box(0.2, 0.2, at=(1.0, -0.5)), name="lost")], [StillWater(0.8)], ["lost: no fluid touches it"]),
    ([TANK,
      Obstacle(Polygon([(1.0, 0.0), (1.0, 0.3), (1.02, 0.3), (1.02, 0.32), (1.5, 0.32), (1.5, 0.0)]), name="step")],
     [StillWater(0.8)], ["step: an edge of 0.02 m", "shorter than 0.6 spacings"]),
    ([TANK], [Box(0.01, 0.01, at=(1.01, 0.51))], ["fluid[0] (box): it has no particles"]),
    ([TANK], [Box(1.0, 0.5), Box(0.5, 0.2, at=(0.2, 0.2))],
     ["fluid[1] (box): it has no particles, because it lies in other fluid; leave it out"]),
    ([TANK], [StillWater(0.5), StillWater(0.3)], ["fluid[1]: there is still water before it; give one, with the hig"]),
    ([], [StillWater(0.5)], ["there are no walls around it"]),
    ([Tank(1.0, 1.0, at=(1.0, 1.0)), Obstacle(Box(5.0, 5.0))], [StillWater(0.5)], ["each body lies inside another"]),
])
def test_what_is_wrong_is_said(walls, fluids, words):
    found = "\n".join(findings(walls, fluids))
    for word in words:
        assert word in found, found


@pytest.mark.parametrize("height", [0.08, 0.31])
@pytest.mark.parametrize("above", [
    lambda y: Obstacle(Box(0.5, 0.3, at=(1.0, y))),
    lambda y: Plate([(1.0, y), (1.0, y + 0.5)]),
    lambda y: Plate([(1.0, y), (1.0, 2.0)]),    # joined to the lid
    lambda y: Obstacle(Polygon([(1.0, y), (1.2, y + 0.3), (0.7, y + 0.4)])),
])
def test_thinnest_gap_is_below_the_body(above, height):
    walls = [Tank(3.0, 2.0, lid=True), above(height)]
    chains = joined([solid_of(wall) for wall in walls], S)
    gap, at, one, other = thinnest_gap(wall_mesh(walls, S), chains)
    assert gap == pytest.approx(height)
    assert at[1] == pytest.approx(height / 2) and {one, other} == {0, 1}


def test_walls_that_do_not_face_each_other_have_no_gap():
    walls = [Profile([(0.0, 0.0), (1.0, 0.0), (2.0, 1.0)])]
    gap, at, one, other = thinnest_gap(wall_mesh(walls, S), joined([solid_of(walls[0])], S))
    assert np.isinf(gap) and one == other == -1
