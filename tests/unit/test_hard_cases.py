"""The hard cases' own rules: the theory they are judged by, their table, and what is made of a process that fails."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from parisph.base.errors import SolverDiverged
from parisph.base.fields import BALLISTIC, FLUID, SURFACE
from tests import apart
from tests.hard import columns, drops, flow, scenes, table, waves
from tests.hard.impulse import lost_energy
from tests.hard.scene import Scene
from tests.hard.table import Line, Outcome
from tests.scenes import simulated


def by_differences(thickness, n):
    """Return the share of lost energy from Laplace's equation on a grid of side/n: sum of |grad P|^2 over the edges.

    Unit side, density and speed. P = 0 on the free sides; on the side at the wall the flux through half cells is 1.
    """
    h, rows = 1.0 / n, round(thickness * n)
    number = np.arange(rows * (n - 1)).reshape(rows, n - 1)    # nodes from the wall on, without the free sides
    matrix, flux = np.zeros((number.size, number.size)), np.zeros(number.size)
    flux[number[0]] = h
    edges = [(number[:-1], number[1:], 1.0), (number[1:, :-1], number[1:, 1:], 1.0), (number[-1], None, 1.0),
             (number[1:, 0], None, 1.0), (number[1:, -1], None, 1.0),
             (number[0, :-1], number[0, 1:], 0.5), (number[0, [0, -1]], None, 0.5)]    # along the wall: half a cell
    for a, b, share in edges:
        a = np.ravel(a)
        np.add.at(matrix, (a, a), share)
        if b is not None:
            b = np.ravel(b)
            np.add.at(matrix, (b, b), share)
            matrix[a, b] -= share
            matrix[b, a] -= share
    p = np.linalg.solve(matrix, flux)
    return 0.5 * (p @ matrix @ p) / (0.5 * thickness)


@pytest.mark.parametrize("thickness", [0.5, 1.0])
def test_lost_energy_of_an_impact(thickness):
    """The series against finite differences of second order, extrapolated; a corner leaves an error of h^2 log h."""
    coarse, fine = (by_differences(thickness, n) for n in (20, 40))
    assert abs(fine / lost_energy(thickness, 1.0) - 1.0) < 0.01
    assert fine + (fine - coarse) / 3.0 == pytest.approx(lost_energy(thickness, 1.0), rel=1e-3)


def test_a_thin_rectangle_loses_all():
    """It moves as one with the wall, but for its ends."""
    assert 0.97 < lost_energy(0.02, 1.0) < 1.0
    assert lost_energy(3.0, 3.0) == pytest.approx(lost_energy(1.0, 1.0))


@pytest.mark.parametrize(("line", "met", "reached"), [
    (Line("a", 0.5), None, None), (Line("a", 0.5, 0.5, 0.4), True, False),
    (Line("a", 0.5, 0.4, 0.5, least=True), True, True),
    (Line("a", 0.3, 0.4, least=True), False, None), (Line("a", math.nan, 1.0, 1.0), False, False),
])
def test_line(line, met, reached):
    assert (line.met, line.reached) == (met, reached)


def test_table_is_kept(tmp_path):
    lines = [Line("x", 1.25, 1.0), Line("y", math.nan, 1.0, 2.0, True)]
    found = [Outcome("a", lines=lines, steps=7, cpu_seconds=1.5), Outcome("b")]
    table.save(found, tmp_path / "results.json")
    again = table.load(tmp_path / "results.json")
    assert table.text(again) == table.text(found) and [entry.met for entry in again] == [False, True]
    assert "| a | x | 1.25 | <= 1 |  | NO | | |" in table.text(found)


def test_starts_are_one_entry():
    """The worst of them decides, and a stop of one is said."""
    lines = [[Line("x", 0.5, 1.0, 0.6), Line("y", 3.0)], [Line("x", 0.7, 1.0, 0.6), Line("y", 2.0)]]
    found = [Outcome("a", lines=lines[k], seed=k + 1, steps=5, cpu_seconds=0.25) for k in (0, 1)]
    shown = table.text([*found, Outcome("a", "stopped: too fast", True, seed=3, steps=1)]).splitlines()[2:]
    assert shown == ["| a, 3 starts | came to its end; stopped: too fast | | | | ok | 11 | 0.5 |",
                     "| a, 3 starts | x | 0.5 to 0.7 | <= 1 | <= 0.6 | ok | | |",
                     "| a, 3 starts | y | 2 to 3 |  |  |  | | |"]
    worse = Outcome("a", lines=[Line("x", 1.5, 1.0, 0.6)], seed=2)
    assert " 0.5 to 1.5 | <= 1 | <= 0.6 | NO |" in table.text([found[0], worse])


def fails(error):
    def measure(bench):
        bench.steps += 3
        raise error
    return measure


@pytest.mark.parametrize(("error", "may_stop", "ended", "met"), [
    (SolverDiverged("too fast: go slower"), True, "stopped: SolverDiverged: too fast: go slower", True),
    (SolverDiverged("far too fast"), False, "stopped: SolverDiverged: far too fast", False),
    (IndexError("out of bounds"), True, "failed: IndexError: out of bounds", False),
])
def test_scene_that_stops(error, may_stop, ended, met):
    found = Scene("x", fails(error), may_stop=may_stop).outcome("x")
    assert (found.ended, found.met, found.steps) == (ended, met, 3)


@pytest.mark.parametrize(("name", "limit", "ended"), [
    ("columns-1-wall", 0.05, "failed: not finished after 0.05 s"), ("nothing", 60.0, "failed: exit code 1")])
def test_process_that_fails(monkeypatch, name, limit, ended):
    monkeypatch.setitem(scenes.SCENES, name, Scene("x", None, limit=limit))    # here, not in the process
    found = apart.apart(scenes.Start(name, 2))
    assert (found.scene, found.seed, found.ended, found.met) == (name, 2, ended, False)


def test_names():
    first = [f"columns-1-{where}" for where in columns.WHERE]
    assert apart.chosen(["columns-1", "vortex"], [*scenes.SCENES]) == [*first, "vortex"]
    assert apart.chosen([], [*scenes.QUICK]) == list(scenes.QUICK)
    with pytest.raises(ValueError, match="no column among "):
        apart.chosen(["column"], [*scenes.SCENES])


@pytest.mark.parametrize("where", columns.WHERE)
@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_columns_are_as_wide_as_they_say(width, where):
    from parisph.geometry.build import build, volume

    case = columns.column(width, where)
    built = build(case)
    x = built["x"][built["kind"] == 0]
    assert len(np.unique(np.round(x[:, 0], 6))) == width
    assert volume(case) == pytest.approx(width * columns.S * columns.HEIGHT)


def seen(x, role, spacing):
    """What the measures look at of a Simulation, of fluid particles at x (n, 2) [m]."""
    x = np.asarray(x, float)
    particles = SimpleNamespace(x=x, kind=np.zeros(len(x), np.int8), role=np.full(len(x), role, np.int8))
    return SimpleNamespace(particles=particles, numerics=SimpleNamespace(spacing=spacing))


def test_nearest_and_flying():
    x = [(0.0, 0.0), (0.03, 0.04), (0.2, 0.0), (0.0, 0.15), (0.1, 0.1), (0.15, 0.1), (9.0, 9.0)]
    assert flow.nearest(seen(x, SURFACE, 0.1)) == pytest.approx(0.5)
    assert flow.nearest(seen(x[-2:], SURFACE, 0.1)) == 1.0
    assert flow.flying_among_others(seen(x, BALLISTIC, 0.1)) == 4, "(0.2, 0) and (0, 0.15) are 0.25 m apart"
    assert flow.flying_among_others(seen(x, SURFACE, 0.1)) == 0


def test_first_mode_of_a_surface():
    x = 2.0 * np.random.default_rng(1).random(200)
    wave = seen(np.column_stack([x, 1.0 + 0.1 * np.cos(np.pi * x) + 0.05 * np.cos(2.0 * np.pi * x)]), SURFACE, 0.01)
    assert waves.mode(wave) == pytest.approx(0.1, rel=0.01)
    t = np.linspace(0.0, 3.0, 3000)
    np.testing.assert_allclose(waves.modal_energy(t, 0.3 * np.cos(waves.OMEGA * t))[1:-1], 0.09, rtol=1e-4)


def test_centre_pressure_of_a_drop():
    """At the start rho/2 R^2 times the rate squared; it falls as the drop gets long."""
    assert drops.exact_centre(1.0, 1.0) == 500.0
    assert drops.exact_centre(2.0, 0.5) == pytest.approx(2000.0 / 4.25**2)


@pytest.mark.parametrize("width", [2, 3, 4])
def test_energy_of_a_column_that_spreads_from_a_wall_is_exact(width):
    """Of u = x and the mean height as x and u change; one velocity per volume has 31 % too much for a width of two."""
    s = simulated(columns.column(width, "wall"))
    p = s.particles
    rows = columns.rows_of(s, width)
    rest = columns.energy_between(s, rows)
    p.u[:, 0] = p.x[:, 0]
    exact = (width * columns.S) ** 3 / 6.0 * columns.HEIGHT
    assert columns.energy_between(s, rows) - rest == pytest.approx(exact)
    mine = p.kind == FLUID
    assert 0.5 * p.volume[mine] @ p.u[mine, 0] ** 2 > 1.05 * exact
