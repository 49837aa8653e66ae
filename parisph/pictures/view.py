"""Pictures of the flow of a run. Needs matplotlib, no MPI."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Array, Floats
from parisph.base.errors import CaseError, StoreError
from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE
from parisph.base.paths import AnyPath
from parisph.case.bodies import Profile
from parisph.case.schema import Case
from parisph.case.shapes import Tank
from parisph.geometry.build import domain
from parisph.geometry.solid import solid_of
from parisph.geometry.standing import standing
from parisph.io.reader import Run, open_run
from parisph.io.views import Snapshot
from parisph.pictures import style, window
from parisph.pictures.bodies_view import draw_bodies, draw_marks
from parisph.pictures.colouring import SOLID, ColouredView, Look
from parisph.pictures.frames import PictureFrame
from parisph.pictures.slices import Slice

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import Collection, EllipseCollection
    from matplotlib.figure import Figure

# Diameters in spacings: of a particle, and of the ground below particles inside, which fills the gaps between discs.
DISC, GROUND = 1.05, 1.8
ABOVE = 1.5    # drawing order of particles: above solids, so that a particle in a wall is visible


def plot_field(run: Run | AnyPath, which: int | float | Mapping[str, Any] = -1, field: str = "pressure",
               path: AnyPath | None = None, **look: Any) -> "Figure":
    """Draw the particles at one time, coloured by a quantity; return the matplotlib Figure.

    The colours end at the greatest value in the picture, of fluid or wet walls.

    run : or its folder
    which : number of the snapshot (int, negative from the end), time [s] of the nearest one (float), or a snapshot
        (dict, as from Run.snapshot and Run.peak)
    field : see Look, also for further keywords; path : file to write (.png, .pdf, ...), or None

    Raises CaseError : as Look, nothing to normalise by, or a zoom outside the scene; MissingLibrary
    StoreError : no such snapshot, or the quantity was not written
    """
    run = run if isinstance(run, Run) else open_run(run)
    snapshot = which if isinstance(which, Mapping) else run.snapshot(which)
    view = view_of(run.scene, [snapshot], Look(field, **look))
    picture = style.new_figure(figsize=view.size(), layout="compressed")
    axes = picture.add_subplot()
    view.add_colour_bar(picture, axes, view.draw(axes, snapshot, view.limits([snapshot], whole=True)), [snapshot])
    style.save(picture, path)
    return picture


def view_of(scene: Case, snapshots: Sequence[Mapping[str, Any]], look: Look) -> ColouredView:
    """Return the view of snapshots that a Look asks for. Raises CaseError, StoreError, MissingLibrary."""
    if look.view != SOLID:
        return FieldView(scene, snapshots, look)
    from parisph.pictures.rendered_view import RenderedView

    return RenderedView(scene, snapshots, look)


def spread(run: Run, count: int) -> list[Snapshot]:
    """Return at most `count` snapshots, evenly spread over a run. Raises StoreError for a run without snapshots."""
    if len(run) == 0:
        raise StoreError(f"{run.folder} has no snapshots")
    return [run.snapshot(int(number)) for number in np.unique(np.linspace(0, len(run) - 1, count).round())]


class FieldView(ColouredView):
    """Draws snapshots of one run, with common scales, walls, colours and window; of a 3D flow a slice."""

    def __init__(self, scene: Case, snapshots: Sequence[Mapping[str, Any]], look: Look) -> None:
        super().__init__(scene, look)
        self.slice = Slice.through(scene, look.frame, look.slice) if scene.dim == 3 else None
        if self.slice is None and look.slice is not None:
            raise CaseError(f"--slice {look.slice}: the flow is 2D, and shown as a whole; leave it out")
        # The 2D scene whose walls are drawn as outlines; None of a slice without.
        self.scene = scene if self.slice is None else self.slice.section
        self.lidded, self.up = scene.lidded, "y" if self.slice is None else "z"
        self.names = ("x", "y") if self.slice is None else self.slice.names
        self.length = self.own.length if look.normalise else 1.0
        self.spacing = scene.numerics.spacing / self.length
        self.seen = PictureFrame.of(scene, look.frame) if self.slice is None else self.slice
        self.window = self._window(snapshots)
        self.stretch = window.stretch(self.window)    # vertical scale over the horizontal one

    def size(self, width: float = 8.0) -> tuple[float, float]:
        """Return the figure size [inch] for the window, with room for labels and colour bar."""
        (left, right), (low, high) = self.window
        height = 0.84 * width * self.stretch * (high - low) / (right - left) + 1.2
        return (width, height) if height <= 9.0 else (max(4.0, width * 9.0 / height), 9.0)

    def draw(self, axes: "Axes", snapshot: Mapping[str, Any], limits: tuple[float, float] | None, label: bool = True,
             note: str = "") -> "Collection | None":
        """Draw one snapshot into axes; return the coloured collection, or None for roles.

        limits : (lowest, highest) of the colours; label : whether the title names the case; note : further text in it
        """
        pieces = self.slice.walls(snapshot) if self.slice is not None else np.empty((0, 2, 2))
        snapshot = self.seen.snapshot(snapshot)
        x, values = snapshot["x"] / self.length, self.values(snapshot)
        fluid = snapshot["kind"] == FLUID
        ground = ((fluid & (snapshot["role"] == INNER)) | self._walls_to_fill(snapshot)) & self._outlined
        layers = [(style.discs(axes, x[rows], size * self.spacing), values[rows])
                  for rows, size in ((ground, GROUND), (fluid, DISC))]
        # The ground is cut at the walls, but not particles: one that crosses a wall is visible.
        self._draw_walls(axes, layers[0][0], snapshot["time"], pieces)
        layers[1][0].set_zorder(ABOVE)
        roles = self.quantity.needs == "role"
        for discs, colour in layers:
            if roles:
                discs.set_facecolor([style.ROLES[int(role)][1] for role in colour])
            else:
                discs.set(array=colour, cmap=self.look.colours or self.quantity.colours, clim=limits)
        if roles:
            self._name_roles(axes, snapshot["role"][fluid | ground])
        elif self.look.surface:
            self._ring(axes, x, snapshot)
        away = window.outside(x[fluid], self.window) if self.look.zoom is None else 0
        self._finish(axes, snapshot["time"], label,
                     [note, f"{away} particle{'s' * (away > 1)} outside" if away else ""])
        return None if roles else layers[1][0]

    @property
    def _outlined(self) -> bool:
        """Whether all walls have outlines, at which discs that reach into them are cut."""
        return self.slice is None or (self.scene is not None and not self.whole.surfaces) or not self.whole.all_bodies

    def mark(self, axes: "Axes", time: float, probes: bool = True) -> None:
        """Draw still level, zones and probes into axes."""
        if self.scene is not None and self.scene.fluids:
            draw_marks(axes, self.scene, self.window, time, self.length, self.seen, probes)

    def _shown_values(self, snapshots: Sequence[Mapping[str, Any]]) -> Floats:
        """Return the finite values (n,) inside the window, of fluid and of walls with a pressure."""
        found = []
        (left, right), (low, high) = self.window
        for snapshot in map(self.seen.snapshot, snapshots):
            x, values = snapshot["x"] / self.length, self.values(snapshot)
            inside = (x[:, 0] >= left) & (x[:, 0] <= right) & (x[:, 1] >= low) & (x[:, 1] <= high)
            shown = (snapshot["kind"] == FLUID) | (self._walls_to_fill(snapshot) & self._outlined)
            found.append(values[shown & inside & np.isfinite(values)])
        return np.concatenate(found)

    def _window(self, snapshots: Sequence[Mapping[str, Any]]) -> window.Ends:
        """Return ((left, right), (low, high)) of the axes: the zoom, else those of walls and fluid."""
        box, spacing = self._box(), self.spacing * self.length
        fluid = [self._fluid(snapshot) for snapshot in snapshots]
        fluid = [x[window.shown(x, spacing, box)] for x in fluid]
        times = np.array([snapshot["time"] for snapshot in snapshots])
        walls = [] if box is None else self.seen.course(self._walls_shown(box, fluid), times)
        ends = window.of([self.seen.placed(x, t) for x, t in zip(fluid, times)], walls, self.length)
        if self.look.zoom is None:
            return ends
        left, right, bottom, top = self.look.zoom
        if left >= ends[0][1] or right <= ends[0][0] or bottom >= ends[1][1] or top <= ends[1][0]:
            reach = " and from ".join(f"{name} = {end[0]:.4g} to {end[1]:.4g}" for name, end in zip(self.names, ends))
            raise CaseError(f"--zoom {left:g} {right:g} {bottom:g} {top:g}: nothing is there; the scene reaches from "
                            f"{reach}")
        return (left, right), (bottom, top)

    def _box(self) -> window.Box | None:
        """Return the corners (2,) [m] of a box around the walls, None without walls."""
        if self.whole.wall_bounds is None:
            return None
        return domain(self.whole) if self.slice is None else self.slice.box()

    def _fluid(self, snapshot: Mapping[str, Any]) -> Floats:
        """Return the places (n, 2) [m] of all fluid in the frame of the tank, so that all slices show the same box."""
        x: Floats = snapshot["x"][snapshot["kind"] == FLUID]
        return x if self.slice is None else self.slice.flat(x)

    def _walls_shown(self, box: window.Box, fluid: Sequence[Floats]) -> Floats:
        """Return the corners (4, 2) [m] around the walls, without the empty top of a tank without a lid."""
        (left, low), (right, top) = box
        high = max((x[:, 1].max() for x in fluid if len(x)), default=top)
        if not self.lidded and self.names[1] == self.up and high <= low + 0.7 * (top - low):
            top = min(top, low + 1.2 * (high - low))
        return window.corners((np.array([left, low]), np.array([right, top])))

    def _name_roles(self, axes: "Axes", roles: Array) -> None:
        from matplotlib.patches import Patch

        present = [style.ROLES[role] for role in style.ROLES if np.any(roles == role)]
        axes.legend(handles=[Patch(facecolor=colour, label=name) for name, colour in present],
                    loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=9)

    def _draw_walls(self, axes: "Axes", cut: "EllipseCollection", time: float, pieces: Floats) -> None:
        """Draw the walls at a time [s]; clip the discs `cut` to the inside of a tank or the space above a bed.

        pieces : (k, 2, 2) [m], of walls in a slice that have no outline
        """
        from matplotlib.collections import LineCollection
        from matplotlib.patches import Polygon

        (left, right), (low, high) = self.window
        far = (right - left + high - low) * self.length
        floor = low * self.length - (far if self.seen.moved else 0.0)    # below the axes for any place of the tank
        if self.scene is not None:
            draw_bodies(axes, self.scene, time, self.length, floor, self.seen)
            around = [_room(wall, time, far) for wall in standing(self.scene)
                      if isinstance(wall, Tank) or (isinstance(wall, Profile) and wall.side is None)]
        else:
            around = [window.corners(box)] if (box := self._box()) is not None else []
        if len(pieces):
            axes.add_collection(LineCollection(list(pieces / self.length), colors=style.WALL_COLOUR, linewidths=2.0,
                                               zorder=3, capstyle="round"))
        if len(around) == 1:    # other walls are filled, and hide the discs inside
            cut.set_clip_path(Polygon(self.seen.placed(around[0], time) / self.length, transform=axes.transData))

    def _ring(self, axes: "Axes", x: Floats, snapshot: Mapping[str, Any]) -> None:
        from matplotlib.lines import Line2D

        handles = []
        for role in (SURFACE, BALLISTIC):
            name, colour = style.ROLES[role]
            chosen = (snapshot["kind"] == FLUID) & (snapshot["role"] == role)
            if np.any(chosen):
                style.discs(axes, x[chosen], DISC * self.spacing, facecolors="none", edgecolors=colour, linewidths=0.8,
                            zorder=4)
                handles.append(Line2D([], [], marker="o", linestyle="", markerfacecolor="none",
                                      color=colour, label=name))
        if handles:
            axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2,
                        frameon=False, fontsize=9, borderaxespad=0.2, handletextpad=0.1)

    def _finish(self, axes: "Axes", time: float, label: bool, notes: Sequence[str]) -> None:
        axes.set_xlim(self.window[0])
        axes.set_ylim(self.window[1])
        axes.set_aspect(self.stretch)
        across, up = (f"${name}/H$" if self.look.normalise else f"${name}$ [m]" for name in self.names)
        axes.set(xlabel=across, ylabel=up)
        axes.tick_params(direction="in", top=True, right=True)
        where = self.slice.said if self.slice is not None else ""
        more = ",   ".join(filter(None, [where, self.seen.note(time), window.said(self.stretch), *notes]))
        title = [*([style.literal(self.whole.title)] if label else []), style.time_label(time, self.own),
                 *([more] if more else [])]
        axes.set_title("\n".join(title), loc="left", fontsize=11 if label else 9)
        down = self.seen.down(time)
        if down is not None:
            _arrow(axes, down, "$g$")


def _room(wall: Tank | Profile, time: float, far: float) -> Floats:
    """Return points (n, 2) [m] around the inside of a tank, or the space above a bed."""
    x = wall.motion.placed(solid_of(wall).points, time)
    top = x[:, 1].max() + far
    return x if isinstance(wall, Tank) else np.concatenate([x, [(x[-1, 0], top), (x[0, 0], top)]])


def _arrow(axes: "Axes", direction: Floats, name: str) -> None:
    """Draw an arrow in a direction (2,), with a name at its tail, in the upper right corner of the axes."""
    arrow = axes.annotate(name, xy=(0.92, 0.82), xycoords="axes fraction", xytext=tuple(-24.0 * direction),
                          textcoords="offset points", ha="center", va="center", fontsize=9, zorder=6,
                          arrowprops={"arrowstyle": "-|>", "color": "black", "shrinkA": 6.0, "shrinkB": 0.0,
                                      "path_effects": style.halo()}, path_effects=style.halo())
    arrow.set_in_layout(False)
