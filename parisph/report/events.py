"""What a report says of events: the greatest values in intervals of time, and when probes pass a value."""

from collections.abc import Iterator, Sequence
from typing import Any

from parisph.case.truths import bands_of
from parisph.report.account import CASE, SUMMARY, Content, Probes, name_of
from parisph.report.entries import Cell, Table, number

PEAK_HEAD = ("probe", "from [s]", "to [s]", "run smoothed over [s]", "greatest value", "at [s]",
             "band from", "to", "level at rest", "beyond the band by", "others have it at [s]", "truth")
PEAKS = (
    "A share beyond a band is that of its nearer end. Both count from the level at rest, where it is not 0: heights "
    "above the bed include that of still water. A row without a greatest value has an interval that ends after the run."
)
PASSED = (
    "The first time at which a probe is at the value given in the case, or passes it, by lines between samples. A "
    "splash that comes by counts as well."
)
ARRIVAL_HEAD = ("probe", "passes", "at")
IMPACT_HEAD = ("probe", "greatest value", "at [s]", "lasts [s]", "mean over 5 ms", "greatest that lasts", "at [s]",
               "mean over 5 ms")
IMPACTS = (
    "Greatest pressures [Pa] and forces [N/m, by size], and for how long they are above half of their rise. "
    "A peak that is only one or two values of the pressure long, as of a cavity without air that collapses, is marked: "
    "it depends on the time step and on chance, and the next one that lasts longer stands beside it."
)
PASSED_HEAD = ("probe", "event", "from [s]", "to [s]", "volume [m²]")
LINES = (
    "Volumes of water that have passed lines, per metre of width, positive from the left of a line to its right as "
    "seen from its start to its end. An event ends when no water passes for the `pause` of its probe."
)


def peaks(probes: Probes, summary: Content) -> Table:
    """Return the greatest values in intervals of time beside what others have there."""
    columns = (("start", ".4g"), ("end", ".4g"), ("smooth", ".3g"), ("found", ".4g"), ("time", ".4g"),
               ("low", ".4g"), ("high", ".4g"), ("level", ".4g"), ("beyond", "+.0%"), ("when", ".4g"))
    return Table(PEAK_HEAD, tuple(
        (Cell(probe.name), *(number(summary, SUMMARY, [*path, name], form, remarks.get(name, ""))
                             for name, form in columns), Cell(name_of(probe.truth)))
        for probe in probes if probe.truth is not None
        for path in (("errors", probe.name, "peaks", k) for k in range(len(bands_of(probe.truth))))
        for remarks in (_remarks(summary, path),)
    ))


def _remarks(summary: Content, path: Sequence[str | int]) -> dict[str, str]:
    """Return {column: what is said behind its number} of a peak: one that rises until the end is none."""
    mean = number(summary, SUMMARY, [*path, "mean"]).text
    said = {"short": ("found", f"(short: not resolved; {mean} over 5 ms)"),
            "last": ("time", "(last sample: the value may still rise)")}
    return dict(said[flag] for flag in said if number(summary, SUMMARY, [*path, flag]).text == "True")


def arrivals(case: Content, summary: Content) -> Table:
    """Return when probes pass the values of their `arrival`, with these values."""
    levels = {name: number(case, CASE, place, ".4g", "Pa" if kind == "pressure_tap" else "m")
              for name, kind, place in _levels(case)}
    return Table(ARRIVAL_HEAD, tuple(
        (Cell(name), levels.get(name, Cell("-")), number(summary, SUMMARY, ["arrivals", name], ".4g", "s"))
        for name in summary.get("arrivals") or ()))


def impacts(summary: Content) -> Table:
    """Return the greatest pressures and forces, which of them are too short to be resolved, and the next ones."""
    rows = []
    for name, found in (summary.get("peaks") or {}).items():
        path = ["peaks", name]
        short = " (short: not resolved)" * bool(found.get("short"))
        rows.append((Cell(name + short), *(number(summary, SUMMARY, [*path, *inner], form) for inner, form in (
            (["value"], ".4g"), (["time"], ".4g"), (["lasts"], ".2g"), (["mean"], ".4g"),
            (["lasting", "value"], ".4g"), (["lasting", "time"], ".4g"), (["lasting", "mean"], ".4g")))))
    return Table(IMPACT_HEAD, tuple(rows))


def passed(summary: Content) -> Table:
    """Return the volumes that have passed the lines of probes: in all, and in each event."""
    rows: list[tuple[Cell, ...]] = []
    for name, found in (summary.get("passed") or {}).items():
        path = ["passed", name]
        rows.append((Cell(name), Cell("all"), Cell(""), Cell(""), number(summary, SUMMARY, [*path, "total"])))
        rows += [(Cell(name), Cell(str(k + 1)), *(number(summary, SUMMARY, [*path, "events", k, what])
                                                  for what in ("start", "end", "volume")))
                 for k in range(len(found.get("events") or ()))]
    return Table(PASSED_HEAD, tuple(rows))


def _levels(case: Content) -> Iterator[tuple[str, str, list[Any]]]:
    """Yield names, kinds and places of the `arrival` of a case's probes; in arrays they are named as in "gauges.x1"."""
    for k, probe in enumerate(case.get("probes") or ()):
        yield probe["name"], probe["kind"], ["probes", k, "arrival"]
        for n, inner in enumerate(probe.get("probes") or ()):
            yield f"{probe['name']}.{inner['name']}", inner["kind"], ["probes", k, "probes", n, "arrival"]
