"""The table at the end of a run, and the text of `parisph info`. Not collective."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from parisph.base.errors import StoreError
from parisph.base.text import plain_lines
from parisph.io import made
from parisph.io.layout import INDEX, PEAKS
from parisph.io.reader import Run


def table(summary: Mapping[str, Any]) -> list[str]:
    """Return the lines of a short table of summary.json; missing entries are left out."""
    return _plain(f"{name:<15} {text}" for name, text in _entries(summary) if text is not None)


def last_words(summary: Mapping[str, Any]) -> list[str]:
    """Return the line below the table of a run, [] without warnings: status, first warning and number of others."""
    warnings = summary.get("warnings") or ()
    more = f" (and {len(warnings) - 1} more above)" if len(warnings) > 1 else ""
    return _plain([f"{str(summary.get('status')).partition(':')[0]}: {warnings[0]}{more}"]) if warnings else []


def describe(run: Run) -> str:
    """Return the content and the results of a Run as text. Raises StoreError."""
    lines = [str(run.case.get("title", "")), f"{'folder':<16}{run.folder}"]
    lines += [f"{name:<16}{text}" for name, text in made.lines(run.made)]
    lines += ["", *(_results(run) if run.summary else ["no summary.json: the run goes on, or was killed"])]
    if len(run):
        lines += ["", f"{'snapshots':<16}{len(run)}, t = {run.times[0]:.6g} to {run.times[-1]:.6g} s "
                      f"({run.folder / INDEX})"]
    checkpoints = sorted((run.folder / "checkpoints").glob("*.h5"))
    if checkpoints:
        lines.append(f"{'checkpoints':<16}{', '.join(path.name for path in checkpoints)}")
    for name in run.probe_names:
        columns = (f"{column} [{unit}]" if unit else column for column, unit in run.units(name).items()
                   if column not in ("time", "step"))
        kept = "; the flow at its peak is kept" if (run.folder / PEAKS / f"{name}.vtkhdf").exists() else ""
        lines.append(f"{'probe':<16}{name}: {', '.join(columns)}{kept}")
    return "\n".join(_plain(lines))


def provenance(run: Run) -> str:
    """Return the versions and options of a Run as text, "" if it has no snapshot.

    Entries that `describe` shows from the summary are left out. If an entry changed during the run, as PETSc's options
    may, both values are shown. Raises StoreError if the first snapshot is damaged.
    """
    summary = run.summary or {}
    told = {name: str(summary.get(name)) for name in ("method", "ranks")}
    # attributes of files hold tables as JSON
    end = {name: json.dumps(value) if isinstance(value, dict) else str(value) for name, value in summary.items()}
    lines = []
    for name, value in sorted(run.about.items()):
        if told.get(name) != str(value):
            lines.append(f"{name:<16}{value}")
        if end.get(name, str(value)) != str(value):
            lines.append(f"{'  at the end':<16}{end[name]}")
    return "\n".join(_plain(lines))


def _results(run: Run) -> list[str]:
    """Return the table of the summary of a Run. Raises StoreError if an entry is not of its type."""
    try:
        return table(run.summary or {})
    except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
        raise StoreError(f"{run.folder / 'summary.json'} is damaged: its entries are not those of a summary") from None


def _plain(entries: Iterable[str]) -> list[str]:
    """Return texts with escaped control characters and indented further lines: files of a run may be anybody's."""
    return [plain_lines(entry, indent=4 * " ") for entry in entries]


def _entries(summary: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    get = summary.get
    yield "status", get("status")
    for warning in get("warnings") or ():
        yield "warning", str(warning)
    yield "method", get("method")
    yield "ranks", _number(get("ranks"), "d")
    yield "particles", _number(get("particles"), ",d")
    yield "steps", _number(get("steps"), ",d")
    yield "time", _number(get("time"), ".6g", " s")
    yield "wall time", _number(get("wall_seconds"), ".1f", " s")
    yield "CPU time", _number(get("cpu_seconds"), ".1f", " s")
    iterations = get("iterations")
    if iterations:
        words = (f"{name} {iterations[name]:.0f}" for name in ("median", "p99", "max")
                 if iterations.get(name) is not None)
        yield "iterations", ", ".join(words)
    fallbacks = get("fallbacks")
    if fallbacks:
        each = isinstance(fallbacks, dict)
        yield "fallbacks", ", ".join(f"{name} {n}" for name, n in fallbacks.items()) if each else str(fallbacks)
    left = get("left") or {}
    if left.get("particles"):
        once = left["particles"] + (get("fluid_particles") or 0)
        yield "left the tank", (f"{left['particles']:,d} of {once:,d} particles over the rim, "
                                f"{left['volume']:.4g} {left.get('unit', 'm2')} of water")
    for probe, words in (get("touched") or {}).items():
        yield f"probe {probe}", str(words)
    unknown = get("volume_unknown")
    yield "volume drift", f"not measured: {unknown}" if unknown else _drift(get("volume_drift"), get("volume_range"))
    # if work is done on the fluid, a change of its energy is not an error
    yield "energy change" if get("driven") else "energy drift", _drift(get("energy_drift"), get("energy_range"))
    yield "in motion", _motion(get("energy_in_motion"))
    yield from _of_probes(get)


def _of_probes(get: Callable[[str], Any]) -> Iterator[tuple[str, Any]]:
    """Yield the entries of single probes."""
    peaks = get("peaks") or {}
    for probe, time in (get("arrivals") or {}).items():
        yield f"arrival at {probe}", "not in this run" if time is None else f"{time:.6g} s"
    for probe, found in peaks.items():
        if found.get("short"):
            yield f"peak of {probe}", _short(found, found.get("unit", ""))
    for probe, found in (get("greatest") or {}).items():
        if not (peaks.get(probe) or {}).get("short"):
            yield f"peak of {probe}", f"{found['value']:.4g} {found['unit']} at {found['time']:.4g} s"
    for probe, found in (get("passed") or {}).items():
        yield f"passed {probe}", _passed(found)
    yield "reflection", _reflection(get("reflection"))
    for probe, error in (get("errors") or {}).items():
        if isinstance(error, dict) and error.get("relative_l2") is None:
            yield f"error of {probe}", f"not judged: {error.get('reason', 'no reason is known')}"
        elif isinstance(error, dict):
            yield f"error of {probe}", _number(error["relative_l2"], ".3g", " (relative L2)")
        else:
            yield f"error of {probe}", str(error)


def _number(value: float | None, form: str, unit: str = "") -> str | None:
    return None if value is None else format(value, form) + unit


def _drift(end: float | None, extremes: Any) -> str | None:
    """Return the change from start to end with its extremes."""
    text = _number(end, "+.2%")
    if not isinstance(extremes, dict):
        return text
    return (f"{text or 'not known at the end'} (lowest {extremes['low']:+.2%} at {extremes['low_time']:.4g} s, "
            f"highest {extremes['high']:+.2%} at {extremes['high_time']:.4g} s)")


def _short(found: Mapping[str, Any], unit: str) -> str:
    """Return a peak that is not resolved, and the greatest one that is."""
    lasting = found.get("lasting")
    text = (f"{found['value']:.4g} {unit} at {found['time']:.4g} s lasts only {1e3 * found['lasts']:.2g} ms, and "
            f"depends on chance: mean over {1e3 * found['mean_over']:g} ms {found['mean']:.4g} {unit}")
    return text + (f"; the greatest that lasts: {lasting['value']:.4g} {unit} at {lasting['time']:.4g} s"
                   if lasting else "")


def _passed(found: Mapping[str, Any]) -> str:
    """Return the volume that has passed a line, and its events."""
    unit, events = found.get("unit", "m2"), found.get("events")
    text = f"{found['total']:.4g} {unit} of water"
    if events:
        most = max(events, key=lambda event: abs(event["volume"]))
        text += (f" in {len(events)} event{'s' * (len(events) > 1)}, the largest {most['volume']:.4g} {unit} from "
                 f"{most['start']:.4g} to {most['end']:.4g} s")
    return text


def _reflection(found: Mapping[str, Any] | None) -> str | None:
    """Return the reflection of the waves in a flume."""
    if not found or "reason" in found:
        return f"not known: {found['reason']}" if found else None
    if found["coefficient"] is None:
        return f"no waves at {', '.join(found['probes'])}"
    return (f"{found['coefficient']:.3g} of the incident {'' if found['regular'] else 'significant '}height, "
            f"{found['incident']:.4g} m, at {', '.join(found['probes'])} (residual {found['residual']:.2g})")


def _motion(energy: Any) -> str | None:
    """Return the energy of waves and flow, without that of the water at rest."""
    if not isinstance(energy, dict):
        return None
    unit = energy["unit"]
    text = f"{energy['start']:.4g} {unit} at the start, "
    text += "not known at the end" if energy["end"] is None else f"{energy['end']:.4g} {unit} at the end"
    if energy.get("drift") is not None:
        text += f" (drift {energy['drift']:+.2%} of it)"
    return f"{text}, highest {energy['high']:.4g} {unit} at {energy['high_time']:.4g} s"
