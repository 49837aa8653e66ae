"""Guesses of the next pressure: what they extrapolate, and which of them the solve takes."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import ParisphError
from parisph.base.fields import FieldSet
from parisph.methods.guesses import Guesses
from parisph.parallel.particles import Particles
from parisph.pressure.solver import PressureSolver
from tests import systems


def particles(n=5):
    p = Particles(MPI.COMM_SELF, 2, FieldSet((*Guesses.fields, *Guesses.of_waves)))
    p.assign({"x": np.random.default_rng(0).random((n, 2))})
    return p


def history(p, times, pressure, waves=False):
    guesses = Guesses(waves)
    guesses.restart(times[0])
    p.p = pressure(times[0])
    for time in times[1:]:
        guesses.remember(p, time)
        p.p = pressure(time)
    return guesses


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_steps_of_any_length_extrapolate_what_is_quadratic_in_time(degree):
    p = particles()
    scale = p.x[:, 0]
    times = [0.3, 0.45, 0.5, 0.7]
    found = history(p, times, lambda t: scale * t**degree).at(p, 0.85)
    assert found.shape == (3, p.n_owned)
    for order, guess in enumerate(found):
        right = np.allclose(guess, scale * 0.85**degree, rtol=1e-7)
        assert right == (degree <= order)


def test_in_waves_what_is_cubic_in_time_is_extrapolated():
    p = particles()
    times = [0.3, 0.45, 0.5, 0.7, 0.75]
    found = history(p, times, lambda t: p.x[:, 0] * t**3, waves=True).at(p, 0.85)
    right = [np.allclose(guess, p.x[:, 0] * 0.85**3, rtol=1e-7) for guess in found]
    assert right == [False, False, True]


def test_only_what_is_known_is_extrapolated():
    p = particles()
    guesses = Guesses()
    assert guesses.at(p, 0.1).shape == (1, p.n_owned)    # after an older checkpoint
    for known, times in ((1, [0.0]), (2, [0.0, 0.1]), (3, [0.0, 0.1, 0.2]), (3, [0.0, 0.1, 0.2, 0.3])):
        found = history(p, times, lambda t: np.full(p.n_owned, 2.0 + t)).at(p, 0.4)
        assert len(found) == known
        np.testing.assert_allclose(found[1:], 2.4, rtol=1e-7)


@pytest.mark.parametrize("best", [0, 1, 2])
def test_the_solve_begins_with_the_guess_of_the_least_residual(best):
    x, _, *rows = systems.square(20)
    p = np.cos(np.pi * x[:, 0]) * np.cos(0.5 * np.pi * x[:, 1])
    b = systems.product(rows, p)
    guesses = np.stack([p + 0.1 * np.sin((k + 3) * x[:, 0]) for k in range(3)])
    guesses[best] = p
    solver = PressureSolver(MPI.COMM_SELF)
    try:
        assert solver.solve(*rows, b, guesses)[1].iterations == 0
        assert solver.solve(*rows, b, np.delete(guesses, best, axis=0))[1].iterations > 0
        found, record = solver.solve(*rows, b, 100.0 * guesses)    # all worse than zero
        due, from_zero = solver.solve(*rows, b, None)
        assert record.iterations == from_zero.iterations > 0
        np.testing.assert_array_equal(found, due)
    finally:
        solver.destroy()


def test_a_pressure_that_still_holds_stays_and_an_extrapolation_is_solved_closer():
    x, _, *rows = systems.square(20)
    p = np.cos(np.pi * x[:, 0]) * np.cos(0.5 * np.pi * x[:, 1])
    b = systems.product(rows, p)
    wrong = b * np.sin(40.0 * x[:, 0])

    def off(residual):
        """Return a guess with about this relative residual."""
        error = systems.product(rows, wrong)
        return p + wrong * residual * np.linalg.norm(b) / np.linalg.norm(error)
    solver = PressureSolver(MPI.COMM_SELF, rtol=1e-6)
    try:
        holds, record = solver.solve(*rows, b, np.stack([off(0.9e-6), off(0.1e-6)]))
        assert record.iterations == 0
        np.testing.assert_array_equal(holds, off(0.9e-6))
        _, record = solver.solve(*rows, b, np.stack([off(1e-3), off(0.9e-6)]))
        assert record.iterations > 0 and record.residual < 1e-7
        _, record = solver.solve(*rows, b, np.stack([off(1e-3), off(1e-4)]))    # no closer than asked
        assert record.iterations > 0 and 1e-8 < record.residual < 1e-6
    finally:
        solver.destroy()


def test_a_bad_guess_among_several_is_named():
    _, _, *rows = systems.square(8)
    b = np.ones(len(rows[0]) - 1)
    solver = PressureSolver(MPI.COMM_SELF)
    try:
        for bad in (np.ones((2, 3)), np.stack([b, np.where(np.arange(len(b)) == 4, np.nan, b)])):
            with pytest.raises(ParisphError, match="guess"):
                solver.solve(*rows, b, bad)
    finally:
        solver.destroy()


def test_equal_steps_have_whole_weights_however_their_times_are_summed():
    p = particles()
    p.p, p.p_before, p.p_earlier = 4.0, 2.0, 1.0
    found = []
    for start in (0.0, 123.4):
        guesses = Guesses()
        guesses.times = [start + 0.3, start + 0.2, start + 0.1]
        found.append(guesses.at(p, start + 0.4))
    np.testing.assert_array_equal(*found)
    np.testing.assert_array_equal(found[0], np.outer([4.0, 6.0, 7.0], np.ones(p.n_owned)))
