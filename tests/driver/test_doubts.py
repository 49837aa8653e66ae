"""A run that is wrong says by what, and what it advises helps: a short run passes each limit, and another keeps it."""

import json
import re
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Disc, Fluid, Heave, Obstacle, StillWater, SurfaceGauge, Tank
from parisph.driver import Simulation, run
from parisph.driver.doubts import LIMITS, advice, heights, of_gauges
from parisph.driver.summary import Account
from tests.hard.tanks import swayed
from tests.lasting import standing
from tests.lasting.long import Setting

# Waves as they were computed once: no longer than some ten periods, and less if they are steep.
SHORT = {"surface_rule": "frozen", "gradient": "mixed", "surface_gradient": "harmonic", "wall_rows": "harmonic",
         "regularisers": ("filter", "wall_guard"), "filter": 0.03, "volume_time": 30.0, "wave_step": 0.0}


def short(case, **more):
    """Return a case with those numerics."""
    return case.changed(**{f"numerics.{name}": value for name, value in {**SHORT, **more}.items()})


def wave(depth, periods, preset=None, **values):
    """Return a standing wave with a depth in spacings."""
    usual = {"kd": pi, "amplitude": 0.02, "depth": depth, "jitter": 0.0}
    return standing.long(usual | values, Setting(preset, None, periods)).case


def status(case, folder):
    """Return the status of a run, and its warnings as one text."""
    summary = run(case, MPI.COMM_SELF, folder, progress=False)
    return summary["status"], "; ".join(summary["warnings"])


def test_pairs_and_motion_of_a_wave_that_is_too_steep_and_the_other_preset(tmp_path):
    """A surface that keeps its particles cannot turn over."""
    said, lines = status(short(wave(10.0, 1.0, amplitude=0.3)), tmp_path / "gentle")
    assert said == "completed with warnings" and 'preset="violent" for steep or breaking waves' in lines
    assert "particles were 0.0" in lines and "times all energy in motion at the start" in lines
    lines = status(wave(10.0, 1.0, "violent", amplitude=0.3), tmp_path / "violent")[1]
    assert "particles were" not in lines and "in motion" not in lines


def test_a_level_that_falls_and_the_other_preset(tmp_path):
    said, lines = status(short(wave(10.0, 1.5, amplitude=0.2)), tmp_path / "gentle")
    assert said == "completed with warnings" and "the mean level was -" in lines
    assert "level" not in status(wave(10.0, 1.5, "violent", amplitude=0.2), tmp_path / "violent")[1]


def test_waves_that_are_not_alike_and_a_smaller_spacing(tmp_path):
    """A strong filter takes long waves, too, if they are coarse."""
    found = [status(short(wave(depth, 12.0), filter=0.3), tmp_path / str(depth))
             for depth in (10.0, 20.0)]
    assert found[0][0] == "completed with warnings" and "though all should be alike: use a smaller" in found[0][1]
    coarse, fine = (abs(int(re.search(r"was ([+-]\d+)% off the middle", lines).group(1))) for _, lines in found)
    assert fine < 0.8 * coarse


def test_water_that_is_lost_and_higher_walls(tmp_path):
    low, high = (swayed(height, 0.08, lid=False, end=1.2).changed(**{"numerics.spacing": 0.05})
                 for height in (0.55, 0.9))
    assert "% of the water left the tank" in status(low, tmp_path / "low")[1]
    assert "left the tank" not in status(high, tmp_path / "high")[1]


def test_a_restart_knows_what_was_seen():
    s = Simulation(wave(10.0, 1.0), MPI.COMM_SELF)
    s.solve_start()
    account = Account.new()
    account.start(s)
    assert not account.warnings()
    two = np.flatnonzero(s.particles.kind == 0)[:2]
    x = s.particles.x[two[1]].copy()
    s.particles.x[two[1]] = s.particles.x[two[0]] + [0.01, 0.0]
    account.measure(s)
    s.particles.x[two[1]] = x
    resumed = Account.resumed(json.loads(json.dumps(account.state(s))))
    resumed.start(s)
    for known in (account, resumed):
        (line,) = known.warnings()
        assert "two particles were 0.1 spacings apart at t = 0 s" in line
    s.destroy()


def test_heights_of_waves_behind_their_front_over_a_trend():
    t = np.linspace(0.0, 20.0, 1001)
    begins, high = heights(t, np.minimum(t, 4.0) / 4.0 * np.sin(2.0 * np.pi * t) + 0.2 * t)
    assert high == pytest.approx(2.0, rel=0.1) and begins[0] > 5.0 and len(high) > 10
    assert len(heights(t, np.sin(2.0 * np.pi * t * (1.0 + 0.1 * t)))[1]) == 0    # not regular


@pytest.mark.parametrize("preset", ["violent", "gentle", "solitary", "closed"])
def test_advice_does_not_name_the_preset_in_use(preset):
    told = advice(LIMITS["level"], preset)
    named = set(re.findall('preset="([a-z]+)"', told))
    assert "smaller spacing" in told
    assert named == {"violent", "gentle"} - {"gentle" if preset == "solitary" else preset}


def test_waves_that_a_body_drives_need_not_be_alike():
    """Unless a zone takes them up: an obstacle that heaves is no wave of the start."""
    gauge = SurfaceGauge("gauge", at=1.5)
    walls = Tank(width=2.0, height=1.5), Obstacle(Disc(radius=0.2, at=(1.0, 0.5)))
    case = wave(10.0, 1.0).changed(walls=walls, probes=(gauge,), fluid=Fluid(StillWater(level=1.0), density=1000.0))
    t = np.linspace(0.0, 20.0, 1001)
    one = SimpleNamespace(probe=lambda name: {"time": t, "y": (1.0 + (t > 15.0)) * np.sin(2.0 * np.pi * t)})
    assert of_gauges(case, one)
    heaving = walls[1].model_copy(update={"motion": Heave(amplitude=0.1, frequency=6.0)})
    assert not of_gauges(case.changed(walls=(walls[0], heaving)), one)


def test_limits_are_in_their_ranges():
    assert all(limit.range[0] <= limit.value <= limit.range[1] for limit in LIMITS.values())
