"""Fluid that has got into a solid or behind a wall: an error, as it would go on unseen there."""

import numpy as np

from parisph.base.arrays import Ints
from parisph.base.errors import ParticleLost, agree
from parisph.base.fields import FLUID
from parisph.geometry.distance import heights
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.parallel.wall_elements import WallElements

EVERY = 10     # steps from one look to the next: fluid is still near the wall that it has gone through
DEEP = 0.5     # spacings behind a wall, from where on fluid is lost


def find(domain: Domain) -> None:
    """Look for fluid behind the walls that it is near, of any shape. Collective.

    Raises ParticleLost on every rank. Only particles with elements in their lists are looked at.
    """
    elements = domain.elements
    p = domain.particles
    near = np.flatnonzero((p.kind == FLUID) & (np.diff(elements.walls.indptr)[: p.n_owned] > 0))
    deep = -heights(p.x[near], elements.walls.corners, domain.radius) / elements.spacing
    lost = near[deep > DEEP]
    worst = deep.max(initial=0.0) if len(near) else 0.0
    agree(p.comm, _loss(p, elements, lost, worst) if len(lost) else None)


def _loss(p: Particles, elements: WallElements, lost: Ints, worst: float) -> ParticleLost:
    more = f", and {len(lost) - 1} more" if len(lost) > 1 else ""
    name = elements.name_near(p.x[lost[0]])
    return ParticleLost(f"particle {p.id[lost[0]]} at {np.round(p.x[lost[0]], 6).tolist()} m: in {name}, or behind it, "
                        f"by up to {worst:.2g} spacings{more}")
