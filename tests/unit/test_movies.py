"""How fast an animation goes, and what its title says of that."""

import io
import sys

import numpy as np
import pytest

from parisph.base import live_line
from parisph.base.errors import CaseError, StoreError
from parisph.pictures import movies, orders, view
from parisph.pictures.movies import Pace
from tests.unit.test_view import basin, water, written

pytest.importorskip("matplotlib")
TIMES = 0.01 * np.arange(11)


def test_each_snapshot_is_a_frame_and_the_factor_follows():
    pace = Pace.of(TIMES)
    assert (pace.fps, pace.slow, pace.note) == (20.0, pytest.approx(5.0), "slowed 5 x")
    assert pace.numbers.tolist() == list(range(11))
    assert Pace.of(TIMES, fps=40.0).note == "slowed 2.5 x"
    assert Pace.of(TIMES, fps=100.0).note == "real time" and Pace.of(10.0 * TIMES).note == "speeded up 2 x"


def test_a_factor_chooses_the_frames():
    pace = Pace.of(TIMES, slow=4.0)
    assert (pace.fps, pace.numbers.tolist()) == (pytest.approx(25.0), list(range(11)))
    pace = Pace.of(TIMES, fps=20.0, slow=2.5)       # every other snapshot
    assert (pace.numbers.tolist(), pace.note) == ([0, 2, 4, 6, 8, 10], "slowed 2.5 x")
    pace = Pace.of(TIMES, fps=20.0, slow=10.0)      # each twice
    assert np.bincount(pace.numbers).tolist() == 10 * [2] + [1]
    pace = Pace.of(TIMES, slow=0.1)                 # 1000 frames a second: more than a player shows
    assert pace.fps == 60.0 and len(pace.numbers) == 2
    pace = Pace.of(TIMES, slow=1000.0)              # a snapshot every ten seconds: each in ten frames
    assert pace.fps == pytest.approx(1.0) and np.bincount(pace.numbers)[1:-1].tolist() == 9 * [10]


def test_time_runs_evenly_whatever_the_times_of_the_snapshots():
    times = np.sort([*TIMES, 0.031, 0.0333, 0.1047])      # asked for besides, and the end
    pace = Pace.of(times)
    shown = times[pace.numbers]
    assert len(shown) == 11 and np.abs(shown - TIMES).max() <= 0.001


def test_frames_of_a_gif_last_whole_hundredths_of_a_second():
    pace = Pace.of(TIMES, fps=30.0, whole_hundredths=True)
    assert pace.fps == pytest.approx(100 / 3) and pace.slow == pytest.approx(3.0)
    assert Pace.of(TIMES, fps=99.0, whole_hundredths=True).fps == 50.0
    kept = Pace.of(TIMES, fps=30.0, slow=8.0, whole_hundredths=True)
    assert kept.slow == 8.0 and len(kept.numbers) == round(0.1 * 8.0 * 100 / 3) + 1


def test_one_snapshot_has_no_pace():
    pace = Pace.of(np.array([0.3]), slow=5.0)
    assert (pace.note, pace.numbers.tolist()) == ("", [0])


@pytest.mark.parametrize("asked, message", [
    ({"fps": 0.0}, "--fps 0: must be a number greater than 0 and at most 120"), ({"fps": 1e3}, "at most 120"),
    ({"slow": -1.0}, "--slow -1: must be a number greater than 0"), ({"slow": np.inf}, "--slow inf"),
    ({"slow": np.nan}, "--slow nan"), ({"slow": 1e7, "fps": 20.0}, "makes 2e\\+07 frames of 0.1 s, at most 20,000"),
])
def test_what_cannot_be_played_is_said(asked, message):
    with pytest.raises(CaseError, match=message):
        Pace.of(TIMES, **asked)


def test_the_gif_is_as_fast_as_its_title_says(tmp_path):
    from PIL import Image

    run = written(tmp_path / "run", basin(), water(), count=4)      # .1 s apart
    path = movies.movie(run, tmp_path / "a.gif", slow=0.3, dpi=40)
    with Image.open(path) as frames:
        lengths = []
        for number in range(frames.n_frames):
            frames.seek(number)
            lengths.append(frames.info["duration"])
    assert sum(lengths) == 4 * 30     # [ms]: .3 times .1 s each, if all frames are alike they are one


def test_the_title_of_a_frame_says_the_factor(tmp_path, monkeypatch):
    notes = []
    draw = view.FieldView.draw
    monkeypatch.setattr(view.FieldView, "draw", lambda *args, **how: notes.append(how["note"]) or draw(*args, **how))
    run = written(tmp_path / "run", basin(), water())
    movies.movie(run, tmp_path / "a.gif", dpi=40)
    assert notes == 3 * ["speeded up 2 x"]


class Terminal(io.StringIO):
    """A terminal of which one second passes whenever somebody looks at the clock."""

    now = 0.0

    def isatty(self):
        return True

    def clock(self):
        self.now += 1.0
        return self.now


def test_progress_says_how_many_frames_are_drawn_and_how_long_the_others_take(tmp_path, monkeypatch):
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(live_line, "perf_counter", screen.clock)
    run = written(tmp_path / "run", basin(), water())
    movies.movie(run, tmp_path / "a.gif", dpi=20, progress=True)
    lines = screen.getvalue().split("\r\x1b[2K")
    assert lines[1].startswith("frame 1 of 3  0:0") and lines[1].endswith(" left")
    assert lines[3] == "frame 3 of 3  0:00 left" and lines[-1] == ""
    screen.truncate(0)
    movies.movie(run, tmp_path / "b.gif", dpi=20)
    assert screen.getvalue().strip("\0") == ""


def test_without_ffmpeg_a_movie_is_a_gif_and_says_so(tmp_path, monkeypatch, capsys):
    run = written(tmp_path / "run", basin(), water(), count=1)
    monkeypatch.setattr(movies, "has_ffmpeg", lambda: False)
    assert orders.animate(run) == tmp_path / "run" / "flow_pressure.gif"
    assert "note: the movie is a .gif, because the program ffmpeg is not installed" in capsys.readouterr().err
    with pytest.raises(StoreError, match="install it, for example by `apt install ffmpeg`, or write .*b.gif"):
        movies.movie(run, tmp_path / "b.mp4")
    written_by = []
    monkeypatch.setattr(movies, "has_ffmpeg", lambda: True)
    monkeypatch.setattr(movies, "movie", lambda run, path, **how: written_by.append(path))
    orders.animate(run)
    assert written_by == [tmp_path / "run" / "flow_pressure.mp4"]
