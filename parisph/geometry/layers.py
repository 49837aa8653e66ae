"""The fluid at the start of a 3D scene: layers across, each filled like the 2D scene of its section.

Layers lie in the planes of wall nodes (geometry.spans), the first one a step from the front. A body of fluid with ends
between these planes has planes of its own, with points on its ends, like a Box between the points of its tank in 2D.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.case.breadth import section_of
from parisph.case.fluids import Fluid
from parisph.case.lattice import FIT
from parisph.case.scene import Scene
from parisph.case.sections import cuts, fluids_across, section
from parisph.geometry.fill import CUT, EDGE, ROUNDING, Filling, filling_of
from parisph.geometry.mesh import wall_mesh
from parisph.geometry.planes import lifted
from parisph.geometry.quadrature import fluid_area
from parisph.geometry.quadrature import samples as samples_of
from parisph.geometry.raised import lowered, raised
from parisph.geometry.scene_cache import cached
from parisph.geometry.solid import Wall, in_fluid
from parisph.geometry.spans import divided, spans
from parisph.geometry.standing import standing

FINE = 4    # pieces per spacing of the quadrature, in each direction


@dataclass(frozen=True)
class Layer:
    """One layer of a body of fluid.

    y : its plane [m]; step : the distance [m] of layers there; size : the thickness [m] of the fluid nearest to it
    fluid, fill : of the section; walls : of the section, with those half a spacing to both sides
    bounds : corners (2,) [m] of a box around the fluid in the section
    """

    y: float
    step: float
    size: float
    fluid: Fluid
    fill: Filling
    walls: tuple[Wall, ...]
    bounds: tuple[Floats, Floats]

    def raised(self, x: Floats) -> tuple[Floats, Floats]:
        """See geometry.raised.raised. x : (n, 2) [m]"""
        return raised(self.fluid, wall_mesh(self.walls, self.fill.spacing) if self.walls else None, self.bounds, x)

    def stretch(self, x: Floats) -> Floats:
        """Return the stretch (n,) at points x (n, 2) [m]."""
        return self.raised(x)[1]


class LayeredFilling:
    """The lattice points that one body of fluid fills in 3D. It has what a Filling has, for (n, 3) [m].

    case : the scene; number : of the body of fluid

    layers : its layers, in the order of y; step : (3,) [m], in the middle; count : number of points
    even : whether they lie on the lattice of the tank as the only wall, or there is no wall
    """

    def __init__(self, case: Scene, number: int) -> None:
        self.case, self.number, self.spacing = case, number, case.numerics.spacing
        whole, own = case.breadth, case.extent_of(case.fluids[number])
        assert whole is not None and own is not None
        self.shape, self._walled = case.fluids[number].shape, bool(case.bodies)
        self._ends = (max(own[0], whole[0]), min(own[1], whole[1])) if self._walled else own
        self._planes, fits = _planes(case, self._ends)
        self.layers = self._layers()
        self._before = np.concatenate([[0], np.cumsum([layer.fill.count for layer in self.layers])])
        self.count = self._total = int(self._before[-1])    # a RoomFilling leaves some of them out
        self.even = fits and all(layer.fill.even for layer in self.layers)
        middle = self.layers[len(self.layers) // 2]
        self.step = np.insert(middle.fill.step, 1, middle.step)
        slack = EDGE * self.spacing    # a shape that reaches a wall reaches beyond it
        self._from = -np.inf if self._walled and self._ends[0] <= whole[0] + slack else self._ends[0] - slack
        self._to = np.inf if self._walled and self._ends[1] >= whole[1] - slack else self._ends[1] + slack

    def _layers(self) -> list[Layer]:
        y, (low, high) = self._planes, self._ends
        whole = self.case.breadth
        assert whole is not None
        inside = np.ones(len(y), dtype=bool)
        if self._walled:    # the planes of front and back belong to the walls
            inside = (y > whole[0] + ROUNDING * self.spacing) & (y < whole[1] - ROUNDING * self.spacing)
        if not inside.any():
            inside[len(y) // 2] = True
        gaps = np.diff(y) if len(y) > 1 else np.array([self.spacing])
        steps = 0.5 * (np.append(gaps, gaps[-1]) + np.insert(gaps, 0, gaps[0]))
        own = y[inside]
        edges = np.concatenate([[low], 0.5 * (own[1:] + own[:-1]), [high]])
        return [_layer(self.case, self.number, *numbers) for numbers in zip(
            own.tolist(), steps[inside].tolist(), np.diff(edges).tolist())]

    def indices(self, start: int = 0, stop: int | None = None) -> Ints:
        """Return the lattice indices (n, 3) of points start to stop: along x, of the layer, upwards."""
        stop = min(self._total if stop is None else stop, self._total)
        found = [np.empty((0, 3), np.int64)]
        first = int(np.searchsorted(self._before, start, side="right")) - 1
        for number in range(max(first, 0), len(self.layers)):
            low, high = self._before[number:number + 2].tolist()
            if low >= stop:
                break
            index = self.layers[number].fill.indices(max(start - low, 0), min(stop, high) - low)
            found.append(np.insert(index, 1, number, axis=1))
        return np.concatenate(found)

    def position(self, index: Ints) -> Floats:
        """Return the positions (n, 3) [m] of lattice indices (n, 3)."""
        y = np.array([layer.y for layer in self.layers])[index[:, 1]]
        return lifted(self._each(index[:, 1], lambda layer, own: layer.fill.position(index[own][:, [0, 2]]), 2), y)

    def moved(self, index: Ints) -> tuple[Floats, Floats]:
        """Return the positions (n, 3) [m] of lattice indices (n, 3) below the raised surface, and the stretch (n,)."""
        x, at = self.position(index), index[:, 1]

        def stretched(layer: Layer, own: Ints) -> Floats:
            places, factor = layer.raised(section_of(x[own]))
            return np.concatenate([places, factor[:, None]], axis=1)
        found = self._each(at, stretched, 3)
        return lifted(found[:, :2], x[:, 1]), found[:, 2]

    def cell(self, index: Ints) -> Floats:
        """Return the volume (n,) [m3] of the lattice cells of indices (n, 3)."""
        found: Floats = np.array([layer.step * layer.fill.step.prod() for layer in self.layers])[index[:, 1]]
        return found

    def cells(self, index: Ints) -> Floats:
        """Return the volume (n,) [m3] of a Box nearest to each of its points (n, 3), without other shapes."""
        sizes: Floats = np.array([layer.size for layer in self.layers])[index[:, 1]]
        return sizes * self._each(index[:, 1], lambda layer, own: layer.fill.cells(index[own][:, [0, 2]])[:, None],
                                  1)[:, 0]

    def is_surface(self, index: Ints, others: "Sequence[LayeredFilling]" = ()) -> Flags:
        """Return which of the filled indices (n, 3) have a neighbour along an axis outside the fluid, (n,) bool."""
        free, fills = np.zeros(len(index), dtype=bool), {self, *others}
        for axis in (0, 2):
            for side in (-1, 1):
                beside = index.copy()
                beside[:, axis] += side
                free |= ~_held(fills, self.position(beside))
        x = self.position(index)
        steps = np.array([layer.step for layer in self.layers])[index[:, 1]]
        for way in (-1.0, 1.0):
            free |= ~_held(fills, x + way * steps[:, None] * np.array([0.0, 1.0, 0.0]))
        return free

    def holds(self, x: Floats, lower: bool = False) -> Flags:
        """Return which points x (n, 3) [m] lie in the shape or on its edge, whatever the walls, (n,) bool.

        lower : whether x are places in raised fluid (geometry.raised)
        """
        found = (x[:, 1] >= self._from) & (x[:, 1] <= self._to)
        at = self._nearest(x[found, 1])
        flat = section_of(x[found])
        found[found] = self._each(at, lambda layer, own: layer.fill.holds(
            lowered(layer.fluid, flat[own]) if lower else flat[own])[:, None], 1)[:, 0] > 0.0
        return found

    def samples(self, lower: Floats, upper: Floats, box: tuple[Floats, Floats]) -> Iterator[tuple[Floats, Floats]]:
        """Yield sample places (m, 3) [m] of the raised fluid in a part of the scene, and the volume (m,) [m3] of each.

        lower, upper : (3,) [m], corners of the part; box : of the whole scene
        """
        for y, thickness, layer in self._slices(FINE):
            if not lower[1] <= y < upper[1]:
                continue
            for places, area in samples_of(layer.fill, section_of(box[0]), section_of(box[1]),
                                           (float(lower[0]), float(upper[0])), FINE):
                places, factor = layer.raised(places)
                near = (places[:, 1] >= lower[2]) & (places[:, 1] < upper[2])
                yield lifted(places[near], y), (area * factor)[near] * thickness

    def volume(self, box: tuple[Floats, Floats]) -> float:
        """Return the volume [m3] of the fluid. box : corners (3,) [m] of the scene"""
        fine = FINE if _varies(self.case.fluids[self.number]) else None
        low, high = map(section_of, box)
        found = 0.0
        for _, thickness, layer in self._slices(fine):
            found += thickness * fluid_area(layer.fill, low, high, layer.stretch)
        return found

    def _slices(self, fine: int | None) -> Iterator[tuple[float, float, Layer]]:
        """Yield middle and thickness [m] of slices across the fluid, `fine` in a spacing, and the fluid there."""
        low, high = self._ends
        ends = [low, *(cut for cut in cuts(self.case, fluids=True).tolist() if low < cut < high), high]
        for a, b in zip(ends, ends[1:]):
            many = 1 if fine is None else max(int(np.ceil((b - a) * fine / self.spacing - 1e-9)), 1)
            for k in range(many):
                y = a + (k + 0.5) * (b - a) / many
                yield y, (b - a) / many, _layer(self.case, self.number, y, 0.0, 0.0, True)

    def _nearest(self, y: Floats) -> Ints:
        planes = np.array([layer.y for layer in self.layers])
        found: Ints = np.searchsorted(0.5 * (planes[1:] + planes[:-1]), y)
        return found

    def _each(self, at: Ints, asked: Callable[[Layer, Ints], Array], columns: int) -> Floats:
        """Return rows (n, columns) of numbers for points in the layers `at` (n,), asked of one layer of each kind."""
        found = np.empty((len(at), columns))
        kinds: dict[int, list[int]] = {}
        for number in np.unique(at).tolist():
            kinds.setdefault(id(self.layers[number].fill), []).append(number)
        for numbers in kinds.values():
            own = np.flatnonzero(np.isin(at, numbers))
            found[own] = asked(self.layers[numbers[0]], own)
        return found


def _held(fills: set["LayeredFilling"], x: Floats) -> Flags:
    found: Flags = np.any([fill.holds(x) for fill in fills], axis=0)
    return found


@cached(4)
def layered(case: Scene) -> tuple[LayeredFilling, ...]:
    """Return the LayeredFilling of each body of fluid of a 3D scene. Cached."""
    return tuple(LayeredFilling(case, number) for number in range(len(case.fluids)))


def _cuts(case: Scene) -> list[float]:
    """Return the cuts [m] between parts with different walls."""
    found: list[float] = cuts(case)[1:-1].tolist() if case.bodies else []
    return found


def _planes(case: Scene, ends: tuple[float, float]) -> tuple[Floats, bool]:
    """Return the planes (m,) [m] of the layers between the ends of a body of fluid, and whether walls have them."""
    s = case.numerics.spacing
    if not case.bodies:
        return divided(*ends, s), True
    walls = np.unique(np.concatenate([span.layers for span in spans(case)]))
    near = [float(walls[np.argmin(np.abs(walls - end))]) for end in ends]
    fits = [abs(end - place) <= FIT * s for end, place in zip(ends, near)]
    low, high = (place if fit else end for end, place, fit in zip(ends, near, fits))
    breaks = [low, *(cut for cut in _cuts(case) if low < cut < high), high]
    found = []
    for a, b in zip(breaks, breaks[1:]):
        known = all(np.abs(walls - end).min() <= FIT * s for end in (a, b))
        found.append(walls[(walls >= a) & (walls <= b)] if known else divided(a, b, s))
    return np.unique(np.concatenate(found)), all(fits)


def _varies(fluid: Fluid) -> bool:
    """Return whether the elevation of a fluid may vary across."""
    return isinstance(fluid.elevation, str)


def _layer(case: Scene, number: int, y: float, step: float, size: float, between: bool = False) -> Layer:
    """Return a layer of a body of fluid.

    between : only walls and fluid at y itself, not within half a spacing
    """
    s = case.numerics.spacing
    near = [cut for cut in _cuts(case) if abs(cut - y) < (CUT - ROUNDING) * s and not between]
    walls: tuple[Wall, ...] = ()
    if case.bodies:
        at = near[0] if near else y
        span = next((span for span in spans(case) if span.lower < at < span.upper), None)
        walls = span.walls if span is not None else standing(section(case, at, at))
    ends = [case.extent_of(fluid) for fluid in case.fluids]
    room = 0.0 if between else CUT * s
    here = [k for k, end in enumerate(ends) if k == number or end is not None and end[0] - room < y < end[1] + room]
    fluids = tuple(_fluid_at(case, k, y) for k in here)
    own = fluids[here.index(number)]
    return Layer(y, step, size, own, filling_of(fluids, here.index(number), walls, s), walls,
                 section(case, y, y).bounds_of(own))


def _fluid_at(case: Scene, number: int, y: float) -> Fluid:
    """Return a body of fluid in the section at y [m], or at its end if that is nearer to it."""
    low, high = case.extent_of(case.fluids[number]) or (y, y)
    at = min(max(y, low), high)
    return section(case, at, at).fluids[fluids_across(case, at, at).index(number)]


def in_front(case: Scene, x: Floats) -> Flags:
    """Return which points x (n, 3) [m] lie in front of all walls of a 3D scene, (n,) bool."""
    found = np.zeros(len(x), dtype=bool)
    behind = np.zeros(len(x), dtype=bool)
    for span in spans(case):
        there = np.flatnonzero((x[:, 1] >= span.lower) & (x[:, 1] <= span.upper))
        free = in_fluid(span.walls, section_of(x[there]))
        found[there] |= free
        behind[there] |= ~free    # on a cut, both parts count
    whole = case.breadth
    assert whole is not None
    return found & ~behind & (x[:, 1] > whole[0]) & (x[:, 1] < whole[1])
