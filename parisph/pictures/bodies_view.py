"""Pictures of the walls of any scene, and of a case before it runs. Needs matplotlib; needs no MPI."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import FLUID
from parisph.base.paths import AnyPath
from parisph.case import stored
from parisph.case.bodies import Profile
from parisph.case.probes import ColumnHeight, PressureTap, SurfaceGauge, VelocityProfile
from parisph.case.schema import Case
from parisph.case.shapes import Tank
from parisph.geometry.build import build, counts, domain
from parisph.geometry.outline import outline_of
from parisph.geometry.standing import given, standing
from parisph.pictures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SOLID = "#d9d9d9"
WATER = "#9ecae1"
MOST = 200_000    # particles that a picture of a case shows one by one


def of_dict(case: Mapping[str, Any]) -> Case:
    """Return the Case of a dict, as in case.json, which is only looked at. Raises CaseError."""
    return stored.from_json(json.dumps(dict(case)), read_only=True)


def draw_bodies(axes: "Axes", case: Case, time: float = 0.0, length: float = 1.0, floor: float | None = None) -> None:
    """Draw the walls of a case as they are at a time [s]; lengths are divided by `length` [m].

    floor : height [m] down to which the ground below a bed is drawn, None for a little below the lowest wall
    """
    if floor is None:
        lower, upper = domain(case)
        floor = float(lower[1] - 0.05 * (upper - lower)[1])
    for wall in standing(case):
        outline = outline_of(wall)
        x = wall.motion.placed(outline.points, time)
        if isinstance(wall, Profile) and wall.side is None:
            ground = np.concatenate([x, [(x[-1, 0], floor), (x[0, 0], floor)]]) / length
            axes.fill(*ground.T, color=SOLID, linewidth=0.0, zorder=1.2)
        elif outline.closed and not outline.two_sided and not isinstance(wall, Tank):
            axes.fill(*(x / length).T, color=SOLID, linewidth=0.0, zorder=1.2)
        line = np.concatenate([x, x[:1]]) if outline.closed else x
        axes.plot(*(line / length).T, color=style.WALL_COLOUR, linewidth=2.0, solid_joinstyle="miter", zorder=3)


def plot_scene(case: Case, path: AnyPath | None = None) -> "Figure":
    """Draw a case at the start: fluid, walls with their names, probes; return the matplotlib Figure.

    path : of the picture, None for none. Raises CaseError, StoreError.
    """
    lower, upper = domain(case)
    upper = np.maximum(upper, case.fluid_bounds[1])
    wide, high = upper - lower
    picture = style.drawing().Figure(figsize=(10.0, float(np.clip(8.5 * high / wide, 1.5, 7.0)) + 1.5))
    axes = picture.add_subplot()
    x, size = places_of_water(case, wide * high)
    window = axes.get_window_extent()
    dot = size * 72.0 / picture.dpi * max(window.width / wide, window.height / high)
    axes.scatter(*x.T, s=dot**2, color=WATER, linewidths=0.0, zorder=1.1)
    draw_bodies(axes, case)
    for wall in given(case):
        x = outline_of(wall).points
        at = (x[:, 0].mean(), x[:, 1].min() if isinstance(wall, Tank) else x[:, 1].mean())
        axes.annotate(style.literal(wall.name), at, fontsize=8, ha="center", zorder=5, xytext=(0, 4),
                      textcoords="offset points")
    _draw_probes(axes, case, upper[1])
    axes.set_aspect("equal" if wide < 12.0 * high else "auto")
    axes.set_xlabel("$x$ [m]")
    axes.set_ylabel("$y$ [m]")
    axes.set_title(style.literal(case.title), loc="left", fontsize=11)
    style.save(picture, path)
    return picture


def places_of_water(case: Case, area: float) -> tuple[Floats, float]:
    """Return places (n, 2) [m] all over the water at the start, and their distance [m].

    They are its particles, or of more than MOST the squares of a grid in which there are particles, of which only a
    part is held in memory at a time. area : of the picture [m2]
    """
    slices = -(-counts(case)["all"] // MOST)
    size = case.numerics.spacing if slices == 1 else max(1.5 * case.numerics.spacing, float(np.sqrt(area / MOST)))
    found: list[Floats] = []
    for number in range(slices):
        arrays = build(case, number, slices)
        x = arrays["x"][arrays["kind"] == FLUID]
        found.append(x if slices == 1 else np.unique(np.floor(x / size), axis=0))
    if slices == 1:
        return found[0], size
    squares: Floats = (np.unique(np.concatenate(found), axis=0) + 0.5) * size
    return squares, size


def _draw_probes(axes, case, top):
    for probe in case.probes:
        if isinstance(probe, PressureTap):
            axes.plot(*probe.at, "o", color="#d62728", markersize=4.0, zorder=6)
            at = probe.at
        elif isinstance(probe, (SurfaceGauge, ColumnHeight)):
            axes.axvline(probe.at, color="#d62728", linewidth=0.8, linestyle=":", zorder=4)
            at = probe.at, top
        elif isinstance(probe, VelocityProfile):
            axes.plot(*np.transpose([probe.start, probe.end]), color="#d62728", linewidth=0.8, zorder=4)
            at = probe.start
        else:
            continue
        axes.annotate(style.literal(probe.name), at, fontsize=8, color="#d62728", xytext=(3, 3),
                      textcoords="offset points", zorder=6)
