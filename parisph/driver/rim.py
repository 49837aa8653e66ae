"""Water that leaves an open tank or bed: over the rim it is removed and counted, through a wall it is an error."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from parisph.base.arrays import Flags, Floats
from parisph.base.errors import ParticleLost, agree
from parisph.base.fields import FLUID
from parisph.base.log import logger
from parisph.case.schema import Case
from parisph.geometry.build import scene_mesh
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.watch.sampling import Scene

OUTSIDE = 0.5    # spacings beyond a side wall, from where on water above the rim has left
BELOW = 1.0      # spacings below the rim that water may have fallen in the step that took it out


@dataclass
class Left:
    """What has left the tank over its rim since the start of the run; the same on all ranks.

    particles : number; volume [m^dim]; energy : kinetic and potential, when it left [J/m, J in 3D]
    """

    particles: int = 0
    volume: float = 0.0
    energy: float = 0.0


@dataclass
class OpenTank:
    """The rim of walls without a lid.

    Attributes
    ----------
    lower, upper : (dim,) corners of the box around the walls [m]
    rims : heights of the walls at its lower and its upper x [m]
    spacing, reach [m] : the second is how far behind a wall a particle is lost
    scene : for the energy
    left : Left
    """

    lower: Floats
    upper: Floats
    rims: tuple[float, float]
    spacing: float
    reach: float
    scene: Scene
    left: Left = field(default_factory=Left)

    @classmethod
    def of(cls, case: Case, domain: Domain, state: Mapping[str, Any] | None = None) -> "OpenTank | None":
        """Return the open tank of a case, None if it has none. state : the Left of a checkpoint, as a dict."""
        if case.walls is None or case.lidded:
            return None
        return cls(domain.lower, domain.upper, _rims(case, domain), case.numerics.spacing, domain.radius,
                   Scene.of(case), Left(**(state or {})))

    def let_leave(self, domain: Domain) -> None:
        """Remove the fluid that is out over the rim, and count it. Collective.

        Raises ParticleLost on every rank: a particle is behind a wall or below the bed, or all fluid has left.
        """
        p = domain.particles
        gone, lost = self._gone_and_lost(p)
        counts = np.array([gone.sum(), lost.sum(), np.count_nonzero(p.kind == FLUID)])
        if p.comm.size > 1:
            counts = p.comm.allreduce(counts)
        if counts[1]:
            agree(p.comm, self._loss(p, lost))
        if counts[0]:
            self._count(p, gone)
            domain.remove(gone)
            if counts[0] == counts[2]:
                raise ParticleLost("all water has left the tank over its rim; end the run earlier, "
                                   "or make the tank higher")

    def _gone_and_lost(self, p: Particles) -> tuple[Flags, Flags]:
        x, up = p.x, p.x[:, -1]
        beyond = np.maximum(self.lower[:-1] - x[:, :-1], x[:, :-1] - self.upper[:-1]).max(axis=1)
        rim = np.where(x[:, 0] < 0.5 * (self.lower[0] + self.upper[0]), *self.rims)
        gone = np.where(up >= rim, beyond > OUTSIDE * self.spacing, (beyond > 0.0) & (up > rim - BELOW * self.spacing))
        gone &= p.kind == FLUID
        lost = ~gone & ((beyond > self.reach) | (up < self.lower[-1] - self.reach))
        return gone, lost

    def _loss(self, p: Particles, lost: Flags) -> ParticleLost | None:
        which = np.flatnonzero(lost)
        if not len(which):
            return None
        more = f", and {len(which) - 1} more" if len(which) > 1 else ""
        return ParticleLost(f"particle {p.id[which[0]]} at {np.round(p.x[which[0]], 6).tolist()} m: outside the tank, "
                            f"but not over its rim{more}")

    def _count(self, p: Particles, gone: Flags) -> None:
        volume, u = p.volume[gone], p.u[gone]
        height = self.scene.gravity @ (volume.sum() * self.scene.lower - volume @ p.x[gone])
        mine = np.array([gone.sum(), volume.sum(), self.scene.density * (0.5 * (volume @ (u * u)).sum() + height)])
        particles, volume, energy = p.comm.allreduce(mine)
        if not self.left.particles and p.comm.rank == 0:
            logger.warning("water leaves the tank over its rim; it is removed and counted")
        self.left = Left(self.left.particles + int(particles), self.left.volume + float(volume),
                         self.left.energy + float(energy))


def _rims(case: Case, domain: Domain) -> tuple[float, float]:
    """Return the heights [m] at which walls end at the lower and at the upper x of the box around them at the start."""
    mesh = None if case.plain else scene_mesh(case)
    if mesh is None:
        return float(domain.upper[-1]), float(domain.upper[-1])
    x, s = mesh.x0[:, 0], case.numerics.spacing
    left, right = (float(mesh.x0[side, -1].max()) for side in (x < x.min() + s, x > x.max() - s))
    return left, right
