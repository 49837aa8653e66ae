"""The flow by the Serre-Green-Naghdi equations that a solitary wave on a beach is compared with."""

import numpy as np
import pytest

from run_scripts.studies import solitary_shoaling as shoaling
from tests.launch import ROOT

FILE = ROOT / "cases" / "computed" / "solitary_shoaling.csv"


def hill(spacing):
    """Return a bed whose bends have as much to say as its slopes, which the beach has not."""
    x = shoaling.flat(spacing, -20.0, 20.0).x
    height = 0.3 * np.exp(-x * x)
    return shoaling.Bed(x, height, -2.0 * x * height, (4.0 * x * x - 2.0) * height)


def energy(bed, eta, u):
    """Return the energy that these equations keep over any bed: h u T u is a sum of two squares."""
    h, ux = 1.0 + eta - bed.height, np.gradient(u, bed.spacing)
    stretched = h**3 / 3.0 * (ux - 1.5 * bed.slope * u / h) ** 2 + 0.25 * h * (bed.slope * u) ** 2
    return 0.5 * bed.spacing * np.sum(eta**2 + h * u**2 + stretched)


def test_the_wave_of_the_equations_keeps_its_form_and_speed_to_second_order():
    coarse, fine = (shoaling.form_error(spacing, after=10.0) for spacing in (0.1, 0.05))
    assert fine < 0.001 and np.log2(coarse / fine) > 1.9


def test_a_wave_over_a_hill_keeps_its_energy_to_second_order_and_its_volume():
    drifts = []
    for spacing in (0.1, 0.05):
        bed = hill(spacing)
        eta, u = shoaling.flow(bed, *shoaling.solitary(bed.x, 0.2, 4.0), [0.0, 2.0])    # to above the side of the hill
        assert np.sum(eta[1]) == pytest.approx(np.sum(eta[0]), rel=1e-4)
        drifts.append(abs(energy(bed, eta[1], u[1]) / energy(bed, eta[0], u[0]) - 1.0))
    assert drifts[1] < 3e-6 and np.log2(drifts[0] / drifts[1]) > 1.8


def test_water_at_rest_on_the_beach_rests():
    bed = shoaling.beach(0.1)
    assert bed.height[0] == pytest.approx(1.0 - shoaling.SHELF, abs=1e-3) and bed.height[-1] < 1e-3
    np.testing.assert_allclose(np.gradient(bed.height, 0.1)[1:-1], bed.slope[1:-1], atol=1e-3)
    eta, u = shoaling.flow(bed, *np.zeros((2, len(bed.x))), [5.0])
    assert np.abs(eta).max() < 1e-13 and np.abs(u).max() < 1e-13


def test_the_file_of_profiles_is_what_the_study_makes():
    data = np.loadtxt(FILE, delimiter=",", skiprows=FILE.read_text(encoding="utf-8").count("#") + 1)
    eta = shoaling.at_places(*shoaling.shoaled(0.05))
    assert data.shape == (eta.size, 3)
    np.testing.assert_allclose(data[:, 0].reshape(eta.shape)[:, 0], shoaling.TIMES)
    np.testing.assert_allclose(data[:, 1].reshape(eta.shape), np.broadcast_to(shoaling.PLACES, eta.shape))
    np.testing.assert_allclose(data[:, 2].reshape(eta.shape), eta, atol=0.002)    # the grid has twice the spacing
