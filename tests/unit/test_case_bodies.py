"""Profile, Obstacle, Plate and StillWater: what they accept, what they say, and their JSON."""

import pytest
from pydantic import TypeAdapter

from parisph import Box, CaseError, Disc, Polygon
from parisph.case.bodies import Body, Obstacle, Plate, Profile, StillWater

SLOPE = [(0.0, 0.0), (5.0, 0.0), (8.0, 1.0)]


@pytest.mark.parametrize("body", [
    Profile(SLOPE, name="beach", slip="none"), Profile([(1.0, 0.0), (1.0, 1.0)], side="left"),
    Obstacle(Box(1.0, 0.5, at=(3.0, 0.0)), name="box"), Obstacle(Disc(0.5)),
    Obstacle(Polygon([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])), Plate([(1.0, 0.0), (1.0, 0.7)], name="gate"),
])
def test_body_survives_json(body):
    assert TypeAdapter(Body).validate_json(body.model_dump_json()) == body


@pytest.mark.parametrize(("points", "side", "left"), [
    (SLOPE, None, True), (SLOPE[::-1], None, False), (SLOPE, "right", False), ([(1.0, 0.0), (1.0, 1.0)], "left", True)])
def test_fluid_is_above_a_profile_unless_its_side_is_given(points, side, left):
    assert Profile(points, side=side).fluid_on_left is left


@pytest.mark.parametrize(("make", "words"), [
    (lambda: Profile([(1.0, 0.0), (1.0, 1.0)]),
     ["points: the first and the last have the same x = 1", "neither side is above", 'side="left"']),
    (lambda: Profile([(0.0, 0.0), (0.0, 0.0), (1.0, 0.0)]), ["(0.0, 0.0) is given twice in a row"]),
    (lambda: Profile([(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (1.0, -1.0)]), ["meets that from (1.0, 1.0) to (1.0, -1.0)"]),
    (lambda: Plate([(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)]), ["meets that from (2.0, 0.0) to (1.0, 0.0)"]),
    (lambda: Polygon([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.5)]), ["meets that from"]),
    (lambda: Obstacle(Polygon([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 0.0)])), ["given twice in a row"]),
    (lambda: Plate([(0.0, 0.0)]), ["Plate.points", "at least 2 values"]),
    (lambda: Plate(SLOPE, name="a b"), ["Plate.name = 'a b'", "begins with a letter"]),
    (lambda: Plate(SLOPE, slip="partly"), ["Plate.slip = 'partly'", "'free' or 'none'"]),
    (lambda: StillWater(float("inf")), ["StillWater.level"]),
])
def test_faults_are_named(make, words):
    with pytest.raises(CaseError) as error:
        make()
    for word in words:
        assert word in str(error.value)


def test_lines_may_turn_straight_on():
    Profile([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0)])
    Obstacle(Polygon([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]))
