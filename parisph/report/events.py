"""Tables of a report: greatest values, arrivals, volumes that have passed lines, incident and reflected waves."""

from collections.abc import Iterator, Sequence
from typing import Any

from parisph.case.probes import Probe, class_of
from parisph.case.truths import bands_of
from parisph.report.account import CASE, SUMMARY, Content, Probes, name_of
from parisph.report.entries import Cell, CellTable, number

PEAK_HEAD = ("probe", "from [s]", "to [s]", "run smoothed over [s]", "greatest value", "at [s]",
             "band from", "to", "level at rest", "beyond the band by", "others have it at [s]", "truth")
PEAKS = (
    "The distance from a band is relative to its nearer end, which counts from the level at rest. If that is 0, "
    "heights above the bed include the depth of still water. Without a greatest value, the interval ends after the run."
)
PASSED = (
    "The first time at which a probe reaches the value in the case, interpolated between samples. A splash counts."
)
ARRIVAL_HEAD = ("probe", "passes", "at")
IMPACT_HEAD = ("probe", "greatest value", "at [s]", "lasts [s]", "mean over 5 ms", "greatest that lasts", "at [s]",
               "mean over 5 ms")
IMPACTS = (
    "Greatest pressures [Pa] and forces [N/m, by size], and the time that they are above half of their rise. A peak of "
    "one or two values, as when a cavity without air collapses, is marked: it depends on the time step and on chance. "
    "The next one that lasts longer is beside it."
)
PASSED_HEAD = ("probe", "event", "from [s]", "to [s]", "volume [m²]")
LINES = (
    "Volumes of water that have passed lines, per metre of width, positive from left to right as seen from the start "
    "of a line towards its end. An event ends when no water passes for the `pause` of its probe."
)
WAVES_HEAD = ("waves", "gauges", "from [s]", "to [s]", "depth [m]", "incident height [m]", "reflected height [m]",
        "reflection coefficient", "residual")
BANDS_HEAD = ("frequency [Hz]", "incident [m²/Hz]", "reflected [m²/Hz]", "reflection coefficient")
WAVES = (
    "By least squares from the elevations at the gauges: Goda and Suzuki (two), Mansard and Funke (three). Heights of "
    "irregular waves are significant heights, of half to twice the frequency of the peak. The residual is the part of "
    "the amplitudes that two waves do not explain. For other gauges or times, use parisph reflection."
)


def peaks(probes: Probes, summary: Content) -> CellTable:
    """Return the greatest values in intervals of time beside those of others."""
    columns = (("start", ".4g"), ("end", ".4g"), ("smooth", ".3g"), ("found", ".4g"), ("time", ".4g"),
               ("low", ".4g"), ("high", ".4g"), ("level", ".4g"), ("beyond", "+.0%"), ("when", ".4g"))
    return CellTable(PEAK_HEAD, tuple(
        (Cell(probe.name), *(number(summary, SUMMARY, [*path, name], form, remarks.get(name, ""))
                             for name, form in columns), Cell(name_of(probe.truth)))
        for probe in probes if probe.truth is not None
        for path in (("errors", probe.name, "peaks", k) for k in range(len(bands_of(probe.truth))))
        for remarks in (_remarks(summary, path),)
    ))


def _remarks(summary: Content, path: Sequence[str | int]) -> dict[str, str]:
    """Return {column: remark after its number} of a peak."""
    mean = number(summary, SUMMARY, [*path, "mean"]).text
    said = {"short": ("found", f"(short: not resolved; {mean} over 5 ms)"),
            "last": ("time", "(last sample: the value may still rise)")}
    return dict(said[flag] for flag in said if number(summary, SUMMARY, [*path, flag]).text == "True")


def arrivals(case: Content, summary: Content) -> CellTable:
    """Return when probes reach the values of their `arrival`."""
    levels = {name: number(case, CASE, place, ".4g", next(iter((class_of(kind) or Probe).columns.values()), ""))
              for name, kind, place in _levels(case)}
    return CellTable(ARRIVAL_HEAD, tuple(
        (Cell(name), levels.get(name, Cell("-")), number(summary, SUMMARY, ["arrivals", name], ".4g", "s"))
        for name in summary.get("arrivals") or ()))


def impacts(summary: Content) -> CellTable:
    """Return the greatest pressures and forces, with the next ones beside those too short to be resolved."""
    rows = []
    for name, found in (summary.get("peaks") or {}).items():
        path = ["peaks", name]
        short = " (short: not resolved)" * bool(found.get("short"))
        rows.append((Cell(name + short), *(number(summary, SUMMARY, [*path, *inner], form) for inner, form in (
            (["value"], ".4g"), (["time"], ".4g"), (["lasts"], ".2g"), (["mean"], ".4g"),
            (["lasting", "value"], ".4g"), (["lasting", "time"], ".4g"), (["lasting", "mean"], ".4g")))))
    return CellTable(IMPACT_HEAD, tuple(rows))


def passed(summary: Content) -> CellTable:
    """Return the volumes that have passed the lines of probes, in total and in each event."""
    rows: list[tuple[Cell, ...]] = []
    for name, found in (summary.get("passed") or {}).items():
        path = ["passed", name]
        rows.append((Cell(name), Cell("all"), Cell(""), Cell(""), number(summary, SUMMARY, [*path, "total"])))
        rows += [(Cell(name), Cell(str(k + 1)), *(number(summary, SUMMARY, [*path, "events", k, what])
                                                  for what in ("start", "end", "volume")))
                 for k in range(len(found.get("events") or ()))]
    return CellTable(PASSED_HEAD, tuple(rows))


def _levels(case: Content) -> Iterator[tuple[str, str, list[Any]]]:
    """Yield name, kind and place of the `arrival` of each probe; in an array as "gauges.x1"."""
    for k, probe in enumerate(case.get("probes") or ()):
        yield probe["name"], probe["kind"], ["probes", k, "arrival"]
        for n, inner in enumerate(probe.get("probes") or ()):
            yield f"{probe['name']}.{inner['name']}", inner["kind"], ["probes", k, "probes", n, "arrival"]


def reflection(summary: Content) -> Iterator[tuple[CellTable, str]]:
    """Yield tables with the text below them; none for a run without a `reflection`."""
    found = summary.get("reflection")
    if not found:
        return
    path = ["reflection"]
    if "reason" in found:
        yield CellTable((), ((Cell("not known"), number(summary, SUMMARY, [*path, "reason"])),)), ""
        return
    columns = (("start", ".4g"), ("end", ".4g"), ("depth", ".4g"), ("incident", ".4g"), ("reflected", ".4g"),
               ("coefficient", ".3g"), ("residual", ".3g"))
    gauges = Cell(", ".join(found["probes"]), f"{SUMMARY}: reflection/probes")
    yield CellTable(WAVES_HEAD, ((Cell("regular" if found["regular"] else "irregular"), gauges,
                        *(number(summary, SUMMARY, [*path, name], form) for name, form in columns)),)), WAVES
    names = ("frequency", "incident", "reflected", "coefficient")
    rows = tuple(tuple(number(summary, SUMMARY, [*path, "bands", k, name], ".3g") for name in names)
                 for k in range(len(found.get("bands") or ())))
    if rows:
        yield CellTable(BANDS_HEAD, rows), ""
