"""Motions of rigid bodies: poses, their derivatives, measured series, and the motions of wavemakers."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from parisph import CaseError, Heave, Moved, Roll, Series, Sway, load
from parisph.case.motion import AnyMotion, AtRest, FlapStroke, PistonStroke, Tabulated
from parisph.case.motion.second_order import second_harmonic
from parisph.case.motion.wavemaker import flap_ratio, piston_ratio
from parisph.case.waves import Airy, Jonswap, SolitaryWave, Stokes, StreamFunction, angular_frequency, wave_number

H = 1e-5
TIMES = tuple(np.linspace(0.0, 3.0, 16))
WAVY = Series(times=TIMES, values=tuple(0.1 * np.sin(2.0 * np.array(TIMES)) ** 2))
RATE = Series(times=TIMES, values=tuple(0.1 * np.sin(2.0 * np.array(TIMES)) ** 2), rate=True)
LONG = SolitaryWave(0.05, 0.25)
ALL = [
    AtRest(),
    Sway(0.02, 3.0, direction=(3.0, 4.0)),
    Heave(0.02, 3.0),
    Roll(0.1, 3.0, centre=(0.3, -0.2)),
    Roll(0.1, 3.0, ramp=0.0),
    Roll(WAVY, centre=(0.3, 0.1)),
    Roll(RATE),
    Moved(WAVY),
    Moved(RATE, (0.0, 1.0)),
    Tabulated(TIMES, WAVY.values),
    Tabulated(TIMES, RATE.values, rate=True),
    PistonStroke(LONG),
    PistonStroke(SolitaryWave(0.05, 0.25, "boussinesq", leftward=True)),
    PistonStroke(Airy(0.02, 1.0, 0.25)),
    PistonStroke(Stokes(0.02, 1.0, 0.25, leftward=True), place=0.4),
    PistonStroke(Jonswap(0.02, 1.0, 0.25, components=20)),
    PistonStroke(Airy(0.02, 1.0, 0.25), second_order=False, ramp=0.0),
    FlapStroke(Airy(0.02, 1.0, 0.25), centre=(0.1, 0.05)),
    FlapStroke(Jonswap(0.02, 1.0, 0.25, components=20)),
]
POINTS = np.array([[0.0, 0.0], [0.4, 0.3], [-1.0, 0.7]])


def slope(function, t):
    return (np.asarray(function(t + H)) - np.asarray(function(t - H))) / (2.0 * H)


@pytest.mark.parametrize("motion", ALL, ids=lambda motion: motion.kind)
def test_rates_are_derivatives_of_the_pose(motion):
    for t in (0.37, 1.234, 2.71):
        value, rate, second = motion.law(t)
        assert rate == pytest.approx(slope(lambda t: motion.law(t)[0], t), abs=1e-8)
        assert second == pytest.approx(slope(lambda t: motion.law(t)[1], t), abs=1e-6)
        there = motion.placed(POINTS, t)
        assert motion.velocity_at(there, t) == pytest.approx(slope(lambda t: motion.placed(POINTS, t), t), abs=1e-8)
        assert motion.acceleration_at(there, t) == pytest.approx(
            slope(lambda t: motion.velocity_at(motion.placed(POINTS, t), t), t), abs=1e-6
        )


@pytest.mark.parametrize("motion", ALL, ids=lambda motion: motion.kind)
def test_bodies_stay_rigid_and_motions_are_stored(motion):
    t = 1.234
    there, normals = motion.placed(POINTS, t), motion.turned(np.eye(2), t)
    assert np.linalg.norm(there[:, None] - there, axis=-1) == pytest.approx(
        np.linalg.norm(POINTS[:, None] - POINTS, axis=-1), abs=1e-14
    )
    assert normals @ normals.T == pytest.approx(np.eye(2), abs=1e-14) and motion.seen(normals, t) == pytest.approx(
        np.eye(2), abs=1e-14
    )
    assert there[1] - there[0] == pytest.approx((POINTS[1] - POINTS[0]) @ normals, abs=1e-14)
    again = TypeAdapter(AnyMotion).validate_json(motion.model_dump_json())
    assert again == motion and again.law(t) == motion.law(t)


@pytest.mark.parametrize("motion", ALL, ids=lambda motion: motion.kind)
def test_limits_for_the_time_step(motion):
    times = np.linspace(0.0, 12.0, 800)
    rates = np.array([motion.law(t)[1] for t in times])
    margin = 1.1 if motion.kind != "roll" else 1.15
    assert np.abs(rates).max() <= margin * motion.top_rate + 1e-15
    lower, upper = np.array([-0.5, 0.0]), np.array([1.0, 0.8])
    corners = np.array([[-0.5, 0.0], [1.0, 0.0], [1.0, 0.8], [-0.5, 0.8]])
    at = times[np.argmax(np.abs(rates))]
    assert (
        np.linalg.norm(motion.velocity_at(corners, at), axis=1).max() <= margin * motion.top_speed(lower, upper) + 1e-15
    )
    assert motion.longest_step > 0.0


def test_what_a_tank_feels_is_seen_from_the_tank():
    roll, t = Roll(0.3, 2.0, centre=(0.5, 0.2)), 4.1
    angle, rate, second = roll.law(t)
    assert roll.seen(np.array([[0.0, -9.81]]), t)[0] == pytest.approx([-9.81 * np.sin(angle), -9.81 * np.cos(angle)])
    x = np.array([[1.5, 0.2]])
    assert -roll.acceleration_at(x, t)[0] == pytest.approx([rate**2, -second]), "outwards, and against the spin"
    # a point at rest in the room: its acceleration in the tank is what it feels, and Coriolis' part
    room = np.array([[0.9, 0.6]])

    def in_tank(t):
        return np.array(roll.centre) + roll.seen(room - roll.centre, t)

    u, a = slope(in_tank, t), (in_tank(t + 1e-4) - 2.0 * in_tank(t) + in_tank(t - 1e-4)) / 1e-8
    coriolis = -2.0 * rate * np.array([[-u[0, 1], u[0, 0]]])
    assert a == pytest.approx(coriolis - roll.acceleration_at(in_tank(t), t), abs=1e-6)


def test_a_roll_grows_from_rest_and_stays_at_its_centre():
    roll = Roll(0.1, 3.0, centre=(0.3, -0.2))
    assert roll.law(0.0) == (0.0, 0.0, 0.0)
    assert roll.placed(np.array([[0.3, -0.2]]), 1.7) == pytest.approx(np.array([[0.3, -0.2]]), abs=1e-15)
    assert roll.law(2.0 * np.pi / 3.0 + 0.4)[0] == pytest.approx(0.1 * np.sin(3.0 * 0.4)), (
        "at its amplitude after one period"
    )
    assert Roll(0.1, 3.0, ramp=0.0).law(0.0)[1] == pytest.approx(0.3)
    assert Roll(0.1, 3.0).placed(np.array([[1.0, 0.0]]), 2.3)[0, 1] > 0.0, "against the clock"


def test_series_is_read_beside_the_case_file_and_stored_as_numbers(tmp_path):
    (tmp_path / "roll.csv").write_text("# measured\nt_ms,angle\n0,0\n1000,1\n2000,0\n3000,-1\n4000,0\n")
    (tmp_path / "rolling.py").write_text("""
from parisph import *
def case():
    series = Series("roll.csv", time="t_ms", value="angle", scale=0.5, offset=0.1, time_scale=1e-3)
    roll = Roll(series, centre=(0.5, 0.0))
    return Case(title="t", fluid=Fluid(Box(1.0, 0.5), 1000.0), walls=Tank(1.0, 1.0), gravity=(0.0, -9.81), frame=roll,
                numerics=Numerics(spacing=0.1), end_time=1.0)
""")
    case = load(tmp_path / "rolling.py")
    assert case.frame.angle.times == (0.0, 1.0, 2.0, 3.0, 4.0) and case.frame.angle.values == (0.1, 0.6, 0.1, -0.4, 0.1)
    (tmp_path / "roll.csv").unlink()
    assert type(case).model_validate_json(case.model_dump_json()) == case
    assert case.frame.law(1.0)[0] == pytest.approx(0.6)


def test_rates_are_integrated():
    t = np.linspace(0.0, 3.0, 31)
    series = Series(times=tuple(t), values=tuple(np.cos(t)), rate=True)
    assert [series.law(value)[0] for value in (0.0, 0.77, 2.95)] == pytest.approx(np.sin([0.0, 0.77, 2.95]), abs=1e-6)
    assert series.law(5.0) == (pytest.approx(np.sin(3.0), abs=1e-6), 0.0, 0.0) and series.law(-1.0)[1] == 0.0


@pytest.mark.parametrize("theory", ["exact", "grimshaw", "boussinesq"])
def test_a_piston_follows_the_solitary_wave(theory):
    wave = SolitaryWave(0.05, 0.25, theory)
    piston = PistonStroke(wave, place=1.0)
    made = piston.made
    for t in (0.4, 1.1, 1.6):
        x, u = 1.0 + piston.law(t)[0], piston.law(t)[1]
        eta = made.elevation(x, t)
        assert u == pytest.approx(made.celerity * eta / (0.25 + eta), rel=1e-4, abs=1e-6)
    assert piston.law(0.0) == (0.0, 0.0, 0.0)
    assert piston.law(60.0)[0] == pytest.approx(wave.area / 0.25, rel=2e-3)
    assert made.elevation(1.0, 0.0) == pytest.approx(1e-3 * wave.height, rel=0.05)


def test_boussinesq_stroke_is_that_of_goring():
    assert PistonStroke(SolitaryWave(0.2, 1.0, "boussinesq")).law(60.0)[0] == pytest.approx(
        np.sqrt(16.0 * 0.2 / 3.0), rel=2e-3
    )
    mirrored = PistonStroke(SolitaryWave(0.2, 1.0, leftward=True), place=3.0)
    assert mirrored.law(2.0)[0] == -PistonStroke(SolitaryWave(0.2, 1.0)).law(2.0)[0] and mirrored.made.at > 3.0


def test_transfer_functions():
    assert piston_ratio(0.01, 1.0) == pytest.approx(0.01, rel=1e-4) and piston_ratio(60.0, 1.0) == pytest.approx(2.0)
    assert flap_ratio(0.01, 1.0, 0.0) == pytest.approx(0.005, rel=1e-4), "half of what a piston moves in shallow water"
    k = 2.3
    assert flap_ratio(k, 1.0, -1e6) == pytest.approx(piston_ratio(k, 1.0), rel=1e-5)
    sinh, cosh = np.sinh(k), np.cosh(k)
    assert flap_ratio(k, 1.0, 0.0) == pytest.approx(
        4.0 * sinh / k * (k * sinh - cosh + 1.0) / (np.sinh(2.0 * k) + 2.0 * k)
    )
    # the flow that the wall asks for, projected on the travelling wave
    y = np.linspace(0.3, 1.0, 20001)
    push = np.trapezoid if hasattr(np, "trapezoid") else np.trapz
    share = push((y - 0.3) / 0.7 * np.cosh(k * y), y) / push(
        np.cosh(k * np.linspace(0.0, 1.0, 20001)), np.linspace(0.0, 1.0, 20001)
    )
    assert flap_ratio(k, 1.0, 0.3) == pytest.approx(piston_ratio(k, 1.0) * share, rel=1e-6)


def test_regular_and_irregular_strokes():
    wave = Airy(0.02, 1.0, 0.25)
    piston = PistonStroke(wave, second_order=False)
    t = np.linspace(2.0, 3.0, 400)
    stroke = np.ptp([piston.law(value)[0] for value in t])
    assert stroke * piston_ratio(wave.k, 0.25) == pytest.approx(0.02, rel=1e-4)
    # the piston pushes while the crest passes
    assert piston.law(3.0)[1] == pytest.approx(np.pi * stroke, rel=1e-4)
    flap = FlapStroke(wave, centre=(0.0, 0.05), second_order=False)
    turn = np.ptp([flap.law(value)[0] for value in t])
    assert turn * 0.2 * flap_ratio(wave.k, 0.25, 0.05) == pytest.approx(0.02, rel=1e-4)
    assert flap.velocity_at(np.array([[0.0, 0.25]]), 3.0)[0, 0] > 0.0
    sea = PistonStroke(Jonswap(0.02, 1.0, 0.25, components=20), ramp=0.0)
    assert sea.law(0.0)[0] != 0.0 and PistonStroke(sea.wave).law(0.0)[0] == 0.0
    # in shallow water the piston moves with the water of the wave
    long = Airy(0.001, 12.0, 0.25)
    assert PistonStroke(long, second_order=False).law(17.0)[1] == pytest.approx(
        long.velocity(0.0, 0.1, 17.0)[0], rel=0.02, abs=2e-6
    )


@pytest.mark.parametrize(("kd", "ratio"), [(0.1, 1.0), (0.3, 1.005), (1.0, 3.57)])
def test_the_second_harmonic_of_a_piston_is_madsens_in_long_waves_only(kd, ratio):
    """Madsen (1971): height^2/(32 d) (3 cosh(kd)/sinh(kd)^3 - 2/piston_ratio) sin(2 w t), for X1 sin(w t)."""
    omega, height = float(angular_frequency(kd, 1.0, 9.81)), 1e-3
    found = second_harmonic(height, omega, 1.0, np.ones_like, 0.0, 9.81)
    madsen = height**2 / 32.0 * (3.0 * np.cosh(kd) / np.sinh(kd) ** 3 - 2.0 / piston_ratio(kd, 1.0))
    assert found.imag / madsen == pytest.approx(ratio, rel=5e-3) and abs(found.real) < 0.1 * found.imag


@pytest.mark.parametrize("kd", [0.4, 1.0, 3.0])
def test_the_second_harmonic_of_a_wall_that_bends_like_the_wave_is_that_of_stokes(kd):
    """It makes no evanescent waves: what the bound wave asks of it is known, and is projected on the free wave."""
    a, omega, count = 1e-3, float(angular_frequency(kd, 1.0, 9.81)), 4000
    y, weights = np.polynomial.legendre.leggauss(80)
    y, weights = 0.5 * (y + 1.0), 0.5 * weights
    t = np.arange(count) / count * 2.0 * np.pi / omega
    sine, cosine, twice = (f(n * omega * t)[:, None] for n, f in ((1, np.sin), (1, np.cos), (2, np.cos)))
    shape, u = np.cosh(kd * y) / np.cosh(kd), a * omega * np.cosh(kd * y) / np.sinh(kd)
    x, v = a / np.tanh(kd) * sine, -a * omega * np.sinh(kd * y) / np.sinh(kd) * sine
    bound = 0.75 * a * a * omega * kd * np.cosh(2.0 * kd * y) / np.sinh(kd) ** 4 * twice
    speed = bound + x * shape * kd * u * sine - v * x * kd * np.sinh(kd * y) / np.cosh(kd)
    test = np.cosh(float(wave_number(2.0 * omega, 1.0, 9.81)) * y) * weights
    rate = 2.0 * np.mean(speed @ test / (shape @ test) * np.exp(-2j * omega * t))
    found = second_harmonic(2.0 * a, omega, 1.0, lambda y: np.cosh(kd * y) / np.cosh(kd), 0.0, 9.81)
    assert found == pytest.approx(-rate / (2j * omega), rel=1e-9, abs=1e-12)    # X1 sin(w t): turned by a quarter


def test_strokes_have_the_second_harmonic():
    """Of a hinge far below the bed it is that of a piston; of another height it goes with the square."""
    wave = Airy(0.02, 1.0, 0.25)
    t = np.arange(64) / 64.0 + 2.0
    second = [2.0 * np.mean([stroke.law(value)[0] for value in t] * np.exp(-4j * np.pi * t)) for stroke in (
        PistonStroke(wave), FlapStroke(wave, centre=(0.0, -1e5)), PistonStroke(Airy(0.01, 1.0, 0.25)),
        PistonStroke(wave, second_order=False))]
    due = second_harmonic(0.02, 2.0 * np.pi, 0.25, np.ones_like, 0.0, 9.81)
    assert second[0] == pytest.approx(-due, rel=1e-9), "for X1 sin(w t)"
    assert -1e5 * second[1] == pytest.approx(second[0], rel=1e-3) and second[2] == pytest.approx(0.25 * second[0])
    assert abs(second[3]) < 1e-15


@pytest.mark.parametrize(("make", "words"), [
    (lambda: Roll(0.1), "frequency is missing: give the angular frequency .*, or a Series as amplitude"),
    (lambda: Roll(WAVY, 2.0), "frequency = 2: is that of a harmonic roll; leave it out with a Series"),
    (lambda: Roll(WAVY, ramp=2.0), "ramp = 2: is that of a harmonic roll; leave it out with a Series"),
    (lambda: Roll(0.1, 1.0, centre=(0.0,)), r"Roll.centre = .*: must be at least 2 values, not 1"),
    (lambda: Heave(0.1, -1.0), "Heave.frequency = -1.0: must be greater than 0"),
    (lambda: Heave(0.1, 1.0, (0.0, 0.0)), "Heave.direction: .* must not be zero"),
    (lambda: Series("no_such_file.csv"), "file = 'no_such_file.csv': cannot be read"),
    (lambda: Series(), r"Series.times = \(\): must be at least 4 values, not 0 \(increasing times"),
    (lambda: Series(times=(0, 1, 1, 2), values=(0, 0, 0, 0)), r"times\[2\] = 1.0: must be later"),
    (lambda: Moved(WAVY, (0.0, 0.0)), "must not be zero"),
    (lambda: PistonStroke(LONG, ramp=1.0), "ramp = 1: is for regular and irregular waves"),
    (
        lambda: PistonStroke(StreamFunction(0.05, 4.0, 0.25)),
        "the second order holds up to 26.3; use .* PistonStroke with second_order=False",
    ),
    (lambda: FlapStroke(StreamFunction(0.05, 4.0, 0.25)), "a FlapStroke with second_order=False"),
    (
        lambda: FlapStroke(Airy(0.02, 1.0, 0.25), centre=(0.0, 0.3)),
        "the hinge must be below the still surface at y = 0.25",
    ),
    (lambda: FlapStroke(LONG), "FlapStroke.wave .* must be of a known kind"),
])
def test_bad_input(make, words):
    with pytest.raises(CaseError, match=words):
        make()


@pytest.mark.parametrize(("text", "options", "words"), [
    ("t,x\n0,0\n1,1\n", {}, "must be at least 4 values, not 2"),
    ("t,x\n0,0\n1,1\n2,a\n3,0\n", {}, "line 4 holds something that is not a finite number"),
    ("t,x\n0,0\n1,1\n", {"value": "y"}, "value = 'y': .* has no such column; it has"),
    ("t,x\n0,0,1\n", {}, "cannot be read .line 2 has 3 values"),
])
def test_bad_files(tmp_path, text, options, words):
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(CaseError, match=words):
        Series(str(tmp_path / "m.csv"), **options)
