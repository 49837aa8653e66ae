"""The frame of a picture: that of the tank, in which the flow is computed, or that of the room."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.case.expressions import uniform_field
from parisph.case.motion import AtRest, Motion, Rotation, Spatial
from parisph.case.motion.spatial import pose_of
from parisph.case.schema import Case

TANK, WORLD = "tank", "world"
BETWEEN = 100    # times between the first and the last picture at which the place of the tank is computed


@dataclass(frozen=True)
class PictureFrame:
    """The frame of a picture. motion : of the tank; world : whether the frame is the room

    gravity : (dim,) in the room, None if not uniform; dim : of the flow
    """

    motion: Motion
    world: bool
    gravity: Floats | None = None
    dim: int = 2

    @classmethod
    def of(cls, case: Case, frame: str) -> "PictureFrame":
        """Return the frame "tank" or "world" of a case. Raises CaseError for another word."""
        if frame not in (TANK, WORLD):
            raise CaseError(f"--frame {frame}: must be {TANK} or {WORLD}")
        if frame == WORLD and isinstance(case.frame, Spatial):
            raise CaseError(f"--frame {WORLD}: the tank turns out of the plane of the picture ({case.frame.kind}); use "
                            f"--frame {TANK}")
        return cls(case.frame, frame == WORLD, uniform_field(case.gravity), case.dim)

    @property
    def moved(self) -> bool:
        """Whether places differ from those in the frame of the tank."""
        return self.world and not isinstance(self.motion, AtRest)

    def placed(self, x: Floats, time: float) -> Floats:
        """Return places (n, 2) [m] of the tank's frame in this frame at a time [s]."""
        return self.motion.placed(x, time) if self.moved else np.asarray(x)

    def snapshot(self, snapshot: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a snapshot with places and velocities in this frame."""
        if not self.moved:
            return snapshot
        time = snapshot["time"]
        found = {**snapshot, "x": self.placed(snapshot["x"], time)}
        if "u" in snapshot:
            found["u"] = self.motion.turned(snapshot["u"], time) + self.motion.velocity_at(found["x"], time)
        return found

    def course(self, corners: Floats, times: Floats) -> list[Floats]:
        """Return corners (n, 2) [m] in this frame at times (k,) [s] and between them."""
        if not self.moved:
            return [np.asarray(corners)]
        between = np.linspace(np.min(times), np.max(times), BETWEEN) if np.ptp(times) else times[:0]
        return [self.placed(corners, float(t)) for t in (*times, *between)]

    def note(self, time: float) -> str:
        """Return the frame and the place of the tank at a time [s] as text; "" for a tank at rest."""
        if isinstance(self.motion, AtRest):
            return ""
        if isinstance(self.motion, Spatial):
            turn = np.clip(0.5 * (np.trace(pose_of(self.motion, time).turn) - 1.0), -1.0, 1.0)
            return f"tank's frame, turned {np.rad2deg(np.arccos(turn)):.1f}\N{DEGREE SIGN}"
        value = self.motion.law(time)[0]
        if isinstance(self.motion, Rotation):
            angle = np.rad2deg(value)
            way = "anticlockwise" if angle > 0.0 else "clockwise"
            where = f"turned {abs(angle):.1f}\N{DEGREE SIGN}" + (f" {way}" if abs(angle) >= 0.05 else "")
        else:
            along = self.motion.placed_by(np.zeros((1, self.dim)), value)[0] + 0.0
            where = f"moved by ({', '.join(f'{part:.3g}' for part in along)}) m"
        return f"seen from the room, tank {where}" if self.world else f"tank's frame, {where}"

    def down(self, time: float) -> Floats | None:
        """Return the direction (2,) of gravity at a time [s] in the frame of a tank that turns, else None."""
        if self.world or self.gravity is None or not isinstance(self.motion, Rotation) or not self.gravity.any():
            return None
        seen: Floats = self.motion.seen(self.gravity[None, :2], time)[0]
        return seen / float(np.linalg.norm(seen))
