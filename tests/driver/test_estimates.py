"""What `check` estimates: steps against those of real runs, seconds against real steps, waves against theory."""

import json
from time import process_time

import numpy as np
import pytest

from parisph.case import scales, waves
from parisph.case.schema import Sway
from parisph.driver import cost, describe
from parisph.driver.estimate import estimated_steps
from tests.scenes import run_alone, scene, simulated, water


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """An empty cache folder; returns the file of costs in it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "parisph" / "costs.json"


def sloshing(amplitude=0.03, spacing=0.04, **values):
    """The first case of the README: a tank of water shaken at its first natural frequency."""
    return water((1.0, 0.4), (1.0, 1.0, True), spacing, title="sloshing",
                 frame=Sway(amplitude=amplitude, frequency=float(waves.angular_frequency(np.pi, 0.4))),
                 end_time=3.0).changed(**values)


CASES = {
    "dam break": lambda: scene("dam_break", spacing=1 / 20, time_step=None),
    "sloshing": sloshing,
    "gentle sloshing": lambda: sloshing(0.003),
    "free drop": lambda: scene("free_drop", spacing=0.1, time_step=None),
    "drop in a central force": lambda: scene("free_drop", spacing=0.1, time_step=None, stiffness=1.0, end_time=4.0),
    "rotating patch": lambda: scene("rotating_patch", spacing=1 / 20),
    "water at rest": lambda: scene("hydrostatic", spacing=0.1, time_step=None),
}


@pytest.mark.parametrize("name", CASES)
def test_steps_and_seconds_of_real_runs(name):
    """Within a factor of 2.5 for the steps and of 3 for the cost of one; CPU time, as the machine may be busy."""
    simulation = simulated(CASES[name]())
    simulation.solve_start()
    taken = []
    while not simulation.finished():
        start = process_time()
        simulation.advance()
        taken.append(process_time() - start)
    case = simulation.case
    steps = estimated_steps(case, case.numerics, scales.expected(case))
    seconds, _ = cost.seconds_per_step(case.numerics, simulation.particles.n_global)
    assert len(taken) / 2.5 < steps < 2.5 * len(taken)
    assert np.median(taken) / 3.0 < seconds < 3.0 * np.median(taken)


@pytest.mark.parametrize("phase", [0.0, 0.5 * np.pi])
def test_steps_of_a_steep_gentle_wave_are_those_of_its_strain(phase):
    """They were estimated at less than half of what they are."""
    wave = waves.StandingWave(amplitude=0.05, length=1.0, depth=0.5, phase=phase)
    case = water((1.0, 0.5), (1.0, 0.8), dict(preset="gentle", spacing=0.05), wave=wave,
                 end_time=0.5 * np.pi / wave.omega)
    simulation, taken = simulated(case), []
    while not simulation.finished():
        simulation.advance()
        taken.append(simulation.dt)
    steps = estimated_steps(case, case.numerics.resolved(), scales.expected(case))
    last = case.end_time / min(taken)    # as all steps of the wave are, once its strain is seen
    assert last / 1.3 < steps < 1.3 * last


def test_fixed_steps_are_counted():
    case = scene("dam_break", spacing=1 / 80, time_step=0.004)
    assert estimated_steps(case, case.numerics.resolved(), scales.expected(case)) == 2500


@pytest.mark.parametrize("ratio", [0.8, 1.0, 1.3])
def test_waves_of_a_shaken_tank_are_those_of_linear_theory(ratio):
    case = sloshing(0.001).changed(**{"frame.frequency": ratio * 5.1, "end_time": 10.0})
    eta = waves.sway_sloshing_elevation(0.0, np.linspace(0.0, 10.0, 2000), 1.0, 0.4, 0.001, ratio * 5.1)
    assert 0.5 * scales.expected(case).wave.height == pytest.approx(np.abs(eta).max(), rel=0.2)


def test_a_wave_that_is_smaller_than_any_number_of_a_case_is_none():
    assert scales.expected(sloshing(0.001).changed(**{"frame.amplitude": 1e-35})).wave is None


def test_waves_of_the_start():
    case = scene("standing_wave")    # a = s
    wave = scales.expected(case).wave
    assert 0.5 * wave.height == pytest.approx(case.numerics.spacing, rel=0.02)
    assert wave.length == pytest.approx(2.0, rel=0.02)
    raised = case.changed(**{"fluid.velocity": (0.0, 0.0), "fluid.elevation": "0.03*cos(pi*x)"})
    assert 0.5 * scales.expected(raised).wave.height == pytest.approx(0.03, rel=0.02)


def test_resolution_is_told():
    lines = dict(line.split(None, 1) for line in describe(sloshing()).splitlines() if not line.startswith(" "))
    assert lines["resolution"] == "fluid 25 x 10 spacings"
    assert lines["wave"].startswith("the start or the motion of the tank, height 0.462 m (12 spacings), length 2 m "
                                    "(50), depth 0.4 m (10), about ")
    assert "tank 40 wide" in describe(scene("dam_break", spacing=1 / 20))


# ---- the cost of earlier runs

def clock(monkeypatch, steps, each):
    """A Clock that has seen steps of so many seconds."""
    now, found = iter(np.arange(1, steps + 1) * each), cost.Clock()
    with monkeypatch.context() as patch:
        patch.setattr(cost, "process_time", lambda: next(now))
        for _ in range(steps):
            found.step()
    return found


@pytest.fixture
def numerics():
    return scene("dam_break").numerics.resolved()


def test_an_earlier_run_is_the_measure(monkeypatch, cache, numerics):
    _, basis = cost.seconds_per_step(numerics, 4000)
    assert basis == "a short timing of this processor"
    clock(monkeypatch, 101, 0.5).remember(numerics, 4000, 1)
    assert cost.seconds_per_step(numerics, 4000) == (pytest.approx(0.5),
                                                     "an earlier run of 4000 particles on this processor")
    assert cost.seconds_per_step(numerics, 40000)[0] == pytest.approx(5.0, rel=0.1)


def write(cache, *runs):
    cache.parent.mkdir(exist_ok=True)
    cache.write_text(json.dumps([{"processor": cost._processor(), "method": "ISPH_R", "projection": True,
                                  "particles": 4000, "seconds": 1.0} | run for run in runs]))


def test_the_run_most_like_it_is_taken(cache, numerics):
    write(cache, {"particles": 3900, "method": "ISPH"}, {"particles": 100}, {"particles": 5000, "seconds": 2.0},
          {"particles": 4000, "processor": "of another node"})
    assert "of 5000 particles" in cost.seconds_per_step(numerics, 4000)[1]


@pytest.mark.parametrize(("steps", "each", "ranks"), [(10, 0.5, 1), (0, 0.0, 1), (1, 60.0, 1), (101, 0.5, 100_000)])
def test_what_is_no_measure_is_not_kept(monkeypatch, cache, numerics, steps, each, ranks):
    clock(monkeypatch, steps, each).remember(numerics, 4000, ranks)
    assert not cache.exists()


def test_only_the_last_runs_are_kept(monkeypatch, cache, numerics):
    write(cache, *({"particles": n} for n in range(1, cost.KEPT + 1)))
    clock(monkeypatch, 101, 0.5).remember(numerics, 4000, 1)
    kept = [run["particles"] for run in json.loads(cache.read_text())]
    assert kept == [*range(2, cost.KEPT + 1), 4000] and len(list(cache.parent.iterdir())) == 1


@pytest.mark.parametrize("content", ["", "{", "[1]", "null", '[{"particles": 0, "seconds": 1}]', '{"a": 1}'])
def test_a_damaged_file_is_no_error(cache, numerics, content):
    cache.parent.mkdir()
    cache.write_text(content)
    assert cost.seconds_per_step(numerics, 4000)[1] == "a short timing of this processor"


def test_a_cache_that_cannot_be_written_is_no_error(monkeypatch, tmp_path, numerics):
    (tmp_path / "parisph").write_text("a file where the folder should be")
    clock(monkeypatch, 101, 0.5).remember(numerics, 4000, 1)


def test_a_run_keeps_what_it_cost(monkeypatch, cache, tmp_path):
    monkeypatch.setattr(cost, "LEAST", 0.0)
    case = scene("dam_break", spacing=0.1, end_time=0.2)
    run_alone(case, tmp_path / "run")
    run, = json.loads(cache.read_text())
    assert run["particles"] == 130 and 0.0 < run["seconds"] < 1.0
