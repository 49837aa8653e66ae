"""The volume of water that passes lines, from the path of each particle in every step (2D)."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.communicator import Communicator
from parisph.base.fields import FLUID
from parisph.case.probes import Probe, singles
from parisph.case.schema import Case

if TYPE_CHECKING:    # a case is described without MPI and numba
    from parisph.parallel.particles import Particles


class Passages:
    """The volume that has passed each line of a scene since its start.

    A particle passes a line if its path from the start to the end of a step crosses it, whatever moves the particle. So
    errors do not accumulate: the sum is the volume on the other side.

    case : probes with a `line` count, also in arrays; state : volumes of an earlier part of the run
    """

    def __init__(self, case: Case, comm: Communicator, state: Mapping[str, float] | None = None) -> None:
        self._lines = {_key(probe): np.array(probe.line, float) for _, probe in singles(case.probes) if probe.line}
        self._comm = comm
        before = state if state and comm.rank == 0 else {}
        self._counted = {key: float(before.get(key, 0.0)) for key in self._lines}

    def look(self, particles: "Particles") -> None:
        """Add the volumes that have passed in the last step. Not collective."""
        if not self._lines:
            return
        fluid = particles.kind == FLUID
        before, after, volume = (field.compress(fluid, axis=0) for field in
                                 (particles.x0, particles.x, particles.volume))
        for key, line in self._lines.items():
            self._counted[key] += passed(line, before, after, volume)

    def mine(self, probe: Probe) -> float:
        """Return the volume that has passed a line on this rank [m2]; add up those of all ranks. Not collective."""
        return self._counted[_key(probe)]

    def state(self) -> dict[str, float]:
        """Return {line: volume so far [m2]}, the same on all ranks. Collective."""
        return {key: float(self._comm.allreduce(counted)) for key, counted in self._counted.items()}


def _key(probe: Probe) -> str:
    return " to ".join(map(str, probe.line or ()))


def passed(line: Floats, before: Floats, after: Floats, volume: Floats) -> float:
    """Return the volume that passes a line [m2]: positive from its left to its right, seen from its first point.

    line : (2, 2) points [m]; before, after : (n, 2) places of particles [m]; volume : (n,) [m2]
    """
    start, along = line[0], line[1] - line[0]
    first, last = (along[0] * (x[:, 1] - start[1]) - along[1] * (x[:, 0] - start[0]) for x in (before, after))
    own = np.flatnonzero((first >= 0.0) != (last >= 0.0))    # a place on the line belongs to its left: counted once
    first, last = first[own], last[own]
    crossing = before[own] + (first / (first - last))[:, None] * (after[own] - before[own])
    share = (crossing - start) @ along / (along @ along)
    inside = (share >= 0.0) & (share <= 1.0)
    return float(np.where(first >= 0.0, volume[own], -volume[own]) @ inside)
