"""What pictures of the flow say of the scene and of the run: marks, names, frames, spray, failures."""

import itertools

import numpy as np
import pytest

from parisph import Box, Fluid, Piston, PressureTap, ProbeArray, Profile, Sponge, SurfaceGauge, Tank, VelocityProfile
from parisph.base.errors import CaseError
from parisph.base.fields import FLUID
from parisph.case.motion import Heave, Moved, Roll, Series, Sway
from parisph.case.schema import StillWater
from parisph.case.waves import Stokes
from parisph.pictures import bodies_view, curves, movies, overview, states, view, window
from parisph.pictures.frames import PictureFrame
from tests.stored import stored
from tests.unit.test_view import STEPS, S, basin, water, written

pytest.importorskip("matplotlib")


def flume(gauges=8, taps=6, **changes):
    """A flume with a piston and a sponge, and probes near to each other."""
    probes = [*(SurfaceGauge(f"gauge_{k}", at=2.5 + 0.3 * k % 9.0) for k in range(gauges)),
              *(PressureTap(f"tap_{k}", at=(12.0, 0.1 * (k + 1))) for k in range(taps)),
              VelocityProfile("profile", start=(2.0, 0.0), end=(2.0, 0.4))]
    return basin(fluid=Fluid(StillWater(level=0.5), density=1000.0), absorb=Sponge(start=8.5, length=3.5), **{
        "walls": (Tank(width=12.5, height=0.8, at=(-0.5, 0.0)),
                  Piston(at=0.0, wave=Stokes(height=0.1, period=1.6, depth=0.5), name="piston")),
        "probes": probes, **changes})


def marked(axes):
    """Return {name: artist} of what axes show of a scene."""
    return {artist.get_gid(): artist for artist in (*axes.lines, *axes.patches) if artist.get_gid()}


def names(picture, axes):
    """Return {text: extent} of the names in axes, as they are drawn."""
    picture.draw_without_rendering()
    return {text.get_text(): text.get_window_extent() for text in axes.texts if text.get_text() and text.get_visible()}


def check_apart(picture, axes):
    found = names(picture, axes)
    for (one, a), (other, b) in itertools.combinations(found.items(), 2):
        assert not a.overlaps(b), (one, other)
    frame = axes.get_window_extent().padded(1.0)
    assert all(frame.contains(box.x0, box.y0) and frame.contains(box.x1, box.y1) for box in found.values())
    return found


def test_the_overview_shows_probes_lid_zone_and_still_level(tmp_path):
    case = basin(walls=Tank(1.0, 0.8, lid=True), absorb=Sponge(start=0.5, length=0.5))
    picture = overview.plot_overview(written(tmp_path / "run", case, water()))
    first, second = picture.subfigs[0].axes[:2]
    found = marked(first)
    assert set(found) == {"P1", "left", "still level", "sponge"}
    np.testing.assert_allclose(found["P1"].get_xydata(), [[0.0, 0.1]])
    np.testing.assert_allclose(found["left"].get_xdata(), 0.0)
    np.testing.assert_allclose(found["still level"].get_xydata(), [[0.0, 0.5], [1.0, 0.5]])
    assert np.ptp(found["sponge"].get_xy()[:, 0]) == pytest.approx(0.5)
    assert set(check_apart(picture, first)) == {"P1", "left", "sponge"}
    assert set(marked(second)) == {"still level", "sponge"} and first.get_ylim()[1] > 0.8    # the lid is inside


@pytest.mark.parametrize("changes", [{"fluid": Fluid(Box(0.5, 0.5), density=1000.0)}, {"gravity": ("-x", "-y")},
                                     {"walls": Tank(1.0, 0.5, lid=True)}])
def test_a_scene_without_still_water_has_no_still_level(tmp_path, changes):
    picture = overview.plot_overview(written(tmp_path / "run", basin(**changes), water(), count=1))
    assert "still level" not in marked(picture.subfigs[0].axes[0])


@pytest.mark.parametrize("case, count", [
    (flume(), 18), (flume(gauges=90), None), (basin(walls=Tank(0.1, 3.0), fluid=Fluid(Box(0.1, 1.0), density=1000.0),
     probes=[*(PressureTap(f"tap_{k}", at=(0.1, 0.05 * k)) for k in range(9)), SurfaceGauge("middle", at=0.05)]), 11),
])
def test_names_in_a_picture_of_a_scene_do_not_lie_over_each_other(case, count):
    picture = bodies_view.plot_scene(case)
    found = check_apart(picture, picture.axes[0])
    assert count is None or len(found) == count, sorted(found)
    if count is None:
        assert any(text.startswith("and ") and text.endswith(" more names") for text in found)
    stretched = picture.axes[0].get_aspect()
    assert ("vertical scale x2" in picture.axes[0].get_title(loc="left")) == (stretched > 1.0)


def test_an_array_of_many_gauges_has_one_name():
    many = ProbeArray("wave", [SurfaceGauge(f"x{k}", at=0.02 * k) for k in range(1, 41)])
    picture = bodies_view.plot_scene(basin(probes=[many]))
    assert set(names(picture, picture.axes[0])) == {"wave (40)", "tank"}


def spray(*places):
    """The water of the basin, of which the first particles are at other places."""
    particles = water()
    particles.x[:len(places)] = places
    return particles


def test_spray_far_from_the_water_does_not_stretch_the_picture_and_is_counted(tmp_path):
    run = written(tmp_path / "run", basin(), spray((0.5, 40.0)))
    picture = view.plot_field(run)
    axes = picture.axes[0]
    assert axes.get_ylim()[1] < 1.0 and axes.get_title(loc="left").endswith("1 particle outside")
    assert axes.get_aspect() == 1.0
    whole = view.plot_field(run, zoom=(-1.0, 2.0, -1.0, 41.0)).axes[0]
    assert "outside" not in whole.get_title(loc="left")
    inside = written(tmp_path / "inside", basin(), spray((0.5, 0.75)))    # in the tank: nothing is hidden
    assert "outside" not in view.plot_field(inside).axes[0].get_title(loc="left")
    over = view.plot_field(written(tmp_path / "lost", basin(), spray((np.nan, 0.1), (-9.0, 0.1)))).axes[0]
    assert over.get_xlim()[0] > -0.5 and "2 particles outside" in over.get_title(loc="left")


def test_the_bulk_of_the_water_has_jets_and_drops_but_no_single_particles():
    x = np.array([(a, b) for a in np.arange(0.0, 1.0, S) for b in np.arange(0.0, 0.5, S)])
    jet = np.array([(1.0, b) for b in np.arange(0.5, 2.0, S)])
    drop = np.array([(0.5 + a, 3.0 + b) for a in (0.0, S, 2 * S) for b in (0.0, S, 2 * S)])
    assert window.bulk(np.concatenate([x, jet]), S)[1][1] == pytest.approx(1.95)
    assert window.bulk(np.concatenate([x, drop]), S)[1][1] == pytest.approx(3.1)
    lower, upper = window.bulk(np.concatenate([x, [(0.5, 3.0), (-2.0, 0.1)]]), S)
    np.testing.assert_allclose([lower, upper], [[0.0, 0.0], [0.95, 0.45]])


PATH = Series(times=(0.0, 0.1, 0.2, 0.3), values=(0.0, 0.1, 0.2, 0.3))


@pytest.mark.parametrize("frame, note", [
    (Roll(0.5, 2.0, centre=(0.5, 0.0), ramp=0.0), "turned 11.2\N{DEGREE SIGN} anticlockwise"),
    (Roll(-0.5, 2.0, centre=(0.5, 0.0), ramp=0.0), "turned 11.2\N{DEGREE SIGN} clockwise"),
    (Sway(1.0, 5.0), "moved by (0.46, 0) m"), (Heave(1.0, 5.0), "moved by (0, 0.46) m"),
    (Moved(PATH, direction=(0.0, 1.0)), "moved by (0, 0.2) m"),
])
def test_a_tank_that_moves_is_seen_from_itself_or_from_the_room(tmp_path, frame, note):
    case = basin(frame=frame)
    run = written(tmp_path / "run", case, water())
    axes = view.plot_field(run).axes[0]
    assert axes.get_title(loc="left").endswith(f"\ntank's frame, {note}")
    arrows = [text for text in axes.texts if text.get_text() == "$g$"]
    assert len(arrows) == (frame.kind == "roll")    # where gravity turns
    world = view.plot_field(run, frame="world").axes[0]
    assert world.get_title(loc="left").endswith(f"\nseen from the room, tank {note}") and not world.texts
    corners = np.array([(0.0, 0.8), (0.0, 0.0), (1.0, 0.0), (1.0, 0.8)])
    np.testing.assert_allclose(world.lines[0].get_xydata(), frame.placed(corners, 0.2))
    fluid = water().kind == FLUID
    np.testing.assert_allclose(world.collections[1].get_offsets(), frame.placed(water().x[fluid], 0.2))
    (left, right), (low, high) = world.get_xlim(), world.get_ylim()
    lower = frame.placed(corners[1:3], 0.2)
    assert np.all(lower > (left, low)) and np.all(lower < (right, high))
    with pytest.raises(CaseError, match="--frame sea: must be tank or world"):
        view.plot_field(run, frame="sea")


def test_the_ground_below_a_basin_reaches_below_the_axes_wherever_it_is(tmp_path):
    basin_of = Profile(points=((0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), name="basin")
    run = written(tmp_path / "run", basin(walls=(basin_of,), frame=Heave(1.0, 5.0), probes=[]), water())
    for frame in ("tank", "world"):
        axes = view.plot_field(run, frame=frame).axes[0]
        assert axes.patches[0].get_xy()[:, 1].min() <= axes.get_ylim()[0] + 1e-9
        path, moved = axes.collections[0].get_clip_path().get_transformed_path_and_affine()
        inside = axes.transData.inverted().transform(moved.transform(path.vertices))
        np.testing.assert_allclose(np.ptp(inside[:, 0]), 1.0)    # the wet walls are cut at the sides


@pytest.mark.parametrize("frame", [Roll(0.5, 2.0, centre=(0.5, 0.2), ramp=0.0), Sway(0.2, 5.0)])
def test_velocities_in_the_room_are_those_of_places_in_the_room(frame):
    seen = PictureFrame.of(basin(frame=frame), "world")
    x, u, t, dt = np.array([(0.2, 0.3), (0.9, 0.1)]), np.array([(0.3, -0.1), (0.0, 0.4)]), 0.3, 1e-6
    found = seen.snapshot({"x": x, "u": u, "time": t})
    later, earlier = seen.placed(x + dt * u, t + dt), seen.placed(x - dt * u, t - dt)
    np.testing.assert_allclose(found["u"], (later - earlier) / (2 * dt), rtol=1e-6)


def test_a_movie_of_the_room_has_room_for_the_tank_wherever_it_is(tmp_path, monkeypatch):
    frame = Roll(0.8, 2 * np.pi / 0.2, centre=(0.5, 0.0), ramp=0.0)    # it is level in every snapshot but one
    ends = []
    draw = view.FieldView.draw
    monkeypatch.setattr(view.FieldView, "draw",
                        lambda own, *args, **how: ends.append(own.window) or draw(own, *args, **how))
    movies.movie(written(tmp_path / "run", basin(frame=frame), water()), tmp_path / "a.gif", dpi=20, frame="world")
    assert ends[0][1][0] < -0.3 and ends[0][1][1] > 0.7


def ended(folder, status, **more):
    """Return a Run that has ended after 100 steps of .01 s, in the last two of which its values are absurd."""
    samples = [(0.01 * step, step, {"steps": (0.01, 8), "probes/P1": ((1e9 if step > 98 else 1000.0) + step,)})
               for step in range(1, 101)]
    return stored(folder, basin(), STEPS, samples, [(water(), 0.0, 0)], status and {"status": status, **more})


@pytest.mark.parametrize("peaks", [{}, {"P1": {"value": 1e9, "time": 1.0, "lasts": 0.01, "mean": 5e8,
                                               "mean_over": 0.005, "short": True}}])
def test_after_a_failure_the_axes_show_the_flow_before_it_and_the_title_why(tmp_path, peaks):
    run = ended(tmp_path / "run", "failed: particle 7 at (0, 9) m: outside the tank\n  in step 101, from t = 1 s",
                peaks=peaks)
    picture = overview.plot_overview(run)
    said = "failed after t = 1 s: particle 7 at (0, 9) m: outside the tank"
    assert picture.subfigs[0].get_suptitle() == said == states.state(run)
    pressure, steps = picture.subfigs[1].axes[:2]
    assert pressure.get_xlim() == pytest.approx((0.0, 1.0)) and steps.get_xlim() == pytest.approx((0.0, 1.0))
    assert pressure.get_ylim()[1] < 1200.0 and pressure.get_title(loc="right") == "the last values lie outside"
    assert curves.plot_probe(run).get_suptitle() == f"Basin\n{said}"


@pytest.mark.parametrize("status, said", [
    ("completed", ""), ("completed with warnings", ""), ("interrupted", "interrupted after t = 1 s"),
    (None, "goes on, or was killed, after t = 1 s of 1 s"),
])
def test_how_a_run_has_ended_is_said(tmp_path, status, said):
    run = ended(tmp_path / "run", status)
    assert states.state(run) == said
    axes = curves.plot_probe(run).axes[0]
    assert axes.get_ylim()[1] > 1e5    # [kPa], no failure: all is shown


def test_a_run_that_has_only_begun_is_drawn(tmp_path):
    run = stored(tmp_path / "run", basin(), STEPS, [], [(water(), 0.0, 0)])
    picture = overview.plot_overview(run, tmp_path / "a.png")
    assert picture.subfigs[0].get_suptitle() == "goes on, or was killed, before its first step of 1 s"
