"""Bodies of fluid that touch, overlap or nearly touch: one body without doubled particles, or a refusal that helps."""

import re

import numpy as np
import pytest

from parisph import Box, Case, Disc, Fluid, Numerics, Obstacle, Plate, Polygon, StillWater, Tank
from parisph.base.fields import FLUID
from parisph.geometry import build, scene_checks

S = 0.1
LEFT, DISC = Box(2.0, 1.0), Disc(0.6, at=(2.0, 1.4))


def scene(*shapes, spacing=S, walls=(), holes=()):
    fluids = tuple(Fluid(shape, 1000.0, holes=holes if number == 0 else ()) for number, shape in enumerate(shapes))
    return Case(title="fluids", fluid=fluids, walls=(Tank(4.0, 2.5), *walls), gravity=(0.0, -9.81), end_time=1.0,
                numerics=Numerics(spacing=spacing))


def faults(case):
    return scene_checks.faults(case)


def segment(radius, height):
    """Return the area of a disc below a line at a height above its centre."""
    return radius**2 * (np.pi - np.arccos(height / radius)) + height * np.sqrt(radius**2 - height**2)


@pytest.mark.parametrize("case, area", [
    (scene(LEFT, Box(2.0, 1.0, at=(2.0, 0.0))), 4.0),                                      # side by side
    (scene(LEFT, Box(2.0, 1.0, at=(0.0, 1.0))), 4.0),                                      # stacked
    (scene(LEFT, Box(2.0, 1.0, at=(2.0, 1.0))), 4.0),                                      # at a corner
    (scene(LEFT, Box(2.0, 1.0, at=(1.0, 0.5))), 3.5),                                      # overlapping
    (scene(LEFT, Box(2.0, 0.93, at=(1.03, 0.57))), 2.0 + 2.0 * 0.93 - 0.97 * 0.43),        # off the lattice
    (scene(LEFT, Box(2.0, 1.0, at=(2.0 + 1e-6, 0.0))), 4.0),                               # apart by rounding
    (scene(LEFT, Box(1.5, 1.0, at=(2.1, 0.0))), 3.5), (scene(LEFT, Box(1.5, 1.0, at=(2.2, 0.0))), 3.5),
    (scene(LEFT, StillWater(0.5)), 3.0), (scene(StillWater(0.5), LEFT), 3.0),              # Box in StillWater
    (scene(StillWater(0.5), Box(1.0, 1.0, at=(1.0, 0.2))), 2.7), (scene(Box(4.0, 2.0), DISC), 8.0),
    (scene(Box(4.0, 1.0), DISC), 4.0 + np.pi * 0.36 - segment(0.6, -0.4)),                 # Disc in Box
    (scene(DISC, Box(4.0, 1.0)), 4.0 + np.pi * 0.36 - segment(0.6, -0.4)),
    (scene(Box(4.0, 2.0), Disc(0.5, at=(2.0, 1.0)), holes=(Disc(0.5, at=(2.0, 1.0)),)), 8.0),    # in its hole
    (scene(LEFT, Polygon([(2.0, 0.0), (4.0, 0.0), (2.0, 1.0)])), 3.0),
    (scene(LEFT, Box(1.98, 1.0, at=(2.02, 0.0)), walls=(Obstacle(Box(0.02, 2.0, at=(2.0, 0.0))),)), 3.98),
    (scene(LEFT, Box(1.98, 1.0, at=(2.02, 0.0)), walls=(Plate([(2.01, 0.0), (2.01, 1.5)]),)), 3.98),
])
def test_bodies_that_touch_or_overlap_are_one(case, area):
    if "it lies in other fluid" in "\n".join(faults(case)):
        case = case.changed(fluid=case.fluids[0])
    assert faults(case) == []
    parts = build.build(case)
    fluid = parts["kind"] == FLUID
    x, volume = parts["x"][fluid], parts["volume"][fluid].sum()
    apart = np.linalg.norm(x[:, None] - x, axis=2) + np.eye(len(x))
    assert apart.min() > 0.49 * S
    assert build.volume(case) == pytest.approx(area, rel=2e-4)
    assert volume == pytest.approx(area, rel=0.06)    # by cells of the lattice, of which half lie beyond free edges


def test_bodies_that_touch_do_not_gain_particles():
    whole = build.counts(scene(Box(4.0, 1.0)))["fluid"]
    assert build.counts(scene(LEFT, Box(2.0, 1.0, at=(2.0, 0.0))))["fluid"] == whole
    assert build.counts(scene(LEFT, Box(2.0, 0.5, at=(2.0, 0.0)), Box(2.0, 0.5, at=(2.0, 0.5))))["fluid"] == whole


@pytest.mark.parametrize("other, gap", [
    (Box(1.5, 1.0, at=(2.02, 0.0)), 0.02), (Box(1.5, 1.0, at=(2.05, 0.0)), 0.05), (Box(1.5, 1.0, at=(2.09, 0.0)), 0.09),
    (Box(2.0, 1.0, at=(0.0, 1.02)), 0.02), (Disc(0.5, at=(1.0, 1.55)), 0.05), (Disc(0.5, at=(2.55, 0.6)), 0.05),
])
def test_a_slit_between_bodies_is_refused_with_remedies_that_work(other, gap):
    said, = faults(scene(LEFT, other))
    assert said.startswith(f"fluid[1] and fluid[0]: they are {gap:g} m apart"), said
    assert faults(scene(LEFT, other, spacing=float(re.search(r"a spacing of at most (\S+)", said)[1]))) == []
    for shift in (-gap, S - gap):
        moved = other.at[0] + (shift if other.at[0] > 2.0 else 0.0), other.at[1] + (shift if other.at[0] < 2.0 else 0.0)
        assert faults(scene(LEFT, other.model_copy(update={"at": moved}))) == []


@pytest.mark.parametrize("left, right, stepped", [
    (1.0, 1.0, False), (1.05, 1.05, True), (1.0, 1.2, True), (1.2, 1.0, True),
])
def test_a_surface_off_the_lattice_is_announced(left, right, stepped):
    """It starts in steps below its place. With gentle, a slope of 15 degrees and d/s = 13, p at the bed is 4 % low."""
    corners = [(0.0, 0.0), (4.0, 0.0), (4.0, right), (0.0, left)]
    for order in (corners, corners[::-1]):
        said = [text for text in scene_checks.warnings(scene(Polygon(order))) if "on the lattice" in text]
        assert len(said) == stepped and all(f"from (0, {left:g}) to (4, {right:g})" in text for text in said), said
