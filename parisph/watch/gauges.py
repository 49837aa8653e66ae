"""Probes of where the water is: surface gauges, columns, the front and the run-up."""

from collections.abc import Sequence

import numpy as np

from parisph.case import probes
from parisph.kernels.water_columns import BODY, HEIGHT, TOP, Column, column_rows
from parisph.watch.elevation import COLUMN, bodies, surface_height
from parisph.watch.sampling import WIDTH, Sampler, Scene, View

# Lengths in spacings.
GAUGE_GAP = 1.5     # air under a gauge: more than this between one particle and the next above it
STRETCH = 1.25      # more than that above a particle inside the fluid: under the crest of a steep wave they lie apart
COLUMN_GAP = 2.1    # air in a column: falling water stretches, in the dam break to 1.6, beside a wall to 2.2
BED = 2.0           # water on the bed is as near to it as this
BED_GAP = 2.1       # and reaches from one particle to the next, as far as gradients do
NODES = 4.0         # surface particles that may serve a gauge

ROUNDING = 1.0 + 1e-9


class _Column(Sampler):
    """Bodies of water in the column at x = `at`.

    Above a particle inside the fluid is water: there a body may have gaps that are longer by `stretch`. Water below a
    floor, such as an obstacle that does not stand on the bed, is no part of the water on it.
    """

    columns = {"y": "m"}
    gap, stretch = GAUGE_GAP, STRETCH
    beside = -1.0    # spacings to either side of `at` within which surface particles serve, too; negative for none

    def __init__(self, probe, scene, at):
        super().__init__(probe, scene)
        self.at = at
        self.floors = scene.floors_at(at, 0.0)

    def place(self, time: float) -> None:
        if self.scene.now is not None and self.scene.now.moving:
            self.floors = self.scene.floors_at(self.at, time)

    def rows(self, view: View) -> np.ndarray:
        p, s = view.particles, self.scene.spacing
        column = Column(self.at, COLUMN * s * ROUNDING, self.beside * s, self.gap * s, self.stretch * s)
        return column_rows(p.x, p.kind, p.role, column, self.floors)

    def top(self, rows: np.ndarray) -> tuple[float, bool]:
        """Return the height of the water on the highest floor on which some stands [m], and whether there is any.

        That is the lowest floor where all are dry. Without walls it is the top of the largest body, nan without one.
        """
        s, floors = self.scene.spacing, self.floors.tolist()
        for number in range(len(floors), -1 if not floors else 0, -1):
            found, tops = self._standing(rows, number)
            if not len(found) or (number and found[0, 0] > floors[number - 1] + BED_GAP * s):
                continue
            low, end, _ = found[0] if number else found[np.argmax(found[:, 2])]
            return float(tops[(tops >= low) & (tops <= end)].max()), True
        return (floors[0] if floors else np.nan), False

    def _standing(self, rows, number):
        """Return the bodies (n, 3) above so many floors, from the rows of all ranks, and the tops of their parts."""
        own = rows if not number else rows[np.searchsorted(self.floors, rows[:, 1], side="right") == number]
        return bodies_of_all(own[own[:, 0] == BODY], self.gap * self.scene.spacing), own[own[:, 0] == TOP, 1]


class ColumnHeight(_Column):
    """Height of the topmost particle of the water that stands on the bed within 1.5 spacings of x = `at`.

    Surface particles of the lattice lie on the surface: nothing is added to their height. Air of
    more than 2.1 spacings ends the column; above a particle inside the fluid, of 3.35. A dry bed gives the height of
    the bed.
    """

    gap = COLUMN_GAP

    def __init__(self, probe: probes.ColumnHeight, scene: Scene) -> None:
        super().__init__(probe, scene, probe.at)
        self.title = f"Height of the water column at x = {probe.at:g} m"

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        return (self.top(rows)[0],)


class SurfaceGauge(_Column):
    """Height of the free surface above x = `at`: a smooth fit if the surface is smooth.

    See surface.surface_height. Where the surface breaks, the value is that of ColumnHeight; on a dry
    bed it is the height of the bed.
    """

    dims = (2,)
    beside = NODES

    def __init__(self, probe: probes.SurfaceGauge | probes.RunUp, scene: Scene, at: float | None = None) -> None:
        super().__init__(probe, scene, probe.at if at is None else at)
        self.title = f"Height of the free surface above x = {self.at:g} m"
        self.mirrors = self._mirrors(0.0)

    def _mirrors(self, time):
        return [side for side in self.scene.sides_at(time) if abs(side - self.at) < NODES * self.scene.spacing]

    def place(self, time: float) -> None:
        super().place(time)
        if self.scene.now is not None and self.scene.now.moving:
            self.mirrors = self._mirrors(time)

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        height = rows[:, 0] == HEIGHT
        top, wet = self.top(rows[~height])
        if not height.any() or not wet:
            return (top,)
        return (surface_height(self.at, rows[height, 1], rows[height, 2], top, self.scene.spacing, self.mirrors),)


class WaterFront(Sampler):
    """Foremost x of the water on the bed that is connected to its main body.

    On the bed: within 2 spacings of it. The main body is the largest that has no gap of more than
    2.1 spacings along x, so that a droplet ahead is not the front. Without a tank the same of all
    the fluid.
    """

    columns = {"x": "m"}

    def __init__(self, probe: probes.WaterFront, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.title = ("Position of the water's foremost particle along the bed" if scene.tank or scene.mesh is not None
                      else "Foremost position of the fluid")

        self._time = 0.0

    def place(self, time: float) -> None:
        self._time = time

    def rows(self, view: View) -> np.ndarray:
        x, y = view.body
        bed = self.scene.bed_at(x, self._time)
        if bed is not None:
            x = x[y <= bed + BED * self.scene.spacing * ROUNDING]
        return body_rows(bodies(x, BED_GAP * self.scene.spacing))

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        found = bodies_of_all(rows, BED_GAP * self.scene.spacing)
        return (found[np.argmax(found[:, 2]), 1] if len(found) else np.nan,)


def body_rows(found: np.ndarray) -> np.ndarray:
    """Return bodies (n, 3) of this rank as rows for all."""
    rows = np.empty((len(found), WIDTH - 1))
    rows[:, 0], rows[:, 1:] = BODY, found
    return rows


def bodies_of_all(rows: np.ndarray, gap: float) -> np.ndarray:
    """Return the bodies (n, 3) that those of all ranks are together."""
    if len(rows) < 2:    # as for most gauges in most steps
        return rows[:, 1:]
    return bodies(rows[:, 1], gap, counts=rows[:, 3], ends=rows[:, 2])
