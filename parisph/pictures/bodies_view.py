"""Pictures of the walls of a scene, and of a case before it runs. Needs matplotlib, no MPI."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import FLUID
from parisph.base.paths import AnyPath
from parisph.case.bodies import Profile
from parisph.case.schema import Case
from parisph.case.sections import richest
from parisph.case.shapes import Tank
from parisph.geometry.build import build, counts, domain
from parisph.geometry.solid import Wall, solid_of
from parisph.geometry.standing import given, standing
from parisph.pictures import labels, marks, style, window
from parisph.pictures.frames import TANK, PictureFrame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SOLID = "#d9d9d9"
WATER = "#9ecae1"
MOST = 200_000    # most particles in a picture of a case; more are shown as squares of a grid


def draw_bodies(axes: "Axes", case: Case, time: float = 0.0, length: float = 1.0, floor: float | None = None,
                seen: PictureFrame | None = None) -> None:
    """Draw the walls of a case at a time [s]; lengths are divided by `length` [m].

    floor : lower end [m] of the ground below a bed, None for slightly below the lowest wall
    seen : frame of the picture, None for that of the tank
    """
    seen = seen or PictureFrame.of(case, TANK)
    if floor is None:
        lower, upper = domain(case)
        floor = float(lower[1] - 0.05 * (upper - lower)[1])
    for wall in standing(case):
        outline = solid_of(wall)
        x = wall.motion.placed(outline.points, time)
        if isinstance(wall, Profile) and wall.side is None:
            ground = seen.placed(np.concatenate([x, [(x[-1, 0], floor), (x[0, 0], floor)]]), time) / length
            axes.fill(*ground.T, color=SOLID, linewidth=0.0, zorder=1.2)
        elif outline.closed and not outline.two_sided and not isinstance(wall, Tank):
            axes.fill(*(seen.placed(x, time) / length).T, color=SOLID, linewidth=0.0, zorder=1.2)
        axes.plot(*(seen.placed(_closed(wall, time), time) / length).T,
                  color=style.WALL_COLOUR, linewidth=2.0, solid_joinstyle="miter", zorder=3)


def plot_scene(case: Case, path: AnyPath | None = None) -> "Figure":
    """Draw fluid, walls, zones and probes of a case at the start, with names; return the matplotlib Figure.

    path : of the picture, or None. Of a case in 3D, the section with most bodies is drawn, with all probes. Raises
    CaseError, StoreError.
    """
    title, upwards = case.title, "$y$ [m]"
    if case.dim == 3:
        low, high, part = richest(case)
        title, upwards = f"{title}: section from y = {low:g} to {high:g} m", "$z$ [m]"
        case = part.model_copy(update={"probes": case.probes})
    lower, upper = domain(case)
    upper = np.maximum(upper, case.fluid_bounds[1])
    ends = window.of([], [np.array([lower, upper])])
    times = window.stretch(ends)
    wide, high = (end - start for start, end in ends)
    height = 8.5 * times * high / wide
    width = 10.0 if height <= 7.5 else max(10.0 * 7.5 / height, 4.0)
    picture = style.new_figure(figsize=(width, min(height, 7.5) + 1.5), layout="constrained")
    axes = picture.add_subplot()
    x, size = places_of_water(case, float(np.prod(upper - lower)))
    style.discs(axes, x, 1.4 * size, facecolors=WATER, zorder=1.1)
    draw_bodies(axes, case, floor=ends[1][0])
    draw_marks(axes, case, ends, walls=True)
    axes.set(xlim=ends[0], ylim=ends[1], xlabel="$x$ [m]", ylabel=upwards, aspect=times)
    more = window.said(times)
    axes.set_title(style.literal(title) + (f"\n{more}" if more else ""), loc="left", fontsize=11)
    style.save(picture, path)
    return picture


def draw_marks(axes: "Axes", case: Case, ends: window.Ends, time: float = 0.0, length: float = 1.0,
               seen: PictureFrame | None = None, probes: bool = True, walls: bool = False) -> None:
    """Draw the still level, zones and probes of a case with their names into axes with these ends.

    probes, walls : whether probes are shown, and walls are named; time, length, seen : as of draw_bodies
    """
    view = seen or PictureFrame.of(case, TANK)

    def placed(x: Floats) -> Floats:
        return view.placed(x, time) / length

    heights = (ends[1][0] * length, ends[1][1] * length)
    if view.moved:    # lines end at the tank, not at the axes
        lower, upper = domain(case)
        heights = float(lower[1]), float(upper[1])
    marks.draw_still_level(axes, case, placed)
    names = marks.draw_zones(axes, case, placed, heights)
    lines: list[Floats] = []
    dots: list[Floats] = []
    if probes:
        names = [*marks.draw_probes(axes, case, placed, heights, lines, dots), *names]
    outlines = [placed(_closed(wall, time)) for wall in standing(case)]
    if walls:
        shown = [placed(_closed(wall, time)) for wall in given(case)]    # fillings of wedges have no name
        names += [labels.Label(wall.name, _beside(x, ends)) for wall, x in zip(given(case), shown)]
    labels.add(axes, names, [*lines, *outlines], np.concatenate(dots) if dots else None)


def _closed(wall: Wall, time: float) -> Floats:
    """Return the outline (n, 2) [m] of a wall at a time [s], closed if the wall is."""
    outline = solid_of(wall)
    x = wall.motion.placed(outline.points, time)
    return np.concatenate([x, x[:1]]) if outline.closed else x


def _beside(x: Floats, ends: window.Ends) -> Floats:
    """Return the middles of the pieces of a line (n, 2) inside the axes, the longest one first."""
    a, b = x[:-1], x[1:]
    middles = 0.5 * (a + b)
    inside = [window.outside(middle[None], ends) == 0 for middle in middles]
    order = np.argsort(-np.linalg.norm(b - a, axis=1), kind="stable")
    kept = [k for k in order if inside[k]][:8]
    return np.concatenate([middles[kept], a[kept] + 0.25 * (b - a)[kept]]) if kept else middles[:1]


def places_of_water(case: Case, area: float) -> tuple[Floats, float]:
    """Return places (n, 2) [m] in the water at the start, and their distance [m]. area : of the picture [m2]

    They are the particles, or, of more than MOST, the squares of a grid that contain particles.
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
