"""A probe of a run against any reference series: what `parisph compare` prints. Not collective."""

from parisph.base.errors import CaseError
from parisph.io import series
from parisph.study import errors


def compare(run, reference, probe=None, column=None, time=None, value=None, offset=0.0, scale=1.0,
            time_scale=1.0, shift=0.0, best_shift=None, rest=None):
    """Return how far a probe is from a reference.

    Parameters
    ----------
    run : io.reader.Run
    reference : path of a CSV file with one header line
    probe, column : name of the probe and of its column; may be left out where there is only one
    time, value : names of the reference's columns (default: its first and its second)
    offset, scale, time_scale : truth = offset + scale * value; t = time_scale * time [s]
    shift : [s], added to the run's time
    best_shift : None, or the largest time shift [s] either way among which the best one is sought
    rest : None, or the level at rest: the error is then a share of the wave alone

    Returns
    -------
    dict: probe, column, shift [s], and what errors.judge returns.

    Raises
    ------
    CaseError for names that are not there or series that do not overlap; StoreError for files.
    """
    probe = _only(probe, run.probe_names, f"{run.folder} has the probes", "--probe")
    found = run.probe(probe)
    column = _only(column, [name for name in found.dtype.names if name not in ("time", "step")], f"{probe} has the columns", "--column")
    names = series.read(reference, cut=False).dtype.names
    if len(names) < 2:
        raise CaseError(f"{reference} has one column; a series needs a time and a value")
    t, truth = series.read_reference(reference, time or names[0], value or names[1], offset, scale, time_scale)
    try:
        if best_shift is not None:
            shift = errors.best_shift(found["time"], found[column], t, truth, best_shift)
        judged = errors.judge(found["time"] + shift, found[column], t, truth, rest)
    except ValueError as error:
        raise CaseError(f"{probe} against {reference}: {error}") from None
    return {"probe": probe, "column": column, "shift": shift, **judged}


def text(result):
    """Return the result of `compare` as lines."""
    of = "the wave" if result["relative_l2"] != result["z14"] else "the reference"
    return (f"{result['probe']}, {result['column']}: {result['samples']} samples, t = {result['start']:.6g} to "
            f"{result['end']:.6g} s, run shifted by {result['shift']:+.4g} s\n"
            f"relative L2 error  {result['relative_l2']:.4g} of {of}\n"
            f"norm of Z14        {result['z14']:.4g}")


def _only(name, names, there, option):
    if name in names:
        return name
    listed = ", ".join(names) or "none"
    if name is not None:
        raise CaseError(f"{there} {listed}; there is no {name!r}")
    if len(names) != 1:
        raise CaseError(f"{there} {listed}: choose one with {option}")
    return names[0]
