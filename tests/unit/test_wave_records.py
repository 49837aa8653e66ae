"""The waves that are part of a case: their own equations, each other, and exact solitary waves."""

import csv
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from parisph import CaseError
from parisph.case import waves
from parisph.case.waves import (
    Airy,
    AnyWave,
    Jonswap,
    Sloshing,
    SolitaryWave,
    StandingWave,
    Stokes,
    StreamFunction,
    babenko_solver,
)
from parisph.case.waves.babenko import solitary

EXACT = Path(__file__).parents[2] / "cases" / "exact"
H = 1e-5
ALL = [
    Airy(0.02, 1.5, 0.5, at=0.3),
    Stokes(0.05, 1.5, 0.5, at=0.3, leftward=True),
    Stokes(0.02, 1.5, 0.5, order=2),
    StreamFunction(0.1, 3.0, 0.5),
    StreamFunction(0.1, 3.0, 0.5, closed=True),
    SolitaryWave(0.05, 0.25, at=0.2),
    SolitaryWave(0.05, 0.25, "grimshaw", leftward=True),
    SolitaryWave(0.05, 0.25, "boussinesq"),
    StandingWave(0.01, 2.0, 0.5, phase=0.4),
    Sloshing(1.0, 0.5, 0.0005, 4.2),
    Jonswap(0.02, 1.5, 0.5, seed=3),
]
# relative errors of what a theory leaves open: divergence, rotation, and the motion of the surface
OPEN = {
    "grimshaw": (5e-3, 5e-2, 1e-2),
    "boussinesq": (1e-8, 0.7, 1e-8),
    "airy": (1e-8, 1e-8, 0.03),
    "standing": (1e-8, 1e-8, 0.03),
    "sloshing": (1e-8, 1e-8, 0.02),
    "jonswap": (0.01, 0.05, 0.03),
    "stokes2": (1e-8, 1e-8, 3e-3),
    "stokes5": (1e-8, 1e-8, 1e-4),
}


def name_of(wave):
    return {"solitary": getattr(wave, "theory", ""), "stokes": f"stokes{getattr(wave, 'order', '')}"}.get(
        wave.kind, wave.kind
    )


def table(name):
    with open(EXACT / name, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def slope(function, *args, along):
    """Central differences of each value of function(*args) with respect to one argument."""
    low, high = list(args), list(args)
    low[along], high[along] = low[along] - H, high[along] + H
    return [(b - a) / (2.0 * H) for a, b in zip(np.atleast_2d(function(*low)), np.atleast_2d(function(*high)))]


@pytest.mark.parametrize("wave", ALL, ids=name_of)
def test_flow_is_free_of_divergence_and_rotation_and_moves_the_surface(wave):
    x, y = np.random.default_rng(0).uniform(0.0, 1.0, (2, 40))
    y, t = wave.depth * (0.3 + 0.5 * y), 0.37
    (ux, vx), (uy, vy) = (slope(wave.velocity, x, y, t, along=axis) for axis in (0, 1))
    eta = wave.elevation(x, t)
    (ex,), (et,) = (slope(wave.elevation, x, t, along=axis) for axis in (0, 1))
    u, v = wave.velocity(x, wave.depth + eta, t)
    found = (
        np.abs(ux + vy).max() / np.abs(ux).max(),
        np.abs(uy - vx).max() / np.abs(ux).max(),
        np.abs(v - et - u * ex).max() / np.abs(v).max(),
    )
    for error, limit in zip(found, OPEN.get(name_of(wave), (1e-8, 1e-8, 1e-7))):
        assert error < limit, found


@pytest.mark.parametrize("wave", ALL, ids=name_of)
def test_json_round_trip_bed_and_shapes(wave):
    stored = TypeAdapter(AnyWave).validate_json(wave.model_dump_json())
    assert stored == wave and type(stored) is type(wave)
    x = np.linspace(0.0, 1.0, 6).reshape(2, 3)
    u, v = wave.velocity(x, 0.0, 0.1)
    assert u.shape == v.shape == wave.elevation(x, 0.1).shape == (2, 3)
    assert np.abs(v).max() < 1e-12 and np.abs(u).max() > 0.0, "no flow through the bed"
    assert np.allclose(stored.elevation(x, 0.1), wave.elevation(x, 0.1), rtol=0.0, atol=0.0)


@pytest.mark.parametrize("wave", [wave for wave in ALL if hasattr(wave, "celerity")], ids=name_of)
def test_travelling_waves_keep_their_form(wave):
    sign = -1.0 if wave.leftward else 1.0
    x, t = np.linspace(-1.0, 1.0, 9), 0.6
    assert np.allclose(wave.elevation(x + sign * wave.celerity * t, t), wave.elevation(x, 0.0), atol=1e-12)
    assert wave.elevation(wave.at, 0.0) == np.max(wave.elevation(wave.at + np.linspace(-0.5, 0.5, 41), 0.0))
    u, _ = wave.velocity(wave.at, wave.depth, 0.0)
    assert sign * u > 0.0, "water moves with the crest"
    if hasattr(wave, "period"):
        assert wave.celerity * wave.period == pytest.approx(wave.length, rel=1e-9)


def residuals(wave):
    """Largest errors of the two conditions on the surface of a steady wave."""
    x = np.linspace(0.0, 0.5 * wave.length, 41)
    eta, (rise,) = wave.elevation(x, 0.0), slope(wave.elevation, x, 0.0, along=0)
    u, v = wave.velocity(x, wave.depth + eta, 0.0)
    bernoulli = 0.5 * ((u - wave.celerity) ** 2 + v**2) + wave.g * eta
    return np.array(
        [np.abs((u - wave.celerity) * rise - v).max() / wave.celerity, np.ptp(bernoulli) / wave.celerity**2]
    )


@pytest.mark.parametrize("order", [2, 3, 4, 5])
@pytest.mark.parametrize("period", [1.2, 2.0])
def test_stokes_waves_have_their_order(order, period):
    errors = [residuals(Stokes(height, period, 1.0, order=order)) for height in (0.04, 0.08)]
    assert np.log2(errors[1] / errors[0]) == pytest.approx([order + 1.0, order + 1.0], abs=0.12)


def test_stream_function_is_exact_and_agrees_with_stokes():
    wave = StreamFunction(0.08, 2.0, 1.0)
    assert (residuals(wave) < 1e-10).all()
    assert wave.celerity == pytest.approx(Stokes(0.08, 2.0, 1.0).celerity, rel=1e-6)
    assert (residuals(StreamFunction(0.45, 6.0, 1.0, order=30)) < 2e-4).all()
    assert wave.elevation(0.0, 0.0) - wave.elevation(0.5 * wave.length, 0.0) == pytest.approx(0.08, abs=1e-12)


def test_a_long_stream_function_wave_is_nearly_solitary():
    F, trough = solitary(0.2).F, 0.0
    long = StreamFunction(0.2, 36.0 / F / np.sqrt(9.81), 1.0, order=40)
    trough = float(long.elevation(0.5 * long.length, 0.0))
    x = np.linspace(-6.0, 6.0, 61)
    alone = SolitaryWave(0.2, 1.0).elevation(x, 0.0)
    assert np.linalg.norm(long.elevation(x, 0.0) - trough - alone) < 0.06 * np.linalg.norm(alone)


def test_mean_current_or_mean_flux_is_zero():
    x = np.linspace(0.0, 1.0, 400, endpoint=False)
    for closed in (False, True):
        wave = StreamFunction(0.1, 3.0, 0.5, closed=closed)
        x = np.linspace(0.0, wave.length, 400, endpoint=False)
        mean = np.mean(wave.velocity(x, 0.1, 0.0)[0])
        y = np.linspace(0.0, 1.0, 200)[:, None] * (0.5 + wave.elevation(x, 0.0))
        flux = np.mean(
            np.trapezoid(wave.velocity(x, y, 0.0)[0], y, axis=0)
            if hasattr(np, "trapezoid")
            else np.trapz(wave.velocity(x, y, 0.0)[0], y, axis=0)
        )
        assert abs(flux if closed else mean) < 1e-6 and abs(mean if closed else flux) > 1e-4


def test_exact_solitary_wave_has_the_known_parameters():
    data = table("solitary_parameters.csv")
    for k, height in enumerate(data["a_over_d"]):
        if height > 0.76:
            continue
        wave = solitary(float(height))
        crest, bed = wave.velocity(np.zeros(2), np.array([1.0 + height, 0.0]))[0]
        found = (wave.F, wave.mass, wave.kinetic, wave.potential, crest, bed)
        known = [data[name][k] for name in ("F_exact", "mass", "KE", "PE", "u_crest", "u_bed")]
        assert found == pytest.approx(known, abs=1e-9)
        assert 3.0 * wave.potential == pytest.approx((wave.F**2 - 1.0) * wave.mass, rel=1e-11)


@pytest.mark.parametrize(("height", "limit"), [(0.2, 1e-5), (0.6, 2e-4)])
def test_exact_solitary_wave_has_the_known_profile(height, limit):
    data = table("solitary_profiles.csv")
    rows = data["a_over_d"] == height
    x, eta, u, v, bed = (data[name][rows] for name in ("x_over_d", "eta", "u_surf", "v_surf", "u_bed"))
    wave = SolitaryWave(height, 1.0, g=1.0)
    surface = wave.elevation(x, 0.0)
    assert np.abs(surface - eta).max() < limit
    assert np.abs(wave.velocity(x, 1.0 + surface, 0.0) - np.stack([u, v])).max() < 1.2 * limit
    assert np.abs(wave.velocity(x, 0.0, 0.0)[0] - bed).max() < 1e-8
    # the surface is a streamline on which the pressure is constant
    speeds = wave.velocity(x, 1.0 + surface, 0.0)
    assert np.ptp(0.5 * ((speeds[0] - wave.celerity) ** 2 + speeds[1] ** 2) + surface) < 1e-10


@pytest.mark.parametrize(("theory", "profile", "order"), [("grimshaw", 0.0017, 3.5), ("boussinesq", 0.0468, 1.8)])
def test_theories_of_low_waves_approach_the_exact_one(theory, profile, order):
    x, errors = np.linspace(-8.0, 8.0, 161), []
    for height in (0.1, 0.2):
        wave, exact = SolitaryWave(height, 1.0, theory), SolitaryWave(height, 1.0)
        eta = exact.elevation(x, 0.0)
        errors.append(np.abs(wave.velocity(x, 0.6, 0.0)[0] - exact.velocity(x, 0.6, 0.0)[0]).max())
    assert np.linalg.norm(wave.elevation(x, 0.0) - eta) == pytest.approx(profile * np.linalg.norm(eta), rel=0.05)
    assert np.log2(errors[1] / errors[0]) > order


@pytest.mark.parametrize("theory", ["exact", "grimshaw", "boussinesq"])
def test_shape_of_a_solitary_wave(theory):
    wave = SolitaryWave(0.1, 0.4, theory)
    x = np.linspace(-2.0, 2.0, 21)
    eta, rise, area = wave.shape(x)
    assert rise == pytest.approx((wave.elevation(x + H, 0.0) - wave.elevation(x - H, 0.0)) / (2.0 * H), abs=1e-8)
    assert -eta == pytest.approx((wave.shape(x + H)[2] - wave.shape(x - H)[2]) / (2.0 * H), abs=1e-8)
    assert wave.shape(-30.0)[2] == pytest.approx(wave.area, abs=1e-8) and abs(wave.shape(30.0)[2]) < 1e-8


@pytest.mark.parametrize("bands", ["energy", "frequency"])
def test_jonswap_has_its_height_and_depends_on_its_seed_only(bands):
    wave = Jonswap(0.02, 1.5, 0.5, seed=3, bands=bands)
    t = np.arange(0.0, 3000.0, 0.2)
    eta = wave.elevation(0.7, t)
    assert 4.0 * np.std(eta) == pytest.approx(0.02, rel=0.02)
    assert np.array_equal(eta, Jonswap(0.02, 1.5, 0.5, seed=3, bands=bands).elevation(0.7, t))
    assert not np.allclose(eta, Jonswap(0.02, 1.5, 0.5, seed=4, bands=bands).elevation(0.7, t), atol=1e-3)
    spectrum, f = np.abs(np.fft.rfft(eta)) ** 2, np.fft.rfftfreq(len(t), 0.2)
    assert (f * spectrum).sum() / spectrum.sum() == pytest.approx(1.0 / 1.5, rel=0.25)


def test_standing_and_sloshing_records_are_the_functions():
    x, t = 0.3, np.linspace(0.0, 2.0, 7)
    wave = StandingWave(0.025, 2.0, 1.0)
    assert wave.elevation(x, t) == pytest.approx(waves.standing_wave_elevation(x, t, 0.025, np.pi, 1.0), abs=1e-15)
    assert np.allclose(wave.velocity(x, 0.8, t), waves.standing_wave_velocity(x, 0.8, t, 0.025, np.pi, 1.0), atol=1e-15)
    moved = Sloshing(1.0, 0.5, 0.0005, 4.2, at=-0.5)
    assert moved.elevation(x - 0.5, t) == pytest.approx(
        waves.sway_sloshing_elevation(x, t, 1.0, 0.5, 0.0005, 4.2), abs=1e-15
    )


def test_agrees_with_raschii():
    raschii = pytest.importorskip("raschii")
    ours = StreamFunction(0.2, 2.5, 1.0)
    theirs = raschii.FentonWave(height=0.2, depth=1.0, length=ours.length, N=20)
    x = np.linspace(0.0, 0.5 * ours.length, 11)
    assert ours.elevation(x, 0.0) == pytest.approx(theirs.surface_elevation(x) - 1.0, abs=1e-6)


@pytest.mark.parametrize(("wave", "words"), [
    (
        lambda: Airy(0.5, 1.0, 0.5),
        r"height = 0.5: must be at most 0.2042 m, that of the highest steady wave; use a lower or a longer one",
    ),
    (lambda: Airy(0.1, 0.0, 0.5), r"Airy.period = 0.0: must be greater than 0 \(period \[s\]\)"),
    (lambda: Airy(0.1, 1.0), "Airy.depth is missing: give depth of the still water"),
    (lambda: Stokes(0.2, 4.0, 0.5), "where Stokes's expansion ends .*; use StreamFunction"),
    (lambda: Stokes(0.1, 1.0, 0.5, order=6), r"Stokes.order = 6: must be less than or equal to 5"),
    (lambda: StreamFunction(0.4, 3.0, 0.5), "height = 0.4: "),
    (
        lambda: SolitaryWave(0.2, 0.25),
        "height = 0.2: must be at most 0.1875 m, 0.75 depths for theory = exact; use a lower one",
    ),
    (
        lambda: SolitaryWave(0.05, 0.25, "cnoidal"),
        "SolitaryWave.theory = 'cnoidal': must be 'exact', 'grimshaw' or 'boussinesq'",
    ),
    (lambda: Jonswap(0.2, 1.5, 0.5), "0.6 of the highest steady wave of the peak period"),
    (lambda: Jonswap(0.02, 1.5, 0.5, gamma=0.5), "Jonswap.gamma = 0.5: must be greater than or equal to 1"),
])
def test_bad_input(wave, words):
    with pytest.raises(CaseError, match=words):
        wave()


def test_gmres_solves_linear_systems_and_there_is_no_wave_above_the_highest():
    random = np.random.default_rng(0)
    matrix = np.eye(12) + 0.2 * random.standard_normal((12, 12))
    right = random.standard_normal(12)
    assert babenko_solver.gmres(lambda x: matrix @ x, right, 1e-12, 12) == pytest.approx(np.linalg.solve(matrix, right))
    assert not babenko_solver.gmres(lambda x: x, np.zeros(3), 1e-6, 3).any()
    assert babenko_solver.solve(0.95, 1.32, 40.0, 0.9) is None
