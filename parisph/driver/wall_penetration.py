"""Fluid that has passed through a wall. This is an error: the flow would go on there unseen."""

import numpy as np

from parisph.base.arrays import Ints
from parisph.base.errors import ParticleLost, agree
from parisph.base.fields import FLUID
from parisph.geometry.distance import heights
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.parallel.wall_elements import WallElements

EVERY = 10     # steps between checks, few enough that the fluid is still near the wall it has passed
DEEP = 0.5     # depth behind a wall from which on fluid is lost [spacings]


def check(domain: Domain) -> None:
    """Raise ParticleLost on every rank if fluid is behind a wall that it is near. Collective."""
    elements = domain.elements
    if elements is None:
        return
    p = domain.particles
    near = np.flatnonzero((p.kind == FLUID) & (np.diff(elements.indptr)[: p.n_owned] > 0))
    deep = -heights(p.x[near], elements.corners, domain.radius) / elements.spacing
    lost = near[deep > DEEP]
    worst = deep.max(initial=0.0) if len(near) else 0.0
    agree(p.comm, _loss(p, elements, lost, worst) if len(lost) else None)


def _loss(p: Particles, elements: WallElements, lost: Ints, worst: float) -> ParticleLost:
    more = f", and {len(lost) - 1} more" if len(lost) > 1 else ""
    name = elements.name_near(p.x[lost[0]])
    return ParticleLost(f"particle {p.id[lost[0]]} at {np.round(p.x[lost[0]], 6).tolist()} m: in {name}, or behind it, "
                        f"by up to {worst:.2g} spacings{more}")
