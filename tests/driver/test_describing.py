"""What is said about a run before, while and where it goes: description, progress, schedule, phases."""

import io
import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

from parisph import Airy, Case, Flap, Fluid, Numerics, Profile, StillWater
from parisph.base import memory
from parisph.case.time_scales import stable_time_step
from parisph.driver import describe, progress
from parisph.driver.progress import Progress
from parisph.driver.schedule import Times
from parisph.kernels import jit
from parisph.methods.reports import ProjectionReport
from tests.launch import ROOT, parisph
from tests.scenes import scene


def test_numbers_that_no_part_reads_are_named():
    case = scene("standing_wave", spacing=0.1)
    given = {"numerics.kappa": 0.5, "numerics.filter_strain": 1.0, "numerics.shift_strain": 9.0}
    told = describe(case.changed(**given))
    assert "numerics.filter_strain = 1 has no effect" in told and "that read it: filter;" in told
    assert "kappa = 0.5 has" not in told and "shift_strain = 9 has" not in told
    for values in ({"numerics.kappa": 0.0}, {"numerics.filter_strain": 1.0, "numerics.preset": "violent"}):
        assert "has no effect" not in describe(case.changed(**values))


@pytest.mark.parametrize("name, why", [("standing_wave", "resolves the shortest waves"),
                                       ("dam_break", "moves the fastest fluid by 0.3 spacings")])
def test_a_fixed_step_that_is_too_long_is_warned_of(name, why):
    case = scene(name, {"time_step": 1e-3}, spacing=0.05)
    limit, reason = stable_time_step(case)
    told = describe(case.changed(**{"numerics.time_step": 1.5 * limit}))
    assert why in reason and f"s is 1.5 times the step of {limit:.3g} s that {why}" in told
    assert "give a shorter one, or None to adapt it" in told
    for step in (1.2 * limit, None):
        assert "warning" not in describe(case.changed(**{"numerics.time_step": step}))


@pytest.mark.parametrize("preset", ["gentle", "violent"])
def test_a_flap_beside_which_no_pairs_collide_is_warned_of(preset):
    flap = Flap(hinge=(0.0, 0.0), wave=Airy(height=0.02, period=1.1, depth=0.25))
    case = Case(title="flume", fluid=Fluid(StillWater(level=0.25), density=1000.0), gravity=(0.0, -9.81), end_time=1.0,
                walls=(Profile([(-0.4, 0.0), (4.3, 0.0), (4.3, 0.4)], name="bed"), flap),
                numerics=Numerics(preset=preset, spacing=0.025, time_step=None))
    assert "caught in the corner" not in describe(case)
    for without in ({"numerics.collision_distance": 0.0}, {"numerics.regularisers": ("filter", "wall_guard")}):
        assert "caught in the corner between a Flap and the bed" in describe(case.changed(**without))


def test_stages_are_those_that_the_scene_has():
    calm, violent = describe(scene("hydrostatic")), describe(scene("dam_break", time_step=0.004))
    assert "even distances" in calm and "position projection" not in calm
    assert "surface (gap)" in violent and "position projection, parting of close pairs, Fick shift" in violent
    assert "adaptive" in describe(scene("rotating_patch")) and "2500 of 0.00128 s" in violent


def test_memory_is_estimated_as_it_is_measured(tmp_path):
    """Of the second run: the first one may compile its kernels, which takes more than the rest.

    What the process that started the run has is not counted.
    """
    ballast = np.ones(100_000_000)    # 800 MB, as a notebook may have
    case = ROOT / "cases" / "dam_break.py"
    for out in ("first", "second"):
        done = parisph("run", case, "-q", "-o", out, "--set", "spacing=1/240", "--set", "end_time=0.005", cwd=tmp_path,
                       timeout=200)
        assert done.returncode == 0, done.stderr
    peak, = json.loads((tmp_path / "second" / "summary.json").read_text())["peak_memory_mb"]
    told = next(line for line in describe(scene("dam_break", spacing=1 / 240)).splitlines()
                if line.startswith("memory"))
    assert int(told.split()[2]) == pytest.approx(peak, rel=0.15) and ballast[-1] == 1.0


def test_a_case_for_a_larger_machine_is_described_all_the_same(monkeypatch):
    told = describe(scene("dam_break"))
    assert "MB on one rank\n" in told
    monkeypatch.setattr(memory, "total", lambda: 10**8)
    assert "MB on one rank, more than the 100 MB of this machine" in describe(scene("dam_break"))
    radius = scene("free_drop").fluid.shape.radius
    drop = scene("free_drop").changed(**{"numerics.spacing": radius / 10_000, "numerics.time_step": None})
    told = describe(drop)
    assert re.search(r"particles   31415\d{4} \(31415\d{4} fluid, 0 wall\)", told) and "about 786 GB" in told


def test_values_are_written_as_set_takes_them():
    told = describe(scene("dam_break"),
                    {"spacing": 1 / 3, "method": "ISPH", "time_step": None, "lid": True, "at": (0.0, 2.5)})
    assert (told.splitlines()[-1]
            == "--set       spacing=0.333333333333333, method=ISPH, time_step=none, lid=True, at=0,2.5")


def test_times_are_due_once_each():
    due = Times(0.5, (0.1, 0.6))
    assert [due.due(t) for t in (0.0, 0.05, 0.1, 0.2, 0.5, 0.9, 1.0, 1.0, 3.0, 3.4)] == [
        False, False, True, False, True, True, True, False, True, False]
    assert not any(Times(None).due(t) for t in (0.0, 1e9))


def test_rounding_does_not_put_off_what_is_due():
    due, time, seen = Times(0.1), 0.0, 0
    for _ in range(1000):
        time += 0.01
        seen += due.due(time + 0.005)
    assert seen == 100


def test_skipped_times_are_not_due():
    due = Times(0.5, (0.1, 0.6))
    due.skip(0.55)
    assert not due.due(0.58) and due.due(0.6)


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    held = SimpleNamespace(now=0.0)
    monkeypatch.setattr(progress, "perf_counter", lambda: held.now)
    return held


def stepped(shown, clock, times, first=1):
    report = ProjectionReport(dt=0.01, iterations=8, divergence=1e-4)
    for number, time in enumerate(times, start=first):
        clock.now += 1.0
        shown.step(SimpleNamespace(time=time, steps=number), report)


def test_live_line_on_a_terminal(clock):
    """The first steps are short, or take long: what is left is told from the second half of those so far."""
    screen = Terminal()
    shown = Progress(10.0, True, stream=screen)
    stepped(shown, clock, 0.01 * np.arange(1, 11))
    text = screen.getvalue()
    assert text.count("\n") == 0 and "t 0.1 of 10 s" in text and "8 iterations" in text
    assert "steps/s" not in text and "left" not in text, "there is nothing to say from nine steps"
    stepped(shown, clock, 0.1 + 0.2 * np.arange(1, 31), first=11)
    last = screen.getvalue().rstrip().split("\r")[-1]
    assert last.endswith("0:20 left") and "1.0 steps/s" in last    # 3.9 s of flow, at 0.2 s in 1 s
    shown.close()
    assert screen.getvalue().endswith("\x1b[2K")


def test_plain_lines_in_a_batch_log_grow_rare(clock, caplog):
    shown = Progress(1e4, True, stream=io.StringIO())
    with caplog.at_level("INFO", logger="parisph"):
        stepped(shown, clock, range(1, 601))
    assert 30 < len(caplog.records) < 100
    assert "steps/s" in caplog.text


@pytest.mark.parametrize(("wanted", "first"), [(False, True), (True, False)])
def test_quiet_and_other_ranks_are_silent(clock, caplog, wanted, first):
    screen = Terminal()
    with caplog.at_level("INFO", logger="parisph"):
        shown = Progress(10.0, wanted, first, stream=screen)
        stepped(shown, clock, (1.0, 2.0))
        shown.close()
    assert screen.getvalue() == "" and not caplog.records


@pytest.mark.parametrize(("wanted", "kernels", "says"), [
    (True, 0, "compiling kernels, about a minute, once for each machine and version of parisph (kept in "),
    (True, 80, "compiling further kernels (kept in "), (False, 0, None)])
def test_a_line_before_kernels_are_compiled_and_one_after(clock, monkeypatch, caplog, wanted, kernels, says):
    """The time that it takes is not that of steps."""

    @jit.uncached
    def doubled(x):
        return 2.0 * x

    monkeypatch.setattr("parisph.kernels.compiling.perf_counter", lambda: 0.0)    # however busy the machine is
    monkeypatch.setattr(progress.kept, "state", lambda folders: {"kernels": kernels})
    screen = Terminal()
    with caplog.at_level("INFO", logger="parisph"), Progress(10.0, wanted, stream=screen) as shown:
        assert screen.getvalue() == ""
        doubled(1.0)
        said = screen.getvalue()
        doubled(1)
        jit.COMPILATION.seconds += 50.0
        clock.now += 50.0
        stepped(shown, clock, np.arange(1, 21))
        jit.COMPILATION.seconds += 50.0    # further ones, of a snapshot
        clock.now += 50.0
        stepped(shown, clock, np.arange(21, 23), first=21)
    if says is None:
        assert screen.getvalue() == "" and not caplog.messages
        return
    assert said.startswith(says) and said.count("\n") == 1 and screen.getvalue().count("compiling") == 1
    line, = caplog.messages
    assert line == "compiled 2 kernels in 50.0 s" and "1.0 steps/s" in screen.getvalue().split("\r")[-1]
    with Progress(10.0, True, stream=screen) as shown:
        stepped(shown, clock, (1.0, 2.0))    # nothing is compiled, and nothing told
    assert len(caplog.messages) == 1 and jit.COMPILATION.before is None
