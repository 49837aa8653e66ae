"""A run that is wrong says by what, and what it advises helps: a short run passes each limit, and another keeps it."""

import json
import re
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from parisph import Disc, Fluid, Heave, Obstacle, PressureTap, ProbeArray, StillWater, SurfaceGauge, Tank, VelocityPoint
from parisph.base.errors import SolverDiverged, exit_code
from parisph.base.fields import FLUID, SURFACE
from parisph.driver import probe_gaps
from parisph.driver.diagnostics import LIMITS, Diagnostics, advice, heights, of_gauges
from parisph.driver.summary import Account
from parisph.io import info
from tests.hard.tanks import swayed
from tests.lasting import standing
from tests.lasting.long import Setting
from tests.scenes import run_alone, scene, simulated

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
    summary = run_alone(case, folder)
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
    assert found[0][0] == "completed with warnings" and "though all should be equal: use a smaller" in found[0][1]
    coarse, fine = (abs(int(re.search(r"was ([+-]\d+)% off the middle", lines).group(1))) for _, lines in found)
    assert fine < 0.8 * coarse


def test_water_that_is_lost_and_higher_walls(tmp_path):
    low, high = (swayed(height, 0.08, lid=False, end=1.2).changed(**{"numerics.spacing": 0.05})
                 for height in (0.55, 0.9))
    said, lines = status(low, tmp_path / "low")
    assert re.match(r"[1-9] of 190 particles, \d\.\d+% of the water, left the tank over its rim: make the walls higher",
                    lines)
    assert said == "completed with warnings"
    assert "left the tank" not in status(high, tmp_path / "high")[1]


def test_a_run_that_lost_a_good_part_of_its_water_does_not_read_as_completed(tmp_path):
    """The loss is the first warning, and the last line; probes say that they were touched."""
    probes = [SurfaceGauge("g", at=0.1), VelocityPoint("v", at=(0.3, 0.2)), PressureTap("tap", at=(0.0, 0.1))]
    case = swayed(0.55, 0.3, lid=False, end=0.9).changed(**{"numerics.spacing": 0.05}, probes=probes)
    summary = run_alone(case, tmp_path / "run")
    left, share = summary["left"]["particles"], summary["left"]["volume"] / 0.5
    assert share > 0.1 and summary["status"] == f"completed with warnings: {share:.0%} of the water has left"
    part, said = summary["warnings"][0].split("% of the water, left")[0].rsplit(" ", 1)
    assert part == f"{left} of 190 particles," and float(said) == pytest.approx(100.0 * share, abs=0.0051)
    assert info.last_words(summary)[0].startswith(f"completed with warnings: {left} of 190 particles")
    assert info.last_words({"status": "completed", "warnings": []}) == []
    assert "out of range, above the walls, in " in summary["touched"]["g"]
    table = info.table(summary)
    assert any(line.startswith("probe g ") for line in table)
    assert any(f"{left} of 190 particles over the rim" in line for line in table)


def test_probes_that_were_emptied_or_out_of_the_water_are_named():
    """With water at first; what was dry at the start, as behind a dam, is not emptied."""
    gauges = ProbeArray("row", [SurfaceGauge("a", at=0.3), SurfaceGauge("b", at=0.8)])
    taps = PressureTap("wet", at=(0.0, 0.1)), PressureTap("dry", at=(1.0, 0.1))
    probes = (gauges, *taps, VelocityPoint("v", at=(0.3, 0.2)))
    case = swayed(0.9, 0.0, lid=False, end=1.0).changed(probes=probes)
    t, nan = np.arange(5.0), np.nan
    series = {"row": {"a": [0.5, 0.4, 0.0, 0.0, 0.2], "b": [0.0, 0.1, 0.0, 1.0, 0.1]},
              "wet": {"pressure": [3e3, 0.0, 2e3, 1.0, 1e3]}, "dry": {"pressure": [0.0, 0.0, 3e3, 0.0, 0.0]},
              "v": {"u": [0.0, 0.1, nan, 0.1, 0.1], "v": [0.0, 0.0, nan, 0.0, 0.0], "p": [1.0, 1.0, nan, 1.0, 1.0]}}
    tables = {name: np.rec.fromarrays([t, t.astype(int), *map(np.array, columns.values())],
                                      names=["time", "step", *columns]) for name, columns in series.items()}
    assert probe_gaps.gaps(case, SimpleNamespace(probe=tables.__getitem__)) == {
        "row.a": "emptied in 40% of its samples, first at t = 2 s",
        "row.b": "out of range, above the walls, in 20% of its samples, first at t = 3 s",
        "wet": "emptied in 20% of its samples, first at t = 1 s",
        "v": "no value, outside the fluid, in 20% of its samples, first at t = 2 s"}


def test_energy_in_motion_is_judged_by_the_surface():
    """Particles that are moved inside change the whole energy, and no wave; a surface that rises does."""
    s = simulated(wave(10.0, 1.0))
    s.solve_start()
    account = Account()
    account.start(s)
    p = s.particles
    inside = (p.kind == FLUID) & (p.role != SURFACE)
    p.x[inside, 1] += 0.01
    account.measure(s)
    assert account.diagnostics.conservation.energy.extremes()["high"] > 0.005 and not account.warnings()
    u = p.u.copy()
    p.u *= 1.2
    account.measure(s)
    p.u[:] = u
    assert any("the energy in motion was 1.4" in line for line in account.warnings())
    assert json.loads(json.dumps(account.diagnostics.conservation.content()))["energy_in_motion"]["high"] > 0.0
    p.role[inside] = SURFACE    # torn: the surface has no elevation, and the whole energy counts again
    account.measure(s)
    assert account.diagnostics.conservation.content()["energy_in_motion"]["end"] is None
    assert any("the energy was +" in line for line in account.warnings())


def test_a_restart_knows_what_was_seen():
    s = simulated(wave(10.0, 1.0))
    s.solve_start()
    account = Account()
    account.start(s)
    assert not account.warnings()
    two = np.flatnonzero(s.particles.kind == 0)[:2]
    x = s.particles.x[two[1]].copy()
    s.particles.x[two[1]] = s.particles.x[two[0]] + [0.01, 0.0]
    account.measure(s)
    s.particles.x[two[1]] = x
    resumed = Account(json.loads(json.dumps(account.state(s))))
    resumed.start(s)
    for known in (account, resumed):
        (line,) = known.warnings()
        assert "two particles were 0.1 spacings apart at t = 0 s" in line


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


# -- a flow that explodes: its first rise of energy is told when it comes, and the run fails soon ----------


def test_a_run_that_explodes_says_so_at_once_and_fails_soon(tmp_path):
    """A surface that keeps its particles cannot break."""
    case = scene("dam_break", spacing=0.05, surface_rule="frozen")
    with pytest.raises(SolverDiverged, match="use a smaller spacing") as failed:
        run_alone(case, tmp_path / "run")
    assert exit_code(failed.value) == 3 and "energy first rose beyond its limit at t = 0." in str(failed.value)
    log = (tmp_path / "run" / "run.log").read_text()
    told = [line for line in log.splitlines() if "WARNING" in line and "the energy was +" in line]
    assert len(told) == 2, "once when the limit is passed, and in the end with the greatest value"
    assert float(told[0].partition("+")[2].partition("%")[0]) < float(told[1].partition("+")[2].partition("%")[0])


@pytest.mark.parametrize("driven, start, kinetic, fails", [
    (False, 2.0, 210.0, True), (False, 2.0, 190.0, False), (True, 2.0, 210.0, False), (False, 0.0, 210.0, False),
    (False, 2.0, None, False)])
def test_only_energy_without_a_source_is_an_explosion(driven, start, kinetic, fails):
    conservation = SimpleNamespace(driven=driven, energy=SimpleNamespace(start=start),
                                   kinetic=SimpleNamespace(now=kinetic))
    checks = SimpleNamespace(conservation=conservation, _preset="gentle")
    if not fails:
        return Diagnostics.check(checks)
    with pytest.raises(SolverDiverged, match='105 times all energy.*smaller spacing.*preset="violent"'):
        Diagnostics.check(checks)
