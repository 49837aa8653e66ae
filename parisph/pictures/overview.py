"""A whole run on one page: four moments of the flow, the probes, and the solver. Needs matplotlib, no MPI."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Array
from parisph.base.paths import AnyPath
from parisph.io.reader import Run, open_run
from parisph.pictures import curves, rendering, states, style
from parisph.pictures.colouring import SOLID, Look
from parisph.pictures.view import FieldView, spread, view_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase, SubFigure


def plot_overview(run: Run | AnyPath, path: AnyPath | None = None, field: str = "pressure", **look: Any) -> "Figure":
    """Draw a whole run on one page; return the matplotlib Figure.

    Parameters and errors as of view.plot_field and curves.plot_probe. The colours cover most values of all moments.
    """
    run = run if isinstance(run, Run) else open_run(run)
    moments = spread(run, 4)
    panels = [(unit, lines) for (_, unit), lines in curves.by_quantity([run]).items()]
    view = FieldView(run.scene, moments, Look(field, **look))
    columns = min(2, len(moments))
    heights = -(-len(moments) // columns) * _height(view, 5.2), 2.3 * (len(panels) // 2 + 1)
    picture = style.new_figure(figsize=(11.0, 1.0 + sum(heights)), layout="constrained")
    flow, series = picture.subfigures(2, 1, height_ratios=heights)
    _draw_moments(flow, view, moments, columns, marked=True)
    _draw_series(series, run, panels)
    picture.suptitle(style.literal(run.scene.title), fontsize=13)
    if state := states.state(run):
        flow.suptitle(style.literal(state, states.LONGEST), fontsize=9, color=style.LINES[1])
    style.save(picture, path)
    return picture


def plot_moments(run: Run, path: AnyPath | None = None) -> "Figure":
    """Draw the pressure at moments evenly spread over a run; return the matplotlib Figure. Raises StoreError."""
    moments = spread(run, 6)
    view, columns = FieldView(run.scene, moments, Look()), min(2, len(moments))
    height = -(-len(moments) // columns) * _height(view, 10.4 / columns)
    picture = style.new_figure(figsize=(11.0, 0.4 + height), layout="constrained")
    _draw_moments(picture, view, moments, columns)
    style.save(picture, path, dpi=110)
    return picture


def plot_small(run: Run, which: int, path: AnyPath, field: str = "pressure") -> None:
    """Draw the particles at a snapshot, small and with few colours, for galleries. Raises as view.plot_field.

    A 3D flow is rendered where pyvista is installed, with its speed, as the pressure on the surface is 0.
    """
    snapshot = run.snapshot(which)
    solid = run.scene.dim == 3 and rendering.available()
    view = view_of(run.scene, [snapshot], Look("speed", view=SOLID) if solid else Look(field))
    width, height = view.size(5.6)
    picture = style.new_figure(figsize=(width, height), layout="compressed")
    axes = picture.add_subplot()
    discs = view.draw(axes, snapshot, view.limits([snapshot], whole=True), label=False)
    view.add_colour_bar(picture, axes, discs, [snapshot])
    style.save_small(picture, path)


def plot_solver(run: Run, path: AnyPath | None = None) -> "Figure":
    """Draw the iterations and the time steps of a run; return the matplotlib Figure."""
    picture = style.new_figure(figsize=(8.0, 2.6), layout="constrained")
    _draw_steps(picture.add_subplot(), run.steps)
    style.save(picture, path, dpi=110)
    return picture


def _height(view: FieldView, width: float) -> float:
    (left, right), (low, high) = view.window
    return min(0.8 * width * view.stretch * (high - low) / (right - left) + 0.7, 6.0)


def _draw_moments(flow: "FigureBase", view: FieldView, moments: Sequence[Mapping[str, Any]], columns: int,
                  marked: bool = False) -> None:
    """Draw moments. marked : whether to draw zones and the still level, and probes in the first one"""
    limits = view.limits(moments)
    grid = flow.subplots(-(-len(moments) // columns), columns, squeeze=False, sharex=True, sharey=True)
    discs = [view.draw(axes, moment, limits, label=False) for axes, moment in zip(grid.flat, moments)]
    for number, (axes, moment) in enumerate(zip(grid.flat, moments)):
        if marked:
            view.mark(axes, moment["time"], probes=number == 0)
    for axes in grid.flat[len(moments):]:
        axes.remove()
    for axes in grid.flat:
        axes.label_outer()
    view.add_colour_bar(flow, list(grid.flat[:len(moments)]), discs[-1], moments)


def _draw_series(series: "SubFigure", run: Run, panels: Sequence[tuple[str, list[curves.Curve]]]) -> None:
    """Draw the probes, two per row, and the record of the solver in the rest of the last row."""
    grid = series.add_gridspec(len(panels) // 2 + 1, 2)
    for number, (unit, lines) in enumerate(panels):
        axes = series.add_subplot(grid[number // 2, number % 2])
        curves.draw_curves(axes, lines, unit)
        curves.time_label(axes, False, True)
        curves.show_steps(axes, run)
    last = grid[-1, 1] if len(panels) % 2 else grid[-1, :]
    axes = series.add_subplot(last)
    _draw_steps(axes, run.steps)
    curves.show_steps(axes, run)


def _draw_steps(axes: "Axes", steps: Array) -> None:
    """Draw the time step and the iterations of the pressure solve; without a solve the compression."""
    solved = "iterations" in (steps.dtype.names or ())
    axes.plot(steps["time"], steps["iterations" if solved else "compression"], ".", color=style.LINES[0], markersize=2)
    axes.set_ylabel("iterations per solve [-]" if solved else r"compression $|\rho/\rho_0 - 1|$ [-]",
                    color=style.LINES[0])
    axes.set_ylim(bottom=0)
    if solved:
        axes.locator_params(axis="y", integer=True)
    axes.set_xlabel("$t$ [s]")
    axes.grid(True, linewidth=0.4, alpha=0.5)
    other = axes.twinx()
    other.plot(steps["time"], 1e3 * steps["dt"], color=style.LINES[1], linewidth=0.9)
    other.set_ylabel(r"step $\Delta t$ [ms]", color=style.LINES[1])
    other.set_ylim(bottom=0, top=1.25e3 * np.max(steps["dt"], initial=1e-12))
    other.margins(x=0.0)
