"""Velocity of free-slip walls."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import WALL
from parisph.kernels import gradient
from parisph.methods import lengths

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


def write_wall_velocity(flow: "Flow", shear: Floats, later: float = 0.0) -> None:
    """Write the velocity of owned walls: normal part from the wall, tangential part from the fluid. Not collective.

    No-slip walls have their own velocity. Ghosts keep theirs until the field "u" is updated.

    shear : (n_owned, dim) [1/s] of Flow.wall_shear; later : time [s] after that of the walls' stored velocity
    """
    p = flow.particles
    own = p.wall_u if flow.slides else np.zeros_like(p.u)
    moved = flow.walls.acceleration(flow) if later else None
    if moved is not None:
        own = own + later * moved
    gradient.wall_velocity(p.u_all, flow.cloud, own, shear, lengths.WALL * flow.spacing)
    if p.dim == 3:
        gradient.slip_along_edges(p.u_all, flow.cloud, own, lengths.WALL * flow.spacing)
    if flow.sticks:
        sticky = (p.kind == WALL) & (p.no_slip == 1)
        p.u[sticky] = own[sticky]
