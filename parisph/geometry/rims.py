"""Where water leaves a scene: the ends of what holds it, and the upper ends of wavemakers."""

from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Flags, Floats
from parisph.case.bodies import Flap, Piston, Profile
from parisph.case.motion import AtRest, Motion
from parisph.case.scene import Scene
from parisph.case.shapes import Tank
from parisph.geometry.solid import solid_of
from parisph.geometry.standing import standing

OUTSIDE = 0.5    # spacings beyond a side wall, from where on water above the rim has left
BELOW = 1.0      # spacings below the rim that water may have fallen in the step that took it out


@dataclass(frozen=True)
class Rim:
    """The box around what holds the water: the Tank, or else all Profiles, or else all bodies, off which it runs.

    motion : how it moves; lower, upper : (dim,) corners at rest [m]; left, right : heights at which it ends there [m],
    -inf where water may leave at any height
    """

    motion: Motion
    lower: Floats
    upper: Floats
    left: float
    right: float

    def out(self, x: Floats, t: float, spacing: float, reach: float) -> tuple[Flags, Flags]:
        """Return which points x (n, dim) [m] are out over the rim at a time [s], and which are lost behind a wall.

        reach : [m] behind a wall, from where on a point is lost
        """
        if not isinstance(self.motion, AtRest):    # as seen in what holds the water
            x = self.motion.placed_by(x, -self.motion.law(t)[0])
        if self._within(x, reach):    # as in most steps
            return np.zeros(len(x), bool), np.zeros(len(x), bool)
        up = x[:, -1]
        beyond = np.maximum(self.lower[:-1] - x[:, :-1], x[:, :-1] - self.upper[:-1]).max(axis=1)
        rim = np.where(x[:, 0] < 0.5 * (self.lower[0] + self.upper[0]), self.left, self.right)
        gone = _over(up, rim, beyond, spacing)
        behind: Flags = (beyond > reach) | (up < self.lower[-1] - reach)
        if not np.isfinite(self.left):
            return gone | behind, np.zeros_like(gone)
        return gone, ~gone & behind

    def _within(self, x: Floats, reach: float) -> bool:
        """Return whether no point x (n, dim) [m] is beyond a side, or more than `reach` [m] below the lower corner."""
        if not len(x):
            return True
        for column, low, high in zip(x.T[:-1], self.lower, self.upper):    # numpy is slow along a short last axis
            if not (column.min() >= low and column.max() <= high):
                return False
        return bool(x[:, -1].min() >= self.lower[-1] - reach)


@dataclass(frozen=True)
class Face:
    """The face of a wavemaker: motion, place [m] at rest, top [m], and whether the fluid is at smaller x."""

    motion: Motion
    place: float
    top: float
    fluid_on_left: bool

    def out(self, x: Floats, t: float, spacing: float) -> Flags:
        """Return which points x (n, 2) [m] have gone over its top at a time [s]."""
        x = self.motion.placed_by(x, -self.motion.law(t)[0])
        beyond = (x[:, 0] - self.place) * (1.0 if self.fluid_on_left else -1.0)
        return _over(x[:, 1], self.top, beyond, spacing)


def _over(up: Floats, top: Floats | float, beyond: Floats, spacing: float) -> Flags:
    """Return which points at heights `up` (n,) [m] and so far beyond a side (n,) [m] are out over its top [m]."""
    gone: Flags = np.where(up >= top, beyond > OUTSIDE * spacing, (beyond > 0.0) & (up > top - BELOW * spacing))
    return gone


def rim_of(case: Scene) -> Rim | None:
    """Return the Rim of a scene, None without walls or under a lid."""
    if case.walls is None or case.lidded:
        return None
    pairs = list(zip(standing(case), case.bodies))
    holders = next(filter(None, ([wall for wall, body in pairs if isinstance(body, kind)] for kind in (Tank, Profile))),
                   None)
    walls = holders or [wall for wall, _ in pairs]
    resting = [wall for wall in walls if isinstance(wall.motion, AtRest)]
    motion = resting[0].motion if resting else walls[0].motion
    x = np.concatenate([solid_of(wall).points for wall in walls if wall.motion == motion])
    lower, upper, s = x.min(axis=0), x.max(axis=0), case.numerics.spacing
    left, right = (float(x[side, -1].max()) if holders else -np.inf
                   for side in (x[:, 0] < lower[0] + s, x[:, 0] > upper[0] - s))
    return Rim(motion, lower, upper, left, right)


def faces_of(case: Scene) -> tuple[Face, ...]:
    """Return the faces of the wavemakers of a scene."""
    return tuple(Face(body.moved, body.place, float(wall.bounds[1][-1]), body.fluid_on_left)
                 for wall, body in zip(standing(case), case.bodies) if isinstance(body, (Piston, Flap)))
