"""Tables of a report: cost, errors, profiles, from summary.json and case.json."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from parisph.base.text import named
from parisph.case.probes import Probe
from parisph.case.profiles import Profiles
from parisph.case.truths import Peaks, Truth, WaveTruth
from parisph.report.entries import Cell, CellTable, entry, number

SUMMARY, CASE = "summary.json", "case.json"
ALIGNMENT = (
    "No series is shifted: the time of the run is that of the reference (shift = 0). The last two columns are for "
    "information only: the shift of the run's time with the least error (sought within 5 % of the compared time, "
    "either way), and this error."
)
ERROR_HEAD = ("probe", "reference", "relative L2 error, shift = 0", "from [s]", "to [s]", "both smoothed over [s]",
              "samples", "least of others", "best shift [s]", "error if so shifted")
PROFILE_HEAD = ("profiles", "reference", "at [s]", "relative L2 error", "mean difference [m]", "rms [m]")
AT_END = 0.999    # share of the range of shifts, beyond which the error may decrease further
Probes = Sequence[Probe]
AnyTruth = Truth | WaveTruth | Peaks | Profiles
Content = Mapping[str, Any]    # of a JSON file


def cost(summary: Content) -> CellTable:
    """Return the cost of a run: wall and CPU time, steps, iterations, phases."""
    rows = [("CPU time", number(summary, SUMMARY, ["cpu_seconds"], ".4g", "s")),
            ("wall time", number(summary, SUMMARY, ["wall_seconds"], ".4g", "s")),
            ("steps", number(summary, SUMMARY, ["steps"], "d")),
            ("iterations per solve, median", number(summary, SUMMARY, ["iterations", "median"])),
            ("iterations per solve, most", number(summary, SUMMARY, ["iterations", "max"])),
            ("peak memory of the first rank", number(summary, SUMMARY, ["peak_memory_mb", 0], ".0f", "MB"))]
    phases = summary.get("cpu_phases") or {}
    longest = sorted(phases, key=lambda name: -float(phases[name]))[:4]
    rows += [(f"CPU time, {name}", number(summary, SUMMARY, ["cpu_phases", name], ".4g", "s")) for name in longest]
    return named_rows(rows)


def errors(probes: Probes, case: Content, summary: Content) -> CellTable:
    """Return the errors of the probes with a truth, a line for each reference."""
    return CellTable(ERROR_HEAD, tuple(row for k, probe in enumerate(probes)
                                   for row in _of_probe(k, probe, case, summary)))


def _of_probe(k: int, probe: Probe, case: Content, summary: Content) -> Iterator[tuple[Cell, ...]]:
    for truth, place, path in _truths(k, probe):
        reason = number(summary, SUMMARY, [*path, "reason"])
        error = number(summary, SUMMARY, [*path, "relative_l2"], ".3g") if reason.text == "-" else reason
        start, end, points, shift, shifted = (
            number(summary, SUMMARY, [*path, name], form) for name, form in
            (("start", ".4g"), ("end", ".4g"), ("points", "d"), ("best_shift", "+.3g"), ("shifted_l2", ".3g")))
        best, sought = (entry(summary, [*path, name]) for name in ("best_shift", "shift_sought"))
        if best and sought and abs(best) > AT_END * sought:
            shift = Cell(f"{shift.text} (end of the range, no minimum)", shift.source)
        of_wave = isinstance(truth, WaveTruth) or (isinstance(truth, (Truth, Profiles)) and truth.wave)
        name = name_of(truth) + (", relative to the wave alone" if of_wave else "")
        yield (Cell(probe.name), Cell(name), error, start, end, number(case, CASE, [*place, "smooth"], ".3g"),
               points, least_of_others(truth, case, place), shift, shifted)


def _truths(k: int, probe: Probe) -> Iterator[tuple[AnyTruth, list[Any], list[Any]]]:
    """Yield the truths of probe k, each with its place in the case and in the summary."""
    truth: AnyTruth | None = probe.truth
    path: list[Any] = ["errors", probe.name]
    place: list[Any] = ["probes", k, "truth"]
    if truth is not None and not isinstance(truth, Peaks):
        yield truth, place, [*path]
    others: Sequence[Truth | Profiles] = truth.others if isinstance(truth, (Truth, Profiles)) else ()
    for n, other in enumerate(others):
        yield other, [*place, "others", n], [*path, "others", other.name]


def name_of(truth: AnyTruth) -> str:
    """Return the name of a truth, or that of its file."""
    if isinstance(truth, WaveTruth):
        return "wave"
    return truth.name or ("numbers" if isinstance(truth, Peaks) else named(truth.file.rpartition("/")[2]))


def least_of_others(truth: AnyTruth, case: Content, place: list[Any]) -> Cell:
    """Return the least error of others that the case states for a truth at a place in case.json."""
    levels = truth.published if isinstance(truth, (Truth, Profiles)) else {}
    if not levels:
        return Cell("-")
    best = min(levels, key=lambda name: levels[name])
    return number(case, CASE, [*place, "published", best], ".3g", f"({best})")


def profiles(probes: Probes, summary: Content) -> CellTable:
    """Return the errors of arrays of gauges against each profile."""
    columns = (("time", ".4g"), ("relative_l2", ".3g"), ("mean", "+.2g"), ("rms", ".2g"))
    rows: list[tuple[Cell, ...]] = []
    for k, probe in ((k, probe) for k, probe in enumerate(probes) if isinstance(probe.truth, Profiles)):
        for truth, _, path in _truths(k, probe):
            rows += [(Cell(probe.name), Cell(name_of(truth)),
                      *(number(summary, SUMMARY, [*path, "profiles", n, name], form) for name, form in columns))
                     for n in range(len(entry(summary, [*path, "profiles"]) or ()))]
    return CellTable(PROFILE_HEAD, tuple(rows))


def published(probes: Probes) -> list[tuple[str, str]]:
    """Return (names of probes, text) of the errors of others that the case states."""
    found = []
    for probe in probes:
        for one in _with_files(probe):
            if one.published:
                levels = "; ".join(f"{who}: {level:.3g}" for who, level in one.published.items())
                found.append((probe.name, f"against {one.name or 'the reference'}: {levels}"))
    return _once(found)


def notes(probes: Probes) -> list[tuple[str, str]]:
    """Return (names of probes, note) of the truths that have one."""
    own = [(probe.name, probe.truth.note) for probe in probes if isinstance(probe.truth, Peaks)]
    own += [(probe.name, one.note) for probe in probes for one in _with_files(probe)]
    return _once([(name, note) for name, note in own if note])


def _once(told: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return (names of probes, text), each text once."""
    names: dict[str, list[str]] = {}
    for name, text in told:
        names.setdefault(text, []).append(name)
    return [(", ".join(dict.fromkeys(all_of_them)), text) for text, all_of_them in names.items()]


def _with_files(probe: Probe) -> tuple[Truth | Profiles, ...]:
    truth = probe.truth
    return (truth, *truth.others) if isinstance(truth, (Truth, Profiles)) else ()


def named_rows(rows: Iterable[tuple[str, Cell]]) -> CellTable:
    """Return a table of (name, Cell)."""
    return CellTable((), tuple((Cell(name), cell) for name, cell in rows))
