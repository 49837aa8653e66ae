"""Rank-0 logging and phase timers."""

import io
from types import SimpleNamespace

import pytest

from parisph.base import log
from parisph.base.log import Timers


class Ranks:
    """Stands for a communicator in which the other ranks hand in what is given."""

    def __init__(self, *others):
        self.answers = list(others)

    def allgather(self, mine):
        return [mine, self.answers.pop(0)]


@pytest.fixture(autouse=True)
def screen():
    yield io.StringIO()
    log.stop()


def test_rank_0_speaks_on_screen_and_in_the_file(screen, tmp_path):
    log.start(SimpleNamespace(rank=0), tmp_path / "run.log", stream=screen)
    log.logger.info("step %d", 7)
    log.logger.debug("detail")
    log.stop()
    assert screen.getvalue() == "step 7\n"
    written = (tmp_path / "run.log").read_text().splitlines()
    assert [line.split(" ", 2)[2] for line in written] == ["INFO step 7", "DEBUG detail"]


def test_no_text_looks_like_another_record(screen, tmp_path):
    log.start(SimpleNamespace(rank=0), tmp_path / "run.log", stream=screen)
    log.logger.info("a\n2026-01-01 00:00:00,000 ERROR not so\x1b[2J\r\udcff")
    log.stop()
    assert screen.getvalue() == "a\n    2026-01-01 00:00:00,000 ERROR not so\\x1b[2J\\r\\udcff\n"
    assert [line[:4] for line in (tmp_path / "run.log").read_text().splitlines()][1] == 4 * " "


def test_other_ranks_are_silent(screen, tmp_path, capsys):
    log.start(SimpleNamespace(rank=1), tmp_path / "run.log", stream=screen)
    log.logger.warning("heard?")
    assert screen.getvalue() == "" and not (tmp_path / "run.log").exists()
    assert capsys.readouterr().err == ""


def test_starting_again_does_not_say_things_twice(screen):
    for _ in range(2):
        log.start(SimpleNamespace(rank=0), stream=screen)
    log.logger.info("once")
    assert screen.getvalue() == "once\n"


def test_stop_leaves_the_logger_as_it_was():
    log.start(SimpleNamespace(rank=0), stream=io.StringIO())
    log.stop()
    assert log.logger.propagate and not log.logger.handlers and log.logger.level == 0


@pytest.fixture
def clock(monkeypatch):
    """A clock that moves when told: clock.now += seconds, of which half are of the processor."""
    held = SimpleNamespace(now=100.0)
    monkeypatch.setattr(log, "perf_counter", lambda: held.now)
    monkeypatch.setattr(log, "process_time", lambda: 0.5 * held.now)
    return held


def test_phases_add_up_and_nest(clock):
    timers = Timers()
    with timers("step"):
        for _ in range(2):
            with timers("solve"):
                clock.now += 3.0
            with timers("step"):  # inside itself: counted once
                clock.now += 0.5
    assert timers.seconds == {"step": 7.0, "solve": 6.0} and timers.cpu == {"step": 3.5, "solve": 3.0}
    assert list(timers.seconds) == ["step", "solve"]


def test_a_phase_that_raises_is_counted_and_closed(clock):
    timers = Timers()
    for _ in range(2):
        with pytest.raises(ZeroDivisionError), timers("bad"):
            clock.now += 1.0
            1 / 0
    assert timers.seconds == {"bad": 2.0}


def test_reduce_takes_phases_of_all_ranks():
    timers = Timers()
    assert timers.reduce(Ranks([], [])) == {}
    timers.seconds, timers.cpu = {"solve": 3.0, "record": 1.0}, {"solve": 2.0, "record": 1.0}
    found = timers.reduce(Ranks(["solve", "wait"], [(1.0, 0.5), (0.0, 0.0), (4.0, 4.0)]))
    assert found == {"solve": {"max": 3.0, "mean": 2.0, "cpu": 2.5}, "record": {"max": 1.0, "mean": 0.5, "cpu": 1.0},
                     "wait": {"max": 4.0, "mean": 2.0, "cpu": 4.0}}
