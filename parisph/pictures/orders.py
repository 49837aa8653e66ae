"""The pictures of runs by `parisph plot` and `parisph movie`, and their files. Needs no MPI."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base.errors import CaseError, ParisphError, StoreError
from parisph.base.paths import AnyPath
from parisph.base.text import clipped
from parisph.io.layout import PEAKS
from parisph.io.reader import Run
from parisph.pictures import curves, movies, overview, view
from parisph.pictures.colouring import SOLID
from parisph.truth.comparison import Comparison
from parisph.truth.recorded import own_columns

ROUNDED = 1e-9  # largest relative rounding error of a greatest value in a file
LONGEST = 100   # most characters of a file name made of names of probes


def plot(runs: Sequence[Run], time: float | None = None, peak: str | None = None, probes: Sequence[str] | None = None,
         out: AnyPath | None = None, normalise: bool = False, **look: Any) -> list[Path]:
    """Write pictures of a run, or of the probes of several runs, and return their paths.

    One run without time, peak, field and probes is drawn as a whole on one page.

    time : [s], of the flow at the nearest snapshot, with a warning on standard error if it is outside the run; the last
        snapshot if only `field` is given
    peak : name of a probe, in place of `time`: the flow at the greatest value of its first column, as kept by the run
        (Run.peak), else at the nearest snapshot, with a note on standard error
    probes : names of probes whose series are drawn in one picture
    out : file to write; None for files in the folder of the (first) run, named after their content
    normalise, look : see colouring.Look; None for a default

    Raises CaseError : `out` for two pictures, `normalise` for the whole run, the flow of several runs, no such probe or
    quantity; StoreError : no such snapshot, a field that was not written, or a file that cannot be written
    """
    look = _given(look)
    flow = time is not None or peak is not None or "field" in look or "view" in look or "camera" in look
    if len(runs) > 1:
        if flow or look:
            raise CaseError("only probes can be drawn for several runs: give one run for pictures of the flow")
        return [_plot_probes(runs, probes, normalise, out)]
    if out is not None and flow and probes:
        raise CaseError("-o names one file, but these are two pictures, of the flow and of probes: "
                        "make them one by one")
    run, = runs
    if not flow and not probes:
        if normalise:
            raise CaseError("--normalise does not apply to the whole run on one page: also give --time, --peak, "
                            "--field or --probe")
        path = Path(out or run.folder / "overview.png")
        overview.plot_overview(run, path, **look)
        return [path]
    made = []
    if flow:
        made.append(_plot_flow(run, time, peak, out, {**look, "normalise": normalise}))
    if probes:
        made.append(_plot_probes([run], probes, normalise, out))
    return made


def animate(run: Run, out: AnyPath | None = None, fps: float | None = None, slow: float | None = None,
            progress: bool = False, **look: Any) -> Path:
    """Write an animation of all snapshots (movies.movie) and return its path.

    Without `out` it is an .mp4, or without ffmpeg a .gif, with a note on standard error.
    """
    look = _given(look)
    if out is None:
        mp4 = movies.has_ffmpeg()
        out = run.folder / f"flow_{look.get('field', 'pressure')}.{'mp4' if mp4 else 'gif'}"
        if not mp4:
            print("parisph: note: the movie is a .gif, because the program ffmpeg is not installed; an .mp4 is smaller "
                  "and can be paused", file=sys.stderr)
    return movies.movie(run, out, fps=fps, slow=slow, progress=progress, **look)


def _given(look: dict[str, Any]) -> dict[str, Any]:
    """Return what was given of a Look; a rendered view shows the speed, as the pressure on the surface is 0."""
    given = {name: value for name, value in look.items() if value is not None}
    return {"field": "speed", **given} if given.get("view") == SOLID else given


def compare(run: Run, comparison: Comparison, reference: AnyPath, path: AnyPath) -> None:
    """Draw a probe of a run, its reference and their difference to a file. reference : path of its file

    Raises CaseError for a name that matplotlib cannot write, StoreError for a file that cannot be written.
    """
    result, (time, values) = comparison.result, comparison.found
    shift = f"; run shifted by {result['shift']:+.4g} s" if result["shift"] else ""
    title = f"{run.folder.name}: {result['probe']} against {result['value']} of {Path(reference).name}{shift}"
    curves.plot_comparison((time + result["shift"], values), comparison.truth, comparison.difference,
                           clipped(title, 100),
                           result["column"], run.units(result["probe"])[result["column"]], path)


def peak_of(run: Run, probe: str) -> tuple[float, float]:
    """Return time [s] and value of the maximum of the first column of a probe. Raises CaseError, StoreError."""
    series = run.probe(probe)
    column = own_columns(series)[0]
    if not np.any(np.isfinite(series[column])):
        raise StoreError(f"the probe {probe!r} of {run.folder} has no value to find the peak of")
    line = series[np.nanargmax(series[column])]
    return float(line["time"]), float(line[column])


def _plot_probes(runs: Sequence[Run], probes: Sequence[str] | None, normalise: bool, out: AnyPath | None) -> Path:
    if out is None:
        names = ["probes", *(probes or []),
                 *(curves.folder_names([run.folder for run in runs]) if len(runs) > 1 else [])]
        name = "_".join(names).replace("/", "-")
        out = runs[0].folder / f"{name if len(name) <= LONGEST else f'probes_of_{len(runs)}_runs'}.png"
    truths = {}
    for run in reversed(runs):
        truths.update(_truths(run))
    curves.plot_probe(runs, probes, out, truths, normalise)
    return Path(out)


def _plot_flow(run: Run, time: float | None, peak: str | None, out: AnyPath | None, look: dict[str, Any]) -> Path:
    which: float | Mapping[str, Any] = -1
    if peak is not None:
        which = _at_peak(run, peak)
    elif time is not None:
        _warn_of_other_time(run, time)
        which = float(time)
    if out is None:
        shown = which["time"] if isinstance(which, Mapping) else run.times[run.number(which)]
        of = SOLID if look.get("view") == SOLID else look.get("slice", "").replace(" ", "")
        out = run.folder / f"flow_{look.get('field', 'pressure')}_{shown:.4f}s{f'_{of}' if of else ''}.png"
    view.plot_field(run, which, path=out, **look)
    return Path(out)


def _at_peak(run: Run, probe: str) -> float | Mapping[str, Any]:
    """Return the flow at a peak (dict) if the run has kept it, else the time [s] of the peak, with a note."""
    time, value = peak_of(run, probe)
    kept = run.peak(probe)
    if kept is not None and kept["peak"] >= value - ROUNDED * abs(value):
        return kept
    if time > 0.0:    # a pressure belongs to the middle of the step, and the flow to its end
        ends = run.steps["time"]
        time = float(ends[min(np.searchsorted(ends, time * (1.0 - 1e-12)), len(ends) - 1)])
    late = run.times[run.number(time)] - time
    if late:
        print(f"parisph: note: there is no snapshot at the peak of {probe}, t = {time:.6g} s: "
              f"the nearest one is drawn, {abs(late):.3g} s {'later' if late > 0.0 else 'earlier'}; "
              f"{_why_not_kept(run, probe, kept)}", file=sys.stderr)
    return time


def _why_not_kept(run: Run, probe: str, kept: Mapping[str, Any] | None) -> str:
    about = next((one for one in run.scene.probes if one.name == probe), None)
    if kept is not None and about and about.truth:
        return f"the run keeps the flow at t = {kept['time']:.6g} s, the peak within the time of its truth"
    if kept is not None:
        return f"the run keeps the flow at t = {kept['time']:.6g} s, with a value of {kept['peak']:.6g}"
    if about and about.peak:
        return f"the flow at the peak is missing in {run.folder / PEAKS}"
    return "a probe with peak=True keeps the flow at its peak"


def _warn_of_other_time(run: Run, time: float) -> None:
    """Warn on standard error if a time [s] is outside the run, with the time of the picture."""
    if len(run) == 0:
        return
    slack = 0.5 * np.diff(run.times).max(initial=0.0)
    if not run.times[0] - slack <= time <= run.times[-1] + slack:
        print(f"parisph: warning: --time {time:g} s is outside the run, which has snapshots from {run.times[0]:g} to "
              f"{run.times[-1]:g} s: the picture is of {run.times[run.number(float(time))]:g} s", file=sys.stderr)


def _truths(run: Run) -> dict[str, curves.Samples]:
    """Return the references of the probes; none, with a note, if a file is missing."""
    try:
        return curves.truths(run)
    except ParisphError as error:
        print(f"parisph: drawn without its reference: {error}", file=sys.stderr)
        return {}
