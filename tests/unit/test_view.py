"""Pictures: what a reader of them relies on - sizes, scales, units, walls, marks - and clear errors."""

import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Disc, Energy, Fluid, Numerics, Obstacle, PressureTap, SurfaceGauge, Tank, Truth, Volume
from parisph.base.errors import CaseError, MissingLibrary, StoreError
from parisph.base.fields import BALLISTIC, DRY, FIELDS, FLUID, INNER, SURFACE, WALL, WET
from parisph.io.reader import open_run
from parisph.io.store import Store
from parisph.pictures import curves, movies, overview, style, view
from tests import watched
from tests.stored import stored

pytest.importorskip("matplotlib")
S = 0.05  # particle spacing [m]
STEPS = {"steps": {"dt": "s", "iterations": ""}, "probes/P1": {"pressure": "Pa"}}    # columns


def basin(**changes):
    """Water of 1 m x 0.5 m in a tank of 1 m x 0.8 m."""
    about = dict(title="Basin", fluid=Fluid(Box(1.0, 0.5), density=1000.0), walls=Tank(1.0, 0.8), gravity=(0.0, -9.81),
                 numerics=Numerics(spacing=S), end_time=1.0,
                 probes=[PressureTap("P1", at=(0.0, 0.1)), SurfaceGauge("left", at=0.0), Energy("energy"),
                         Volume("volume")])
    return Case(**{**about, **changes})


def water(spike=0.0):
    """Particles of the basin at rest, one of them with another pressure [Pa]."""
    across, up = (np.arange(S, end + S / 2, S) for end in (1.0 - S, 0.5))
    fluid = np.array([(x, y) for x in across for y in up])
    wall = np.array([(0.0, y) for y in np.arange(0.0, 0.8, S)] + [(x, 0.0) for x in across])
    arrays = {name: field.empty(len(fluid) + len(wall), 2) for name, field in FIELDS.items()}
    arrays["id"][:] = np.arange(len(arrays["id"]))
    arrays["x"][:] = np.concatenate((fluid, wall))
    arrays["kind"][len(fluid):] = WALL
    top = fluid[:, 1] > 0.5 - S / 2
    arrays["role"][:] = np.concatenate((np.where(top, SURFACE, INNER), np.full(len(wall), WET)))
    arrays["role"][3] = BALLISTIC
    arrays["p"][:] = 9810.0 * np.maximum(0.5 - arrays["x"][:, 1], 0.0)
    arrays["p"][5] += spike
    arrays["u"][:, 0] = 2.0
    return SimpleNamespace(dim=2, offset=0, n_owned=len(arrays["id"]), n_global=len(arrays["id"]), **arrays)


def written(folder, case, particles, count=3):
    series = {**STEPS, "probes/left": {"height": "m"}, "probes/energy": {"kinetic": "J/m", "potential": "J/m"},
              "probes/volume": {"cell": "", "count": "particles"}}
    samples = [(0.01 * step, step, {"steps": (0.01, 8), "probes/P1": (3924.0 + step,), "probes/left": (0.5,),
                                    "probes/energy": (1.0, 2.0), "probes/volume": (1.0, 9.5)}) for step in range(100)]
    return stored(folder, case, series, samples, [(particles, 0.1 * step, step) for step in range(count)])


@pytest.fixture
def run(tmp_path):
    return written(tmp_path / "run", basin(), water())


def discs(picture):
    """The layers of discs: ground, particles and, if asked for, rings of each kind."""
    return picture.axes[0].collections


def test_particles_are_discs_of_their_spacing_in_the_units_of_the_axes(run):
    for normalise, length in ((False, 1.0), (True, 0.5)):
        picture = view.plot_field(run, normalise=normalise)
        particles = discs(picture)[1]
        picture.draw_without_rendering()
        axes = picture.axes[0]
        metre = axes.transData.transform((1.0, 0.0))[0] - axes.transData.transform((0.0, 0.0))[0]
        scale = particles.get_transform().transform((1.0, 0.0))[0] - particles.get_transform().transform((0.0, 0.0))[0]
        radius = scale * particles.get_transforms()[:, 0, 0] / metre  # of a circle of radius 1
        np.testing.assert_allclose(radius, view.DISC * S / length / 2, rtol=1e-6)
        np.testing.assert_allclose(particles.get_offsets()[0], [S / length, S / length])
        assert axes.get_aspect() == 1.0


def test_axes_colour_bar_and_title_have_units(run):
    picture = view.plot_field(run, 2)
    axes, bar = picture.axes[0], discs(picture)[1].colorbar.ax
    assert (axes.get_xlabel(), axes.get_ylabel(), bar.get_ylabel()) == ("$x$ [m]", "$y$ [m]", "pressure $p$ [kPa]")
    title = axes.get_title(loc="left")
    assert title.startswith("Basin\n") and "0.200 s" in title and "= 0.89,   " in title    # 0.2 sqrt(9.81/0.5)
    assert title.endswith("$H$ = 0.5 m")
    picture = view.plot_field(run, 2, "speed", normalise=True)
    assert picture.axes[0].get_xlabel() == "$x/H$" and r"\sqrt{gH}" in discs(picture)[1].colorbar.ax.get_ylabel()
    np.testing.assert_allclose(discs(picture)[1].get_array(), 2.0 / np.sqrt(9.81 * 0.5))


def test_a_title_is_shown_as_it_stands(tmp_path):
    """Dollar signs are those of formulas to matplotlib, and fail where there is none."""
    title = r"tank for $5 or $\frac{1$"
    run = written(tmp_path / "run", basin(title=title), water())
    picture = view.plot_field(run, 0, path=tmp_path / "a.png")
    assert picture.axes[0].get_title(loc="left").startswith(title.replace("$", r"\$"))
    curves.plot_probe(run, path=tmp_path / "b.png")
    overview.plot_overview(run, path=tmp_path / "c.png")


def test_pressure_is_shown_in_kilopascal_and_the_scale_ends_at_the_greatest_value(tmp_path):
    run = written(tmp_path / "spike", basin(), water(spike=1e5))
    particles = discs(view.plot_field(run))[1]
    assert particles.get_clim() == (0.0, pytest.approx(101.962)) and particles.colorbar.extend == "neither"
    assert particles.get_array().max() == particles.get_clim()[1]
    low, high = discs(view.plot_field(run, limits=(0.0, 2.0)))[1].get_clim()
    assert (low, high) == (0.0, 2.0) and discs(view.plot_field(run, limits=(0.0, 2.0)))[1].colorbar.extend == "max"


def test_a_peak_on_the_wall_is_within_the_scale(tmp_path):
    """The wall particles carry it, and they are drawn; those of a dry wall are not."""
    def touched(role):
        arrays = water()
        arrays.p[arrays.kind == WALL] = np.where(arrays.x[arrays.kind == WALL, 1] < 0.1, 2e4, 0.0)
        arrays.role[arrays.kind == WALL] = role
        return arrays

    for role, high in ((WET, 20.0), (DRY, 9.81 * 0.45)):
        run = written(tmp_path / str(role), basin(), touched(role))
        assert discs(view.plot_field(run))[1].get_clim()[1] == pytest.approx(high)
    assert discs(view.plot_field(run, field="speed"))[1].get_clim() == (0.0, 2.0)


def test_a_spike_does_not_dim_pictures_of_several_moments(tmp_path):
    run = written(tmp_path / "spike", basin(), water(spike=1e7))
    low, high = next(axes for axes in overview.plot_overview(run).axes
                     if axes.get_ylabel() == "$y$ [m]").collections[1].get_clim()
    assert low == 0.0 and 4.0 < high < 5.0  # rho g d = 4.9 kPa


def test_zoom_shows_a_part_whose_values_alone_make_the_scale(run):
    axes = view.plot_field(run, zoom=(0.2, 1.2, 0.3, 0.6)).axes[0]
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.2, 1.2), (0.3, 0.6))
    assert axes.collections[1].get_clim()[1] == pytest.approx(9.81 * 0.2)      # of the particles at y = .3 m
    normalised = view.plot_field(run, zoom=(0.4, 2.4, 0.6, 1.2), normalise=True).axes[0]
    assert normalised.collections[1].get_clim()[1] == pytest.approx(0.4)


def test_colours_may_be_chosen(run):
    assert discs(view.plot_field(run, colours="magma"))[1].get_cmap().name == "magma"


@pytest.mark.parametrize("look, message", [
    ({"limits": (2.0, 1.0)}, "--limits: 2 to 1 is not a range; give two numbers, the lower one first"),
    ({"limits": (0.0, np.nan)}, "--limits"),
    ({"zoom": (1.0, 1.0, 0.0, 1.0)}, "--zoom, along x: 1 to 1 is not a range"),
    ({"zoom": (0.0, 1.0, 1.0, 0.0)}, "--zoom, up: 1 to 0 is not a range"),
    ({"zoom": (5.0, 6.0, 0.0, 1.0)}, "--zoom 5 6 0 1: nothing is there; the scene reaches from x = -0.03 to 1.03"),
    ({"colours": "virids"}, "no colour map 'virids' in matplotlib: try viridis"),
    ({"field": "role", "limits": (0.0, 1.0)}, "--limits does not apply to the field role"),
    ({"field": "role", "colours": "magma"}, "--cmap does not apply to the field role"),
    ({"field": "vorticity"}, "'vorticity' was not written"),
    ({"field": "density_ratio"}, "'alpha' was not written"), ({"which": 7}, "3 snapshots"),
    ({"path": "/no/such/folder/a.png"}, "cannot write the picture"), ({"path": "a.xyz"}, "cannot write the picture"),
])
def test_a_look_without_sense_and_what_cannot_be_drawn_are_said(run, look, message):
    with pytest.raises((CaseError, StoreError), match=re.escape(message)):
        view.plot_field(run, **look)


@pytest.mark.parametrize("more", [(), (Obstacle(Box(0.1, 0.1, at=(0.6, 0.0)), name="box"),)])
def test_the_ground_is_cut_at_the_tank(tmp_path, more):
    run = written(tmp_path / "run", basin(walls=(Tank(1.0, 0.8), *more), probes=[]), water())
    ground, particles = discs(view.plot_field(run))[:2]
    path, moved = ground.get_clip_path().get_transformed_path_and_affine()
    np.testing.assert_allclose(np.ptp(ground.axes.transData.inverted().transform(
        moved.transform(path.vertices)), axis=0), [1.0, 0.8])
    assert particles.get_clip_path() is None, "a particle that crosses a wall is seen"


@pytest.mark.parametrize("lid", [False, True])
def test_walls_are_lines_and_a_lid_is_drawn_if_there_is_one(tmp_path, lid):
    run = written(tmp_path / "run", basin(walls=Tank(1.0, 0.6, lid=lid)), water())
    line = view.plot_field(run).axes[0].lines[0]
    corners = [(0.0, 0.6), (0.0, 0.0), (1.0, 0.0), (1.0, 0.6)] + ([(0.0, 0.6)] if lid else [])
    np.testing.assert_allclose(np.transpose(line.get_data()), corners)


def test_only_wet_walls_fill_the_gap_to_the_wall_and_only_for_the_pressure(run):
    fluid = water().kind == FLUID
    inner, wet = np.sum(water().role[fluid] == INNER), np.sum(~fluid)
    assert len(discs(view.plot_field(run))[0].get_offsets()) == inner + wet
    assert len(discs(view.plot_field(run, field="speed"))[0].get_offsets()) == inner
    assert len(discs(view.plot_field(run))[1].get_offsets()) == np.sum(fluid)


def test_surface_particles_are_ringed_on_request(run):
    role = water().role
    picture = view.plot_field(run, surface=True)
    assert len(discs(picture)) == 4 and len(discs(view.plot_field(run))) == 2
    assert [len(rings.get_offsets()) for rings in discs(picture)[2:]] == [np.sum(role == SURFACE), 1]
    assert [text.get_text() for text in picture.axes[0].get_legend().get_texts()] == ["free surface", "ballistic"]


def test_signed_quantities_have_colours_about_zero_and_roles_a_legend(run):
    low, high = discs(view.plot_field(run, field="velocity_x"))[1].get_clim()
    assert low == -high == -2.0
    texts = view.plot_field(run, field="role").axes[0].get_legend().get_texts()
    assert {text.get_text() for text in texts} == {"inner", "free surface", "ballistic", "wet wall"}


def test_a_scene_without_tank_and_gravity_has_no_dimensionless_time(tmp_path):
    case = basin(fluid=Fluid(Disc(0.25, at=(0.5, 0.25)), density=1000.0), walls=None, gravity=("-x", "-y"), probes=[])
    run = written(tmp_path / "drop", case, water())
    picture = view.plot_field(run)
    assert picture.axes[0].get_title(loc="left") == "Basin\n$t$ = 0.200 s" and not picture.axes[0].lines
    with pytest.raises(CaseError, match="without constant gravity"):
        view.plot_field(run, normalise=True)


def test_pictures_and_movies_are_written(run, tmp_path):
    from PIL import Image

    view.plot_field(run, path=tmp_path / "a.png")
    overview.plot_overview(run, tmp_path / "b.png")
    curves.plot_probe(run, path=tmp_path / "c.pdf")
    movies.movie(run, tmp_path / "d.gif", dpi=40)
    with Image.open(tmp_path / "a.png") as picture, Image.open(tmp_path / "d.gif") as frames:
        assert picture.width > 800 and frames.n_frames == 3
    assert (tmp_path / "b.png").stat().st_size > 20000 and (tmp_path / "c.pdf").read_bytes().startswith(b"%PDF")


def test_probes_of_one_unit_share_axes_and_the_truth_lies_over_its_probe(run):
    few, many = np.linspace(0.0, 2.0, 20), np.linspace(0.0, 0.9, 100)
    picture = curves.plot_probe(run, truth={"P1": (few, 3924.0 + 0 * few), "left": (many, 0.5 + 0 * many)})
    labels = {axes.get_ylabel() for axes in picture.axes}
    assert labels == {"pressure $p$ [kPa]", "energy [J/m]", "surface height $y$ [m]",
                      "mean cell inside the fluid $/\\,s^2$ [-]", "cells counted [particles]"}
    pressure = next(axes for axes in picture.axes if "pressure" in axes.get_ylabel())
    probe, reference = pressure.lines
    assert probe.get_ydata()[0] == pytest.approx(3.924) and reference.get_ydata()[0] == pytest.approx(3.924)
    assert reference.get_marker() == "o" and reference.get_xdata().max() <= 0.99  # few samples; only where the run is
    energy = next(axes for axes in picture.axes if "energy" in axes.get_ylabel())
    assert [text.get_text() for text in energy.get_legend().get_texts()] == ["energy: kinetic", "energy: potential"]


def test_a_normalised_probe_has_the_scenes_own_units(run):
    axes = curves.plot_probe(run, "P1", normalise=True).axes[0]
    time, pressure = axes.lines[0].get_data()
    assert (pressure[0] == pytest.approx(3924.0 / (9810.0 * 0.5))
            and time[-1] == pytest.approx(0.99 * np.sqrt(9.81 / 0.5)))
    assert axes.get_xlabel() == r"$t\sqrt{g/H}$" and axes.get_ylabel() == r"pressure $p$$\,/\,(\rho g H)$"


def test_truths_named_in_the_case_are_read(run, tmp_path):
    (tmp_path / "truth.csv").write_text("t,eta\n0,0\n1,0.1\n")
    truth = Truth(str(tmp_path / "truth.csv"), time="t", value="eta", offset=0.5, scale=2.0)
    run.scene = run.scene.model_copy(update={"probes": (SurfaceGauge("left", at=0.3, truth=truth),)})
    (time, value), = curves.truths(run).values()
    np.testing.assert_allclose(time, [0.0, 1.0])
    np.testing.assert_allclose(value, [0.5, 0.7])


def test_what_is_misnamed_is_an_error_of_usage(run, tmp_path):
    for draw, says in ((lambda: view.plot_field(run, field="enstrophy"), "no quantity 'enstrophy' .*: pressure"),
                       (lambda: curves.plot_probe(run, "P9"), "no probe 'P9'"),
                       (lambda: movies.movie(run, tmp_path / "a.txt"), "ends in .gif or .mp4")):
        with pytest.raises(CaseError, match=says):
            draw()


def test_a_run_without_snapshots_or_probes_is_said(tmp_path):
    Store.create(MPI.COMM_SELF, tmp_path / "run", watched.scene([]).model_dump_json())
    for draw in (view.plot_field, overview.plot_overview, curves.plot_probe):
        with pytest.raises(StoreError, match="has no"):
            draw(tmp_path / "run")
    with pytest.raises(StoreError, match="has no snapshots"):
        movies.movie(tmp_path / "run", tmp_path / "a.gif")


def test_without_matplotlib_the_remedy_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingLibrary, match=r"pip install 'parisph\[plot\]'"):
        style.drawing()


def test_a_long_flume_is_drawn_stretched_and_says_so(tmp_path):
    case = basin(fluid=Fluid(Box(9.0, 0.2), density=1000.0), walls=Tank(9.0, 0.3), probes=[])
    written(tmp_path / "run", case, water())
    axes = view.plot_field(tmp_path / "run", 0).axes[0]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    stretch = axes.get_aspect()
    assert stretch == round(stretch) > 1.0 and 4.0 < (right - left) / (high - low) / stretch < 7.5
    assert f"vertical scale x{stretch:.0f}" in axes.get_title(loc="left")
    overview.plot_small(open_run(tmp_path / "run"), 0, tmp_path / "small.png")
    assert 1000 < (tmp_path / "small.png").stat().st_size < 60_000


@pytest.mark.parametrize("look", [{"slice": "y=0.1"}, {"view": "3d"}, {"field": "velocity_z"}])
def test_what_exists_in_3d_only_is_refused_of_a_2d_flow(run, look):
    with pytest.raises(CaseError, match="2D|3D only"):
        view.plot_field(run, **look)
