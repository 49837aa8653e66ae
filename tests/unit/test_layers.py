"""The fluid of 3D scenes at the start: numbers, volumes, surfaces, and the same particles on any number of ranks."""

import numpy as np
import pytest

from parisph import (
    Box,
    Case,
    Disc,
    Fluid,
    Numerics,
    Obstacle,
    Piston,
    Plate,
    Profile,
    SolitaryWave,
    StillWater,
    Sway,
    Tank,
)
from parisph.base.fields import CONTACT, DRY, FLUID, SURFACE, WALL, WET
from parisph.geometry import build
from parisph.geometry.rims import rims_of

S = 0.1
TANK = Tank(1.0, 1.0, breadth=0.8)
COLUMN = Obstacle(Box(0.3, 0.2, breadth=0.4, at=(0.3, 0.2, 0.0)))
SLOPE = Profile(((-0.5, 0.8), (-0.5, 0.0), (1.0, 0.0), (2.0, 0.5)), breadth=0.5)
WAVE = "0.02*cos(pi*x)*cos(2.5*pi*y)"

# scenes: walls, fluid, and the exact volume of the fluid
SCENES = {
    "box": (TANK, Box(1.0, 0.5), 0.4),
    "column": (TANK, Box(0.3, 0.5, breadth=0.42, at=(0.0, 0.1, 0.0)), 0.3 * 0.5 * 0.42),
    "still water": ((TANK, COLUMN), StillWater(0.5), 0.4 - 0.3 * 0.2 * 0.4),
    "slope": ((SLOPE, Piston(0.0, wave=SolitaryWave(height=0.05, depth=0.3))), StillWater(0.3),
              0.5 * 0.3 * (1.0 + 0.3)),
    "plate": ((TANK, Plate(((0.5, 0.0), (0.5, 0.4)), across=(0.2, 0.6))), StillWater(0.5), 0.4),
    "cylinder": ((TANK, Obstacle(Disc(0.15, at=(0.5, 0.28)), across=(0.2, 0.6))), StillWater(0.5),
                 0.4 - 0.4 * np.pi * 0.15**2),
    "drop": (None, Box(0.5, 0.5, breadth=0.4), 0.1),
}


def scene(walls, *fluids, spacing=S, **fields):
    fluids = tuple(fluid if isinstance(fluid, Fluid) else Fluid(fluid, 1000.0) for fluid in fluids)
    return Case(title="Scene", fluid=fluids[0] if len(fluids) == 1 else fluids, walls=walls, gravity=(0.0, -9.81),
                numerics=Numerics(spacing=spacing), end_time=1.0, **fields)


def named(name, **fields):
    walls, fluid, _ = SCENES[name]
    return scene(walls, fluid, **fields)


@pytest.mark.parametrize("name", SCENES)
def test_slices_are_the_same_on_any_number_of_ranks(name):
    case = named(name)
    whole = build.build(case)
    count = build.counts(case)
    assert count["all"] == len(whole["id"]) and count["fluid"] == np.count_nonzero(whole["kind"] == FLUID)
    for size in (2, 3):
        parts = [build.build(case, rank, size) for rank in range(size)]
        for field, values in whole.items():
            assert np.concatenate([part[field] for part in parts]).tobytes() == values.tobytes(), field


@pytest.mark.parametrize("name", SCENES)
def test_volumes_are_exact(name):
    case, exact = named(name), SCENES[name][-1]
    rtol = 1e-3 if name == "cylinder" else 1e-12    # a disc has facets
    np.testing.assert_allclose(build.volume(case), exact, rtol=rtol)
    lower, upper = build.domain(case)
    total, inside = 0.0, True
    for places, volume in build.samples(case, lower - S, upper + S):
        total += volume.sum()
        inside &= bool(((places >= lower) & (places <= upper)).all())
    np.testing.assert_allclose(total, exact, rtol=rtol)
    assert inside


def test_samples_of_parts_are_those_of_the_whole():
    case = named("still water")
    lower, upper = build.domain(case)
    middle = np.array([0.43, 0.37, 0.21])
    parts = 0.0
    for corner in np.ndindex(2, 2, 2):
        low, high = np.where(corner, middle, lower), np.where(corner, upper + 1.0, middle)
        parts += sum(volume.sum() for _, volume in build.samples(case, low, high))
    np.testing.assert_allclose(parts, SCENES["still water"][-1], rtol=1e-12)


def test_a_box_fills_the_lattice_of_its_tank():
    case = named("box")
    made = build.build(case)
    fluid = made["kind"] == FLUID
    x = made["x"][fluid]
    assert build.even(case) and build.weighed(case) and len(x) == 9 * 7 * 5
    np.testing.assert_allclose(x / S, np.round(x / S), atol=1e-9)
    assert x.min(axis=0) == pytest.approx(S) and x.max(axis=0) == pytest.approx([0.9, 0.7, 0.5])
    surface = made["role"][fluid] == SURFACE
    assert np.array_equal(surface, x[:, 2] > 0.45)
    np.testing.assert_allclose(made["volume"][fluid].sum(), 0.4, rtol=1e-12)
    corner = made["volume"][fluid][np.linalg.norm(x - S, axis=1) < 1e-9]
    np.testing.assert_allclose(corner, 1.5**3 * S**3, rtol=1e-12)


def test_a_column_has_points_on_its_ends_and_a_surface_there():
    case = named("column")
    made = build.build(case)
    fluid = made["kind"] == FLUID
    x, surface = made["x"][fluid], made["role"][fluid] == SURFACE
    assert x[:, 1].min() == pytest.approx(0.1) and x[:, 1].max() == pytest.approx(0.52)
    inside = (x[:, 0] < 0.25) & (x[:, 2] < 0.45) & (x[:, 1] > 0.15) & (x[:, 1] < 0.45)
    assert inside.any() and not surface[inside].any()
    assert surface[~inside].all()
    np.testing.assert_allclose(np.diff(np.unique(np.round(x[:, 1], 9))), 0.42 / 4, rtol=1e-9)


@pytest.mark.parametrize("fluid", [Box(1.0, 0.5), StillWater(0.5)])
def test_an_elevation_may_vary_across(fluid):
    case = scene(TANK, Fluid(fluid, 1000.0, elevation=WAVE))
    made = build.build(case)
    water = made["kind"] == FLUID
    x, surface = made["x"][water], made["role"][water] == SURFACE
    top = 0.5 + 0.02 * np.cos(np.pi * x[:, 0]) * np.cos(2.5 * np.pi * x[:, 1])
    np.testing.assert_allclose(x[surface, 2], top[surface], rtol=1e-12)
    np.testing.assert_allclose(build.volume(case), 0.4, rtol=1e-9)    # whole cosines
    lower, upper = build.domain(case)
    assert upper[2] == 1.0
    total = sum(volume.sum() for _, volume in build.samples(case, lower - S, upper + S))
    np.testing.assert_allclose(total, 0.4, rtol=1e-9)


def test_fluid_keeps_half_a_spacing_from_the_walls_and_from_other_fluid():
    case = scene((TANK, COLUMN), Box(0.3, 0.3, breadth=0.35, at=(0.6, 0.0, 0.0)), StillWater(0.5))
    made = build.build(case)
    x = made["x"][made["kind"] == FLUID]
    apart = np.linalg.norm(x[:, None] - x, axis=2)
    np.fill_diagonal(apart, 1.0)
    assert apart.min() >= 0.5 * S
    lower, upper = np.array([0.3, 0.2, -1.0]), np.array([0.6, 0.6, 0.2])
    outside = np.linalg.norm(np.maximum(np.maximum(lower - x, x - upper), 0.0), axis=1)
    assert outside.min() >= 0.5 * S - 1e-6
    np.testing.assert_allclose(build.volume(case), 0.4 - 0.024, rtol=1e-12)
    lower, upper = build.domain(case)
    np.testing.assert_allclose(sum(volume.sum() for _, volume in build.samples(case, lower, upper)), 0.4 - 0.024,
                               rtol=1e-12)


def test_roles_weights_and_no_slip_of_nodes():
    tank = Tank(1.0, 1.0, breadth=0.8, no_slip=("front", "bottom"))
    case = scene((tank, COLUMN), StillWater(0.5))
    made = build.build(case)
    wall = made["kind"] == WALL
    x, role, weight = made["x"][wall], made["role"][wall], made["weight"][wall]

    def at(*place):
        found = np.flatnonzero(np.linalg.norm(x - np.array(place), axis=1) < 1e-9)
        assert len(found) == 1
        return found[0]
    assert role[at(0.5, 0.0, 0.3)] == WET and role[at(0.5, 0.0, 0.5)] == CONTACT and role[at(0.5, 0.0, 0.7)] == DRY
    assert role[at(0.0, 0.0, 0.0)] == WET and role[at(0.4, 0.3, 0.2)] == WET
    assert role[at(0.3, 0.2, 0.2)] == DRY    # a convex corner has no row
    for place, part in [((0.0, 0.0, 0.0), 1 / 8), ((0.3, 0.2, 0.2), 7 / 8), ((0.4, 0.2, 0.2), 3 / 4),
                        ((0.3, 0.2, 0.0), 3 / 8), ((0.5, 0.0, 0.3), 1 / 2), ((0.5, 0.0, 0.0), 1 / 4)]:
        np.testing.assert_allclose(weight[at(*place)], part, rtol=1e-9)
    sticky = made["no_slip"][wall] == 1
    assert np.array_equal(sticky & (made["body"][wall] == 0), ((x[:, 1] == 0.0) | (x[:, 2] == 0.0)) &
                          (made["body"][wall] == 0))


def test_domain_holds_walls_wherever_they_move_and_the_front_of_a_profile():
    moving = COLUMN.model_copy(update={"motion": Sway(0.25, frequency=20.0)})
    lower, upper = build.domain(scene((TANK, moving), StillWater(0.5)))
    np.testing.assert_allclose([lower, upper], [[0.0, 0.0, 0.0], [1.1, 0.8, 1.0]], atol=1e-3)
    lower, upper = build.domain(scene(Profile(((0.0, 0.0), (1.0, 0.0)), breadth=0.5), Box(0.4, 0.4)))
    np.testing.assert_allclose([lower, upper], [[0.0, 0.0, 0.0], [1.0, 0.5, 0.6]], atol=1e-9)


def test_water_leaves_over_the_front_and_is_lost_behind_it():
    rim, = rims_of(scene(TANK, Box(1.0, 0.5)), 0.3)
    places = np.array([(0.5, 0.4, 0.5), (0.5, -0.06, 1.1), (0.5, 0.86, 0.95), (0.5, -0.04, 1.1), (0.5, 0.9, 0.5),
                       (0.5, 1.2, 0.5), (-0.06, 0.4, 1.1), (0.5, 0.4, -0.4)])
    gone, lost = rim.out(places, 0.0)
    assert gone.tolist() == [False, True, True, False, False, False, True, False]
    assert lost.tolist() == [False, False, False, False, False, True, False, True]
