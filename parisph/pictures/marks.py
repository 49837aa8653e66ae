"""Marks in pictures of a scene: probes, zones that absorb waves, and the level of still water."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.expressions import uniform_field
from parisph.case.probes import Gauge, ProbeArray
from parisph.case.schema import Case
from parisph.pictures import labels, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOUR = "black"
MANY = 12    # most gauges of an array with names and full lines; more have one name and short lines
WIDE = 0.98    # least width of still water over that between the walls
Placed = Callable[[Floats], Floats]    # from places (n, 2) [m] in the scene to those in the axes, in their unit


def draw_still_level(axes: "Axes", case: Case, placed: Placed) -> None:
    """Draw the level of still water as a thin dashed line, if the scene has one."""
    level = still_level(case)
    if level is not None:
        left, right = case.ends
        axes.plot(*placed(np.array([(left, level), (right, level)])).T, color=COLOUR, linewidth=0.7,
                  linestyle=(0, (6, 4)), zorder=3.5, gid="still level", path_effects=style.halo(1.4))


def draw_zones(axes: "Axes", case: Case, placed: Placed, heights: tuple[float, float]) -> list[labels.Label]:
    """Shade the zones that absorb waves; return their names. heights : of their lower and upper ends [m]"""
    found = []
    for zone in case.zones:
        corners = placed(np.array([(zone.start, heights[0]), (zone.end, heights[0]), (zone.end, heights[1]),
                                   (zone.start, heights[1])]))
        axes.fill(*corners.T, facecolor="#bbbbbb44", edgecolor="#66666677", hatch="//", linewidth=0.0, zorder=1.7,
                  gid=zone.kind)
        middle = corners.mean(axis=0)
        top = corners[:, 1].max()
        found.append(labels.Label(zone.kind, np.array([(middle[0], middle[1] + share * (top - middle[1]))
                                                       for share in (0.8, 0.5, 0.0, -0.5)])))
    return found


def draw_probes(axes: "Axes", case: Case, placed: Placed, heights: tuple[float, float], lines: list[Floats],
                dots: list[Floats]) -> list[labels.Label]:
    """Draw probes at the start, gauges as vertical lines, taps and points as dots; return their names.

    heights : of the lower and upper ends of gauges [m]; lines, dots : lists that get the points, (n, 2) and (1, 2)
    """
    names: list[labels.Label] = []
    for probe in case.probes:
        members = probe.probes if isinstance(probe, ProbeArray) else (probe,)
        many = len(members) > MANY
        for number, one in enumerate(members):
            upright, x = isinstance(one, Gauge), one.drawn(heights)
            if x is None:
                continue
            if many and upright:
                x[0, 1] = x[1, 1] - 0.06 * (heights[1] - heights[0])
            x = placed(x)
            if len(x) == 1:
                dots.append(x)
                axes.plot(*x.T, "o", color="white", markeredgecolor=COLOUR, markersize=4.0, zorder=5, gid=one.name)
            else:
                lines.append(x)
                axes.plot(*x.T, color=COLOUR, linewidth=0.8, linestyle=":" if upright else "-", zorder=4, gid=one.name,
                          path_effects=style.halo(1.4))
            if number == 0 or not many:
                text = f"{probe.name} ({len(members)})" if many else one.name
                names.append(labels.Label(text, x if upright else x[[0, -1, len(x) // 2]], upright))
    return names


def still_level(case: Case) -> float | None:
    """Return the level y [m] of still water from wall to wall at the start, with gravity downwards; else None."""
    gravity = uniform_field(case.gravity)
    if case.wall_bounds is None or len(case.fluids) > 1 or case.closed or gravity is None:
        return None
    (left, right), (lower, upper) = case.ends, case.fluid_bounds
    down = gravity[1] < 0.0 and abs(gravity[0]) < 1e-9 * abs(gravity[1])
    return float(upper[1]) if down and upper[0] - lower[0] >= WIDE * (right - left) > 0.0 else None
