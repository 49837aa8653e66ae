"""Bodies and gaps near the spacing: what is accepted, what is filled, and that water rests beside all of them."""

import re

import numpy as np
import pytest

from parisph import Box, Case, Disc, Fluid, Numerics, Obstacle, Polygon, Profile, StillWater, Tank
from parisph.base.errors import CaseError
from parisph.base.fields import FLUID
from parisph.driver.solid_walls import elements_of
from parisph.geometry import build, mesh, scene_checks
from parisph.geometry.distance import unit_normals
from parisph.geometry.mesh import chains_of
from parisph.geometry.solid import in_fluid
from parisph.geometry.standing import standing
from parisph.geometry.tips import Filled
from tests.scenes import simulated

S = 0.05
TANK = Tank(2.0, 1.0, name="tank")


def scene(*walls, spacing=S, level=0.6):
    return Case(title="narrow", fluid=Fluid(StillWater(level), 1000.0), walls=walls, gravity=(0.0, -9.81),
                end_time=50.0, numerics=Numerics(spacing=spacing))


def in_tank(shape, **more):
    return scene(TANK, Obstacle(shape, name="body"), **more)


def notched(width):
    h = 0.5 * width
    return Polygon([(0.7, 0.0), (1.3, 0.0), (1.3, 0.3), (1.0 + h, 0.3), (1.0, 0.1), (1.0 - h, 0.3), (0.7, 0.3)])


def ring(radius, corners, at=(1.0, 0.3)):
    turn = 2.0 * np.pi * np.arange(corners) / corners
    return Polygon([(float(at[0] + radius * np.cos(a)), float(at[1] + radius * np.sin(a))) for a in turn])


def star(inner):
    return Polygon([(float(1.0 + r * np.sin(a)), float(0.3 + r * np.cos(a)))
                    for a, r in zip(np.pi / 5.0 * np.arange(10), 5 * [0.2, inner])])


def bowl(over):
    return Profile([(float(1.0 + 0.8 * np.cos(a)), float(0.9 + 0.8 * np.sin(a)))
                    for a in np.linspace(np.pi - over, 2.0 * np.pi + over, 25)], name="bowl")


NEAR = [
    *(Disc(r * S, at=(1.0, 0.3)) for r in (0.2, 0.3, 0.5, 0.7, 1.0, 1.5)), *(
        Disc(r * S, at=(1.0, r * S + gap)) for r in (0.3, 1.0, 3.0, 5.0) for gap in (-1e-3, 0.0, 1e-9, 1e-3, 0.01)),
    *(Disc(r * S, at=(r * S, y)) for r in (0.5, 1.5, 3.0) for y in (r * S, 0.3)),
    *(Box(0.3, 0.2, at=(1.0, gap)) for gap in (-0.001, 1e-9, 1e-7, 0.001, 0.02)), notched(0.5 * S), notched(1.5 * S),
    Polygon([(0.8, 0.3), (1.2, 0.3), (1.0, 0.33)]), Polygon([(0.98, 0.1), (1.02, 0.1), (1.0, 0.5)]), star(0.08),
    star(0.03), ring(0.5 * S, 60), ring(2.0 * S, 20, at=(1.0, 2.0 * S)),
]


@pytest.mark.parametrize("case", [*map(in_tank, NEAR), scene(bowl(0.0)), scene(bowl(0.5)), scene(
    TANK, Obstacle(Disc(0.1, at=(0.8, 0.3))), Obstacle(Disc(0.1, at=(1.001, 0.3))))])
def test_bodies_near_the_spacing_are_accepted_with_the_fluid_on_their_left(case):
    assert scene_checks.faults(case) == []
    walls, away = standing(case), 1e-9
    for chain in chains_of(walls, S):
        middle, left = chain.elements.mean(axis=1), away * unit_normals(chain.elements)
        assert in_fluid(walls, middle + left).all() and not in_fluid(walls, middle - left).any()


@pytest.mark.parametrize("body, steps", [
    (Disc(0.85 * S, at=(1.025, 0.305)), 40), (Disc(3.0 * S, at=(1.0, 3.0 * S)), 15),
    (Disc(2.0 * S, at=(1.0, 2.2 * S)), 15), (Box(S, S, at=(1.0, 0.3)), 15), (notched(1.5 * S), 15),
])
def test_water_rests_beside_them(body, steps):
    run = simulated(in_tank(body), steps)
    u = np.linalg.norm(run.particles.u[run.particles.kind == FLUID], axis=1)
    assert u.max() < 1e-4


def test_a_bowl_with_overhanging_ends_holds_what_is_in_it():
    def held(over):
        return build.volume(scene(bowl(over), level=0.9))
    assert held(0.5) == pytest.approx(held(0.0), rel=5e-3) and held(0.0) == pytest.approx(0.32 * np.pi, rel=0.01)


@pytest.mark.parametrize("shape, words", [
    (Box(0.004, 0.004, at=(1.0, 0.3)), "is 0.004 m thick, 0.08 spacings"), (Disc(0.003, at=(1.0, 0.3)), "is 0.0047 m"),
    (Polygon([(0.8, 0.3), (1.2, 0.3), (1.2, 0.305)]), "is 0.0025 m thick"),
])
def test_what_is_too_thin_says_which_spacing_would_do(shape, words):
    said, = scene_checks.faults(in_tank(shape))
    assert said.startswith(f"walls, body: {words}"), said
    spacing = float(re.search(r"a spacing of at most (\S+)", said)[1])
    assert scene_checks.faults(in_tank(shape, spacing=spacing)) == []


def test_a_line_whose_ends_lead_back_to_it_is_refused():
    spiral = Profile([(0.5, 1.0), (0.5, 0.0), (1.5, 0.0), (1.5, 0.8), (0.8, 0.8), (0.8, 0.3), (1.2, 0.3), (1.2, 0.5)],
                     name="spiral")
    said = "\n".join(scene_checks.faults(scene(spiral)))
    assert said.startswith("walls, spiral: its ends lead back to it") and "Obstacle(Polygon" in said


@pytest.mark.parametrize("gap, words", [
    (0.0, "walls, tank and body: the fluid ends in a wedge at (1, 0). Its tip, where it is less"),
    (0.01, "walls, tank and body: at (1, 0.005) only 0.00999 m are between them, 0.2 spacings. The gap is closed"),
])
def test_what_is_filled_is_said(gap, words):
    case = in_tank(Disc(0.1, at=(1.0, 0.1 + gap)))
    filled = [wall for wall in standing(case) if isinstance(wall, Filled)]
    said = scene_checks.warnings(case)
    assert len(filled) == (2 if gap == 0.0 else 1) and len(said) == 1 and said[0].startswith(words)
    whole = 1.2 - np.pi * 0.01
    assert build.volume(case) == pytest.approx(whole - sum(wall.shape.area for wall in filled), rel=1e-4)
    if gap:    # the spacing that is named leaves the gap open
        finer = in_tank(Disc(0.1, at=(1.0, 0.1 + gap)), spacing=float(said[0].split()[-1]))
        assert len(standing(finer)) == 2


def test_what_is_filled_has_names_of_its_own():
    discs = [Obstacle(Disc(0.1, at=(x, 0.1)), name=name) for x, name in ((0.5, "filled1"), (1.0, "b"), (1.5, "c"))]
    names = [wall.name for wall in standing(scene(TANK, *discs))]
    assert len(set(names)) == len(names) == 10


def clear():
    build.scene_mesh.cache_clear()
    mesh._wall_mesh.cache_clear()


def test_walls_that_an_earlier_release_divided_otherwise_are_not_taken_for_the_same(monkeypatch):
    case = in_tank(Disc(S, at=(1.0, 0.3)))
    clear()
    monkeypatch.setattr(mesh, "BEND", 10.0)
    run = simulated(case)
    monkeypatch.undo()
    clear()
    with pytest.raises(CaseError, match="the checkpoint has 87 particles on walls, and this release has 89 for them:"):
        elements_of(case, run.particles)


def test_fluid_may_touch_itself():
    """As a drop on a bridge of no width over a pool, which an Obstacle refuses."""
    keyhole = Polygon(((0.0, 0.0), (1.0, 0.0), (1.0, 0.3), (0.525, 0.3), (0.525, 0.4), (0.7, 0.5), (0.35, 0.5),
                       (0.525, 0.4), (0.525, 0.3), (0.0, 0.3)))
    case = Case(title="keyhole", fluid=Fluid(keyhole, density=1000.0), walls=Tank(1.0, 1.0), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=0.05), end_time=1.0)
    assert scene_checks.faults(case) == []
