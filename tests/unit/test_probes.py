"""Probes on particles whose answers are known exactly."""

from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import (
    Box,
    ColumnHeight,
    Disc,
    Energy,
    Flux,
    Force,
    Momentum,
    PressureTap,
    ProbeArray,
    RunUp,
    SolitaryWave,
    SurfaceGauge,
    VelocityPoint,
    VelocityProfile,
    Volume,
    WaterFront,
)
from parisph.base.errors import CaseError
from parisph.base.fields import BALLISTIC, DRY, FLUID, INNER, SURFACE, WALL, WET
from parisph.case import probes as descriptions
from parisph.geometry import build
from parisph.watch import instruments
from parisph.watch.gauges import bodies
from parisph.watch.probes.surface_gauge import surface_height
from parisph.watch.sampling import ProbeScene, Sampler
from tests.watched import DENSITY, G, Watch, add_fluid, at_walls, mirrored, only, scene

S = 0.05


def value(probe, change=None, **options):
    """Return what one probe with one column gives for a scene."""
    return only(Watch(scene([probe], **options), change=change).sample())


# -- surface gauge ------------------------------------------------------------------------

def wave_error(at, spacing, phase="cos(pi*x)"):
    found = value(SurfaceGauge(name="g", at=at), spacing=spacing, elevation=f"0.05*{phase}")
    return abs(found - 0.5 - 0.05 * eval(phase, {"cos": np.cos, "sin": np.sin, "pi": np.pi, "x": at}))


@pytest.mark.parametrize("at", [0.0, 0.013, 0.02, 0.317, 1 / 3, 0.72, 0.99, 1.0])
def test_the_gauge_is_of_fourth_order_on_a_wave_between_walls(at):
    errors = [wave_error(at, spacing) for spacing in (0.1, 0.05, 0.025)]
    assert errors[0] < 2e-4 and errors[1] < 2e-5 and errors[2] < 1.5e-6  # of an amplitude of 0.05


def test_the_gauge_mirrors_in_walls_only():
    """A wave with a slope at the wall is not what a wall allows: there the gauge sees its even continuation."""
    assert wave_error(0.0, 0.05, "sin(pi*x)") > 1e-3
    assert wave_error(0.5, 0.05, "sin(pi*x)") < 1e-9  # a particle is there
    assert wave_error(0.231, 0.05, "sin(pi*x)") < 3e-5


@pytest.mark.parametrize("wall, side", [(0.0, 1), (1.0, -1)])
def test_at_a_wall_it_is_the_even_parabola_through_the_nearest_two(wall, side):
    a, b, y1, y2 = 0.8 * S, 2.1 * S, 0.512, 0.497

    def change(arrays):
        lid = np.flatnonzero((arrays["role"] == SURFACE) & (np.abs(arrays["x"][:, 0] - wall) < 2.5 * S))
        lid = lid[np.argsort(np.abs(arrays["x"][lid, 0] - wall))]
        arrays["x"][lid] = [(wall + side * a, y1), (wall + side * b, y2)]

    found = value(SurfaceGauge(name="g", at=wall), change)
    assert found == pytest.approx((y1 * b**2 - y2 * a**2) / (b**2 - a**2), abs=1e-14)


def test_the_gauge_does_not_jump_when_a_particle_passes_it():
    def moved(by):
        def change(arrays):
            fluid = arrays["kind"] == FLUID
            arrays["x"][fluid, 0] += by * np.sin(np.pi * arrays["x"][fluid, 0])
        return change

    before, after = (value(SurfaceGauge(name="g", at=0.4), moved(by), elevation="0.05*cos(3*pi*x)")
                     for by in (-1e-9, 1e-9))
    assert before == pytest.approx(after, abs=1e-9)
    assert value(SurfaceGauge(name="g", at=0.4), moved(0.02),
                 elevation="0.05*cos(3*pi*x)") != pytest.approx(after, abs=1e-4)


@pytest.mark.parametrize("x, role", [
    ([(0.5, 0.62)], SURFACE),                            # a droplet above
    ([(0.5, 0.62)], BALLISTIC),
    ([(0.46, 0.70), (0.5, 0.71), (0.54, 0.70)], SURFACE),
    ([(0.41, 0.62), (0.57, 0.65)], SURFACE),              # droplets beside
    ([(0.595, 0.53)], BALLISTIC),
    ([(0.49, 0.38), (0.53, 0.36), (0.51, 0.30)], SURFACE),  # the surface of a cavity below
])
def test_spray_and_cavities_do_not_touch_a_smooth_surface(x, role):
    probe = SurfaceGauge(name="g", at=0.51)
    clean = value(probe, elevation="0.02*sin(pi*x)")
    assert clean == pytest.approx(0.5 + 0.02 * np.sin(np.pi * 0.51), abs=1e-5)
    assert value(probe, lambda arrays: add_fluid(arrays, x, role), elevation="0.02*sin(pi*x)") == clean


@pytest.mark.parametrize("height", [0.3, 0.6, 0.7])
def test_the_gauge_finds_the_crest_of_a_steep_wave_whose_columns_are_stretched(height):
    """Under it particles lie apart by as much as droplets above a calm surface do."""
    wave = SolitaryWave(height=0.5 * height, depth=0.5, at=1.5)
    for at in (1.47, 1.5, 1.6):
        found = value(SurfaceGauge(name="g", at=at), width=3.0, tank=(3.0, 1.0), wave=wave)
        assert found - 0.5 == pytest.approx(wave.elevation(at, 0.0), abs=2e-3 * height)


def test_at_a_vertical_front_the_gauge_gives_the_top_of_the_column():
    options = {"width": 0.5, "depth": 0.8}
    for at, truth in ((0.5, 0.8), (0.52, 0.8), (0.47, 0.8), (0.2, 0.8), (0.7, 0.0)):
        assert value(SurfaceGauge(name="g", at=at), **options) == pytest.approx(truth, abs=1e-12), at


@pytest.mark.parametrize("points, height", [
    ([(-1.5, 0.0), (-0.5, 0.0), (0.5, 0.0), (1.5, -4.0)], 0.0),       # an edge: the parabola of the other three
    ([(-1.5, 0.1), (-0.5, 0.0), (0.5, 0.1), (1.5, -4.0)], 0.025),
    ([(-1.6, 0.0), (-0.6, 0.3), (0.6, -3.0), (1.6, -3.0)], 1.0),      # a step right here: the top
    ([(-1.5, 0.0), (-0.5, 0.0)], 1.0),
    ([(-0.5, 0.0), (0.5, 0.2)], 0.1),
    ([(-1.5, -0.1), (-0.5, 0.0), (0.0, 0.1), (0.0, 0.4), (0.5, 0.0)], 0.4),
    ([(-1.0, 0.0), (-0.02, 0.1), (0.02, -1.6), (1.0, 0.0)], 0.1 / 0.9996),  # a cavity below
    ([(-0.01, 0.0), (0.01, 0.01)], 1.0),                              # as good as one particle
    ([(-2.4, -1.0), (-2.1, 0.0), (2.1, 0.0), (2.4, -1.0)], 1.0),      # water that touches a lid here
])
def test_what_is_no_smooth_surface_is_left_out(points, height):
    x, y = np.array(points).T
    for order in (slice(None), slice(None, None, -1)):
        found = surface_height(2.0, 2.0 + 0.1 * x[order], 0.1 * y[order], 0.1, 0.1, [])
        assert found == pytest.approx(0.1 * height, abs=1e-12)


def test_without_water_the_gauge_gives_the_bed_and_without_a_bed_nothing():
    assert value(SurfaceGauge(name="g", at=2.9), width=0.5, tank=(1.0, 1.0), at=(2.0, 3.0)) == 3.0
    assert np.isnan(value(SurfaceGauge(name="g", at=0.8), width=0.5, tank=None))
    assert value(SurfaceGauge(name="g", at=0.0), shape=Disc(radius=0.5), tank=None) == pytest.approx(0.5)


# -- water column and front ---------------------------------------------------------------

@pytest.mark.parametrize("at, height", [(0.0, 0.8), (0.3, 0.8), (0.5, 0.8), (0.574, 0.8), (0.576, 0.0), (1.0, 0.0)])
def test_the_column_is_as_high_as_its_topmost_particle(at, height):
    assert value(ColumnHeight(name="c", at=at), width=0.5, depth=0.8) == pytest.approx(height)


@pytest.mark.parametrize("x, role, height", [
    ([(0.3, 0.94)], SURFACE, 0.8),              # air below
    ([(0.3, 0.84)], BALLISTIC, 0.8),            # in free flight
    ([(0.3, 0.84)], SURFACE, 0.84),
    ([(0.35, 0.84), (0.28, 0.9)], SURFACE, 0.9),
    ([(0.7, 0.9)], SURFACE, 0.8),               # elsewhere
])
def test_the_column_stands_on_the_bed(x, role, height):
    found = value(ColumnHeight(name="c", at=0.3), lambda arrays: add_fluid(arrays, x, role), width=0.5, depth=0.8)
    assert found == pytest.approx(height)


def test_a_gap_inside_the_water_does_not_end_the_column():
    """Beside a wall the column has one row of particles, which come to be 2.2 spacings apart."""
    def stretched(arrays):
        row = (arrays["x"][:, 0] < 0.1) & (arrays["kind"] == FLUID)
        arrays["role"][arrays["kind"] == FLUID] = INNER
        arrays["x"][row & (arrays["x"][:, 1] > 0.4), 1] += 0.06

    assert value(ColumnHeight(name="c", at=0.0), stretched, width=0.5, depth=0.8) == pytest.approx(0.86)


def test_air_above_water_that_is_inside_ends_the_column_all_the_same():
    def torn(arrays):
        arrays["role"][arrays["kind"] == FLUID] = INNER
        above = (arrays["x"][:, 1] > 0.4) & (arrays["kind"] == FLUID)
        arrays["x"][above, 1] += 0.13    # 3.6 spacings apart

    assert value(ColumnHeight(name="c", at=0.3), torn, width=0.5, depth=0.8) == pytest.approx(0.4)


def test_a_drop_on_its_way_down_is_no_column():
    assert value(ColumnHeight(name="c", at=0.5), shape=Disc(radius=0.2, at=(0.5, 0.6))) == 0.0
    assert value(ColumnHeight(name="c", at=0.5), shape=Disc(radius=0.2, at=(0.5, 0.6)), tank=None) == pytest.approx(0.8)


@pytest.mark.parametrize("x, role, front", [
    ([], SURFACE, 0.5),
    ([(0.58, 0.03), (0.66, 0.04)], SURFACE, 0.66),                       # a tongue
    ([(0.58, 0.03), (0.66, 0.04)], BALLISTIC, 0.5),
    ([(0.62, 0.03), (0.67, 0.04), (0.7, 0.02), (0.66, 0.08)], SURFACE, 0.5),  # droplets ahead
    ([(0.55, 0.4), (0.6, 0.4)], SURFACE, 0.5),                          # far above the bed
])
def test_the_front_is_that_of_the_main_body_on_the_bed(x, role, front):
    found = value(WaterFront(name="f"), lambda arrays: add_fluid(arrays, np.reshape(x, (-1, 2)), role), width=0.5)
    assert found == pytest.approx(front)


def test_the_front_without_a_tank_is_that_of_all_the_fluid():
    assert value(WaterFront(name="f"), shape=Disc(radius=0.5, at=(0.3, 0.0)), tank=None) == pytest.approx(0.8)


def test_the_main_body_is_that_of_most_particles_not_of_most_ranks():
    view = SimpleNamespace(scene=SimpleNamespace(spacing=S))
    rows = np.array([[1.0, 0.05, 0.5, 20.0], [1.0, 0.8, 0.82, 2.0], [1.0, 0.85, 0.9, 3.0]])  # of three ranks
    assert WaterFront(name="f").values((), rows, view) == (0.5,)


def test_bodies_of_parts_are_the_bodies_of_the_whole():
    random = np.random.default_rng(1)
    z = np.cumsum(random.exponential(1.0, 200))
    whole = bodies(z, 2.0)
    assert len(whole) > 10 and whole[:, 2].sum() == 200
    assert np.all(whole[1:, 0] - whole[:-1, 1] > 2.0)
    parts = np.concatenate([bodies(part, 2.0) for part in (z[::3], z[1::3][::-1], z[2::3])])
    np.testing.assert_array_equal(bodies(parts[:, 0], 2.0, parts[:, 2], parts[:, 1]), whole)
    assert bodies(np.empty(0), 1.0).shape == (0, 3)


# -- pressure -----------------------------------------------------------------------------

def hydrostatic(arrays):
    wall = arrays["kind"] == WALL
    arrays["p"][wall] = DENSITY * G * (0.5 - arrays["x"][wall, 1])
    arrays["p"][arrays["kind"] == FLUID] = 1e9  # of no concern to a tap


@pytest.mark.parametrize("at, depth", [
    ((0.0, 0.25), 0.25), ((0.0, 0.263), 0.237), ((1.0, 0.111), 0.389), ((0.0, 0.0), 0.5), ((1.0, 0.02), 0.48),
    ((0.0, 0.34), 0.16), ((0.37, 0.0), 0.5), ((0.02, 0.0), 0.5),
])
def test_a_tap_is_exact_where_pressure_is_linear(at, depth):
    assert value(PressureTap(name="p", at=at), hydrostatic) == pytest.approx(DENSITY * G * depth, rel=1e-12)


def one_particle_at(y):
    def change(arrays):
        arrays["p"][(arrays["kind"] == WALL) & np.all(np.abs(arrays["x"] - (0.0, y)) < 1e-9, axis=1)] = 100.0
    return change


def test_a_tap_of_one_spacing_takes_the_two_wall_particles_beside_it_and_no_other():
    for y, weight in ((0.25, 1.0), (0.26, 0.8), (0.2, 0.0), (0.24, 0.8), (0.3, 0.0)):
        for radius in (S, 0.1 * S):
            tap = PressureTap(name="p", at=(0.0, y), radius=radius)
            assert value(tap, one_particle_at(0.25)) == pytest.approx(100.0 * weight, abs=1e-9)


@pytest.mark.parametrize("away", [1e-4, 0.01, 0.02, 0.1])
def test_a_tap_of_one_spacing_is_exact_close_to_a_particle(away):
    tap = PressureTap(name="p", at=(0.0, 0.25 + away * S), radius=S)
    assert value(tap, hydrostatic) == pytest.approx(DENSITY * G * (0.25 - away * S), rel=1e-9)


@pytest.mark.parametrize("radius, given", [(3 * S, None), (3 * S, 3 * S), (4.5 * S, 4.5 * S)])
def test_a_tap_weighs_the_wall_within_its_radius(radius, given):
    def weight(y):
        return max(0.0, 1.0 - (y / radius) ** 2) ** 2
    total = sum(weight(k * S) for k in range(-6, 7))
    for away in range(6):
        found = value(PressureTap(name="p", at=(0.0, 0.5 + away * S), radius=given), one_particle_at(0.5))
        assert found == pytest.approx(100.0 * weight(away * S) / total, abs=1e-9)


def test_a_tap_does_not_see_the_wall_across_the_corner():
    """The bed beside the corner is within the radius of a tap on the left wall."""
    def change(arrays):
        arrays["p"][(arrays["kind"] == WALL) & (arrays["x"][:, 0] > 0.5 * S)] = 1e9
    assert value(PressureTap(name="p", at=(0.0, S)), change) == 0.0


def test_a_dry_wall_has_no_pressure():
    assert value(PressureTap(name="p", at=(0.0, 0.8)), hydrostatic) == 0.0

    def dry(arrays):
        hydrostatic(arrays)
        arrays["role"][(arrays["kind"] == WALL) & (arrays["x"][:, 1] > 0.27)] = DRY
    assert value(PressureTap(name="p", at=(0.0, 0.275), radius=S), dry) == pytest.approx(0.5 * DENSITY * G * 0.25)


# -- energy and momentum ------------------------------------------------------------------

# Rows 1 to 10 above the bed have their centre of mass at ROWS times half their height: the first
# stands for 3/2 cells, the last, on the surface, for 1/2.
ROWS = (1.5 * 1 + sum(range(2, 10)) + 0.5 * 10) / (10 * 5)


def test_energy_and_momentum_of_a_moving_box():
    watch = Watch(scene([Energy(name="e"), Momentum(name="m")], velocity=(0.3, -0.2), tank=(1.0, 1.0), at=(2.0, 3.0)),
                  MPI.COMM_SELF, lambda arrays: arrays["u"].__setitem__(arrays["kind"] == WALL, 7.0))
    mass = DENSITY * 1.0 * 0.5
    kinetic, potential, total = watch.sample()["e"]
    assert kinetic == pytest.approx(0.5 * mass * 0.13, rel=1e-12)
    assert potential == pytest.approx(mass * G * 0.25 * ROWS, rel=1e-12)  # the bed is at y = 3
    assert total == kinetic + potential
    np.testing.assert_allclose(watch.sample()["m"], mass * np.array([0.3, -0.2]), rtol=1e-12)
    assert [tuple(w.columns.items()) for w in watch.samplers] == [
        (("kinetic", "J/m"), ("potential", "J/m"), ("total", "J/m")), (("px", "kg/s"), ("py", "kg/s"))]


def test_energy_of_a_rotation_and_of_free_flight():
    n = 21
    found = Watch(scene([Energy(name="e")], tank=None, shape=Box(width=1.0, height=1.0, at=(-0.5, -0.5)),
                        gravity=(0.0, 0.0), velocity=("2*y", "-2*x")), MPI.COMM_SELF,
                  lambda arrays: arrays["role"].__setitem__(slice(0, 100), BALLISTIC)).sample()["e"]
    weight = np.where(np.isin(np.arange(n), (0, n - 1)), 0.5, 1.0)     # cells on the edge are half empty
    squares = weight @ (np.arange(n) - 10) ** 2 * S**2
    assert found == pytest.approx((0.5 * DENSITY * S**2 * 4 * 2 * (n - 1) * squares, 0.0, found[0]))
    assert found[0] == pytest.approx(0.5 * DENSITY * 4 / 6, rel=0.01), "the integral of u^2 over the unit square"


@pytest.mark.parametrize("gravity, factor", [((0.0, "-9.81"), 1.0), ((0.0, "-2*9.81"), 2.0), ((0.0, "-9.81*t"), 0.0),
                                             (("-x", -9.81), 0.0)])
def test_only_a_uniform_constant_force_has_a_potential(gravity, factor):
    found = Watch(scene([Energy(name="e")], gravity=gravity)).sample()["e"]
    assert found[1] == pytest.approx(factor * DENSITY * 0.5 * G * 0.25 * ROWS)


@pytest.mark.parametrize("options", [
    {}, {"width": 0.5, "depth": 0.9}, {"lid": True, "depth": 1.0}, {"lid": True, "depth": 0.95}, {"tank": None},
    {"depth": 0.1},
])
def test_on_the_lattice_current_volumes_are_those_of_the_start(options):
    """Water on a dry bed, up to a lid and one spacing below it, and without a tank."""
    watch = Watch(scene([Energy(name="e", current=True)], velocity=("1 + x", "y"), **options))
    found = watch.sample()["e"]
    assert list(watch.samplers[0].columns.items())[3:] == [
        ("kinetic_now", "J/m"), ("potential_now", "J/m"), ("total_now", "J/m"), ("volume_now", "m^2")]
    width, depth = options.get("width", 1.0), options.get("depth", 0.5)
    assert found[3:6] == pytest.approx(found[:3], rel=1e-13)
    assert found[6] == pytest.approx(width * depth, rel=1e-14)


def test_energy_by_current_volumes_converges_on_a_disordered_wave():
    """To that of the water below the surface, with the second order of cells that are represented by points."""
    truth = DENSITY * G * 0.5 * (0.5**2 + 0.5 * 0.1**2)
    errors = []
    for spacing in (0.05, 0.025, 0.0125):
        found = Watch(scene([Energy(name="e", current=True)], spacing=spacing, jitter=0.4, elevation="0.1*cos(pi*x)"),
                      MPI.COMM_SELF).sample()["e"]
        errors.append(abs(found[4] / truth - 1.0))
        assert found[6] == pytest.approx(0.5, rel=0.1 * spacing)
    assert errors[0] < 0.011 and errors[2] < 0.0012
    assert np.log2(errors[0] / errors[2]) / 2 > 1.7, errors


def cube():
    return ProbeScene(3, S, np.full(3, S), DENSITY, np.zeros(3), np.ones(3), True, np.array([0.0, 0.0, -G]))


def test_current_volumes_are_refused_in_3d():
    with pytest.raises(CaseError, match="'e': current volumes exist in 2D only"):
        Sampler(Energy(name="e", current=True), cube())


# -- volume -------------------------------------------------------------------------------

def cell_by_clipping(i, x):
    """Return the area of the Voronoi cell of x[i] among all x, half plane by half plane, and its farthest corner."""
    corners = [np.array(c) for c in ((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0))]
    for j in np.argsort(np.sum((x - x[i]) ** 2, axis=1))[1:40]:
        r, kept = x[j] - x[i], []
        beyond = [c @ r - 0.5 * r @ r for c in corners]
        for k, corner in enumerate(corners):
            if beyond[k - 1] * beyond[k] < 0:
                t = beyond[k - 1] / (beyond[k - 1] - beyond[k])
                kept.append(corners[k - 1] + t * (corner - corners[k - 1]))
            if beyond[k] <= 0:
                kept.append(corner)
        corners = kept
    x, y = np.array(corners).T
    return 0.5 * abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)), np.hypot(x, y).max()


SIDES = [(0, 0.0), (0, 1.0), (1, 0.0)]    # of a tank, axis and place


def inside_by_distance(p, walls=SIDES):
    """Return the particles whose cells count, and these cells: lists of 2.6 S know corners up to 1.3 S away."""
    away = np.linalg.norm(p.x[:, None] - p.x[None], axis=-1)
    deep = np.flatnonzero((p.kind == FLUID) & (p.role == INNER)
                          & (away[:, np.isin(p.role, (SURFACE, BALLISTIC))].min(axis=1, initial=9.0) >= 2.1 * S))
    fluid = np.flatnonzero(p.kind == FLUID)
    sites = mirrored(p.x[fluid], walls)
    cells = np.array([cell_by_clipping(np.flatnonzero(fluid == i)[0], sites) for i in deep])
    return deep[cells[:, 1] < 1.3 * S], cells[cells[:, 1] < 1.3 * S, 0]


@pytest.mark.parametrize("jitter", [0.0, 0.4, 0.8])
def test_volume_is_the_mean_cell_inside_the_fluid(jitter):
    """Cells end at walls, and a particle that began beside them represents their half cells."""
    case = scene([Volume(name="v")], jitter=jitter, tank=(1.0, 1.0))

    def change(arrays):
        fluid = arrays["kind"] == FLUID
        arrays["x"][fluid] += build.jitter(case, arrays["id"], arrays["role"] == SURFACE)[fluid]
        arrays["role"][40] = BALLISTIC
    watch = at_walls(Watch(case, change=change), SIDES, Watch(case))
    cell, count = watch.sample()["v"]
    chosen, areas = inside_by_distance(watch.particles)
    assert count == len(chosen) and 100 < count < 19 * 8
    assert cell == pytest.approx(np.sum(areas) / np.sum(1.0 + watch.particles.beside[chosen]) / S**2, rel=1e-12)
    assert (cell == pytest.approx(1.0, abs=1e-12)) == (jitter == 0.0)


def test_a_squeezed_drop_has_a_smaller_volume():
    def change(arrays):
        arrays["x"] *= (0.97, 0.99)
    cell, count = Watch(scene([Volume(name="v")], tank=None, shape=Disc(radius=0.5)), MPI.COMM_SELF,
                        change).sample()["v"]
    assert cell == pytest.approx(0.97 * 0.99, rel=1e-12) and count > 100


def test_a_cell_counts_as_what_its_particle_represents():
    """Fluid that has left a wall represents the half cell there besides its own."""
    watch = at_walls(Watch(scene([Volume(name="v")], tank=(1.0, 1.0))), SIDES)
    p, (chosen, _) = watch.particles, inside_by_distance(watch.particles)
    own = np.sum(1.0 + p.beside[chosen])
    p.beside[:] += 0.5
    cell, count = watch.sample()["v"]
    assert cell == pytest.approx(own / (own + 0.5 * len(chosen)), abs=1e-12) and count == len(chosen)


def test_a_cell_that_nothing_closes_is_left_out():
    def change(arrays):  # a cavity without a surface, which the lists do not reach across
        hole = np.linalg.norm(arrays["x"] - (0.5, 0.25), axis=1) < 0.07
        for name in arrays:
            arrays[name] = arrays[name][~hole]
    case = scene([Volume(name="v")], lid=True, depth=1.0)
    sides = [*SIDES, (1, 1.0)]
    whole, full = at_walls(Watch(case), sides).sample()["v"]
    cell, count = at_walls(Watch(case, change=change), sides).sample()["v"]
    assert full == 19 * 19 - 4 and whole == pytest.approx(1.0, abs=1e-12)
    assert count < full - 5 and cell < 1.02


def test_where_nothing_is_deep_there_is_no_volume():
    found = Watch(scene([Volume(name="v")], depth=0.1)).sample()["v"]
    assert np.isnan(found[0]) and found[1] == 0.0


# -- velocity profile ---------------------------------------------------------------------

def quadratic(x):
    """Return u, v and p (n, 3) of a flow that is quadratic in x (n, 2)."""
    a, b = x.T
    return np.column_stack([1.0 + 2.0 * a - b + 3.0 * a * b - b**2, a**2 - 0.5 * b + a * b, 7.0 - a + 4.0 * b**2])


def flowing(arrays):
    found = quadratic(arrays["x"])
    arrays["u"][:], arrays["p"][:] = found[:, :2], found[:, 2]
    arrays["role"][arrays["kind"] == WALL] = WET


@pytest.mark.parametrize("start, end", [((0.0, 0.5), (1.0, 0.5)), ((0.5, 0.0), (0.5, 1.0)), ((0.0, 0.0), (1.0, 1.0))])
def test_a_velocity_profile_is_exact_for_quadratic_flow(start, end):
    """In disorder and up to the walls, corners included."""
    probe = VelocityProfile(name="line", start=start, end=end, points=11)
    watch = Watch(scene([probe], lid=True, depth=1.0, jitter=0.6), change=flowing)
    found = np.reshape(watch.sample()["line"], (11, 3))
    np.testing.assert_allclose(found, quadratic(np.linspace(start, end, 11)), atol=1e-11)
    columns = watch.samplers[0].columns
    assert len(columns) == 33 and list(columns)[:4] == ["u_0", "v_0", "p_0", "u_1"]
    assert columns["u_0"] == columns["v_10"] == "m/s" and columns["p_10"] == "Pa"


def test_a_velocity_profile_has_no_values_outside_the_fluid():
    probe = VelocityProfile(name="line", start=(0.5, 0.0), end=(0.5, 1.0), points=5)
    found = np.reshape(Watch(scene([probe], velocity=(0.3, 0.0))).sample()["line"], (5, 3))
    assert np.isnan(found[3:]).all() and np.isfinite(found[1:3]).all()
    np.testing.assert_allclose(found[1, :2], (0.3, 0.0), atol=1e-12)


def test_a_velocity_profile_ignores_what_has_no_pressure_equation():
    def change(arrays):
        flowing(arrays)
        stray = np.random.default_rng(3).random(len(arrays["x"])) < 0.1
        arrays["role"][stray] = BALLISTIC
        arrays["u"][stray] = 100.0

    probe = VelocityProfile(name="line", start=(0.2, 0.3), end=(0.8, 0.7), points=7)
    found = np.reshape(Watch(scene([probe], lid=True, depth=1.0), change=change).sample()["line"], (7, 3))
    np.testing.assert_allclose(found, quadratic(probe.places), atol=1e-10)


# -- all of them --------------------------------------------------------------------------

ALL = [SurfaceGauge(name="gauge", at=0.42), PressureTap(name="tap", at=(0.0, 0.2)), WaterFront(name="front"),
       ColumnHeight(name="column", at=0.3), Energy(name="energy"), Volume(name="volume"), Momentum(name="momentum"),
       VelocityProfile(name="line", start=(0.5, 0.1), end=(0.5, 0.4), points=3), VelocityPoint("point", at=(0.4, 0.2)),
       RunUp("side", side="left"), RunUp("wall", points=[(1.0, 0.0), (1.0, 1.0)]), Force("load", side="left"),
       PressureTap("disc", at=(0.0, 0.3), diameter=0.2), Force("dynamic", still=0.5, acted=True),
       Flux("through", start=(0.5, 0.0), end=(0.5, 1.0)),
       ProbeArray("several", [SurfaceGauge("g", at=0.3), PressureTap("t", at=(0.0, 0.2)), Force("f"), Volume("v")])]


def test_every_probe_that_a_case_can_have_can_be_sampled():
    assert {*descriptions.ours(), "probe_array"} == {probe.kind for probe in ALL}


def test_together_they_give_what_each_gives_alone():
    watch = Watch(scene(ALL, velocity=(0.1, 0.0), jitter=0.3), change=hydrostatic)
    together = watch.sample()
    assert list(together) == [probe.name for probe in ALL]
    for sampler in watch.samplers:
        assert instruments.sample_all([sampler], watch.particles, watch.domain, 0.0) == {
            sampler.name: together[sampler.name]}
        assert len(together[sampler.name]) == len(sampler.columns) and sampler.title
        assert all(type(number) is float and np.isfinite(number) for number in together[sampler.name])
    assert instruments.sample_all([], watch.particles, watch.domain, 0.0) == {}


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_a_run_that_breaks_down_is_still_sampled(share):
    watch = Watch(scene(ALL))
    p = watch.particles
    for name in ("x", "u", "p"):
        getattr(p, name)[np.random.default_rng(2).random(p.n_owned) < share] = np.nan
    assert np.isnan(watch.sample()["energy"][2])


def test_energy_and_momentum_in_three_dimensions():
    mid = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 0.25]])
    p = SimpleNamespace(comm=MPI.COMM_SELF, kind=np.zeros(2, np.int8), role=np.zeros(2, np.int8), x=mid,
                        u=np.ones((2, 3)), volume=np.full(2, S**3))
    energy, momentum = (Sampler(probe, cube()) for probe in (Energy(name="e"), Momentum(name="m")))
    found = instruments.sample_all([energy, momentum], p, None, 0.0)
    assert found["e"] == pytest.approx(DENSITY * S**3 * np.array([3.0, 0.75 * G, 3.0 + 0.75 * G]))
    assert found["m"] == pytest.approx([2 * DENSITY * S**3] * 3)
    assert energy.columns["total"] == "J" and list(momentum.columns) == ["px", "py", "pz"]
