"""Animations of the flow of a run. Needs matplotlib, no MPI."""

from dataclasses import dataclass
from pathlib import Path
from subprocess import CalledProcessError
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.base.errors import CaseError, StoreError
from parisph.base.live_line import LiveLine, clock
from parisph.base.paths import AnyPath
from parisph.base.text import clipped, plain
from parisph.io.files import replacing
from parisph.io.reader import Run, open_run
from parisph.pictures import style
from parisph.pictures.colouring import Look
from parisph.pictures.view import spread, view_of

if TYPE_CHECKING:
    from matplotlib.animation import AbstractMovieWriter

RATE = 20.0             # frames per second by default
SLOWEST, FASTEST = 1.0, 60.0   # frames per second that players show well
MOST_RATE = 120.0       # largest --fps
MOST_FRAMES = 20_000
SAMPLE = 24             # number of snapshots that give the scale of the colours


def movie(run: Run | AnyPath, path: AnyPath, field: str = "pressure", fps: float | None = None,
          slow: float | None = None, dpi: float = 100, progress: bool = False, **look: Any) -> Path:
    """Write the snapshots of a run as an animation, a .gif, or an .mp4 with ffmpeg; return its path.

    Colours, axes and speed are constant. The title gives the slow-motion factor.

    run : or its folder; path : file to write
    field : see colouring.Look, also for further keywords; without `limits` the colours cover most values of all frames,
        and a short impact may exceed them
    fps : frames per second; None for 20, or with `slow` for the rate that shows each snapshot once
    slow : slow-motion factor; None for the speed that shows each snapshot once
    progress : whether standard error shows the drawn frames and the time left

    Raises CaseError : as plot_field, for another ending, and for fps or slow out of range
    StoreError : as plot_field, or the file cannot be written
    """
    run = run if isinstance(run, Run) else open_run(run)
    figure, path = style.drawing(), Path(path)
    _check_ending(path)
    some = spread(run, SAMPLE)
    pace = Pace.of(run.times, fps, slow, whole_hundredths=path.suffix.lower() == ".gif")
    view = view_of(run.scene, some, Look(field, **look))
    limits = view.limits(some)
    picture = figure.Figure(figsize=view.size(), dpi=dpi, layout="constrained")
    axes = picture.add_subplot()
    writer, line = _writer(path, pace.fps), LiveLine(progress)
    try:
        with replacing(path) as new, writer.saving(picture, str(new), dpi):
            for count, number in enumerate(pace.numbers):
                axes.clear()
                discs = view.draw(axes, run.snapshot(int(number)), limits, note=pace.note)
                view.add_colour_bar(picture, axes, discs, some)
                if count == 0:  # one layout for all frames
                    picture.draw_without_rendering()
                    picture.set_layout_engine("none")
                writer.grab_frame()
                if line.due():
                    made, frames = count + 1, len(pace.numbers)
                    line.show(f"frame {made} of {frames}  {clock((frames - made) * line.elapsed / made)} left")
    except OSError as error:
        raise StoreError(f"cannot write the movie {path}: {error.strerror or error}") from None
    except CalledProcessError as error:
        said = "".join(f" ({clipped(plain(line))})" for line in str(error.stderr or "").strip().splitlines()[-1:])
        raise StoreError(f"cannot write the movie {path}: ffmpeg ended with code {error.returncode}{said}; "
                         "a .gif needs no ffmpeg") from None
    finally:
        line.close()
    return path


def has_ffmpeg() -> bool:
    """Return whether the program ffmpeg, which an .mp4 needs, is installed."""
    style.drawing()
    from matplotlib import animation

    return bool(animation.FFMpegWriter.isAvailable())


@dataclass(frozen=True)
class Pace:
    """The speed of an animation.

    fps : frames per second
    slow : slow-motion factor; None for a single frame
    numbers : (frames,) int, the snapshot of each frame, the nearest in time
    """

    fps: float
    slow: float | None
    numbers: Ints

    @classmethod
    def of(cls, times: Floats, fps: float | None = None, slow: float | None = None,
           whole_hundredths: bool = False) -> "Pace":
        """Return the Pace for snapshots at `times` (n,) [s], increasing.

        fps, slow : see movie; whole_hundredths : whether frames last whole hundredths of a second, as in a .gif

        Raises CaseError: a number out of range, or too many frames
        """
        _check_positive("--fps", fps, MOST_RATE)
        _check_positive("--slow", slow, np.inf)
        apart = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
        if fps is None:
            fps = min(1.0 / (slow * apart), FASTEST) if slow and apart else RATE
            fps *= np.ceil(SLOWEST / fps) if fps < SLOWEST else 1.0    # each snapshot is repeated equally often
        if whole_hundredths:
            fps = 100.0 / max(round(100.0 / fps), 2)    # viewers show shorter frames too slowly
        if not apart:
            return cls(fps, None, np.arange(len(times)))
        slow = slow or 1.0 / (fps * apart)
        count = (times[-1] - times[0]) * fps * slow
        if count > MOST_FRAMES:
            raise CaseError(f"--slow {slow:g} with --fps {fps:g} makes {count:.3g} frames of "
                            f"{times[-1] - times[0]:g} s, at most {MOST_FRAMES:,} are drawn: give a smaller number")
        shown = times[0] + np.arange(round(count) + 1) / (fps * slow)
        half_way = 0.5 * (times[1:] + times[:-1]) + 1e-6 * apart      # half way the earlier one, despite rounding
        return cls(fps, slow, np.searchsorted(half_way, shown))

    @property
    def note(self) -> str:
        """Return the slow-motion factor as text, "" for a single frame."""
        if self.slow is None:
            return ""
        if 0.95 < self.slow < 1.05:
            return "real time"
        return f"slowed {self.slow:.3g} x" if self.slow > 1.0 else f"speeded up {1.0 / self.slow:.3g} x"


def _check_positive(name: str, value: float | None, most: float) -> None:
    if value is not None and not 0.0 < value <= most or value == np.inf:
        limit = f" and at most {most:g}" if most < np.inf else ""
        raise CaseError(f"{name} {value:g}: must be a number greater than 0{limit}")


def _check_ending(path: Path) -> None:
    if path.suffix.lower() not in (".gif", ".mp4"):
        raise CaseError(f"{path}: a movie ends in .gif or .mp4")
    if path.suffix.lower() == ".mp4" and not has_ffmpeg():
        raise StoreError(f"{path}: an .mp4 needs the program ffmpeg, which is not installed here: install it, for "
                         f"example by `apt install ffmpeg`, or write {path.with_suffix('.gif')}")


def _writer(path: Path, fps: float) -> "AbstractMovieWriter":
    from matplotlib import animation

    rate: Any = fps    # matplotlib declares int, and accepts float
    if path.suffix.lower() == ".gif":
        # the writer truncates the milliseconds of a frame: 29.999... would become 20
        return animation.PillowWriter(rate * (1.0 - 1e-9))
    return animation.FFMpegWriter(rate, extra_args=["-pix_fmt", "yuv420p"])
