"""Pictures of a study: error against spacing with the fitted order, and cost against error with the Pareto front."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from parisph.pictures import style
from parisph.study import report
from parisph.study.fits import fitted_order, pareto
from parisph.study.other_codes import OtherPoint
from parisph.study.results import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARKS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")
FRONT = "Pareto front"
MANY = 9           # most entries of a legend inside the axes; a longer one is below them
OTHER_MARKS = ("*", "h", "p", "d", "8", "H")


@dataclass(frozen=True)
class Dot:
    """Runs that differ only by their seed: place on the axis, CPU time [s], and mean, least and largest error."""

    x: float
    cpu: float
    mean: float
    low: float
    high: float


def draw(results: Sequence[Result], name: str, label: str, title: str, path: Path,
         others: Sequence[OtherPoint] = ()) -> bool:
    """Draw a measure of all runs to a file; return whether there was anything to draw. Needs matplotlib.

    name, label : of the measure, in the table and on its axis; others : points of other codes

    Raises MissingLibrary, CaseError, StoreError as pictures.style.save.
    """
    axis, of_axis = report.axis_of(results)
    dots = {curve: found for curve, group in report.curves(results).items() if (found := _dots(group, name, axis))}
    if not dots:
        return False
    both = axis is not None and len({dot.x for group in dots.values() for dot in group}) > 1
    picture = style.new_figure(figsize=(10.4 if both else 6.0, 4.6 + 0.11 * max(0, len(dots) - MANY)),
                               layout="constrained")
    panels = picture.subplots(1, 2 if both else 1, sharey=True, squeeze=False)[0]
    looks = looks_of(report.curves(results))
    if both:
        there = [one for one in others if one.error and one.spacing and axis == "spacing"]
        convergence(panels[0], dots, looks, of_axis, there)
        panels[0].set_ylabel(style.literal(label, 60))
    _costs(panels[-1], dots, looks, [one for one in others if one.error and one.cpu])
    if not both:
        panels[-1].set_ylabel(style.literal(label, 60))
    for axes in panels:
        axes.grid(True, which="both", linewidth=0.4, alpha=0.4)
        axes.tick_params(direction="in", which="both", top=True, right=True)
    picture.suptitle(style.literal(title, 110), x=0.01, ha="left", fontsize=11)
    style.save(picture, path)
    return True


def looks_of(curves: Collection[str]) -> dict[str, style.LineLook]:
    """Return {curve: colour, style and mark}."""
    return {curve: {**look, "marker": MARKS[k % len(MARKS)]}
            for k, (curve, look) in enumerate(zip(curves, style.line_looks(len(curves))))}


def _dots(group: Sequence[Result], name: str, axis: str | None) -> list[Dot]:
    found = []
    for family in report.families(group):
        pairs = [(one.errors.get(name), one.values.get("cpu_seconds")) for one in family]
        errors = [error for error, _ in pairs if error is not None and error > 0.0]
        costs = [cpu for error, cpu in pairs if error is not None and cpu is not None]
        x = None if axis is None else getattr(family[0].run, axis)
        if errors and costs and (axis is None or x is not None):
            found.append(Dot(x or 0.0, float(np.mean(costs)), float(np.mean(errors)), min(errors), max(errors)))
    return sorted(found, key=lambda dot: dot.x)


def convergence(axes: "Axes", dots: Mapping[str, Sequence[Dot]], looks: Mapping[str, style.LineLook],
                label: str, others: Sequence[OtherPoint] = (), most: int = MANY) -> None:
    """Draw errors against spacing with their fitted orders.

    dots : {curve: dots}; label : of the axis; most : as of add_legend
    """
    for curve, group in dots.items():
        x, y = [dot.x for dot in group], [dot.mean for dot in group]
        order = fitted_order(x, y)
        name = curve if order is None else f"{curve} (order {order:.2f})"
        error_bars(axes, x, group, looks[curve], name)
        if order is not None and len(x) > 2:
            ends = np.array([min(x), max(x)])
            middle = np.exp(np.mean(np.log(x))), np.exp(np.mean(np.log(y)))
            fit = middle[1] * (ends / middle[0]) ** order
            axes.plot(ends, fit, color=looks[curve]["color"], linewidth=0.8, linestyle=":")
    _draw_others(axes, others, "spacing", "")
    _logarithmic(axes, [dot.x for group in dots.values() for dot in group]
                 + [one.spacing for one in others if one.spacing])
    axes.set_yscale("log")
    axes.set_xlabel(label)
    add_legend(axes, dots, most)


def _costs(axes: "Axes", dots: Mapping[str, Sequence[Dot]], looks: Mapping[str, style.LineLook],
           others: Sequence[OtherPoint]) -> None:
    everything = [dot for group in dots.values() for dot in group]
    front = [everything[k] for k in pareto([dot.cpu for dot in everything], [dot.mean for dot in everything])]
    axes.plot([dot.cpu for dot in front], [dot.mean for dot in front], color="0.8", linewidth=6, solid_capstyle="round",
              marker="o", markersize=11, zorder=1, label=FRONT)
    for curve, group in dots.items():
        group = sorted(group, key=lambda dot: dot.cpu)
        error_bars(axes, [dot.cpu for dot in group], group, looks[curve], curve)
    _draw_others(axes, others, "cpu", " (other computer)")
    _logarithmic(axes, [dot.cpu for dot in everything] + [one.cpu for one in others if one.cpu])
    axes.set_yscale("log")
    axes.set_xlabel("CPU time of all ranks [s]")
    add_legend(axes, dots)


def error_bars(axes: "Axes", x: Sequence[float], group: Sequence[Dot], look: style.LineLook,
               label: str) -> None:
    """Draw the means of dots at x, with bars from the least to the largest error."""
    y = np.array([dot.mean for dot in group])
    spread = np.array([[dot.mean - dot.low for dot in group], [dot.high - dot.mean for dot in group]])
    axes.errorbar(x, y, yerr=spread if spread.any() else None, markersize=5, linewidth=1.2, capsize=3,
                  label=style.literal(label, 60), zorder=3, **look)


def _draw_others(axes: "Axes", others: Sequence[OtherPoint], of: str, note: str) -> None:
    for number, code in enumerate(dict.fromkeys(one.code for one in others)):
        points = [one for one in others if one.code == code]
        axes.plot([getattr(one, of) for one in points], [one.error or np.nan for one in points],
                  color="black", linestyle="",
                  marker=OTHER_MARKS[number % len(OTHER_MARKS)], markersize=8, markerfacecolor="none", zorder=2,
                  label=style.literal(f"{code}{note}", 60))


def add_legend(axes: "Axes", curves: Iterable[str], most: int = MANY) -> None:
    """Add a legend: the Pareto front, the curves, other codes. most : entries of a legend inside the axes"""
    pairs = list(zip(*axes.get_legend_handles_labels()))
    names = [style.literal(curve, 60) for curve in curves]
    own = [pair for pair in pairs if any(pair[1].startswith(name) for name in names)]
    first = [pair for pair in pairs if pair[1] == FRONT]
    rest = [pair for pair in pairs if pair not in own and pair not in first]
    pairs = [*first, *own, *rest]
    if len(pairs) <= most:
        axes.legend(*zip(*pairs), loc="best", fontsize=8, framealpha=0.8)
    else:
        axes.legend(*zip(*pairs), loc="upper center", bbox_to_anchor=(0.5, -0.14), fontsize=7, ncols=2, frameon=False)


def _logarithmic(axes: "Axes", values: Sequence[float]) -> None:
    """Make the x axis logarithmic, with plain numbers at 1, 2 and 5 if it spans less than a factor of 30."""
    from matplotlib import ticker

    axes.set_xscale("log")
    if max(values) / min(values) < 30.0:
        axes.xaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_minor_locator(ticker.NullLocator())
        axes.xaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
