"""Pictures of time series, and of a whole run on one page. Needs matplotlib, the extra [plot]; needs no MPI."""

import numpy as np

from parisph.base.errors import CaseError, StoreError
from parisph.io import style
from parisph.io.reader import Run, open_run
from parisph.io.reference import read_reference
from parisph.io.view import FieldView

# What a probe of a kind (as in the case) shows; and what a unit means where kinds are mixed.
KINDS = {
    "surface_gauge": "surface height $y$", "pressure_tap": "pressure $p$", "water_front": "front position $x$",
    "column_height": "column height $y$", "energy": "energy", "volume": "volume $V/V_0$", "momentum": "momentum",
}
COLUMNS = {("volume", "count"): "cells counted"}  # where one column is something else
UNITS = {"Pa": "pressure $p$", "m": "length", "J/m": "energy", "m/s": "velocity"}


def plot_probe(run, names=None, path=None, truth=None, normalise=False):
    """Draw the time series of probes, one set of axes for each unit; return the matplotlib Figure.

    Parameters
    ----------
    run : Run, or the folder of one
    names : list of probe names, or one name; all probes if None
    path : file to write (.png, .pdf, ...), or None
    truth : dict of probe name -> (time [s], value) arrays in the probe's unit, drawn over it in black
    normalise : time by sqrt(H/g), pressures by rho g H, lengths by H

    Raises
    ------
    CaseError : no such probe, or nothing to normalise by
    StoreError : nothing to draw
    """
    run = run if isinstance(run, Run) else open_run(run)
    names = [names] if isinstance(names, str) else list(names or run.probe_names)
    groups = _by_unit(run, names)
    if not groups:
        raise StoreError(f"{run.folder} has no probes to draw")
    own = _own(run, normalise)
    picture = style.drawing().Figure(figsize=(8.0, 1.2 + 2.6 * len(groups)), layout="constrained")
    for number, ((unit, _), curves) in enumerate(groups.items()):
        axes = picture.add_subplot(len(groups), 1, number + 1)
        _draw_curves(axes, run.case, curves, unit, own, normalise, truth or {})
        if number == 0:
            axes.set_title(run.case["title"], loc="left", fontsize=11)
            _second_time_axis(axes, own, normalise)
        _time_label(axes, normalise, number == len(groups) - 1)
    style.save(picture, path)
    return picture


def plot_overview(run, path=None, field="pressure", surface=False):
    """Draw a whole run on one page: four moments of the flow, its probes, and how the solver went.

    Parameters and errors as of plot_field and plot_probe.
    """
    run = run if isinstance(run, Run) else open_run(run)
    if len(run) == 0:
        raise StoreError(f"{run.folder} has no snapshots")
    moments = [run.snapshot(int(number)) for number in np.unique(np.linspace(0, len(run) - 1, 4).round())]
    curves = [(unit, lines) for (unit, _), lines in _by_unit(run, run.probe_names).items()]
    view = FieldView(run.case, moments, field, surface)
    columns = min(2, len(moments))
    heights = -(-len(moments) // columns) * _height(view, 5.2), 2.3 * (len(curves) // 2 + 1)
    picture = style.drawing().Figure(figsize=(11.0, 1.0 + sum(heights)), layout="constrained")
    flow, series = picture.subfigures(2, 1, height_ratios=heights)
    _draw_moments(flow, view, moments, columns)
    _draw_series(series, run, curves)
    picture.suptitle(run.case["title"], fontsize=13)
    style.save(picture, path)
    return picture


def truths(run, folder):
    """Return {probe name: (time [s], value)} for the probes of a run whose case names a truth.

    folder : where the case file is; the files of the truths are relative to it. Raises StoreError.
    """
    found = {}
    for probe in run.case.get("probes", ()):
        about = probe.get("truth")
        if about:
            options = {name: about[name] for name in ("offset", "scale", "time_scale") if name in about}
            found[probe["name"]] = read_reference(folder / about["file"], about["time"], about["value"], **options)
    return found


def _by_unit(run, names):
    """{(unit, kind): [(probe, column, time, values)]}: what belongs into one set of axes."""
    groups = {}
    for name in names:
        table, units = run.probe(name), run.units(name)
        columns = [column for column in table.dtype.names if column not in ("time", "step") and table[column].dtype.kind == "f"]
        for column in columns:
            # Probes without a unit have nothing in common: each gets its own axes.
            key = (units[column], "" if units[column] else name)
            groups.setdefault(key, []).append((name, column if len(columns) > 1 else "", table["time"], table[column]))
    return groups


def _own(run, normalise):
    own = style.scales(run.case)
    if normalise and own.time is None:
        raise CaseError("this scene has no constant gravity: it has no sqrt(H/g) to divide by")
    return own


def _draw_curves(axes, case, curves, unit, own, normalise, truth):
    scale = {"Pa": own.pressure, "m": own.length, "m/s": own.speed}.get(unit) if normalise else None
    largest = max((np.nanmax(np.abs(values)) for *_, values in curves if len(values)), default=0.0)
    factor, shown = (1.0 / scale, "") if scale else style.with_prefix(largest, unit)
    by_time = own.time if normalise else 1.0
    for number, (name, column, time, values) in enumerate(curves):
        label = f"{name}: {column}" if column else name
        axes.plot(time / by_time, factor * values, color=style.LINES[number % len(style.LINES)], linewidth=1.1, label=label)
    for name in dict.fromkeys(name for name, *_ in curves):
        if name in truth:
            _draw_truth(axes, name, truth[name], factor, by_time, curves)
    axes.set_ylabel(_value_label(case, curves, unit, shown, scale))
    axes.grid(True, linewidth=0.4, alpha=0.5)
    axes.tick_params(direction="in", top=True, right=True)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.margins(x=0.0)
    axes.legend(loc="best", fontsize=8, framealpha=0.8)


def _draw_truth(axes, name, series, factor, by_time, curves):
    """A reference of few samples is a set of marks, a dense one a dashed line; both only where the run is."""
    time, values = (np.asarray(part, dtype=float) for part in series)
    end = max(times[-1] for probe, _, times, _ in curves if probe == name and len(times))
    inside = time <= end
    how = {"linestyle": "", "marker": "o", "markersize": 4, "markerfacecolor": "none"} if np.sum(inside) < 60 else {"linestyle": "--"}
    axes.plot(time[inside] / by_time, factor * values[inside], color="black", linewidth=1.0, label=f"{name}: reference", **how)


def _value_label(case, curves, unit, shown, scale):
    kinds = {probe["kind"] for probe in case.get("probes", ()) if probe["name"] in {name for name, *_ in curves}}
    what = UNITS.get(unit, "")
    if len(kinds) == 1:
        kind, column = kinds.pop(), curves[0][1]
        what = COLUMNS.get((kind, column), KINDS.get(kind, ""))
    if scale:
        return what + {"Pa": r"$\,/\,(\rho g H)$", "m": r"$\,/\,H$", "m/s": r"$\,/\,\sqrt{gH}$"}[unit]
    return f"{what} [{shown or '-'}]"


def _time_label(axes, normalise, last):
    if last:
        axes.set_xlabel(r"$t\sqrt{g/H}$" if normalise else "$t$ [s]")
    else:
        axes.tick_params(labelbottom=False)


def _second_time_axis(axes, own, normalise):
    if own.time is None:
        return
    to_own, back = (lambda t: t * own.time, lambda t: t / own.time) if normalise else (lambda t: t / own.time, lambda t: t * own.time)
    above = axes.secondary_xaxis("top", functions=(to_own, back))
    above.set_xlabel("$t$ [s]" if normalise else r"$t\sqrt{g/H}$")
    above.tick_params(direction="in")
    axes.tick_params(top=False)


def _height(view, width):
    (left, right), (low, high) = view.window
    return min(0.85 * width * (high - low) / (right - left) + 0.7, 6.0)


def _draw_moments(flow, view, moments, columns):
    limits = view.common_limits(moments)
    grid = flow.subplots(-(-len(moments) // columns), columns, squeeze=False, sharex=True, sharey=True)
    discs = [view.draw(axes, moment, limits, label=False) for axes, moment in zip(grid.flat, moments)]
    for axes in grid.flat[len(moments):]:
        axes.remove()
    for axes in grid.flat:
        axes.label_outer()
    view.add_colour_bar(flow, list(grid.flat[:len(moments)]), discs[-1], moments)


def _draw_series(series, run, curves):
    """The probes, two a row, and the solver's record in what is left of the last row."""
    grid = series.add_gridspec(len(curves) // 2 + 1, 2)
    own = style.scales(run.case)
    for number, (unit, lines) in enumerate(curves):
        axes = series.add_subplot(grid[number // 2, number % 2])
        _draw_curves(axes, run.case, lines, unit, own, False, {})
        _time_label(axes, False, True)
    last = grid[-1, 1] if len(curves) % 2 else grid[-1, :]
    _draw_steps(series.add_subplot(last), run.steps)


def _draw_steps(axes, steps):
    """Iterations of the pressure solve and the size of the step."""
    axes.plot(steps["time"], steps["iterations"], ".", color=style.LINES[0], markersize=2)
    axes.set_ylabel("iterations a solve [-]", color=style.LINES[0])
    axes.set_ylim(bottom=0)
    axes.yaxis.get_major_locator().set_params(integer=True)
    axes.set_xlabel("$t$ [s]")
    axes.grid(True, linewidth=0.4, alpha=0.5)
    other = axes.twinx()
    other.plot(steps["time"], 1e3 * steps["dt"], color=style.LINES[1], linewidth=0.9)
    other.set_ylabel(r"step $\Delta t$ [ms]", color=style.LINES[1])
    other.set_ylim(bottom=0, top=1.25e3 * np.max(steps["dt"], initial=1e-12))
    other.margins(x=0.0)
