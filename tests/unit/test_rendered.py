"""Rendered views: where they look from, what they show, and what they say without their libraries."""

import importlib.util
import io
import sys

import numpy as np
import pytest

from parisph.base.errors import CaseError, MissingLibrary
from parisph.pictures import movies, orders, style, view, water
from parisph.pictures.colouring import Look
from parisph.pictures.rendering import Eye
from tests.flows_in_3d import S, written

pytest.importorskip("matplotlib")
CAN = importlib.util.find_spec("pyvista") is not None
renders = pytest.mark.skipif(not CAN, reason="no pyvista here: pip install 'parisph[render]'")
surfaces = pytest.mark.skipif(water.library() is None, reason="no pysplashsurf here: pip install 'parisph[render]'")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return written(tmp_path_factory.mktemp("3d") / "run")


@pytest.mark.parametrize("azimuth, elevation, way", [(0, 0, (0, -1, 0)), (90, 0, (1, 0, 0)), (-90, 0, (-1, 0, 0)),
                                                     (30, 90, (0, 0, 1))])
def test_the_eye_looks_from_its_angles_and_sees_all_points(azimuth, elevation, way):
    box = np.array([(x, y, z) for x in (0.0, 3.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    eye = Eye.of(box, azimuth, elevation)
    away = (eye.place - eye.target) / np.linalg.norm(eye.place - eye.target)
    np.testing.assert_allclose(away, way, atol=1e-12)
    right = np.array([np.cos(np.deg2rad(azimuth)), np.sin(np.deg2rad(azimuth)), 0.0])
    depth = (eye.place - box) @ away
    half = np.tan(np.deg2rad(0.5 * eye.angle))
    assert np.all(np.abs((box - eye.target) @ np.cross(away, right) / depth) <= half)
    assert np.all(np.abs((box - eye.target) @ right / depth) <= half * eye.aspect)


def test_values_on_the_surface_are_those_of_the_particles_there():
    x = np.random.default_rng(1).uniform(size=(200, 3))
    np.testing.assert_allclose(water.spread(x, x, x[:, 0]), x[:, 0], atol=1e-9)
    np.testing.assert_allclose(water.spread(x[:5] + 0.01, x, np.full(200, 3.0)), 3.0)


@surfaces
def test_the_water_is_a_closed_surface_up_to_the_walls():
    x = np.stack(np.meshgrid(*[np.arange(0, end, S) for end in (1.05, 0.85, 0.55)], indexing="ij"), -1).reshape(-1, 3)
    lower, upper = np.zeros(3), np.array([1.0, 0.8, 0.9])
    points, triangles = water.surface(x, S, (lower, upper))
    np.testing.assert_allclose(points.min(axis=0), lower)
    np.testing.assert_allclose(points.max(axis=0)[:2], upper[:2])
    assert abs(points[:, 2].max() - 0.55) < 0.25 * S    # half a spacing above the uppermost particles
    a, b, c = (points[triangles[:, k]] for k in range(3))
    assert abs(np.sum(np.cross(a, b) * c) / 6 / (0.8 * 0.55) - 1.0) < 0.03    # their volume, seen from outside


@renders
def test_a_rendered_view_shows_water_walls_and_pressure_on_bodies(run, tmp_path):
    picture = view.plot_field(run, field="speed", view="3d")
    image = picture.axes[0].images[0].get_array()
    assert image.ndim == 3 and np.ptp(image, axis=(0, 1)).min() > 50
    bars = [axes.get_ylabel() for axes in picture.axes[0].child_axes]
    assert len(bars) == 2 and bars[0].startswith("speed") and bars[1].startswith("pressure on bodies")
    assert len(view.plot_field(run, field="pressure", view="3d").axes[0].child_axes) == 1
    made, = orders.plot([run], view="3d", camera=(10.0, 5.0))
    assert made.name == "flow_speed_0.2000s_3d.png"
    assert movies.movie(run, tmp_path / "a.gif", "speed", dpi=30, view="3d").exists()


@renders
@pytest.mark.parametrize("width", [3.0, 8.0])
def test_labels_of_two_colour_bars_do_not_overlap_in_a_picture_of_any_size(run, width):
    shown = run.snapshot(-1)
    drawn = view.view_of(run.scene, [shown], Look("speed", view=view.SOLID))
    picture = style.new_figure(figsize=drawn.size(width), layout="compressed")
    axes = picture.add_subplot()
    colours = drawn.draw(axes, shown, drawn.limits([shown], whole=True), label=False)
    drawn.add_colour_bar(picture, axes, colours, [shown])
    picture.savefig(io.BytesIO())
    first, second = (bar.yaxis.label.get_window_extent() for bar in axes.child_axes)
    assert not first.overlaps(second) and (first.x0 < second.x0 - 1.0) == (width < 4.0)


@renders
def test_without_the_library_of_surfaces_particles_are_balls(run, monkeypatch):
    monkeypatch.setattr(water, "library", lambda: None)
    drawn = view.view_of(run.scene, [run.snapshot(0)], Look("speed", view="3d"))
    pieces = list(drawn._water(run.snapshot(0), (0.0, 1.0)))
    assert len(pieces) == 1 and pieces[0].triangles is None and pieces[0].radius == 0.5 * S
    view.plot_field(run, field="speed", view="3d")


def test_without_pyvista_one_line_says_what_to_do(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingLibrary, match=r"pip install 'parisph\[render\]'"):
        view.plot_field(run, field="speed", view="3d")


@pytest.mark.parametrize("look, word", [({"slice": "y=0.4"}, "--slice"), ({"zoom": (0, 1, 0, 1)}, "--zoom"),
                                        ({"surface": True}, "--surface"), ({"field": "role"}, "--field role"),
                                        ({"camera": (0.0, 100.0)}, "-90 to 90"), ({"view": "4d"}, "slice or 3d"),
                                        ({"view": "slice", "camera": (0.0, 0.0)}, "--camera needs --view 3d")])
def test_what_does_not_fit_a_rendered_view_is_refused(look, word):
    with pytest.raises(CaseError, match=word):
        Look(**{"view": "3d", **look})
