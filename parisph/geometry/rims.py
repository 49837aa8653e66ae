"""Where water leaves a scene: over the ends of its container, and over the tops of wavemakers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from parisph.base.arrays import Flags, Floats
from parisph.case.bodies import Body, Flap, Piston, Profile
from parisph.case.motion import AtRest, Motion
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.case.shapes import Tank
from parisph.geometry.extrusion import front_top
from parisph.geometry.solid import Wall, solid_of
from parisph.geometry.spans import container, scene_walls, spans

OUTSIDE = 0.5    # spacings beyond a side wall: farther water above the rim has left
BELOW = 1.0      # spacings below the rim to which water may fall in the step in which it leaves


@dataclass(frozen=True)
class Rim:
    """The box around the Tank, else all Profiles, else all bodies; or the half-space in front of a wavemaker.

    motion : of the container; lower, upper : (dim,) corners at rest [m]; left, right : heights of its sides [m], -inf
    where water may leave at any height; spacing : [m]; reach : [m] behind a wall, beyond which a point is lost
    front : height of front and back [m], in 3D
    """

    motion: Motion
    lower: Floats
    upper: Floats
    left: float
    right: float
    spacing: float
    reach: float = np.inf
    front: float = np.inf

    def out(self, x: Floats, t: float) -> tuple[Flags, Flags]:
        """Return which points x (n, dim) [m] have left over the rim at a time [s], and which are lost behind a wall."""
        if not isinstance(self.motion, AtRest):    # to the frame of the container
            x = self.motion.taken_back(x, t)
        if self._within(x):    # most steps
            return np.zeros(len(x), bool), np.zeros(len(x), bool)
        up = x[:, -1]
        sides = np.maximum(self.lower[:-1] - x[:, :-1], x[:, :-1] - self.upper[:-1])
        beyond = sides.max(axis=1)
        rim = np.where(x[:, 0] < 0.5 * (self.lower[0] + self.upper[0]), self.left, self.right)
        if x.shape[1] == 3:
            rim = np.where(sides[:, 1] > sides[:, 0], self.front, rim)
        gone: Flags = np.where(up >= rim, beyond > OUTSIDE * self.spacing,
                               (beyond > 0.0) & (up > rim - BELOW * self.spacing))
        behind: Flags = (beyond > self.reach) | (up < self.lower[-1] - self.reach)
        if not np.isfinite(self.left):
            return gone | behind, np.zeros_like(gone)
        return gone, ~gone & behind

    def _within(self, x: Floats) -> bool:
        """Return whether no point x (n, dim) [m] is beyond a side, or more than `reach` below the lower corner."""
        if not len(x):
            return True
        for column, low, high in zip(x.T[:-1], self.lower, self.upper):    # numpy is slow along a short last axis
            if not (column.min() >= low and column.max() <= high):
                return False
        return bool(x[:, -1].min() >= self.lower[-1] - self.reach)


def rims_of(case: Scene, reach: float) -> tuple[Rim, ...]:
    """Return the Rim of the container of the water, none without walls or under a lid, and those of wavemakers.

    reach : [m] behind a wall, beyond which a point is lost; it does not apply behind wavemakers, where it is dry
    """
    bodies, s = dict(zip(body_names(case.bodies), case.bodies)), case.numerics.spacing
    pairs = [(wall, bodies[wall.name]) for wall in scene_walls(case) if wall.name in bodies]
    held: tuple[Rim, ...] = () if case.walls is None or case.lidded else (_holder(pairs, s, reach),)
    if case.dim == 3:
        held = tuple(_across(case, rim) for rim in held)
    # water may flow around a wavemaker that does not reach across a 3D scene
    return *held, *(_face(body, float(wall.bounds[1][-1]), s, case.dim) for wall, body in pairs
                    if isinstance(body, (Piston, Flap)) and body.extent is None)


def _across(case: Scene, rim: Rim) -> Rim:
    """Return the Rim of a 3D scene from that of its section."""
    (front, back), walls = case.breadth or (0.0, 0.0), [wall for span in spans(case) for wall in span.walls]
    top = front_top(case, [wall for wall in walls if wall.motion == container(case).motion])
    return replace(rim, lower=np.insert(rim.lower, 1, front), upper=np.insert(rim.upper, 1, back), front=top)


def _holder(pairs: Sequence[tuple[Wall, Body]], spacing: float, reach: float) -> Rim:
    holders = next(filter(None, ([wall for wall, body in pairs if isinstance(body, kind)] for kind in (Tank, Profile))),
                   None)
    walls = holders or [wall for wall, _ in pairs]
    resting = [wall for wall in walls if isinstance(wall.motion, AtRest)]
    motion = resting[0].motion if resting else walls[0].motion
    x = np.concatenate([solid_of(wall).points for wall in walls if wall.motion == motion])
    lower, upper = x.min(axis=0), x.max(axis=0)
    left, right = (float(x[side, -1].max()) if holders else -np.inf
                   for side in (x[:, 0] < lower[0] + spacing, x[:, 0] > upper[0] - spacing))
    return Rim(motion, lower, upper, left, right, spacing, reach)


def _face(maker: Piston | Flap, top: float, spacing: float, dim: int) -> Rim:
    far = np.full(dim, np.inf)
    place = np.array([maker.place] + (dim - 1) * [np.inf if maker.fluid_on_left else -np.inf])
    lower, upper = (-far, place) if maker.fluid_on_left else (place, far)
    return Rim(maker.moved, lower, upper, top, top, spacing)
