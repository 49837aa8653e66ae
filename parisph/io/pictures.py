"""Which pictures `parisph plot` and `parisph movie` make of a run, and into which files. Needs no MPI."""

import shutil
import sys
from pathlib import Path

import numpy as np

from parisph.base.errors import CaseError, StoreError
from parisph.io import curves, view


def plot(run, time=None, peak=None, field=None, probes=None, surface=False, normalise=False, out=None):
    """Write pictures of a run and return their paths.

    Without time, peak, field and probes: the whole run on one page.

    Parameters
    ----------
    run : io.reader.Run
    time : [s], the flow at the nearest snapshot, with a warning on standard error if it is farther before the
        first, or after the last, than any time inside is from its snapshot; the last one if only `field` is given
    peak : name of a probe: the flow when its first column is greatest, instead of `time`
    field : what colours the flow (see view.plot_field); the pressure if None
    probes : list of probe names: their series in one picture
    surface, normalise : see view.plot_field; the page of the whole run cannot be normalised
    out : file to write; None: files in the folder of the run, named after what they show

    Raises
    ------
    CaseError : `out` for two pictures, `normalise` for the whole run, no such probe or quantity; StoreError : no such snapshot, a field that was
    not written, or a file that cannot be.
    """
    flow = time is not None or peak is not None or field is not None
    if out is not None and flow and probes:
        raise CaseError("-o names one file, and these are two pictures, of the flow and of probes: ask for them one by one")
    if not flow and not probes:
        if normalise:
            raise CaseError("--normalise has no meaning for the whole run on one page: give --time, --peak, --field or --probe too")
        path = Path(out or run.folder / "overview.png")
        curves.plot_overview(run, path, field or "pressure", surface)
        return [path]
    made = []
    if flow:
        made.append(_plot_flow(run, time, peak, field or "pressure", surface, normalise, out))
    if probes:
        path = Path(out or run.folder / f"probes_{'_'.join(probes)}.png")
        curves.plot_probe(run, probes, path, _truths(run), normalise)
        made.append(path)
    return made


def animate(run, field=None, surface=False, normalise=False, out=None):
    """Write an animation of all snapshots (view.movie) and return its path: .mp4 with ffmpeg, else .gif."""
    field = field or "pressure"
    ending = "mp4" if shutil.which("ffmpeg") else "gif"
    return view.movie(run, Path(out or run.folder / f"flow_{field}.{ending}"), field, surface, normalise)


def peak_time(run, probe):
    """Return the time [s] at which the first column of a probe is greatest. Raises CaseError, StoreError."""
    series = run.probe(probe)
    column = next(name for name in series.dtype.names if name not in ("time", "step"))
    if not np.any(np.isfinite(series[column])):
        raise StoreError(f"the probe {probe!r} of {run.folder} has no value to find the peak of")
    return float(series["time"][np.nanargmax(series[column])])


def _plot_flow(run, time, peak, field, surface, normalise, out):
    if peak is not None:
        time = peak_time(run, peak)
    elif time is not None:
        _warn_of_other_time(run, time)
    which = -1 if time is None else float(time)
    if out is None:
        out = run.folder / f"flow_{field}_{run.times[run.number(which)]:.4f}s.png"
    view.plot_field(run, which, field, out, surface, normalise)
    return Path(out)


def _warn_of_other_time(run, time):
    """Say on standard error that no snapshot is near a time [s] outside the run, and which one is shown."""
    if len(run) == 0:
        return
    slack = 0.5 * np.diff(run.times).max(initial=0.0)
    if not run.times[0] - slack <= time <= run.times[-1] + slack:
        print(f"parisph: warning: --time {time:g} s is outside the run, whose snapshots are of {run.times[0]:g} to {run.times[-1]:g} s: "
              f"the picture is of {run.times[run.number(float(time))]:g} s", file=sys.stderr)


def _truths(run):
    """References of the probes; a run that was carried to another machine may have left them behind."""
    try:
        return curves.truths(run, Path())
    except StoreError as error:
        print(f"parisph: drawn without its reference: {error}", file=sys.stderr)
        return {}
