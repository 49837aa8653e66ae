"""Wave theories against the exact series that come with the cases, and against their own equations."""

import csv
from pathlib import Path

import numpy as np
import pytest

from parisph.case import waves
from parisph.case.expressions import vector_field

EXACT = Path(__file__).parents[2] / "cases" / "exact"


def table(name):
    """Return the columns of an exact file by name; texts stay texts."""
    with open(EXACT / name, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {key: [row[key] for row in rows] for key in rows[0]}


def floats(values):
    return np.array(values, dtype=float)


def test_sloshing_series_has_the_corrected_sign():
    data = table("small_sloshing.csv")
    omega = 0.8 * waves.angular_frequency(np.pi, 0.5)
    eta = waves.sway_sloshing_elevation(0.0, floats(data["t_s"]), 1.0, 0.5, 0.0005, omega)
    linear = floats(data["eta_linear_m"])
    assert np.linalg.norm(eta - linear) < 1e-6 * np.linalg.norm(linear)
    assert eta[1] > 0.0  # the tank starts to the right, the water rises at the left wall


def test_sloshing_is_finite_and_continuous_at_resonance():
    omega = waves.angular_frequency(np.pi, 0.5)
    t = np.linspace(0.0, 10.0, 50)
    at, near = (waves.sway_sloshing_elevation(0.2, t, 1.0, 0.5, 0.001, f) for f in (omega, omega * (1 + 1e-7)))
    assert np.allclose(at, near, rtol=0.0, atol=1e-5 * np.abs(at).max())


def test_standing_wave_against_the_reference_and_its_derivatives():
    data = table("standing_wave.csv")
    t = floats(data["t_s"])
    eta = waves.standing_wave_elevation(1.0, t, 0.025, np.pi, 1.0)
    assert np.allclose(eta, floats(data["eta_linear_m"]), atol=1e-8)
    nonlinear = floats(data["eta_nonlinear_m"])
    assert np.linalg.norm(eta - nonlinear) / np.linalg.norm(nonlinear) == pytest.approx(0.042, abs=0.002)
    u, v = waves.standing_wave_velocity(0.3, 1.0, 0.2, 0.025, np.pi, 1.0)
    rise = [waves.standing_wave_elevation(0.3, 0.2 + h, 0.025, np.pi, 1.0) for h in (-1e-5, 1e-5)]
    assert v == pytest.approx((rise[1] - rise[0]) / 2e-5, rel=1e-8)  # the surface moves with the water


def test_standing_wave_start_is_the_velocity_at_zero():
    x = np.random.default_rng(1).random((20, 2))
    field = vector_field(waves.standing_wave_start(0.025, np.pi, 1.0), with_time=False)(x)
    assert np.allclose(field.T, waves.standing_wave_velocity(x[:, 0], x[:, 1], 0.0, 0.025, np.pi, 1.0), rtol=1e-13)


@pytest.mark.parametrize("k", [0.01, 1.0, 7.0, 80.0])
def test_dispersion_and_its_inverse(k):
    assert waves.wave_number(waves.angular_frequency(k, 0.5), 0.5) == pytest.approx(k, rel=1e-12)


def test_paper_frequency_is_dimensionless():
    assert waves.angular_frequency(np.pi, 1.0) == pytest.approx(5.5411, abs=1e-4)
    assert waves.angular_frequency(np.pi, 1.0, g=1.0) == pytest.approx(1.769, abs=5e-4)


def test_column_start_pressure():
    data = table("dam_break_start_pressure.csv")
    rows = [k for k, name in enumerate(data["case"]) if name.startswith("H/L=2 ")]
    x, y, p = (floats(data[name])[rows] for name in ("x_over_H", "y_over_H", "p_over_rho_g_H"))
    assert len(rows) > 10
    assert np.allclose(waves.column_start_pressure(x, y, 0.5, 1.0, 1.0, 1.0, modes=4000), p, atol=2e-8)


def test_drop_keeps_its_area_and_oscillates():
    t = np.linspace(0.0, 2.0, 21)
    a, b = waves.drop_half_axes(t, 0.7, 1.0)
    assert np.allclose(a * b, 0.49, rtol=1e-7) and a[-1] > 2.0 * a[0]
    # Small oscillations about the circle: s' = -2 B^2 (a - b)/(a + b), hence omega = sqrt(2) B.
    t = np.linspace(0.0, 2.0 * np.pi / np.sqrt(2.0) / 3.0, 101)
    a, _ = waves.drop_half_axes(t, 1.0, 1e-4, stiffness=3.0)
    assert a[-1] == pytest.approx(1.0, abs=1e-7) and a[25] - 1.0 == pytest.approx(1e-4 / (3.0 * np.sqrt(2.0)), rel=1e-3)


@pytest.mark.parametrize("name, rates, stiffness", [
    ("straining", (0.5, 0.5, -1.0), 0.0), ("central_force", (0.4, -0.1, -0.3), 1.0)])
def test_half_axes_of_a_drop_in_3d(name, rates, stiffness):
    data = {key: floats(column) for key, column in table(f"drop_{name}_3d.csv").items()}
    a, rate, pressure = waves.ellipsoid_half_axes(data["t_s"], (1.0, 1.0, 1.0), rates, stiffness)
    for k, axis in enumerate("abc"):
        np.testing.assert_allclose(a[:, k], data[f"{axis}_m"], rtol=4e-6)
        np.testing.assert_allclose(rate[:, k], data[f"rate_{axis}_1_s"], atol=1e-5)
    np.testing.assert_allclose(1000.0 * pressure, data["p_centre_Pa"], rtol=3e-6)
    np.testing.assert_allclose(a.prod(axis=1), 1.0, rtol=1e-5)
