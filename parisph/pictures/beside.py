"""Pictures of a probe beside its references, with the compared window and the peaks of others."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.case.probes import Probe, ProbeArray
from parisph.case.profiles import read_profiles
from parisph.case.truths import PeakBand, Truth, WaveTruth, bands_of
from parisph.io.reader import Run
from parisph.pictures import curves, style
from parisph.truth import profiled, verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

MOST = 99.8    # percentile of the values of the run up to which the axes reach


def plot_beside(run: Run, probe: Probe, path: AnyPath | None = None) -> "Figure":
    """Draw a probe and its references, without a shift of time; return the matplotlib Figure.

    Times that are not compared are grey. Boxes are bands of peaks in experiments. Raises CaseError, StoreError.
    """
    found, others = verdict.series(probe, run), curves.references(probe, run)
    picture = style.new_figure(figsize=(8.0, 3.6), layout="constrained")
    axes = picture.add_subplot()
    unit = next((unit for name, unit in run.units(probe.name).items() if name not in ("time", "step")), "")
    factor, shown = style.with_prefix(float(np.max(np.abs(found[1]), initial=0.0)), unit)
    axes.plot(found[0], factor * found[1], color=style.LINES[0], linewidth=1.2, label="run", zorder=3)
    curves.draw_short_peak(axes, curves.Curve(run, "", probe.name, "", *found), style.LINES[0], 1.0, factor)
    for number, (name, (time, values)) in enumerate(others.items()):
        known = np.count_nonzero((time >= found[0][0]) & (time <= found[0][-1]))
        time, values = _over_the_run(time, values, found[0])
        inside = (time >= found[0][0]) & (time <= found[0][-1])
        look: style.LineLook = {"linestyle": style.STYLES[number % 4]}
        if number == 0:
            look = curves.marks(int(np.sum(inside)) if known > 1 else curves.MARKS)
        axes.plot(time[inside], factor * values[inside], linewidth=1.0, label=style.literal(name),
                  color="black" if number == 0 else style.LINES[number % len(style.LINES)], **look)
    bands = list({(band.start, band.end, band.low, band.high, band.when): band    # some differ only by their smoothing
                  for band in bands_of(probe.truth)}.values())
    _mark(axes, probe.truth.window if isinstance(probe.truth, Truth | WaveTruth) else None, bands, found[0][-1], factor)
    _limit(axes, factor, shown, found, others, [band for band in bands if band.start < found[0][-1]])
    what = probe.quantity or curves.UNITS.get(unit, str(getattr(probe, "kind")).replace("_", " "))
    what = curves.in_scene(what, run.scene.dim)
    axes.set_ylabel(f"{what} [{style.written(shown) or '-'}]")
    axes.set_xlabel("$t$ [s]")
    curves.plain_axes(axes)
    axes.set_xlim(found[0][0], found[0][-1])
    curves.second_time_axis(axes, [run], False)
    handles, labels = axes.get_legend_handles_labels()
    _legend(picture, dict(zip(labels, handles)))
    style.save(picture, path, dpi=110)
    return picture


def plot_profiles(run: Run, probe: ProbeArray, path: AnyPath | None = None, columns: int = 2) -> "Figure":
    """Draw the profiles of an array of gauges and its references; return the matplotlib Figure.

    Raises CaseError, StoreError.
    """
    truths = () if probe.truth is None else (probe.truth, *probe.truth.others)
    found = {time: (places, ours) for truth in reversed(truths)    # the truth itself last: its places are drawn
             for time, places, ours, _ in profiled.pairs(probe, truth, run)}
    if not found:
        raise CaseError(f"the run has reached none of the profiles of {probe.name}")
    lines = [{time: (x, y) for time, x, y in read_profiles(truth)} for truth in truths]
    rows = -(-len(found) // columns)
    picture = style.new_figure(figsize=(9.0, 0.8 + 1.7 * rows), layout="constrained")
    grid = picture.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    drawn: dict[str, "Line2D"] = {}    # of all panels: one may lack a reference
    for axes, time in zip(grid.flat, sorted(found)):
        for number, (truth, line) in enumerate(zip(truths, lines)):
            if time in line:
                look = {"color": style.LINES[number % len(style.LINES)] if number else "black",
                        "linestyle": style.STYLES[number % 4] if number else (0, (3, 1.5))}
                drawn[truth.name or "reference"], = axes.plot(*line[time], linewidth=1.0, **look)
        drawn["run"], = axes.plot(*found[time], color=style.LINES[0], linewidth=1.4)
        axes.set_title(f"t = {time:.4g} s", loc="left", fontsize=9)
        curves.plain_axes(axes)
    for axes in grid.flat[len(found):]:
        axes.remove()
    for axes in grid[-1]:
        axes.set_xlabel("$x$ [m]")
    for axes in grid[:, 0]:
        axes.set_ylabel("$y$ [m]")
    _legend(picture, {style.literal(name): line for name, line in drawn.items()})
    style.save(picture, path, dpi=110)
    return picture


def _legend(picture: "Figure", lines: dict[str, Any]) -> None:
    """Add a legend of {label: line} below the axes."""
    wide = curves.LETTER * max(map(len, lines)) + 0.7
    columns = min(max(int(picture.get_figwidth() / wide), 1), len(lines))
    picture.legend(lines.values(), lines.keys(), loc="outside lower center", ncols=columns, fontsize=8, frameon=False)


def _over_the_run(time: Floats, values: Floats, run: Floats) -> curves.Samples:
    """Return a reference (n,), with samples only at the ends of the run if fewer than two are inside it."""
    if np.count_nonzero((time >= run[0]) & (time <= run[-1])) > 1:
        return time, values
    ends = np.clip([run[0], run[-1]], time[0], time[-1])
    return ends, np.interp(ends, time, values)


def _mark(axes: "Axes", window: tuple[float, float] | None, bands: Sequence[PeakBand], end: float,
          factor: float) -> None:
    if window is not None:
        axes.axvspan(-1e3, window[0], color="0.93", zorder=0)
        axes.axvspan(window[1], window[1] + 1e3, color="0.93", zorder=0)
    label: str | None = "peaks of others"
    for band in bands:
        if band.low is not None and band.high is not None:
            axes.fill_between([band.start, min(band.end, end)], factor * band.low, factor * band.high,
                              color=style.LINES[4], alpha=0.35, linewidth=0.0, zorder=1, label=label)
        elif band.when is not None:
            axes.axvline(band.when, color=style.LINES[4], linewidth=1.6, zorder=1, label=label)
        label = None


def _limit(axes: "Axes", factor: float, unit: str, found: curves.Samples, others: dict[str, curves.Samples],
           bands: Sequence[PeakBand]) -> None:
    """Limit the axes to references, bands, and the run without single spikes; a title names the greatest spike."""
    end = found[0][-1]
    parts = [values[(time >= found[0][0]) & (time <= end)] for time, values in others.values()]
    fits = [np.percentile(found[1], [100.0 - MOST, MOST]), *(part for part in parts if len(part))]
    fits += [np.array([band.low, band.high]) for band in bands if band.low is not None and band.high is not None]
    low, high = (factor * of([of(part) for part in fits]) for of in (np.min, np.max))
    slack = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - slack, high + slack)
    if factor * np.max(found[1]) > high + slack:
        axes.set_title(f"the run reaches {factor * np.max(found[1]):.4g} {unit}", loc="right", fontsize=8)
