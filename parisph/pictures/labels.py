"""Names in a picture, which overlap neither each other nor, if there is room, lines."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.pictures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text

SIZE = 7.5    # [points] size of letters
APART = 3.0    # [points] distance of a name from its object
ROWS = 4    # most rows of names of lines below the upper end of the axes
STEP = 3.0    # [pixels] distance of points on a line that names avoid


@dataclass(frozen=True)
class Label:
    """A name with its possible places.

    places : (n, 2) in the units of the axes, the best one first; of a line, its lower and its upper end
    line : whether it names a vertical line, and is placed beside its upper end
    """

    text: str
    places: Floats
    line: bool = False


def add(axes: "Axes", labels: Sequence[Label], lines: Sequence[Floats] = (), dots: Floats | None = None) -> None:
    """Write names into axes when these are drawn, and the size of names is known.

    Names without room are left out, and a text says how many.

    lines : (n, 2) each, dots : (n, 2), in the units of the axes, which names avoid
    """
    from matplotlib.artist import Artist

    how: dict[str, Any] = {"fontsize": SIZE, "zorder": 6, "path_effects": style.halo()}
    texts = [axes.text(0.0, 0.0, style.literal(label.text, 40), transform=None, **how) for label in labels]
    left_out = axes.text(0.0, 0.0, "", transform=None, **how)
    for text in (*texts, left_out):
        text.set_in_layout(False)

    class Placer(Artist):
        """Places the names just before they are drawn."""

        def draw(self, renderer: Any) -> None:
            _place(axes, labels, texts, left_out, lines, dots, renderer)

    placer = Placer()
    placer.set_in_layout(False)
    placer.set_zorder(-1.0)
    axes.add_artist(placer)


def _place(axes: "Axes", labels: Sequence[Label], texts: Sequence["Text"], left_out: "Text", lines: Sequence[Floats],
           dots: Floats | None, renderer: Any) -> None:
    """Place all names; if some have no room, repeat this with a text that says how many are left out."""
    pixels = renderer.points_to_pixels(1.0)
    box = axes.get_window_extent(renderer)
    inside = np.array([box.x0, box.y0, box.x1, box.y1]) + pixels * np.array([1.0, 1.0, -1.0, -1.0])
    along = _sampled([axes.transData.transform(line) for line in lines])
    radius, there = 2.5 * pixels, axes.transData.transform(dots) if dots is not None and len(dots) else ()
    taken = [np.concatenate([x - radius, x + radius]) for x in there]
    left_out.set(text="")
    missing = _put(axes, labels, texts, inside, along, list(taken), pixels, renderer)
    if missing:
        left_out.set(text=f"and {len(texts)} more names", position=inside[[2, 1]], ha="right", va="bottom")
        corner = left_out.get_window_extent(renderer)
        taken.append(np.array([corner.x0, corner.y0, corner.x1, corner.y1]))
        missing = _put(axes, labels, texts, inside, along, taken, pixels, renderer)
        left_out.set_text(f"and {missing} more name{'s' * (missing != 1)}")


def _put(axes: "Axes", labels: Sequence[Label], texts: Sequence["Text"], inside: Floats, along: Floats,
         taken: list[Floats], pixels: float, renderer: Any) -> int:
    """Put each name at the place without overlap that crosses the fewest lines; return the number without a place."""
    missing = 0
    for label, text in zip(labels, texts):
        text.set(rotation=0.0, visible=True)
        extent = text.get_window_extent(renderer)
        best = None
        for corner, turned in _candidates(axes.transData.transform(label.places), label.line, extent.width,
                                          extent.height, APART * pixels, inside):
            size = (extent.height, extent.width) if turned else (extent.width, extent.height)
            own = np.array([*corner, corner[0] + size[0], corner[1] + size[1]])
            if not (np.all(own[:2] >= inside[:2]) and np.all(own[2:] <= inside[2:])) or any(
                    _overlap(own, other) for other in taken):
                continue
            crossed = int(np.sum(np.all((along > own[:2]) & (along < own[2:]), axis=1)))
            if best is None or crossed < best[0]:
                best = crossed, own, turned
            if crossed == 0:
                break
        if best is None:
            text.set_visible(False)
            missing += 1
            continue
        _, own, turned = best
        taken.append(own + 0.5 * pixels * np.array([-1.0, -1.0, 1.0, 1.0]))
        text.set(position=own[:2], ha="left", va="bottom", rotation=90.0 if turned else 0.0)
    return missing


def _candidates(places: Floats, line: bool, width: float, height: float, apart: float,
                inside: Floats) -> Iterator[tuple[tuple[float, float], bool]]:
    """Yield (lower left corner [pixels], whether it is vertical) of possible places of a name."""
    if line:
        x, top = places[-1, 0], min(places[-1, 1], inside[3])
        rows = top - height * np.arange(1, ROWS + 1) - apart
        for left in (False, True):
            for turned in (False, True):
                across = -apart - (height if turned else width) if left else apart
                for y in ((top - width - apart,) if turned else rows):
                    yield (x + across, y), turned
        return
    for x, y in places:
        for across in (apart, -apart - width):
            yield (x + across, y - 0.5 * height), False
        for up in (apart, -apart - height):
            for across in (-0.5 * width, apart, -apart - width):
                yield (x + across, y + up), False


def _sampled(lines: Sequence[Floats]) -> Floats:
    """Return points (n, 2) along lines, STEP pixels apart."""
    found = [np.empty((0, 2))]
    for line in lines:
        for a, b in zip(line[:-1], line[1:]):
            if np.isfinite([a, b]).all():
                many = min(max(int(np.linalg.norm(b - a) / STEP), 1), 2000)
                found.append(a + np.linspace(0.0, 1.0, many + 1)[:, None] * (b - a))
    return np.concatenate(found)


def _overlap(a: Floats, b: Floats) -> bool:
    return bool(a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3])
