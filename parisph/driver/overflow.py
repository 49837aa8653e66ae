"""Water that leaves an open tank or bed: over the rim it is removed and counted, through a wall it is an error."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from parisph.base.arrays import Flags
from parisph.base.errors import ParticleLost, agree
from parisph.base.fields import FLUID
from parisph.base.log import logger
from parisph.case.schema import Case
from parisph.geometry.rims import Rim, rims_of
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.parallel.sums import sums
from parisph.watch.sampling import ProbeScene


@dataclass
class Overflow:
    """Fluid that has left the tank over its rim since the start of the run; the same on all ranks.

    particles : number; volume [m^dim]; energy : kinetic and potential, at the time of leaving [J/m, J in 3D]
    """

    particles: int = 0
    volume: float = 0.0
    energy: float = 0.0


@dataclass
class OpenTank:
    """The rims over which water may leave a scene.

    rims : of the container of the water, and of wavemakers, behind which it is dry; scene : for the energy
    """

    rims: tuple[Rim, ...]
    scene: ProbeScene
    left: Overflow = field(default_factory=Overflow)

    @classmethod
    def of(cls, case: Case, domain: Domain, state: Mapping[str, Any] | None = None) -> "OpenTank | None":
        """Return the OpenTank of a case, or None. state : the Overflow of a checkpoint, as a dict."""
        rims = rims_of(case, domain.radius)
        return cls(rims, ProbeScene.of(case), Overflow(**(state or {}))) if rims else None

    def let_leave(self, domain: Domain, time: float = 0.0) -> None:
        """Remove and count the fluid that has left over the rim at a time [s]. Collective.

        Raises ParticleLost on every rank: a particle is behind a wall or below the bed, or all fluid has left.
        """
        p = domain.particles
        gone, lost = self._gone_and_lost(p, time)
        n_gone, n_lost = sums(p.comm, np.count_nonzero(gone), np.count_nonzero(lost))
        if n_lost:
            agree(p.comm, self._loss(p, lost))
        if n_gone:
            left, = sums(p.comm, np.count_nonzero((p.kind == FLUID) & ~gone))
            self._count(p, gone)
            domain.remove(gone)
            if not left:
                raise ParticleLost("all water has left the tank over its rim; end the run earlier, "
                                   "or make the tank higher")

    def _gone_and_lost(self, p: Particles, time: float) -> tuple[Flags, Flags]:
        fluid, (gone, lost) = p.kind == FLUID, np.any([rim.out(p.x, time) for rim in self.rims], axis=0)
        return gone & fluid, lost & ~gone & fluid

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
        self.left = Overflow(self.left.particles + int(particles), self.left.volume + float(volume),
                             self.left.energy + float(energy))
