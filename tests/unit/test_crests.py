"""Crests of solitary waves are found where they are, and profiles are compared there."""

import numpy as np
import pytest

from parisph.base.fields import INNER, SURFACE
from parisph.case.waves import SolitaryWave
from run_scripts.studies import solitary_measures as crests

WAVE = SolitaryWave(height=0.05, depth=0.25, at=2.0)


def snapshot(wave, spacing=0.0167):
    """Return a snapshot with one line of surface particles, not in order, and one below it."""
    x = np.random.default_rng(1).permutation(np.arange(0.0, 4.0, spacing))
    top = np.stack([x, 0.25 + wave.elevation(x, 0.0)], axis=1)
    return {"x": np.concatenate([top, top - [0.0, spacing]]), "role": np.repeat([SURFACE, INNER], len(x))}


def test_crest_of_an_exact_wave():
    x, eta = crests.surface_profile(snapshot(WAVE), 0.25)
    place, height = crests.crest(x, eta, 0.25)
    assert place == pytest.approx(2.0, abs=1e-4) and height == pytest.approx(0.05, rel=1e-4)
    assert np.all(np.diff(x) > 0.0)
    assert crests.profile_error(x, eta, SolitaryWave(height=0.05, depth=0.25)) < 1e-4


def test_a_wave_of_another_form_or_height_is_seen():
    x, eta = crests.surface_profile(snapshot(WAVE.model_copy(update={"theory": "boussinesq"})), 0.25)
    assert crests.profile_error(x, eta, WAVE) == pytest.approx(0.05, abs=0.005)
    assert crests.printed_error(x, eta, WAVE.model_copy(update={"theory": "boussinesq", "at": 0.0})) < 1e-4
    x, eta = crests.surface_profile(snapshot(WAVE), 0.25)
    assert crests.profile_error(x, 1.1 * eta, WAVE) == pytest.approx(0.1, rel=1e-3)
