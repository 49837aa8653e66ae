"""The pressure on a wall."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal, Optional

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Flags, Floats
from parisph.base.probe_rows import WIDTH
from parisph.base.text import point
from parisph.case import probe_checks
from parisph.case.bodies import Plate
from parisph.case.breadth import section_of
from parisph.case.probes import Measure, OfPressure
from parisph.case.scene import Scene
from parisph.geometry.distance import area_vectors, nearest, unit_normals
from parisph.geometry.mesh import WallMesh
from parisph.geometry.probe_places import Places
from parisph.geometry.solid import Wall
from parisph.watch.sampling import ProbeScene, View

RADIUS = 3.0    # [spacings] radius of the face of a tap: 2.1 and 2.6 follow an impact less well, 3.6 no better
FACING = 1e-6   # least cosine between the normals of a tap and a node of its wall; that at a sharp corner is small
TAP = 0.25      # [spacings] largest distance of a tap from its wall, as discs have flat elements
TIE = 1e-6      # [spacings] largest distance of walls at one place
LIFT = 0.1      # [spacings] distance in front of a wall at which its fluid is sought
FACE = 0.5      # [spacings] largest distance of nodes of the face from the plane of a tap
DRY = 1e-6      # largest pressure of a dry tap, over the greatest


class PressureTap(OfPressure):
    """Pressure [Pa] on a wall at the point `at` [m], which is its place at t = 0 and moves with a moving wall.

    It is the value there of a linear pressure fitted to the wall within `radius`, as of a sensor with a face. A single
    wall particle becomes wet within one step, and would show an impact too late and too abruptly. In 3D the face is
    round.

    diameter : [m] of a round sensor, for the mean over its disc instead: in 2D along the wall, weighted by the chords
        of the disc
    side : of a Plate, as seen along its points
    acted : whether to add the pressure that acts in the step, in the column pressure_acted

    A sample has the time for which its pressure is solved, the middle of a step; with method="SPH", the end. It is a
    mean in time, as of a Force.

    >>> PressureTap("P2", at=(2.0, 0.05), radius=0.0375, peak=True).peak
    True
    >>> PressureTap("P1", at=(3.22, 0.16), diameter=0.09).diameter
    0.09
    """

    columns = {"pressure": "Pa"}
    impacts = ("pressure",)
    quantity = "pressure $p$"

    kind: Literal["pressure_tap"] = Field(default="pressure_tap", init=False)
    at: Annotated[tuple[float, ...], Field(
        min_length=2, max_length=3, description="point (x, y) on a wall, in 3D (x, y, z) [m]")]
    radius: Optional[float] = Field(
        default=None, gt=0, description="radius of the face of the tap [m], at least one spacing; default 3 spacings")
    diameter: Optional[float] = Field(default=None, gt=0, description="diameter of the disc of the sensor [m]")
    side: Literal["left", "right"] | None = Field(default=None, description="side of a plate, as seen along its points")

    @model_validator(mode="after")
    def _one_face(self) -> "PressureTap":
        if self.radius is not None and self.diameter is not None:
            raise ValueError(f"radius = {self.radius:g} and diameter = {self.diameter:g}: give only one of them, a fit "
                             "over a stretch of wall or the mean over a disc")
        return self

    def title(self, scene: Any) -> str:
        disc = "" if self.diameter is None else f", mean over a disc of {self.diameter:g} m"
        return f"Pressure on the wall at {point(self.at)} m{disc}"

    def problems(self, case: Scene) -> Iterator[str]:
        """See Probe. `misplaced` checks whether it is on a wall."""
        if case.walls is None:
            yield "a pressure tap needs a wall; give walls=Tank(...) or leave the tap out"
        elif found := list(probe_checks.components(case, at=self.at)):
            yield from found
        elif self.diameter is not None and case.dim == 3:
            yield f"diameter = {self.diameter:g}: the disc of a sensor exists in 2D only; give a radius instead"

    def misplaced(self, places: Places) -> Iterator[str]:
        """See Probe: it is on the side of a wall that fluid can reach."""
        mesh, s = places.mesh, places.spacing
        if mesh is None:
            return
        walls = [places.bodies.get(body.name) for body in mesh.bodies]
        element = tap_element(mesh, walls, self, s)
        number = mesh.element_body[element]
        name, wall = mesh.bodies[number].name, walls[number]
        corners = mesh.corners()[[element]]
        apart, _, foot = nearest(np.array([self.at]), corners)
        normal = unit_normals(corners)[0]
        before = foot + LIFT * (s * normal + corners[0].mean(axis=0) - foot)    # off the other wall of a corner
        hidden = places.hidden(before[0])
        if apart[0] > TAP * s:
            near = ", ".join(f"{value:.6g}" for value in np.round(foot[0], 12) + 0.0)
            yield f"at = {self.at} is not on a wall; the nearest place on one is ({near}) on {name}"
        elif isinstance(wall, Plate) and self.side is None:
            yield (f'{name} has two sides; give side="left" or side="right", as seen along its points from '
                   f"{wall.points[0]} to {wall.points[-1]}")
        elif not isinstance(wall, Plate) and self.side is not None:
            yield f"side = {self.side!r}: only a plate has two sides, {name} has one; leave it out"
        elif hidden:
            yield f"at = {self.at} is behind {hidden[0]}, which no fluid reaches; move it"
        elif self.diameter is not None and not _on_face(mesh, element, foot[0], normal, 0.5 * self.diameter, s):
            yield (f"a disc of diameter = {self.diameter:g} around {self.at} does not lie on one wall; "
                   "move it away from the corner, or give a smaller one")

    def touched(self, values: Floats, case: Any, scene: Any) -> Iterator[tuple[str, Flags]]:
        """See Probe: also "emptied" if the water leaves it."""
        yield from super().touched(values, case, scene)
        if values[0, 0] > 0.0:
            yield "emptied", np.abs(values[0]) <= DRY * np.nanmax(np.abs(values[0]))

    def begin(self, scene: ProbeScene) -> "Tap":
        return Tap(self, scene) if self.diameter is None else DiscTap(self, scene)


class Tap(Measure):
    """Pressure on a wall, by least squares of a linear pressure on the wall particles within the radius.

    The weight is (1 - r^2/radius^2)^2. A dry wall has p = 0. Only the wall of the tap counts.
    """

    def __init__(self, probe: PressureTap, scene: ProbeScene) -> None:
        self.probe, self.scene, self.at = probe, scene, np.array(probe.at)
        self.radius = max(scene.spacing, probe.radius or RADIUS * scene.spacing)
        now = scene.now
        assert now is not None    # the tap is on a wall
        # the wall of the tap at t = 0; tap and nodes then move with its body
        element = tap_element(now.mesh, now.walls, probe, scene.spacing)
        normal = unit_normals(now.mesh.corners()[[element]])[0]
        self.axes = _axes(normal)
        self.across = np.arange(scene.dim) == 0
        motions = np.array([body.motion for body in now.mesh.bodies])
        number = now.mesh.element_body[element]
        self._alike = np.flatnonzero(motions == motions[number])    # bodies with the motion of that of the tap
        self._motion, self._start = now.motion_of(number), (self.at, self.axes)

    def _nodes(self, view: View) -> tuple[Floats, Floats]:
        """Update the place of the tap; return positions (n, dim) [m] and pressures (n,) [Pa] of nodes of its wall.

        These are wall particles that move with it and face as it does, unlike the other side of a plate.
        """
        x, p = view.walls
        at, axes = self._start
        self.at, self.axes = self._motion.placed(at[None], view.time)[0], self._motion.turned(axes, view.time)
        normal, body = view.wall_faces
        own = (normal @ self.axes[0] > FACING) & np.isin(body, self._alike)
        return x[own], p[own]

    def sums(self, view: View) -> Floats:
        from parisph.kernels.tap import tap_moments

        x, p = self._nodes(view)    # updates `at`
        found: Floats = tap_moments(x, p, self.at, self.axes, self.across, 0.5 * self.scene.step, self.radius)
        return found

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        from parisph.kernels.tap import fitted_at_tap

        return (fitted_at_tap(sums, 1 + np.count_nonzero(~self.across)),)


class DiscTap(Tap):
    """Mean of the pressure over the disc of a sensor (2D), exact for a linear pressure between wall particles."""

    def __init__(self, probe: PressureTap, scene: ProbeScene) -> None:
        super().__init__(probe, scene)
        self.radius = 0.5 * (probe.diameter or 0.0)

    def sums(self, view: View) -> Floats:
        return np.empty(0)

    def rows(self, view: View) -> Floats:
        x, p = self._nodes(view)
        d = (x - self.at) @ self.axes.T
        near = (np.abs(d) < 0.5 * self.scene.step)[:, self.across].all(axis=1)
        near &= (np.abs(d) < self.radius + 1.5 * self.scene.step)[:, ~self.across].all(axis=1)
        rows = np.zeros((np.count_nonzero(near), WIDTH))
        rows[:, 1], rows[:, 2] = d[near][:, ~self.across][:, 0], p[near]
        return rows

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        return (disc_mean(rows[:, 1], rows[:, 2], self.radius),)


def tap_element(mesh: WallMesh, walls: Sequence[Wall | None], probe: PressureTap, spacing: float) -> int:
    """Return the number of the element of a tap at t = 0.

    It is on the given side of a plate, and on a moving wall if that is at the same place as another. walls : the bodies
    of the mesh, None for a Surface
    """
    at, corners, allowed = np.array([probe.at]), mesh.corners(), np.ones(len(mesh.elements), dtype=bool)
    for number, wall in enumerate(walls):
        if isinstance(wall, Plate) and probe.side is not None:
            own = np.flatnonzero(mesh.element_body == number)
            allowed[own] = _on_left(corners[own], np.array(wall.points)) == (probe.side == "left")
    allowed = np.flatnonzero(allowed)
    moving = allowed[np.array([body.motion > 0 for body in mesh.bodies])[mesh.element_body[allowed]]]
    apart, element, _ = nearest(at, corners[allowed])
    first, moves, _ = nearest(at, corners[moving], within=apart[0] + TIE * spacing)
    return int(moving[moves[0]] if np.isfinite(first[0]) else allowed[element[0]])


def _on_left(corners: Floats, points: Floats) -> Flags:
    """Return whether elements (M, dim, dim) of a plate are on its left side, as seen along its points, (M,) bool."""
    piece = nearest(section_of(corners.mean(axis=1)), np.stack([points[:-1], points[1:]], axis=1))[1]
    along, normal = np.diff(points, axis=0)[piece], section_of(area_vectors(corners))
    found: Flags = normal[:, 1] * along[:, 0] - normal[:, 0] * along[:, 1] > 0.0
    return found


def _axes(normal: Floats) -> Floats:
    """Return axes (dim, dim) of a wall: its normal (dim,), and one or two unit vectors along it."""
    if len(normal) == 2:
        return np.array([normal, [-normal[1], normal[0]]])
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return np.array([normal, first, np.cross(normal, first)])


def _on_face(mesh: WallMesh, element: int, at: Floats, normal: Floats, radius: float, spacing: float) -> bool:
    """Return whether the wall is flat, within FACE, up to the radius [m] on both sides of a place on it."""
    corners, along = mesh.corners() - at, np.array([-normal[1], normal[0]])
    motion = np.array([body.motion for body in mesh.bodies])[mesh.element_body]
    own = (np.abs(corners @ normal) < FACE * spacing).all(axis=1) & (area_vectors(corners) @ normal > 0.0)
    ends = np.sort((corners @ along)[own & (motion == motion[element])], axis=1)
    low = high = 0.0
    for _ in range(len(ends)):    # extend by adjoining elements
        joined = (ends[:, 0] <= high + TIE * spacing) & (ends[:, 1] >= low - TIE * spacing)
        if not joined.any() or (ends[joined, 0].min() >= low and ends[joined, 1].max() <= high):
            break
        low, high = min(low, ends[joined, 0].min()), max(high, ends[joined, 1].max())
    return bool(min(high, -low) >= radius - TIE * spacing)


def disc_mean(z: Floats, p: Floats, radius: float) -> float:
    """Return the mean of a piecewise linear p over a disc, 2 integral p sqrt(radius^2 - z^2) dz / (pi radius^2).

    z, p : (n,) places along a line from the centre [m], in any order, and values there. Only the part of the disc
        between them counts; nan without one
    """
    order = np.argsort(z)
    z, p = z[order], p[order]
    apart = np.diff(z) > 0.0
    low, high = (np.clip(end, -radius, radius) for end in (z[:-1][apart], z[1:][apart]))
    slope = np.diff(p)[apart] / np.diff(z)[apart]
    zero, first = (_chords(high, radius)[k] - _chords(low, radius)[k] for k in (0, 1))
    total = zero.sum()
    return float(((p[:-1][apart] - slope * z[:-1][apart]) @ zero + slope @ first) / total) if total > 0.0 else np.nan


def _chords(z: Floats, radius: float) -> tuple[Floats, Floats]:
    """Return the antiderivatives of sqrt(radius^2 - z^2) and of z sqrt(radius^2 - z^2)."""
    half = np.sqrt(np.maximum(radius**2 - z**2, 0.0))
    return 0.5 * (z * half + radius**2 * np.arcsin(np.clip(z / radius, -1.0, 1.0))), -(half**3) / 3.0
