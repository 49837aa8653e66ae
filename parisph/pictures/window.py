"""The window of a picture of the flow, without spray, and its vertical scale."""

from collections.abc import Iterable, Sequence

import numpy as np

from parisph.base.arrays import Flags, Floats

FLAT = 5.5    # largest width over height of a picture; flatter windows are stretched vertically
SLENDER = 3.0    # largest height over width of a window; narrower ones get room on both sides
FEW = 0.01    # largest share of the particles that is spray
GAP, SHARE = 4.0, 0.1    # least gap before spray, in spacings and as a share of the extent of the fluid
Box = tuple[Floats, Floats]    # lower and upper corner (2,)
Ends = tuple[tuple[float, float], tuple[float, float]]    # (left, right), (low, high)


def bulk(x: Floats, spacing: float) -> Box:
    """Return the box around the fluid without its spray, which is a few particles beyond a wide gap.

    x : (n, 2) [m] of fluid particles, n > 0; spacing [m]
    """
    lower, upper = x.min(axis=0), x.max(axis=0)
    few = max(int(FEW * len(x)), 1)
    for axis in range(2):
        line = np.sort(x[:, axis])
        low, high = np.quantile(line, (FEW, 1.0 - FEW))
        wide = np.flatnonzero(np.diff(line) > max(GAP * spacing, SHARE * (high - low)))
        beyond = wide[len(line) - 1 - wide <= few]
        before = wide[wide + 1 <= few]
        upper[axis] = line[beyond[0]] if len(beyond) else line[-1]
        lower[axis] = line[before[-1] + 1] if len(before) else line[0]
    return lower, upper


def shown(x: Floats, spacing: float, walls: Box | None) -> Flags:
    """Return whether fluid particles are shown, (n,) bool: those in the bulk of the fluid or within the walls."""
    finite: Flags = np.isfinite(x).all(axis=1)
    if not finite.any():
        return finite
    boxes = [bulk(x[finite], spacing), *([walls] if walls is not None else [])]
    found: Flags = finite & np.any([_inside(x, *box) for box in boxes], axis=0)
    return found


def of(fluid: Iterable[Floats], walls: Sequence[Floats], length: float = 1.0) -> Ends:
    """Return the ends of axes around all points, with a margin.

    fluid : particles (n, 2) [m] each; walls : corners (m, 2) [m] each; length : unit of the axes [m]
    """
    points = np.concatenate([x for x in (*fluid, *walls) if len(x)] or [np.array([[0.0, 0.0], [1.0, 1.0]])])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = np.minimum(0.03 * np.max(high - low), 0.12 * (high - low))
    margin[0] = max(margin[0], 0.5 * ((high - low)[1] / SLENDER - (high - low)[0]))
    low, high = (low - margin) / length, (high + margin) / length
    return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def corners(box: Box) -> Floats:
    """Return the corners (4, 2) of a box, anticlockwise."""
    (left, low), (right, high) = box
    return np.array([(left, low), (right, low), (right, high), (left, high)])


def outside(x: Floats, window: Ends) -> int:
    """Return the number of points (n, 2) outside a window, all in one unit."""
    (left, right), (low, high) = window
    return int(np.sum(~_inside(x, np.array([left, low]), np.array([right, high]))))


def stretch(window: Ends) -> int:
    """Return the vertical scale over the horizontal one, more than 1 for a flat scene."""
    (left, right), (low, high) = window
    return max(1, round((right - left) / (high - low) / FLAT)) if high > low else 1


def said(times: int) -> str:
    """Return the words for a stretched picture, else ""."""
    return f"vertical scale x{times}" if times > 1 else ""


def _inside(x: Floats, lower: Floats, upper: Floats) -> Flags:
    with np.errstate(invalid="ignore"):
        found: Flags = np.all((x >= lower) & (x <= upper), axis=1)
        return found
