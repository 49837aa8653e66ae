"""Probes, the rim and pictures of scenes of several bodies: beds, slopes, moving walls."""

from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, ColumnHeight, Fluid, Numerics, PressureTap, SurfaceGauge, Tank, WaterFront
from parisph.base.fields import FLUID, WALL
from parisph.case.bodies import Obstacle, Piston, Profile, StillWater
from parisph.case.waves import SolitaryWave
from parisph.driver import solid_walls
from parisph.driver.overflow import OpenTank
from parisph.geometry import build
from parisph.geometry.columns import beds
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.pictures import bodies_view, style, view
from parisph.watch import instruments
from parisph.watch.sampling import ProbeScene

S, G = 0.05, 9.81
BEACH = Profile([(0.0, 1.2), (0.0, 0.0), (1.0, 0.0), (3.0, 0.8)], name="beach")
MAKER = Piston(at=0.3, wave=SolitaryWave(height=0.1, depth=0.5), name="maker")


def scene(walls=BEACH, probes=(), fluid=None):
    return Case(title="scene", fluid=fluid or Fluid(StillWater(0.5), 1000.0), walls=walls, gravity=(0.0, -G),
                numerics=Numerics(spacing=S), probes=probes, end_time=2.0)


def sampled(case, change=lambda arrays: None):
    """Return {probe: value} of the particles at the start, with the pressure of still water."""
    arrays = build.build(case)
    arrays["p"][:] = 1000.0 * G * np.maximum(0.5 - arrays["x"][:, 1], 0.0)
    change(arrays)
    particles = Particles(MPI.COMM_SELF, 2)
    particles.assign({name: values for name, values in arrays.items() if name in particles.fields})
    domain = Domain(particles, *build.domain(case), 2.6 * S, 0.4 * S, 0.04 * S,
                    elements=solid_walls.elements_of(case, particles))
    domain.refresh()
    try:
        found = instruments.sample_all(instruments.build(case, MPI.COMM_SELF), particles, domain, 0.0)
    finally:
        domain.destroy()
    return {name: values[0] for name, values in found.items()}


def test_gauges_stand_on_the_bed_where_it_is():
    probes = [SurfaceGauge("deep", at=0.5), SurfaceGauge("shallow", at=1.9), ColumnHeight("column", at=1.5),
              SurfaceGauge("dry", at=2.75), WaterFront("front")]
    found = sampled(scene(probes=probes))
    assert [found[name] for name in ("deep", "shallow", "column")] == pytest.approx([0.5] * 3, abs=1e-9)
    assert found["dry"] == pytest.approx(0.7), "the bed itself"
    assert 2.25 - 2.5 * S < found["front"] < 2.25, "the shore of the still water"


def test_gauge_above_an_obstacle_has_its_top_as_bed():
    box = Obstacle(Box(0.6, 0.7, at=(1.0, 0.0)), name="box")
    found = sampled(scene((Tank(3.0, 1.0), box), [ColumnHeight("top", at=1.3), ColumnHeight("beside", at=2.0)]))
    assert found == pytest.approx({"top": 0.7, "beside": 0.5})


def test_tap_on_a_slope_has_the_pressure_there():
    at = np.array([1.5, 0.2])
    corner = PressureTap("corner", at=(1.0, 0.0), radius=S)
    found = sampled(scene(probes=[PressureTap("slope", at=tuple(at.tolist())), corner]),
                    lambda arrays: np.copyto(arrays["role"], np.where(arrays["kind"] == WALL, 2, arrays["role"])))
    assert found["slope"] == pytest.approx(1000.0 * G * 0.3, rel=1e-9)
    assert found["corner"] == pytest.approx(1000.0 * G * 0.5, rel=0.02)


def test_bed_is_the_highest_wall_at_rest_below():
    mesh = build.scene_mesh(scene((BEACH, MAKER)))
    x = np.array([2.0, 0.5, 0.1, 9.0])
    np.testing.assert_allclose(beds(mesh.corners(), x, 10.0), [0.4, 0.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(ProbeScene.of(scene((BEACH, MAKER))).bed_at(x), [0.4, 0.0, 0.0, 0.0], atol=1e-12)
    plain = ProbeScene.of(scene(Tank(3.0, 1.0, at=(0.0, 0.2)), fluid=Fluid(Box(1.0, 0.5, at=(0.0, 0.2)), 1000.0)))
    assert plain.bed_at(x).tolist() == [0.2] * 4
    assert ProbeScene.of(scene(None, fluid=Fluid(Box(1.0, 0.5), 1000.0))).bed_at(x) is None


def test_water_leaves_over_the_end_of_a_bed():
    case = scene()
    domain = SimpleNamespace(lower=np.zeros(2), upper=np.array([3.0, 1.2]), radius=0.13)
    rim = OpenTank.of(case, domain)
    assert (rim.rims[0].left, rim.rims[0].right) == pytest.approx((1.2, 0.8))
    x = np.array([(3.1, 0.85), (3.1, 0.5), (-0.1, 1.25), (-0.14, 0.9), (1.5, 2.0), (3.01, 0.79)])
    gone, lost = rim._gone_and_lost(SimpleNamespace(x=x, kind=np.full(len(x), FLUID)), 0.0)
    assert gone.tolist() == [True, False, True, False, False, True]
    assert lost.tolist() == [False, False, False, True, False, False]


def test_pictures_show_walls_where_they_are(tmp_path):
    pytest.importorskip("matplotlib")
    case = scene((BEACH, MAKER), [PressureTap("tap", at=(1.5, 0.2)), SurfaceGauge("gauge", at=0.8)])
    picture = bodies_view.plot_scene(case, tmp_path / "scene.png")
    assert {text.get_text() for text in picture.axes[0].texts} - {""} == {"beach", "maker", "tap", "gauge"}
    assert (tmp_path / "scene.png").stat().st_size > 1000
    arrays = build.build(case)
    snapshot = {"time": 2.0, **arrays}
    axes = style.drawing().Figure().add_subplot()
    shown = view.FieldView(case, [snapshot], view.Look())
    shown.draw(axes, snapshot, (0.0, 1.0))
    moved = 0.3 + build.scene_motions(case)[1].law(2.0)[0]
    assert any(np.allclose(line.get_xdata(), moved) for line in axes.lines) and moved > 0.31
    (left, right), (low, _) = shown.window
    assert left < 0.0 and right > 3.0 and low < 0.0
    assert style.scene_units(case).length == 0.5


def test_picture_of_many_particles_shows_all_the_water(monkeypatch):
    case = scene()
    few, size = bodies_view.places_of_water(case, 1.0)
    monkeypatch.setattr(bodies_view, "MOST", len(few) // 3)
    many, square = bodies_view.places_of_water(case, 1.0)
    assert len(many) < len(few) and square >= 1.5 * size
    apart = np.abs(few[:, None] - many).max(axis=2)    # each particle is in a square, and each square has one
    assert apart.min(axis=1).max() <= (0.5 + 1e-9) * square and apart.min(axis=0).max() <= (0.5 + 1e-9) * square
