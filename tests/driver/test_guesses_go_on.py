"""A step solves from guesses of the last pressures, and a restart knows these."""

import numpy as np
import pytest

from tests.scenes import saved, scene, simulated


def test_a_step_begins_with_up_to_three_guesses(monkeypatch):
    s = simulated(scene("standing_wave", spacing=0.1))
    shapes, solve = [], s.method.solver.solve
    monkeypatch.setattr(s.method.solver, "solve", lambda *arrays, **options: (
        shapes.append(arrays[4].shape), solve(*arrays, **options))[1])
    s.solve_start()
    for _ in range(4):
        s.advance()
    n = s.particles.n_owned
    assert shapes == [(n,), (1, n), (2, n), (3, n), (3, n)]


@pytest.mark.parametrize("known", [True, False])
def test_a_restart_guesses_as_the_run_would_have_done(known):
    s = simulated(scene("standing_wave", spacing=0.1), 4)
    start = saved(s)
    if not known:    # as in checkpoints of earlier versions
        for name in ("p_before", "p_earlier", "p_earliest"):
            del start.arrays[name]
        del start.state["pressure_times"]
    again = simulated(s.case, start=start)
    time = s.time + 0.5 * s.dt
    due, found = (one.method.guesses.at(one.particles, time) for one in (s, again))
    order, other = np.argsort(s.particles.id), np.argsort(again.particles.id)
    assert len(found) == (3 if known else 1)
    np.testing.assert_array_equal(found[:, other], due[:len(found), order])
    for one in (s, again):
        one.advance()
    if known:    # with the accelerations and the volume of earlier steps too
        assert again.method.earlier_accelerations.times == s.method.earlier_accelerations.times
        for name in ("x", "u", "acceleration_before", "expansion"):
            value, due = (getattr(one.particles, name)[np.argsort(one.particles.id)] for one in (again, s))
            np.testing.assert_allclose(value, due, rtol=0, atol=1e-8 * np.abs(due).max())    # solved to 1e-9
    np.testing.assert_allclose(again.particles.p[np.argsort(again.particles.id)],
                               s.particles.p[np.argsort(s.particles.id)], rtol=1e-4, atol=1e-3)
