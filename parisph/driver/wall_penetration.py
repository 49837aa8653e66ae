"""Fluid that has passed through a wall, which is an error."""

import numpy as np

from parisph.base.arrays import Ints
from parisph.base.errors import ParticleLost, agree
from parisph.kernels import nearest_walls
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.parallel.wall_elements import WallElements

EVERY = 10     # steps between checks: fluid must still be near the wall that it has passed
DEEP = 0.5     # spacings: fluid deeper behind a wall is lost


def check(domain: Domain) -> None:
    """Raise ParticleLost on every rank if fluid is behind a nearby wall. Collective."""
    elements = domain.elements
    p = domain.particles
    depth = np.empty(p.n_owned)
    nearest_walls.depths(depth, p.cloud(domain.indptr, domain.indices, elements.spacing), elements.walls)
    worst = depth.max(initial=0.0) / elements.spacing
    lost = np.flatnonzero(depth > DEEP * elements.spacing) if worst > DEEP else np.zeros(0, np.int64)
    agree(p.comm, _loss(p, elements, lost, worst) if len(lost) else None)


def _loss(p: Particles, elements: WallElements, lost: Ints, worst: float) -> ParticleLost:
    more = f", and {len(lost) - 1} more" if len(lost) > 1 else ""
    name = elements.name_near(p.x[lost[0]])
    return ParticleLost(f"particle {p.id[lost[0]]} at {np.round(p.x[lost[0]], 6).tolist()} m: in {name}, or behind it, "
                        f"by up to {worst:.2g} spacings{more}")
