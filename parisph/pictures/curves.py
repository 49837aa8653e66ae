"""Pictures of time series: probes of one or several runs, and a probe with its reference. Needs matplotlib, no MPI."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError, StoreError
from parisph.base.paths import AnyPath
from parisph.case import differences
from parisph.case.probes import Gauge, Probe, singles
from parisph.case.truths import Truth, WaveTruth, read_truth
from parisph.io.reader import Run, open_run
from parisph.pictures import states, style
from parisph.truth.recorded import own_columns

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

Samples = tuple[Floats, Floats]    # times [s] and values, (n,) each

# Labels by the unit, for kinds of probes without a label (case.probes.Probe.quantity).
UNITS = {"Pa": "pressure $p$", "m": "length", "J/m": "energy", "m/s": "velocity", "N/m": "force",
         "N m/m": "moment", "m^2/s": "volume rate", "m^2": "volume", "J": "energy", "N": "force", "N m": "moment",
         "m^3/s": "volume rate", "m^3": "volume"}
IN_3D = {"$y$": "$z$", "s^2$": "s^3$"}    # in labels: heights, and the volume of a particle
TALL = 4        # most panels in one column; more have two columns
SHORT = "short peak"    # the mark of a peak that is not resolved
BESIDE = 4      # most lines of a legend in the axes; a longer one is beside them
HIGH = 12       # lines in a column of a legend beside a panel
MOST = 4 * HIGH    # most lines of a legend; of more only the first and the last are named
LETTER = 0.06   # [inch] width of a letter in a legend
ROW = 4.6       # [inch] longest row of a legend in the axes
HEADROOM = 0.16    # share of the height of axes above the curves, for such a row
BLOWN = 1.5    # largest range of the axes over that of the flow before a failure
OWN_TIME = r"$t\sqrt{g/H}$"
STATES = 4      # most incomplete runs in the title
MARKS = 60      # samples of a reference from which on it is a line


@dataclass(frozen=True)
class Curve:
    """One line of a picture: a column of a probe of a run.

    label : name of the run if there are several
    probe, column : names; column is "" if the probe has only one
    time, values : (n,) arrays [s], [the unit of the panel]
    """

    run: Run
    label: str
    probe: str
    column: str
    time: Floats
    values: Floats


def plot_probe(runs: Run | AnyPath | Sequence[Run | AnyPath], names: Sequence[str] | str | None = None,
               path: AnyPath | None = None, truth: Mapping[str, Samples] | None = None,
               normalise: bool = False) -> "Figure":
    """Draw the time series of probes, one set of axes for each quantity; return the matplotlib Figure.

    Several runs are drawn over each other, labelled by the differences of their cases (run_labels).

    runs : or their folders; names : of probes, or one name; all if None
    path : file to write (.png, .pdf, ...), or None
    truth : {probe: (time [s], value)} in the probe's unit, drawn in black
    normalise : divide time by sqrt(H/g), pressures by rho g H and lengths by H of each run

    Raises CaseError : no such probe in one of the runs, or nothing to normalise by
    StoreError : nothing to draw
    """
    given = [runs] if isinstance(runs, (Run, str, PathLike)) else runs
    several = [run if isinstance(run, Run) else open_run(run) for run in given]
    panels = list(by_quantity(several, [names] if isinstance(names, str) else names).items())
    if not panels:
        raise StoreError(f"{', '.join(str(run.folder) for run in several)} {'has' if len(several) == 1 else 'have'} no "
                         "probes to draw")
    columns = 1 if len(panels) <= TALL else 2
    rows = -(-len(panels) // columns)
    picture = style.new_figure(figsize=(8.0 * columns ** 0.75, 1.2 + 2.6 * rows), layout="constrained")
    for number, ((_, unit), curves) in enumerate(panels):
        axes = picture.add_subplot(rows, columns, number + 1)
        draw_curves(axes, curves, unit, normalise, truth or {})
        if number < columns:
            second_time_axis(axes, several, normalise)
        if len(several) == 1:
            show_steps(axes, several[0], own_scales(several[0], normalise).time or 1.0 if normalise else 1.0)
        time_label(axes, normalise, number + columns >= len(panels))
    picture.set_figwidth(picture.get_figwidth() + columns * max(map(_further_columns, picture.axes)))
    labels = run_labels(several) if len(several) > 1 else [""]
    title = [style.literal(" / ".join(dict.fromkeys(run.scene.title for run in several))),
             *(f"{label}{label and ': '}{style.literal(text, 95)}"
               for label, text in zip(labels, map(states.state, several)) if text)]
    picture.suptitle("\n".join(title[:1 + STATES]), x=0.01, ha="left", fontsize=11)
    style.save(picture, path)
    return picture


def plot_comparison(found: Samples, reference: Samples, difference: Samples, title: str, label: str, unit: str,
                    path: AnyPath | None = None) -> "Figure":
    """Draw a probe, its reference, and their difference; return the matplotlib Figure.

    found, reference, difference : (time (n,) [s], values (n,)) each
    title : one line; label, unit : of the values; path : file to write, or None
    """
    start, end = difference[0][0], difference[0][-1]
    picture = style.new_figure(figsize=(8.0, 5.6), layout="constrained")
    upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    inside = [part[1][(part[0] >= start) & (part[0] <= end)] for part in (found, reference)]
    factor, shown = style.with_prefix(max(np.max(np.abs(part), initial=0.0) for part in inside), unit)
    upper.plot(found[0], factor * found[1], color=style.LINES[0], linewidth=1.1, label="run")
    upper.plot(reference[0], factor * reference[1], color="black", linewidth=1.0, label="reference",
               **marks(len(inside[1])))
    lower.axhline(0.0, color="black", linewidth=0.6)
    lower.plot(difference[0], factor * difference[1], color=style.LINES[1], linewidth=1.0,
               marker="." if len(difference[0]) < MARKS else "")
    shown = style.written(shown) or "-"
    upper.set_ylabel(f"{label} [{shown}]")
    lower.set_ylabel(f"run - reference [{shown}]")
    lower.set_xlabel("$t$ [s]")
    upper.legend(loc="best", fontsize=8, framealpha=0.8)
    for axes in (upper, lower):
        plain_axes(axes)
    upper.set_xlim(start, end)
    upper.set_title(style.literal(title), loc="left", fontsize=10)
    style.save(picture, path)
    return picture


def references(probe: Probe, run: Run, others: bool = True) -> dict[str, Samples]:
    """Return {name: (times (n,) [s], values (n,))} of the references of a probe. Raises CaseError for their files.

    others : whether to include those besides the first
    """
    truth = probe.truth
    if isinstance(truth, WaveTruth) and isinstance(probe, Gauge):
        time = run.probe(probe.name)["time"]
        return {"wave": (time, truth.series(probe.at, time))}
    series = (truth, *(truth.others if others else ())) if isinstance(truth, Truth) else ()
    return {one.name or "reference": read_truth(one) for one in series}


def truths(run: Run) -> dict[str, Samples]:
    """Return {probe: (time [s], value)} of the truths of probes. Raises CaseError for their files."""
    return {probe.name: truth for probe in run.scene.probes for truth in references(probe, run, others=False).values()}


def by_quantity(runs: Sequence[Run], names: Sequence[str] | None = None) -> dict[tuple[str, str], list[Curve]]:
    """Return {(quantity, unit): [Curve]} of probes of runs, one entry for each set of axes. names : all if None"""
    groups: dict[tuple[str, str], list[Curve]] = {}
    for run, label in zip(runs, run_labels(runs)):
        probes = {probe.name: probe for probe in run.scene.probes}
        for name in (run.probe_names if names is None else names):
            table, units = run.probe(name), run.units(name)
            columns = [column for column in own_columns(table) if table[column].dtype.kind == "f"]
            several = len(columns) > 1
            probe = probes.get(name, Probe)
            if not run.scene.same_force_everywhere:
                columns = [column for column in columns if not column.startswith(probe.of_potential)]
            for column in columns:
                # a probe of an unknown kind shares axes with those of its unit
                kind = getattr(probe, "kind", "" if units[column] else name)
                curve = Curve(run, label if len(runs) > 1 else "", name, column if several else "",
                              table["time"], table[column])
                groups.setdefault((probe.family or kind, units[column]), []).append(curve)
    return groups


def show_steps(axes: "Axes", run: Run, unit: float = 1.0) -> None:
    """Limit the axis of time to the steps of a run. unit : of the axis [s]"""
    ends = states.span(run)
    if ends is not None and ends[0] < ends[1]:
        axes.set_xlim(ends[0] / unit, ends[1] / unit)


def run_labels(runs: Sequence[Run]) -> list[str]:
    """Return a label for each run: the difference of its case, with or as the folder if that is not unique."""
    found = differences.labels([run.case for run in runs])
    folders = folder_names([run.folder for run in runs])
    return [style.literal(text if text and found.count(text) == 1 else f"{text} ({folder})" if text else folder, 60)
            for text, folder in zip(found, folders)]


def folder_names(folders: Sequence[Path]) -> list[str]:
    """Return a short name for each folder: the shortest end of its path that is unique."""
    parts = [Path(folder).resolve().parts for folder in folders]
    names = []
    for mine in parts:
        length = 1
        while length < len(mine) and sum(other[-length:] == mine[-length:] for other in parts) > 1:
            length += 1
        names.append("/".join(mine[-length:]) if parts.count(mine) == 1 else mine[-1])
    return names


def draw_curves(axes: "Axes", curves: Sequence[Curve], unit: str, normalise: bool = False,
                truth: Mapping[str, Samples] | None = None) -> None:
    """Draw curves of one quantity into axes, with a legend and the label of the values.

    truth : {probe: (time, values)}, drawn over the first run
    """
    scales = [own_scales(curve.run, normalise) for curve in curves]
    by = [{"Pa": own.pressure, "m": own.length, "m/s": own.speed}.get(unit) if normalise else None for own in scales]
    largest = max((np.nanmax(np.abs(curve.values), initial=0.0) for curve in curves), default=0.0)
    factor, shown = (1.0, "") if by[0] else style.with_prefix(largest, unit)
    times = [own.time or 1.0 if normalise else 1.0 for own in scales]
    factors = [1.0 / scale if scale else factor for scale in by]
    series = list(dict.fromkeys((curve.probe, curve.column) for curve in curves))
    runs = list(dict.fromkeys(curve.label for curve in curves))
    looks = style.line_looks(len(runs), len(series))
    drawn: list["Line2D"] = []
    for curve, second, factor in zip(curves, times, factors):
        look = looks[runs.index(curve.label) * len(series) + series.index((curve.probe, curve.column))]
        if curve.column.endswith("_dynamic"):    # it may lie on the line of the total
            look = {**look, "linestyle": style.STYLES[3 if any(one["linestyle"] != "-" for one in looks) else 1]}
        drawn += axes.plot(curve.time / second, factor * curve.values, linewidth=1.1, label=_line_label(curve, series),
                           **look)
        draw_short_peak(axes, curve, look["color"], 1.0 / second, factor)
    known = len(axes.lines)
    for name in dict.fromkeys(curve.probe for curve in curves):
        if truth and name in truth:
            first = next(k for k, curve in enumerate(curves) if curve.probe == name)
            _draw_truth(axes, curves[first], truth[name], factors[first], times[first])
    axes.set_ylabel(_value_label(curves, series, unit, shown, bool(by[0])))
    plain_axes(axes)
    _leave_out_failures(axes, curves, drawn, axes.lines[known:])
    named = _named(axes)
    if len(named) > MOST:
        axes.set_title(f"{len(named)} lines, from {named[0].get_label()} to {named[-1].get_label()}", loc="right",
                       fontsize=8)
    elif len(named) <= BESIDE:
        _legend_inside(axes)
    else:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.02), fontsize=8, frameon=False, handlelength=3.0,
                    ncols=_legend_columns(axes))


def _leave_out_failures(axes: "Axes", curves: Sequence[Curve], drawn: Sequence["Line2D"],
                        references: Sequence["Line2D"]) -> None:
    """Limit the axes to the flow before a failure: the last samples may be a hundred times as large.

    drawn, references : lines of the curves and of references, without marks of short peaks
    """
    bad = {curve.run.folder for curve in curves if states.failed(curve.run)}
    if not bad:
        return
    fits = [np.asarray(line.get_ydata()) for line in (*drawn, *references)]
    for k, curve in enumerate(curves):
        if curve.run.folder in bad:
            fits[k] = fits[k][:states.before_failure(len(fits[k]))]
    values = np.concatenate(fits)
    values = values[np.isfinite(values)]
    low, high = axes.get_ylim()
    if len(values) and np.ptp(values) and high - low > BLOWN * np.ptp(values):
        slack = 0.1 * np.ptp(values)
        axes.set_ylim(max(low, values.min() - slack), min(high, values.max() + slack))
        axes.set_title("the last values lie outside", loc="right", fontsize=8)


def _named(axes: "Axes") -> list["Line2D"]:
    """Return the lines in the legend; of several short peaks only the first."""
    return [line for line in axes.lines if not str(line.get_label()).startswith("_")]


def _legend_inside(axes: "Axes") -> None:
    """Add a legend of few lines: above the curves in one row, with room for it, unless that is too long."""
    count = len(_named(axes))
    if count == 1 or sum(LETTER * len(str(line.get_label())) + 0.5 for line in _named(axes)) > ROW:
        axes.legend(loc="best", fontsize=8, framealpha=0.8)
        return
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + HEADROOM * (high - low))
    axes.legend(loc="upper center", ncols=count, fontsize=8, framealpha=0.8, borderaxespad=0.2, columnspacing=1.2)


def _legend_columns(axes: "Axes") -> int:
    count = len(_named(axes))
    return -(-count // HIGH) if BESIDE < count <= MOST else 0


def _further_columns(axes: "Axes") -> float:
    """Return the width [inch] to be added to the picture for a legend beside the axes, which has an inch already."""
    longest = max((len(str(line.get_label())) for line in _named(axes)), default=0)
    return max(_legend_columns(axes) * (LETTER * longest + 0.7) - 1.0, 0.0)


def own_scales(run: Run, normalise: bool) -> style.SceneUnits:
    """Return the style.SceneUnits of a run. Raises CaseError if it has none to normalise by."""
    own = style.scene_units(run.scene)
    if normalise and own.time is None:
        raise CaseError(f"{run.folder}: without constant gravity there is no sqrt(H/g) to divide by")
    return own


def time_label(axes: "Axes", normalise: bool, last: bool) -> None:
    """Label the axis of time, in the lowest panels only."""
    if last:
        axes.set_xlabel(OWN_TIME if normalise else "$t$ [s]")
    else:
        axes.tick_params(labelbottom=False)


def _line_label(curve: Curve, series: Sequence[tuple[str, str]]) -> str:
    """Return the label of a line: run, probe and column, each only if there are several."""
    probes = {probe for probe, _ in series}
    if curve.label and len(series) == 1:
        return curve.label
    what = ": ".join(part for part in (curve.probe if len(probes) > 1 or not curve.label else "", curve.column) if part)
    return f"{curve.label}, {what}" if curve.label else what


def _draw_truth(axes: "Axes", curve: Curve, series: Samples, factor: float, by_time: float) -> None:
    """Draw a reference within the time of the run."""
    time, values = (np.asarray(part, dtype=float) for part in series)
    inside = time <= max(curve.time, default=-np.inf)
    axes.plot(time[inside] / by_time, factor * values[inside], color="black", linewidth=1.0,
              label=f"{curve.probe}: reference", **marks(np.count_nonzero(inside)))


def _peak_of(curve: Curve) -> str:
    """Return the name of a curve in the `peaks` of a summary: "load.fx", in an array "row.load.fx"."""
    names = [name for probe in curve.run.scene.probes if probe.name == curve.probe for name, _ in singles([probe])]
    members = [name.partition(".")[2] for name in names if name != curve.probe]
    member = max((one for one in members if f"{curve.column}_".startswith(f"{one}_")), key=len, default="")
    column = curve.column.removeprefix(member).removeprefix("_")
    return ".".join(filter(None, (curve.probe, member, "" if column == "pressure" else column)))


def draw_short_peak(axes: "Axes", curve: Curve, colour: str, by_time: float, factor: float) -> None:
    """Mark the greatest value of a probe if it is too short to be resolved, with its mean over 5 ms as a bar.

    colour : of the line; by_time, factor : factors of times [s] and of values
    """
    found = ((curve.run.summary or {}).get("peaks") or {}).get(_peak_of(curve)) or {}
    if not found.get("short"):
        return
    when, over = found["time"], found["mean_over"]
    there = curve.values[np.abs(curve.time - when) == np.abs(curve.time - when).min(initial=np.inf)]
    if len(there) and there[0] < 0.0:    # peaks of forces have no sign
        factor = -factor
    known = [line for line in axes.lines if line.get_gid() == SHORT]    # all have one name
    for line in known:
        line.set_label("short peaks: not resolved")
    axes.plot([by_time * when], [factor * found["value"]], linestyle="", marker="x", markersize=7, color=colour,
              zorder=4, gid=None if known else SHORT,
              label="_" * bool(known) + f"lasts {1e3 * found['lasts']:.2g} ms: not resolved")
    axes.plot([by_time * (when - over / 2), by_time * (when + over / 2)], 2 * [factor * found["mean"]], color=colour,
              linewidth=2.5, zorder=4, label="_" * bool(known) + f"its mean over {1e3 * over:g} ms")


def marks(samples: int) -> style.LineLook:
    """Return the look of a reference: few samples as marks, many as a dashed line."""
    few = {"linestyle": "", "marker": "o", "markersize": 4, "markerfacecolor": "none"}
    return few if samples < MARKS else {"linestyle": "--"}


def in_scene(label: str, dim: int) -> str:
    """Return a label of a probe in a scene with that many dimensions."""
    for flat, solid in IN_3D.items() if dim == 3 else ():
        label = label.replace(flat, solid)
    return label


def _value_label(curves: Sequence[Curve], series: Sequence[tuple[str, str]], unit: str, shown: str,
                 scaled: bool) -> str:
    kinds = {getattr(probe, "kind"): probe for curve in curves for probe in curve.run.scene.probes
             if probe.name == curve.probe}
    what = UNITS.get(unit, "")
    for probe in kinds.values():
        what = (probe.family if len(kinds) > 1 else probe.quantities.get(series[0][1], probe.quantity)) or what
    what = in_scene(what, curves[0].run.scene.dim)
    if curves[0].label and len({probe for probe, _ in series}) == 1:    # the legend names only the runs
        what = what if series[0][0] in what else f"{series[0][0]}: {what}"
    if scaled:
        return what + {"Pa": r"$\,/\,(\rho g H)$", "m": r"$\,/\,H$", "m/s": r"$\,/\,\sqrt{gH}$"}[unit]
    return f"{what} [{style.written(shown) or '-'}]"


def plain_axes(axes: "Axes") -> None:
    """Give axes a light grid, ticks inside, and plain numbers."""
    axes.grid(True, linewidth=0.4, alpha=0.5)
    axes.tick_params(direction="in", top=True, right=True)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.margins(x=0.0)


def second_time_axis(axes: "Axes", runs: Sequence[Run], normalise: bool) -> None:
    """Add the dimensionless time above, if it is the same for all runs."""
    scales = [style.scene_units(run.scene) for run in runs]
    unit = scales[0].time
    if unit is None or len({own.time for own in scales}) != 1:
        return
    to_own, back = (lambda t: t * unit, lambda t: t / unit) if normalise else (lambda t: t / unit, lambda t: t * unit)
    above = axes.secondary_xaxis("top", functions=(to_own, back))
    of = f"; {style.height(scales[0])}, the height of the fluid at the start, without waves"
    above.set_xlabel("$t$ [s]" if normalise else OWN_TIME + of)
    above.tick_params(direction="in")
    axes.tick_params(top=False)
