"""Pictures of a patch study: error against spacing with the fitted order, against disorder, histograms of errors."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from parisph.pictures import style
from parisph.study import error_plots, patch_report
from parisph.study.error_plots import Dot
from parisph.study.patch_study import Histogram, PatchStudy
from parisph.study.patch_tasks import NORMS, PatchResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ACROSS = 2
SIZE = 5.2, 4.0    # [inch] of a panel
INSIDE = 4         # most entries of a legend inside the axes
NARROW = 2.0       # least ratio of the upper end of an axis to its middle


def pictures(results: Sequence[PatchResult], study: PatchStudy) -> Iterator[tuple[str, str, list[PatchResult]]]:
    """Yield (name, axis, results) of each picture of a study; axis is "spacing" or "jitter"."""
    for group in patch_report.groups(results).values():
        task, seen = group[0].task, set()
        walls = f"_{task.operator.walls}-walls" if task.operator.walls else ""
        base = f"{task.operator.kind}_{task.patch}_{task.field.name}{walls}"
        for sweep in study.sweeps:
            along_s = len(sweep.spacings) > 1
            for fixed in sweep.jitters if along_s else sweep.spacings if len(sweep.jitters) > 1 else ():
                name = f"{base}_{'k' if along_s else 's'}{fixed:.4g}"
                chosen = [one for one in group if fixed == (one.task.jitter if along_s else one.task.spacing)]
                if name not in seen and any(one.norms for one in chosen):
                    seen.add(name)
                    yield name, "spacing" if along_s else "jitter", chosen


def draw(results: Sequence[PatchResult], axis: str, title: str, path: Path) -> None:
    """Draw the norms of a group of results to a file, a panel for each. Needs matplotlib.

    axis : "spacing", with fitted orders, or "jitter"
    Raises MissingLibrary, CaseError, StoreError as pictures.style.save.
    """
    names, curves = patch_report.names_in(results), patch_report.curves(results)
    down = -(-len(names) // ACROSS)
    size = SIZE[0] * ACROSS, (SIZE[1] + 0.12 * (len(curves) + 1)) * down
    picture = style.new_figure(figsize=size, layout="constrained")
    panels = picture.subplots(down, ACROSS, squeeze=False)
    looks = error_plots.looks_of(curves)
    for axes, name in zip(panels.flat, names):
        dots = {curve: found for curve, group in curves.items() if (found := _dots(group, name, axis))}
        exact = [curve for curve, group in curves.items()
                 if curve not in dots and any(name in one.norms for one in group)]
        if exact:
            axes.set_title(style.literal(f"exact: {', '.join(exact)}", 90), fontsize=8, loc="left")
        axes.set_ylabel(style.literal(NORMS[name], 60), fontsize=8)
        axes.tick_params(direction="in", which="both", top=True, right=True)
        if not dots:
            continue
        if axis == "spacing":
            error_plots.convergence(axes, dots, looks, "spacing $s$", most=INSIDE)
        else:
            for curve, group in dots.items():
                error_plots.error_bars(axes, [dot.x for dot in group], group, looks[curve], curve)
            axes.set_yscale("log")
            axes.set_xlabel("disorder $k$")
            error_plots.add_legend(axes, dots, INSIDE)
        _widen(axes, [dot for group in dots.values() for dot in group])
        axes.grid(True, which="both", linewidth=0.4, alpha=0.4)
    for axes in list(panels.flat)[len(names):]:
        axes.axis("off")
    task = results[0].task
    fixed = f"k = {task.jitter:g}" if axis == "spacing" else f"s = {task.spacing:.4g}"
    _title(picture, f"{title}\n{patch_report.heading(results)}, {fixed}")
    style.save(picture, path)


def _widen(axes: "Axes", dots: Sequence[Dot]) -> None:
    """Show at least a factor of NARROW^2, so that a constant error is a flat line."""
    low, high = min(dot.low for dot in dots), max(dot.high for dot in dots)
    if high < NARROW * low:
        middle = (low * high) ** 0.5
        axes.set_ylim(middle / NARROW, middle * NARROW)


def draw_histogram(results: Sequence[PatchResult], histogram: Histogram, title: str, path: Path) -> bool:
    """Draw a histogram to a file, with bars from the least to the largest of all seeds. Raises as `draw`.

    Returns whether there was anything to draw.
    """
    found = patch_report.counts(results, histogram)
    if not found:
        return False
    names = patch_report.ranges(histogram)
    picture = style.new_figure(figsize=(max(7.0, 1.0 * len(names)), 4.6), layout="constrained")
    axes, width = picture.subplots(), 0.84 / len(found)
    for number, ((label, seeds), look) in enumerate(zip(found.items(), style.line_looks(len(found)))):
        mean = seeds.mean(axis=0)
        x = np.arange(len(names)) + (number - 0.5 * (len(found) - 1)) * width
        spread = [mean - seeds.min(axis=0), seeds.max(axis=0) - mean]
        axes.bar(x, mean, width, yerr=spread if len(seeds) > 1 else None, color=look["color"], capsize=2,
                 error_kw={"linewidth": 0.8}, edgecolor="white", hatch=None if look["linestyle"] == "-" else "//",
                 label=style.literal(label, 60))
    axes.set_xticks(np.arange(len(names)), names, rotation=30, fontsize=8)
    axes.set_xlabel("error of the Laplacian over its amplitude")
    axes.set_ylabel("particles")
    axes.grid(True, axis="y", linewidth=0.4, alpha=0.5)
    axes.legend(fontsize=8)
    _title(picture, f"{title}\nLaplacian in the interior, s = {histogram.spacing:.4g}, k = {histogram.jitter:g}")
    style.save(picture, path)
    return True


def _title(picture: "Figure", text: str) -> None:
    lines = [style.literal(line, 110) for line in text.strip().split("\n")]
    picture.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=10)


def _dots(group: Sequence[PatchResult], name: str, axis: str) -> list[Dot]:
    """Return the dots of a curve, without errors below ROUNDING."""
    found = []
    for family in patch_report.families(group).values():
        values = [one.norms[name] for one in family if name in one.norms]
        if values and max(values) > patch_report.ROUNDING:
            found.append(Dot(getattr(family[0].task, axis), 0.0, float(np.mean(values)), min(values), max(values)))
    return sorted(found, key=lambda dot: dot.x)
