"""The content and style of pictures of the flow, and the colours of a quantity in them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base import text
from parisph.base.arrays import Flags, Floats
from parisph.base.errors import CaseError, StoreError
from parisph.base.fields import WALL, WET
from parisph.case.schema import Case
from parisph.pictures import style
from parisph.pictures.frames import TANK
from parisph.pictures.slices import parsed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import FigureBase

Place = tuple[float, float, float, float]    # left, lower end, width and height
FLAT, SOLID = "slice", "3d"    # views of a 3D flow


@dataclass(frozen=True)
class Look:
    """The content and style of pictures of the flow.

    field : "pressure", "speed", "velocity_x", "velocity_y", in 3D "velocity_z", "vorticity", "density_ratio" or "role"
    surface : whether particles on the free surface, and ballistic ones, are marked with rings
    normalise : divide lengths by H, pressures by rho g H, velocities by sqrt(g H)
    limits : (lowest, highest) of the colours, in the unit of the picture; None to fit the values
    colours : name of a matplotlib colour map, None for that of the quantity
    zoom : (left, right, low, high) of the axes, in their unit; None for walls and fluid without spray outside
    frame : of places and velocities: "tank", in which the flow is computed, or "world", the room
    slice : of a 3D flow, the plane that is shown, such as "y=0.47"; None for the middle of the breadth
    view : "slice", or of a 3D flow "3d", a rendered view from outside
    camera : of that view, (azimuth, elevation) [degrees]: from the front, seen along y, turned anticlockwise by the
        azimuth and raised by the elevation; None to look from the side on which the fluid starts

    Raises CaseError: unknown quantity or colour map; limits or zoom not in order, or not possible for the field
    """

    field: str = "pressure"
    surface: bool = False
    normalise: bool = False
    limits: tuple[float, float] | None = None
    colours: str | None = None
    zoom: tuple[float, float, float, float] | None = None
    frame: str = TANK
    slice: str | None = None
    view: str = FLAT
    camera: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        style.quantity(self.field)
        if self.field == "role":
            for name, value in (("limits", self.limits), ("cmap", self.colours)):
                if value is not None:
                    raise CaseError(f"--{name} does not apply to the field role, whose colours are fixed: leave it out")
        if self.limits is not None:
            _check_order("--limits", *self.limits)
        if self.zoom is not None:
            _check_order("--zoom, along x", *self.zoom[:2])
            _check_order("--zoom, up", *self.zoom[2:])
        if self.slice is not None:
            parsed(self.slice)
        self._check_view()
        style.check_colours(self.colours)

    def _check_view(self) -> None:
        if self.view not in (FLAT, SOLID):
            raise CaseError(f"--view {text.shown(self.view)}: must be {FLAT} or {SOLID}")
        if self.view == SOLID:
            for name, given in (("slice", self.slice), ("zoom", self.zoom), ("surface", self.surface)):
                if given:
                    raise CaseError(f"--{name} does not apply to --view {SOLID}: leave out one of the two")
            if self.field == "role":
                raise CaseError(f"--field role does not apply to --view {SOLID}: show a slice")
        elif self.camera is not None:
            raise CaseError(f"--camera needs --view {SOLID}")
        if self.camera is not None and not (np.isfinite(self.camera).all() and abs(self.camera[1]) <= 90.0):
            raise CaseError(f"--camera {self.camera[0]:g} {self.camera[1]:g}: must be two angles in degrees, the "
                            "elevation from -90 to 90")


def _check_order(name: str, low: float, high: float) -> None:
    if not (np.isfinite([low, high]).all() and low < high):
        raise CaseError(f"{name}: {low:g} to {high:g} is not a range; give two numbers, the lower one first")


class ColouredView(ABC):
    """A view of snapshots of one run, coloured by a quantity. look : what is shown; own : units of the scene"""

    def __init__(self, scene: Case, look: Look) -> None:
        self.whole, self.look = scene, look
        self.quantity, self.own = style.quantity(look.field), style.scene_units(scene)
        if scene.dim == 2 and look.field == "velocity_z":
            raise CaseError("velocity_z exists in 3D only: velocity_y is the velocity upwards here")
        if look.normalise and self.own.time is None:
            raise CaseError("without constant gravity there is no sqrt(g H) to divide by")

    @abstractmethod
    def size(self, width: float = 8.0) -> tuple[float, float]:
        """Return the figure size [inch], with room for labels and colour bar."""

    @abstractmethod
    def draw(self, axes: "Axes", snapshot: Mapping[str, Any], limits: tuple[float, float] | None, label: bool = True,
             note: str = "") -> "ScalarMappable | None":
        """Draw one snapshot into axes; return what its colour bar shows, or None for roles.

        limits : (lowest, highest) of the colours; label : whether the title names the case; note : further text in it
        """

    @abstractmethod
    def _shown_values(self, snapshots: Sequence[Mapping[str, Any]]) -> Floats:
        """Return the finite values (n,) that are shown, of fluid and of walls with a pressure."""

    def values(self, snapshot: Mapping[str, Any]) -> Floats:
        """Return the quantity in the unit of the picture, (n,). Raises StoreError if it was not written."""
        needed = self.quantity.needs
        if needed not in snapshot:
            raise StoreError(f"{self.look.field} cannot be shown: the field {needed!r} was not written (see "
                             "Output.fields)")
        values = np.asarray(self.quantity.of(snapshot[needed]), dtype=float)
        return values * self._scale[0]

    def _walls_to_fill(self, snapshot: Mapping[str, Any]) -> Flags:
        """Return the wet wall particles, (n,) bool, which have a pressure and fill the gap of s/2 to the wall."""
        wet = (snapshot["kind"] == WALL) & (snapshot["role"] == WET)
        return wet if self.quantity.needs in ("p", "role") else np.zeros_like(wet)

    def limits(self, snapshots: Sequence[Mapping[str, Any]], whole: bool = False) -> tuple[float, float] | None:
        """Return the (lowest, highest) of the colours for all snapshots, None for roles.

        They are the user's, else those of most values, without a short impact or single spikes.

        whole : whether they reach the greatest value
        """
        if self.quantity.needs == "role":
            return None
        if self.look.limits is not None:
            low, high = self.look.limits
            return low, high
        values = np.sort(self._shown_values(snapshots))
        if len(values) < 3:
            return 0.0, 1.0
        spikes = min(-(-len(values) // 200), (len(values) - 1) // 2)  # at either end, one at least
        low, high = values[spikes], values[-1 if whole else -1 - spikes]
        centre = self.quantity.centre
        if centre is not None:
            reach = max(abs((values[0] if whole else low) - centre), abs(high - centre)) or 1.0
            return centre - reach, centre + reach
        if low > -0.05 * high:  # positive except for noise: start at zero
            low = 0.0
        return (low, high) if high > low else (low, low + 1.0)

    def add_colour_bar(self, picture: "FigureBase", axes: "Axes | Sequence[Axes]", shown: "ScalarMappable | None",
                       snapshots: Sequence[Mapping[str, Any]], place: Place = (1.02, 0.0, 0.025, 1.0)) -> None:
        """Add the colour bar of `shown`, with pointed ends if values exceed it; nothing for roles.

        axes : one, or a list; place : of the bar beside one, in shares of its size
        """
        if shown is None:
            return
        values = self._shown_values(snapshots)
        beyond = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
        low, high = shown.get_clim()
        extend = beyond[bool(np.any(values < low)), bool(np.any(values > high))]
        beside = ({"ax": axes, "aspect": 25, "pad": 0.02} if isinstance(axes, Sequence)
                  else {"cax": axes.inset_axes(place)})
        bar = picture.colorbar(shown, extend=extend, **beside)
        bar.set_label(self._scale[1])
        bar.ax.spines["outline"].set_linewidth(0.5)

    @cached_property
    def _scale(self) -> tuple[float, str]:
        """Factor of values in the unit of the picture, and label of the colour bar."""
        scale = getattr(self.own, self.quantity.scale) if self.quantity.scale else None
        if self.look.normalise and scale:
            by = {"pressure": r"(\rho g H)", "speed": r"\sqrt{gH}"}[self.quantity.scale]
            return 1.0 / float(scale), rf"{self.quantity.symbol}$\,/\,{by}$"
        factor, unit = style.with_prefix(scale or 0.0, self.quantity.unit)
        return factor, f"{self.quantity.symbol} [{unit}]" if unit else self.quantity.symbol
