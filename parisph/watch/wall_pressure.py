"""Probes of the pressure on walls."""

from collections.abc import Iterator, Sequence

import numpy as np

from parisph.case import probes
from parisph.geometry.mesh import area_vectors
from parisph.geometry.probe_places import SIDES, tap_element
from parisph.kernels.tap import fitted_at_tap, tap_moments
from parisph.watch.sampling import WIDTH, OfPressure, Scene, View

FACE = 3.0    # radius [s] of the face of a tap: 2.1 and 2.6 follow an impact less well, 3.6 no better
FACING = 1e-6    # cosine between the normals of a tap and of a node of its wall; that of a sharp corner is small


class PressureTap(OfPressure):
    """Pressure on a wall, by least squares of a linear pressure on the wall particles within the radius.

    The weight is (1 - r^2/radius^2)^2. A dry wall has p = 0. Only the wall of the tap counts; in a corner, only
    the particles of both walls.
    """

    columns = {"pressure": "Pa"}

    def __init__(self, probe: probes.PressureTap, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.title = f"Pressure on the wall at ({', '.join(f'{a:g}' for a in probe.at)}) m"
        self.at = np.array(probe.at)
        self.radius = max(scene.spacing, probe.radius or FACE * scene.spacing)
        tolerance = 1e-6 * np.max(scene.upper - scene.lower)
        self.across = (np.abs(self.at - scene.lower) <= tolerance) | (np.abs(self.at - scene.upper) <= tolerance)
        self.axes = np.eye(scene.dim)    # the first across the wall
        self._start = None
        if scene.now is not None:
            self._begin(probe, scene.now)

    def _begin(self, probe, now):
        """Find the wall of the tap as it is at t = 0: then it and its nodes move with its body."""
        element = tap_element(now.mesh, now.walls, probe, self.scene.spacing)
        normal = area_vectors(now.mesh.corners()[[element]])[0]
        normal /= np.linalg.norm(normal)
        self.axes = np.array([normal, [-normal[1], normal[0]]])
        self.across = np.arange(2) == 0
        motions = np.array([body.motion for body in now.mesh.bodies])
        number = now.mesh.element_body[element]
        self._alike = np.flatnonzero(motions == motions[number])    # bodies that move as that of the tap does
        self._motion, self._start = now.motion_of(number), (self.at, self.axes)

    def place(self, time: float) -> None:
        if self._start is not None:
            at, axes = self._start
            self.at, self.axes = self._motion.placed(at[None], time)[0], self._motion.turned(axes, time)

    def _nodes(self, view):
        """Return positions (n, dim) [m] and pressures (n,) [Pa] of wall particles that may be of the wall of the tap.

        Where walls have elements, these face as the tap does, not as the other side of a plate, and move with it.
        """
        x, p = view.walls
        if self._start is None:
            return x, p
        normal, body = view.wall_faces
        own = (normal @ self.axes[0] > FACING) & np.isin(body, self._alike)
        return x[own], p[own]

    def sums(self, view: View) -> np.ndarray:
        x, p = self._nodes(view)
        return tap_moments(x, p, self.at, self.axes, self.across, 0.5 * self.scene.step, self.radius)

    def acting(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        return (fitted_at_tap(sums, 1 + np.count_nonzero(~self.across)),)


class DiscTap(PressureTap):
    """Mean of the pressure over the disc of a sensor, whose chords weight the places along the wall (2D).

    Between wall particles the pressure is linear; the integral is exact.
    """

    dims = (2,)

    def __init__(self, probe: probes.PressureTap, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.radius = 0.5 * probe.diameter
        self.title = f"{self.title}, mean over a disc of {probe.diameter:g} m"

    def sums(self, view: View) -> np.ndarray:
        return np.empty(0)

    def rows(self, view: View) -> np.ndarray:
        x, p = self._nodes(view)
        d = (x - self.at) @ self.axes.T
        near = (np.abs(d) < 0.5 * self.scene.step)[:, self.across].all(axis=1)
        near &= (np.abs(d) < self.radius + 1.5 * self.scene.step)[:, ~self.across].all(axis=1)
        rows = np.zeros((np.count_nonzero(near), WIDTH - 1))
        rows[:, 1], rows[:, 2] = d[near][:, ~self.across][:, 0], p[near]
        return rows

    def acting(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        return (disc_mean(rows[:, 1], rows[:, 2], self.radius),)


def pressure_tap(probe: probes.PressureTap, scene: Scene) -> PressureTap:
    """Return the sampler of a tap: a fit, or the mean over a disc."""
    return PressureTap(probe, scene) if probe.diameter is None else DiscTap(probe, scene)


def disc_mean(z: np.ndarray, p: np.ndarray, radius: float) -> float:
    """Return the mean of a piecewise linear p over a disc, 2 integral p sqrt(radius^2 - z^2) dz / (pi radius^2).

    z, p : (n,) places along a line from the centre [m], in any order, and values there. Where they do not reach, the
    disc does not count; nan if it does nowhere.
    """
    order = np.argsort(z)
    z, p = z[order], p[order]
    apart = np.diff(z) > 0.0
    low, high = (np.clip(end, -radius, radius) for end in (z[:-1][apart], z[1:][apart]))
    slope = np.diff(p)[apart] / np.diff(z)[apart]
    zero, first = (_chords(high, radius)[k] - _chords(low, radius)[k] for k in (0, 1))
    total = zero.sum()
    return float(((p[:-1][apart] - slope * z[:-1][apart]) @ zero + slope @ first) / total) if total > 0.0 else np.nan


def _chords(z, radius):
    """Antiderivatives of sqrt(radius^2 - z^2) and of z times that."""
    half = np.sqrt(np.maximum(radius**2 - z**2, 0.0))
    return 0.5 * (z * half + radius**2 * np.arcsin(np.clip(z / radius, -1.0, 1.0))), -(half**3) / 3.0


def force_columns(probe: probes.Force) -> dict[str, str]:
    """Return the columns of a Force, without those of `acted`."""
    columns = {"fx": "N/m", "fy": "N/m", "moment": "N m/m"}
    dynamic = {} if probe.still is None else {f"{name}_dynamic": unit for name, unit in columns.items()}
    return columns | dynamic


def about(probe: probes.Force) -> str:
    """Return the end of the title of a Force: the point of its moment, and what is in it."""
    found = f"({', '.join(f'{a:g}' for a in probe.about)}) m, with the hydrostatic part"
    return found if probe.still is None else f"{found}; dynamic: less that of water at rest up to y = {probe.still:g} m"


def at_rest(probe: probes.Force, scene: Scene, x: np.ndarray) -> np.ndarray:
    """Return the pressure (n,) [Pa] at x (n, 2) [m] of water at rest up to the still level; 0 above it."""
    return -scene.density * scene.gravity[-1] * np.maximum(probe.still - x[:, -1], 0.0)


class Force(OfPressure):
    """Force of the pressure on the walls of a tank alone, -sum p n A, and its moment about a point (2D).

    Each wall particle stands for a spacing of wall, and at the ends of a side for half of one: this is the trapezoidal
    rule, exact for the force by a pressure that is linear between particles. Dry walls have p = 0. Friction is not in
    it. The dynamic part is found by the same rule from the pressure less that of water at rest.
    """

    dims = (2,)

    def __init__(self, probe: probes.Force, scene: Scene) -> None:
        self.columns = force_columns(probe)
        super().__init__(probe, scene)
        self.about = np.array(probe.about)
        self._sides = [side for name, side in SIDES.items()
                       if (probe.side in (None, name)) and (scene.lid or name != "lid")]
        self.title = (f"Force of the pressure on the {probe.side or 'whole'}{' of the' * bool(probe.side)} {probe.on}, "
                      f"and its moment about {about(probe)}")

    def sums(self, view: View) -> np.ndarray:
        x, p = view.walls
        arm, pressures = x - self.about, [p]
        if self.probe.still is not None:
            pressures.append(p - at_rest(self.probe, self.scene, x))
        found = np.zeros((len(pressures), 3))
        for area in self._areas(x):
            for row, pressure in zip(found, pressures):
                force = -pressure[:, None] * area
                row += (*force.sum(axis=0), (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum())
        return found.ravel()

    def acting(self, sums: np.ndarray, rows: np.ndarray | None) -> np.ndarray:
        return sums

    def _areas(self, x: np.ndarray) -> Iterator[np.ndarray]:
        """Yield the area vectors (n, dim) [m], into the fluid, of wall particles at x (n, dim), for each side."""
        s = self.scene
        for axis, inward in self._sides:
            along = 1 - axis
            plane = (s.lower if inward > 0.0 else s.upper)[axis]
            on = np.abs(x[:, axis] - plane) < 0.5 * s.step[axis]
            steps = np.round(np.minimum(x[:, along] - s.lower[along], s.upper[along] - x[:, along]) / s.step[along])
            area = np.zeros_like(x)
            area[on, axis] = inward * s.step[along] * np.clip(steps[on] + 0.5, 0.0, 1.0)
            yield area
