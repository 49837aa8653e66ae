"""The style of pictures: quantities with labels, units and colours, and the units of a scene."""

import difflib
import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base import libraries
from parisph.base.arrays import Floats
from parisph.base.errors import CaseError, StoreError
from parisph.base.fields import BALLISTIC, CONTACT, DRY, INNER, SURFACE, WET
from parisph.base.paths import AnyPath
from parisph.base.text import clipped, plain, shown
from parisph.case.expressions import uniform_field
from parisph.case.schema import Case
from parisph.io.files import failing_as, replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import EllipseCollection
    from matplotlib.figure import Figure
    from matplotlib.patheffects import AbstractPathEffect


@dataclass(frozen=True)
class PlottedQuantity:
    """A quantity that pictures can show.

    needs : field in the registry; of : function of its array (n, ...) -> (n,)
    symbol, unit : for the colour bar; colours : name of a matplotlib colour map
    scale : the one of SceneUnits that makes it dimensionless, "" for none
    centre : in the middle of a diverging colour map, else None
    """

    needs: str
    of: Callable[..., Floats]
    symbol: str
    unit: str
    colours: str
    scale: str
    centre: float | None = None


# Sequential maps are perceptually uniform: equal steps look equal.
QUANTITIES = {
    "pressure": PlottedQuantity("p", lambda p: p, "pressure $p$", "Pa", "viridis", "pressure"),
    "speed": PlottedQuantity(
        "u", lambda u: np.linalg.norm(u, axis=1), r"speed $|\mathbf{u}|$", "m/s", "plasma", "speed"),
    "velocity_x": PlottedQuantity("u", lambda u: u[:, 0], "velocity $u$", "m/s", "RdBu_r", "speed", 0.0),
    "velocity_y": PlottedQuantity("u", lambda u: u[:, 1], "velocity $v$", "m/s", "RdBu_r", "speed", 0.0),
    "velocity_z": PlottedQuantity("u", lambda u: u[:, 2], "velocity $w$", "m/s", "RdBu_r", "speed", 0.0),
    "vorticity": PlottedQuantity("vorticity", lambda omega: omega, r"vorticity $\omega$", "1/s", "RdBu_r", "", 0.0),
    "density_ratio": PlottedQuantity("alpha", lambda a: a, r"kernel-sum density $\alpha$", "", "RdBu_r", "", 1.0),
    "role": PlottedQuantity("role", lambda r: r, "role", "", "", ""),
}
ALIASES = {"p": "pressure", "u": "speed", "velocity": "speed", "alpha": "density_ratio"}

# Roles of particles: name and colour. Brightnesses differ too, for readers with colour blindness.
ROLES = {
    INNER: ("inner", "#a6cee3"), SURFACE: ("free surface", "#d62728"), BALLISTIC: ("ballistic", "#ff9f1c"),
    WET: ("wet wall", "#4d4d4d"), DRY: ("dry wall", "#cfcfcf"), CONTACT: ("contact line", "#111111"),
}
WALL_COLOUR = "#333333"
# Colours of lines, also for colour blindness: those of Okabe & Ito without black and yellow, and three dark ones.
LINES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#332288", "#882255", "#5b3a00")
STYLES = ("-", (0, (6, 2)), (0, (6, 2, 1, 2)), (0, (2, 1.5)))  # full, dashed, dash-dotted, dotted
LineLook = dict[str, Any]    # {"color", "linestyle"} of a line

SCREEN = 90   # dots per inch of a picture in a notebook
FEW = 6     # most lines that differ only in colour


def line_looks(groups: int, members: int = 1) -> list[LineLook]:
    """Return a list of {"color", "linestyle"} for groups x members lines, member after member in each group.

    Up to FEW lines differ only in colour. More lines also differ in style: groups in colour and members in style if
    there are enough styles, else each line in both.
    """
    count = groups * members
    if 1 < members <= len(STYLES) and 1 < groups <= len(LINES):
        pairs = [(group, member) for group in range(groups) for member in range(members)]
    elif count <= FEW:
        pairs = [(number, 0) for number in range(count)]
    else:   # 9 colours and 4 styles have no common factor: 36 lines are all different
        pairs = [(number, number) for number in range(count)]
    return [{"color": LINES[colour % len(LINES)], "linestyle": STYLES[kind % len(STYLES)]} for colour, kind in pairs]


def quantity(name: str) -> PlottedQuantity:
    """Return the PlottedQuantity of a name. Raises CaseError with the known ones."""
    found = QUANTITIES.get(ALIASES.get(name, name))
    if found is None:
        raise CaseError(f"no quantity {shown(name)} to show (there are: {', '.join(QUANTITIES)})")
    return found


def check_colours(name: str | None) -> None:
    """Raise CaseError if matplotlib has no colour map of this name; None is allowed."""
    if name is None:
        return
    drawing()
    from matplotlib import colormaps

    if name not in colormaps:
        near = difflib.get_close_matches(name, list(colormaps), n=3) or ("viridis", "plasma", "RdBu_r")
        raise CaseError(f"no colour map {shown(name)} in matplotlib: try {', '.join(near)}")


@dataclass(frozen=True)
class SceneUnits:
    """The units of a scene; None for those that it does not have.

    length : height H of the fluid at the start [m], the depth of still water
    time : sqrt(H/g) [s]; speed : sqrt(g H) [m/s]; pressure : rho g H [Pa]
    """

    length: float
    time: float | None = None
    speed: float | None = None
    pressure: float | None = None


def scene_units(case: Case) -> SceneUnits:
    """Return the SceneUnits of a case."""
    low, high = case.fluid_bounds
    height, gravity = float(high[-1] - low[-1]), uniform_field(case.gravity)
    if gravity is None or not gravity.any():
        return SceneUnits(height)
    g = float(np.linalg.norm(gravity))
    return SceneUnits(height, np.sqrt(height / g), np.sqrt(g * height), case.density * g * height)


def literal(text: str, limit: int = 100) -> str:
    """Return a title or name for matplotlib, with escaped dollar signs."""
    return clipped(plain(text), limit).replace("$", r"\$")


def time_label(time: float, own: SceneUnits) -> str:
    """Return "t = 0.512 s", followed by the dimensionless time and its H if the scene has gravity."""
    label = rf"$t$ = {time:.3f} s"
    if own.time is None:
        return label
    return label + rf",   $t\sqrt{{g/H}}$ = {time / own.time:.2f},   {height(own)}"


def height(own: SceneUnits) -> str:
    """Return "H = 0.2 m", the length of the units of a scene."""
    return f"$H$ = {own.length:.4g} m"


def with_prefix(largest: float, unit: str) -> tuple[float, str]:
    """Return (factor, unit) that bring values up to `largest` to a readable size: 12000 Pa -> (1e-3, "kPa")."""
    if unit == "Pa" and largest >= 2000.0:
        return 1e-3, "kPa"
    if unit == "m" and 0.0 < largest < 0.02:
        return 1e3, "mm"
    return 1.0, unit


def halo(width: float = 2.0) -> "list[AbstractPathEffect]":
    """Return the path effects of a white edge [points], which makes text and lines visible on all colours."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=width, foreground="white")]


def drawing() -> ModuleType:
    """Return matplotlib's module `figure`. Raises MissingLibrary with a remedy."""
    libraries.require("matplotlib")
    from matplotlib import figure

    return figure


def new_figure(**how: Any) -> "Figure":
    """Return a new matplotlib Figure, which notebooks show as a picture. how : as of matplotlib's Figure"""
    return _shown_in_notebooks()(**how)


@cache
def _shown_in_notebooks() -> type["Figure"]:
    drawing()
    from matplotlib.figure import Figure

    class Shown(Figure):
        """A figure that notebooks show without pyplot."""

        def _repr_png_(self) -> bytes:
            drawn = io.BytesIO()
            self.savefig(drawn, format="png", dpi=SCREEN, bbox_inches="tight")
            return drawn.getvalue()

    return Shown


def written(unit: str) -> str:
    """Return a unit for pictures: m²/s for m^2/s."""
    return unit.replace("^2", "²").replace("^3", "³")


def discs(axes: "Axes", x: Floats, diameter: float, **how: Any) -> "EllipseCollection":
    """Draw discs at x (n, 2); x and diameter are in the units of the axes."""
    from matplotlib.collections import EllipseCollection

    size = np.full(len(x), diameter)
    drawn = EllipseCollection(size, size, np.zeros(len(x)), units="xy", offsets=x, offset_transform=axes.transData,
                              **{"linewidths": 0.0, **how})
    drawn.set_in_layout(False)
    axes.add_collection(drawn)
    return drawn


def save_small(picture: "Figure", path: AnyPath) -> None:
    """Write a figure as a PNG with 256 colours, half the size. Raises StoreError."""
    from PIL import Image  # matplotlib needs it

    drawn = io.BytesIO()
    picture.savefig(drawn, format="png", dpi=90, bbox_inches="tight")
    small = Image.open(drawn).convert("RGB").quantize(256)
    with failing_as(f"write the picture {path}"), replacing(path) as new:
        small.save(new, format="png", optimize=True)


def save(picture: "Figure", path: AnyPath | None, dpi: float = 150) -> None:
    """Write a figure to `path` (unless None), in the format of its ending. Raises CaseError, StoreError."""
    if path is None:
        return
    if not Path(path).suffix[1:]:    # matplotlib would add one
        raise CaseError(f"{path}: must end in a kind of picture, such as .png or .pdf")
    try:
        with replacing(path) as new:
            picture.savefig(new, dpi=dpi, bbox_inches="tight")
    except (OSError, ValueError) as error:
        raise StoreError(f"cannot write the picture {path}: {getattr(error, 'strerror', None) or error}") from None
