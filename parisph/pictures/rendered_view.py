"""Rendered views of a 3D flow: the water, the container as glass, and bodies with the pressure on them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base import libraries
from parisph.base.arrays import Flags, Floats
from parisph.base.errors import CaseError
from parisph.base.fields import BALLISTIC, FLUID, WALL, WET
from parisph.case.schema import Case
from parisph.geometry.build import domain, scene_mesh
from parisph.geometry.distance import unit_normals
from parisph.geometry.mesh import WallMesh
from parisph.geometry.spans import container
from parisph.pictures import style, water
from parisph.pictures.bodies_view import SOLID as BODY
from parisph.pictures.colouring import ColouredView, Look, Place
from parisph.pictures.frames import PictureFrame
from parisph.pictures.rendering import Eye, Piece, image

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import FigureBase

FROM = (35.0, 22.0)    # [degrees] azimuth, to the side on which the fluid starts, and elevation
GLASS = (0.1, 0.6)    # opacity of walls between the eye and the water, and of those behind it
CLEAR = 0.75    # opacity of water with bodies in it
DROP, BALL = 0.35, 0.5    # radii in spacings, of particles alone, and of all without a surface
PRESSURE = "pressure on bodies"
LABEL = 1.8, 0.8    # length of that label, and breadth of the numbers and the label of a colour bar [inch]


class RenderedView(ColouredView):
    """Draws snapshots of a 3D run from outside, from one place. Parameters as of FieldView.

    Raises CaseError for a 2D run, and MissingLibrary without pyvista.
    """

    def __init__(self, scene: Case, snapshots: Sequence[Mapping[str, Any]], look: Look) -> None:
        if scene.dim == 2:
            raise CaseError("--view 3d: the flow is 2D; leave it out")
        libraries.require("pyvista")
        super().__init__(scene, look)
        self.seen, self.mesh = PictureFrame.of(scene, look.frame), scene_mesh(scene)
        self.lower, self.upper = (np.array(corner, float) for corner in domain(scene))
        if scene.wall_bounds is None:    # fluid without walls goes anywhere
            fluid = np.concatenate([snapshot["x"][snapshot["kind"] == FLUID] for snapshot in snapshots])
            self.lower, self.upper = fluid.min(axis=0), fluid.max(axis=0)
        self.around = self._containers()
        corners = np.stack(np.meshgrid(*zip(self.lower, self.upper), indexing="ij"), axis=-1).reshape(-1, 3)
        times = np.array([snapshot["time"] for snapshot in snapshots])
        self.eye = Eye.of(np.concatenate(self.seen.course(corners, times)), *(look.camera or self._from()))
        self.load = self._load(snapshots)

    def size(self, width: float = 8.0) -> tuple[float, float]:
        """Return the figure size [inch]."""
        height = 0.84 * width / self.eye.aspect + 0.9
        return (width, height) if height <= 9.0 else (max(4.0, width * 9.0 / height), 9.0)

    def draw(self, axes: "Axes", snapshot: Mapping[str, Any], limits: tuple[float, float] | None, label: bool = True,
             note: str = "") -> "ScalarMappable | None":
        """Render one snapshot into axes; return what its colour bar shows. Parameters as of FieldView."""
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        ends = limits or (0.0, 1.0)
        axes.imshow(image([*self._walls(snapshot, ends), *self._water(snapshot, ends)], self.eye))
        axes.set_axis_off()
        more = ",   ".join(filter(None, [self.seen.note(snapshot["time"]), note]))
        title = [*([style.literal(self.whole.title)] if label else []),
                 style.time_label(snapshot["time"], self.own), *([more] if more else [])]
        axes.set_title("\n".join(title), loc="left", fontsize=11 if label else 9)
        return ScalarMappable(Normalize(*ends), self._colours)

    def add_colour_bar(self, picture: "FigureBase", axes: "Axes | Sequence[Axes]", shown: "ScalarMappable | None",
                       snapshots: Sequence[Mapping[str, Any]], place: Place = (1.02, 0.0, 0.02, 1.0)) -> None:
        """Add the colour bar, and that of the pressure on bodies below it, or beside it in a picture that is too low.

        Parameters as of ColouredView.
        """
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        if self.load is None or isinstance(axes, Sequence):
            super().add_colour_bar(picture, axes, shown, snapshots, place)
            return
        left, low, wide, high = place
        span, dpi = axes.get_window_extent(), axes.figure.dpi
        if 0.46 * high * span.height > LABEL[0] * dpi:
            first, second = (left, low + 0.54 * high, wide, 0.46 * high), (left, low, wide, 0.46 * high)
        else:
            first, second = place, (left + wide + LABEL[1] * dpi / span.width, low, wide, high)
        super().add_colour_bar(picture, axes, shown, snapshots, first)
        bar = picture.colorbar(ScalarMappable(Normalize(*self.load), "viridis"), cax=axes.inset_axes(second))
        bar.set_label(f"{PRESSURE} [{self._pressure[1]}]")
        bar.ax.spines["outline"].set_linewidth(0.5)

    @property
    def _colours(self) -> str:
        return self.look.colours or self.quantity.colours

    @property
    def _pressure(self) -> tuple[float, str]:
        """Factor and unit of pressures on bodies."""
        return style.with_prefix(self.own.pressure or 0.0, "Pa")

    def _from(self) -> tuple[float, float]:
        """Return azimuth and elevation [degrees] to look from the side on which the fluid starts."""
        low, high = self.whole.fluid_bounds
        left = low[0] + high[0] < self.lower[0] + self.upper[0] - 1e-9 * (self.upper[0] - self.lower[0])
        return (-FROM[0] if left else FROM[0]), FROM[1]

    def _containers(self) -> Flags:
        """Return which bodies of the mesh (k,) are around the water: its container, and Surfaces with it inside."""
        if self.mesh is None:
            return np.zeros(0, bool)
        names = {container(self.whole).name, *(one.name for one in self.whole.surfaces if one.side == "inside")}
        return np.array([body.name in names for body in self.mesh.bodies], bool)

    def _load(self, snapshots: Sequence[Mapping[str, Any]]) -> tuple[float, float] | None:
        """Return the ends of the colours of the pressure on bodies; None without, or if the water has the same."""
        if self.mesh is None or self.around.all() or self.quantity.needs == "p":
            return None
        if not all("p" in snapshot for snapshot in snapshots):
            return None
        own = ~self.around[self.mesh.body]
        found = [snapshot["p"][snapshot["kind"] == WALL] for snapshot in snapshots]
        most = max((float(np.max(p[own], initial=0.0)) for p in found if len(p) == len(own)), default=0.0)
        return 0.0, self._pressure[0] * most or 1.0

    def _shown_values(self, snapshots: Sequence[Mapping[str, Any]]) -> Floats:
        found = []
        for snapshot in map(self.seen.snapshot, snapshots):
            values = self.values(snapshot)
            found.append(values[self._rows(snapshot) & np.isfinite(values)])
        return np.concatenate(found)

    @property
    def _clear(self) -> float:
        """Opacity of the water: bodies in it are seen."""
        return 1.0 if self.around.all() else CLEAR

    def _rows(self, snapshot: Mapping[str, Any]) -> Flags:
        """Return the particles (n,) bool whose values are shown: fluid, and of the pressure wet walls."""
        found: Flags = (snapshot["kind"] == FLUID) | self._walls_to_fill(snapshot)
        return found

    def _water(self, snapshot: Mapping[str, Any], limits: tuple[float, float]) -> Iterator[Piece]:
        """Yield the surface of the water and the drops, or all particles without the library that makes surfaces."""
        x, s, time = snapshot["x"], self.whole.numerics.spacing, snapshot["time"]
        values, rows = self.values(self.seen.snapshot(snapshot)), self._rows(snapshot)
        fluid, wet = snapshot["kind"] == FLUID, (snapshot["kind"] == WALL) & (snapshot["role"] == WET)
        drops = fluid & (snapshot["role"] == BALLISTIC)
        look: dict[str, Any] = {"limits": limits, "colours": self._colours}
        made = water.surface(x[(fluid & ~drops) | wet], s, None if self.mesh is None else (self.lower, self.upper))
        if made is None:
            yield Piece(self.seen.placed(x[fluid], time), None, values[fluid], radius=BALL * s, **look)
            return
        points, triangles = made
        yield Piece(self.seen.placed(points, time), triangles, water.spread(points, x[rows], values[rows]), smooth=True,
                    opacity=self._clear, **look)
        yield Piece(self.seen.placed(x[drops], time), None, values[drops], radius=DROP * s, **look)

    def _walls(self, snapshot: Mapping[str, Any], limits: tuple[float, float]) -> Iterator[Piece]:
        """Yield the container, as glass with its edges, and the bodies with their pressure."""
        rows = snapshot["kind"] == WALL
        if self.mesh is None or np.count_nonzero(rows) != len(self.mesh.x0):
            return
        nodes = self.seen.placed(snapshot["x"][rows], snapshot["time"])    # ids follow the nodes of the mesh
        glass = self.around[self.mesh.element_body]
        yield from self._glass(nodes, self.mesh, glass, snapshot["role"][rows] == WET)
        bodies = self.mesh.elements[~glass].astype(np.int64)
        if "p" not in snapshot or (self.load is None and self.quantity.needs != "p"):
            yield Piece(nodes, bodies, colour=BODY)
        elif self.quantity.needs == "p":
            yield Piece(nodes, bodies, self.values(snapshot)[rows], limits, self._colours)
        else:
            yield Piece(nodes, bodies, self._pressure[0] * snapshot["p"][rows], self.load or (0.0, 1.0), "viridis")

    def _glass(self, nodes: Floats, mesh: WallMesh, glass: Flags, wet: Flags) -> Iterator[Piece]:
        """Yield the dry part of walls, as the water lies on the wet part, and their sharp edges."""
        corners, dry = nodes[mesh.elements], glass & ~wet[mesh.elements].all(axis=1)
        towards = np.sum((self.eye.place - corners.mean(axis=1)) * unit_normals(corners), axis=1) > 0.0
        for part, opacity in zip((dry & ~towards, dry & towards), GLASS):
            yield Piece(nodes, mesh.elements[part].astype(np.int64), colour=BODY, opacity=opacity, lit=False)
        yield Piece(nodes, mesh.elements[glass].astype(np.int64), colour=style.WALL_COLOUR, lines=True)
