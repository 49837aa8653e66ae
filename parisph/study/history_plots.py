"""Pictures of a study: the series of a probe side by side, one panel for each curve, with the truth."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import ParisphError
from parisph.base.table import names as columns_of
from parisph.base.table import read_reference
from parisph.io.reader import Run, open_run
from parisph.pictures import curves, style
from parisph.study import report
from parisph.study.plan import Plan
from parisph.study.results import Result
from parisph.truth.recorded import own_columns

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

Drawn = tuple[Result, Run]    # a run, and its files

ACROSS = 3    # most panels in a row
WIDE = 4.6    # [inch] width of a panel
LETTER = 0.07    # [inch] width of a letter in the legend
QUANTILE = 0.005    # share of samples above, and below, the axis if there are spikes
BEYOND = 1.5  # largest distance of the axis from the truth, over the range of the truth
SPIKE = 2.5   # least range of a series with spikes, over that between the quantiles


def draw(results: Sequence[Result], probe: str, plan: Plan, path: Path) -> bool:
    """Draw the series of a probe of all runs to a file; return whether there was anything to draw. Needs matplotlib.

    Only the first of starts that differ by their seed is drawn, and one column of a probe: the judged one, else the
    first.

    Raises MissingLibrary, CaseError, StoreError as pictures.style.save.
    """
    panels = {curve: list(_with_samples(group, probe)) for curve, group in report.curves(results).items()}
    panels = {curve: group for curve, group in panels.items() if group}
    if not panels:
        return False
    across = min(len(panels), ACROSS)
    down = -(-len(panels) // across)
    width, height = (WIDE * across, 1.0 + 2.7 * down) if across > 1 else (1.8 * WIDE, 4.8)
    picture = style.new_figure(figsize=(width, height), layout="constrained")
    grid = picture.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    run = next(iter(panels.values()))[0][1]
    column = _column(run, probe)
    unit = run.units(probe).get(column, "")
    values = np.concatenate([run.probe(probe)[column] for group in panels.values() for _, run in group])
    factor, shown = style.with_prefix(float(np.nanmax(np.abs(values), initial=0.0)), unit)
    truths, sort = _truths(run, probe, plan), report.axis_of(results)[0]
    keys = list(dict.fromkeys(_key(one, sort) for group in panels.values() for one, _ in group))
    looks = dict(zip(keys, style.line_looks(len(keys))))
    lines: dict[str, Line2D] = {}
    for axes, (curve, group) in zip(grid.flat, panels.items()):
        _panel(axes, curve, group, probe, column, factor, looks, sort, truths, lines)
    for axes in list(grid.flat)[len(panels):]:
        axes.axis("off")
    for axes in grid[:, 0]:
        axes.set_ylabel(f"{probe}: {column} [{shown or '-'}]")
    for axes in list(grid.flat)[max(len(panels) - across, 0):len(panels)]:
        axes.set_xlabel("$t$ [s]")
        axes.tick_params(labelbottom=True)
    _limit(list(grid.flat)[0], panels, probe, column, factor, truths.values())
    labels = [style.literal(label, 60) for label in lines]
    abreast = max(1, int(width / (LETTER * max(map(len, labels)) + 0.7)))
    picture.legend(lines.values(), labels, loc="outside lower center", ncols=min(len(lines), abreast), fontsize=8)
    picture.suptitle(style.literal(plan.title, 110), x=0.01, ha="left", fontsize=11)
    style.save(picture, path)
    return True


def _panel(axes: "Axes", curve: str, group: Sequence[Drawn], probe: str, column: str, factor: float,
           looks: Mapping[str, style.LineLook], sort: str | None, truths: Mapping[str, tuple[Floats, Floats]],
           lines: "dict[str, Line2D]") -> None:
    end = 0.0
    for one, run in group:
        series = run.probe(probe)
        label = _key(one, sort)
        line, = axes.plot(series["time"], factor * series[column], linewidth=0.9, **looks[label])
        lines.setdefault(label, line)
        end = max(end, float(series["time"][-1]))
        if not one.survived:    # a mark at its end, at the bottom of the panel
            axes.plot(series["time"][-1], 0.04, marker="x", markersize=8, markeredgewidth=2, linestyle="", zorder=5,
                      color=looks[label]["color"], transform=axes.get_xaxis_transform())
    for number, (label, (t, values)) in enumerate(truths.items()):
        inside = t <= end
        few = {"marker": "o", "markersize": 3, "markerfacecolor": "none", "linestyle": ""}
        look = few if inside.sum() < curves.MARKS else {"linestyle": ("--", ":", "-.")[number % 3]}
        line, = axes.plot(t[inside], factor * values[inside], color="black", linewidth=1.0, zorder=4, **look)
        lines.setdefault(label, line)
    axes.set_title(style.literal(curve, 60), fontsize=9, loc="left")
    axes.grid(True, linewidth=0.4, alpha=0.5)
    axes.tick_params(direction="in", top=True, right=True)
    axes.margins(x=0.0)


def _with_samples(group: Sequence[Result], probe: str) -> Iterator[Drawn]:
    """Yield (result, Run) of the first starts of a curve that have samples of a probe."""
    for family in report.families(group):
        with suppress(ParisphError):    # a run that failed at its start has no files
            run = open_run(family[0].folder)
            if len(run.probe(probe)):
                yield family[0], run


def _key(one: Result, sort: str | None) -> str:
    if sort == "time_step":
        return "adaptive" if one.run.time_step is None else f"time step {one.run.time_step:.4g}"
    return f"spacing {one.run.spacing:.4g}"


def _column(run: Run, probe: str) -> str:
    names = own_columns(run.probe(probe))
    judged = next((one.judged for one in run.scene.probes if one.name == probe), "")
    return judged if judged in names else names[0]


def _truths(run: Run, probe: str, plan: Plan) -> dict[str, tuple[Floats, Floats]]:
    """Return {label: (time [s], values)} of the references of a probe in the case and in the study."""
    found = {}
    try:
        if probe in (own := curves.truths(run)):
            found["truth"] = own[probe]
    except ParisphError:    # the file has been moved: the picture is drawn without it
        pass
    for measure in plan.study.errors:
        if measure.kind == "series" and measure.probe == probe:
            file = plan.place / measure.file
            names = columns_of(file)
            time = measure.time or names[0]
            value = measure.value or next(name for name in names if name not in (time, "time", "step"))
            t, values = read_reference(file, time, value, measure.offset, measure.scale, measure.time_scale)
            found[measure.name or f"{file.stem}: {value}"] = t - measure.shift, values
    return found


def _limit(axes: "Axes", panels: Mapping[str, Sequence[Drawn]], probe: str, column: str, factor: float,
           truths: Iterable[tuple[Floats, Floats]]) -> None:
    """Limit the y axis: spikes, failed runs and values far from the truth would hide the rest."""
    runs = [pair for group in panels.values() for pair in group]
    kept = [run for one, run in runs if one.survived] or [run for _, run in runs]
    values = factor * np.concatenate([run.probe(probe)[column] for run in kept])
    values = values[np.isfinite(values)]
    if not len(values):
        return
    low, high = np.quantile(values, (QUANTILE, 1.0 - QUANTILE))
    if np.ptp(values) <= SPIKE * (high - low):
        low, high = values.min(), values.max()
    end = max(run.probe(probe)["time"][-1] for run in kept)
    parts = [factor * part[time <= end] for time, part in truths if np.any(time <= end)]
    if parts and np.ptp(true := np.concatenate(parts)) > 0.0:
        low = min(max(low, true.min() - BEYOND * np.ptp(true)), true.min())
        high = max(min(high, true.max() + BEYOND * np.ptp(true)), true.max())
    if high > low:
        axes.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
