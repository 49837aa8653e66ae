"""Slices of 3D flows: which particles and walls a picture shows, in which frame."""

import numpy as np
import pytest

from parisph import Roll, Sway, Yaw
from parisph.base.errors import CaseError
from parisph.base.fields import FLUID
from parisph.pictures import movies, orders, overview, view
from parisph.pictures.colouring import Look
from parisph.pictures.slices import Slice, crossing
from tests.flows_in_3d import DEPTH, S, tank, water, written

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return written(tmp_path_factory.mktemp("3d") / "run")


def shown(picture):
    """The places (n, 2) of the particles of fluid in a picture, and their colours."""
    discs = picture.axes[0].collections[1]
    return np.asarray(discs.get_offsets()), np.asarray(discs.get_array())


def test_a_slice_shows_one_layer_of_the_lattice_and_the_outline_of_the_walls(run):
    picture = view.plot_field(run)
    x, p = shown(picture)
    flow = run.snapshot(-1)
    layer = (flow["kind"] == FLUID) & (np.abs(flow["x"][:, 1] - 0.4) < 1e-6)    # the middle of the breadth
    np.testing.assert_allclose(x, flow["x"][layer][:, [0, 2]])
    np.testing.assert_allclose(p, 1e-3 * flow["p"][layer])    # [kPa]
    axes = picture.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$ [m]", "$z$ [m]") and "$y$ = 0.4 m" in axes.get_title("left")
    box, = (line.get_xydata() for line in axes.lines if len(line.get_xydata()) == 5)
    np.testing.assert_allclose([box.min(axis=0), box.max(axis=0)], [(0.5, 0.0), (0.7, 0.2)])


def test_of_two_layers_half_a_spacing_away_one_is_shown(run):
    for place in (0.35, 0.45):
        x, _ = shown(view.plot_field(run, slice=f"y={place}"))
        assert len(np.unique(x.round(6), axis=0)) == len(x) > 0


def test_beside_the_box_no_box_is_drawn(run):
    axes = view.plot_field(run, slice="y = 0.1").axes[0]
    assert not any(len(line.get_xydata()) == 5 for line in axes.lines)


@pytest.mark.parametrize("place, names, pieces", [("x=0.6", ("y", "z"), [(0.2, 0.2), (0.6, 0.2)]),
                                                  ("z=0.1", ("x", "y"), [(0.5, 0.2), (0.7, 0.6)])])
def test_slices_across_x_and_z_show_cuts_of_the_walls(run, place, names, pieces):
    axes = view.plot_field(run, slice=place, field="speed").axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == tuple(f"${name}$ [m]" for name in names)
    ends = np.concatenate(axes.collections[2].get_segments())
    for corner in pieces:    # of the box
        assert np.any(np.all(np.abs(ends - corner) < 1e-9, axis=1)), corner


def test_speed_and_velocities_have_three_components(run):
    x, speed = shown(view.plot_field(run, slice="y=0.4", field="speed"))
    np.testing.assert_allclose(speed, np.sqrt(x[:, 0]**2 + 0.4**2 + x[:, 1]**2))
    for name, value in (("velocity_x", x[:, 0]), ("velocity_y", np.full(len(x), 0.4)), ("velocity_z", x[:, 1])):
        np.testing.assert_allclose(shown(view.plot_field(run, slice="y=0.4", field=name))[1], value, err_msg=name)


@pytest.mark.parametrize("motion", [Sway(0.2, 1.0, direction=(1.0, 1.0, 0.0), ramp=0.0), Roll(0.3, 1.0, ramp=0.0)])
def test_the_room_sees_the_slice_where_its_tank_is(motion):
    case, time = tank(frame=motion), 0.2
    flow = {**vars(water(case)), "time": time}
    plane = Slice.through(case, "world", "y=0.4")
    layer = np.abs(flow["x"][:, 1] - 0.4) < 1e-6
    x = motion.placed(flow["x"][layer], time)
    u = motion.turned(flow["u"][layer], time) + motion.velocity_at(x, time)
    found = plane.snapshot(flow)
    np.testing.assert_allclose(found["x"], x[:, [0, 2]], atol=1e-12)
    np.testing.assert_allclose(found["u"], u, atol=1e-12)
    np.testing.assert_allclose(plane.placed(flow["x"][layer][:, [0, 2]], time), x[:, [0, 2]], atol=1e-12)
    assert "seen from the room" in plane.note(time)


def test_a_tank_that_turns_out_of_the_plane_is_seen_from_itself_only():
    case = tank(frame=Yaw(0.3, 1.0, ramp=0.0, centre=(0.5, 0.5, 0.0)))
    assert Slice.through(case, "tank", "y=0.4").note(0.2)
    with pytest.raises(CaseError, match="--frame world: the tank turns out of the plane.*--frame tank"):
        Slice.through(case, "world", "y=0.4")


def test_pieces_of_triangles_lie_in_the_plane():
    corners = np.array([[(0, 0, 0), (2, 0, 0), (0, 2, 0)], [(0, 1, 0), (1, 1, 1), (0, 3, 2)], [(0, 5, 0), (1, 6, 0),
                        (0, 6, 1)]], float)
    np.testing.assert_allclose(np.sort(crossing(corners, 1, 1.0)[0], axis=0), [(0, 1, 0), (1, 1, 0)])
    assert len(crossing(corners, 1, 1.0)) == 1    # the second one touches it, the third one is beyond
    assert len(crossing(corners, 1, 5.5)) == 1


@pytest.mark.parametrize("given, word", [("0.4", "such as y=0.47"), ("q=1", "such as y=0.47"), ("y=1e", "such as"),
                                         ("y=2", "from y = 0 to 0.8 m"), ("x=-1", "from x = 0 to 1.2 m")])
def test_a_slice_that_is_not_there_is_refused(run, given, word):
    with pytest.raises(CaseError, match=word):
        view.plot_field(run, slice=given)


def test_whole_runs_movies_and_names_of_files(run, tmp_path):
    picture = overview.plot_overview(run, slice="y=0.1")
    assert any("$y$ = 0.1 m" in axes.get_title("left") for part in picture.subfigs for axes in part.axes)
    assert movies.movie(run, tmp_path / "a.gif", dpi=30, slice="z=0.05", field="role").exists()
    made, = orders.plot([run], 0.1, slice="x = 0.3")
    assert made.name == "flow_pressure_0.1000s_x=0.3.png"


def test_the_still_level_of_a_slice_is_that_of_the_water(run):
    plane = view.FieldView(run.scene, [run.snapshot(0)], Look(slice="x=0.25"))
    (left, right), (low, high) = plane.window
    assert left < 0.0 and right > 0.8 and low < 0.0 and DEPTH < high < DEPTH + 3 * S
