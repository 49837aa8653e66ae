"""The volume of water that passes lines, in 3D rectangles, from the path of each particle in every step."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.base.communicator import Communicator
from parisph.base.fields import FLUID
from parisph.case.probes import singles
from parisph.case.schema import Case

Across = tuple[Floats, Floats, tuple[float, float]]

if TYPE_CHECKING:    # a case is described without MPI and numba
    from parisph.parallel.particles import Particles


@dataclass(frozen=True)
class Gate:
    """A straight line (2D), or a rectangle with a line in one plane and the third coordinate across it (3D).

    start, end : of the line (2,) [m]; axes : of the plane of the line; third : the other axis; across : ends along it
    [m], None for no ends
    """

    start: tuple[float, ...]
    end: tuple[float, ...]
    axes: tuple[int, int] = (0, 1)
    third: int = -1
    across: tuple[float, float] | None = None

    @property
    def key(self) -> str:
        """Its name in a checkpoint."""
        line = f"{self.start} to {self.end}"
        return line if self.third < 0 else f"{line} along {self.axes}, across {self.across}"

    def passed(self, before: Floats, after: Floats, volume: Floats) -> float:
        """Return the volume [m^dim] of particles (n,) that passes on the way from `before` to `after` (n, dim) [m]."""
        line = np.array([self.start, self.end], float)
        if self.third < 0:
            return passed(line, before, after, volume)
        axes = list(self.axes)
        across = None if self.across is None else (before[:, self.third], after[:, self.third], self.across)
        return passed(line, before[:, axes], after[:, axes], volume, across)

    def near(self, x: Floats, reach: float) -> tuple[Ints, Floats, Floats]:
        """Return the points x (n, dim) [m] within `reach` [m] of it: numbers, distances [m]; and its normal (dim,)."""
        along = np.subtract(self.end, self.start)
        length = float(np.hypot(*along))
        along /= length
        across, off = np.array([along[1], -along[0]]), x[:, list(self.axes)] - self.start
        away, share = np.abs(off @ across), off @ along
        beside = (away < reach) & (share >= 0.0) & (share <= length)
        if self.across is not None:
            beside &= (x[:, self.third] >= self.across[0]) & (x[:, self.third] <= self.across[1])
        found, normal = np.flatnonzero(beside), np.zeros(x.shape[1])
        normal[list(self.axes)] = across
        return found, away[found], normal


class Passages:
    """The volume that has passed each gate of a scene, a line or in 3D a rectangle, since its start.

    A particle passes a line if its path from the start to the end of a step crosses it, whatever moves the particle. So
    errors do not accumulate: the sum is the volume on the other side.

    case : probes with a `gate` count, also in arrays; state : volumes of an earlier part of the run
    """

    def __init__(self, case: Case, comm: Communicator, state: Mapping[str, float] | None = None) -> None:
        gates = (probe.gate(case.dim) for _, probe in singles(case.probes))
        self._gates: dict[str, Any] = {gate.key: gate for gate in gates if gate is not None}
        self._comm = comm
        before = state if state and comm.rank == 0 else {}
        self._counted = {key: float(before.get(key, 0.0)) for key in self._gates}

    def look(self, particles: "Particles") -> None:
        """Add the volumes that have passed in the last step. Not collective."""
        if not self._gates:
            return
        fluid = particles.kind == FLUID
        before, after, volume = (field.compress(fluid, axis=0) for field in
                                 (particles.x0, particles.x, particles.volume))
        for key, gate in self._gates.items():
            self._counted[key] += gate.passed(before, after, volume)

    def mine(self, gate: Gate) -> float:
        """Return the volume that has passed a gate on this rank [m^dim]; add up those of all ranks. Not collective."""
        return self._counted[gate.key]

    def state(self) -> dict[str, float]:
        """Return {gate: volume so far [m^dim]}, the same on all ranks. Collective."""
        return {key: float(self._comm.allreduce(counted)) for key, counted in self._counted.items()}


def passed(line: Floats, before: Floats, after: Floats, volume: Floats, across: Across | None = None) -> float:
    """Return the volume that passes a line [m2]: positive from its left to its right, seen from its first point.

    line : (2, 2) points [m]; before, after : (n, 2) places of particles [m]; volume : (n,) [m2]
    across : for a rectangle: the third coordinates (n,) of both places, and the ends of the rectangle there [m]
    """
    start, along = line[0], line[1] - line[0]
    first, last = (along[0] * (x[:, 1] - start[1]) - along[1] * (x[:, 0] - start[0]) for x in (before, after))
    own = np.flatnonzero((first >= 0.0) != (last >= 0.0))    # a place on the line belongs to its left: counted once
    first, last = first[own], last[own]
    part = first / (first - last)
    crossing = before[own] + part[:, None] * (after[own] - before[own])
    share = (crossing - start) @ along / (along @ along)
    inside = (share >= 0.0) & (share <= 1.0)
    if across is not None:
        start, end, (low, high) = across
        third = start[own] + part * (end[own] - start[own])
        inside &= (third >= low) & (third <= high)
    return float(np.where(first >= 0.0, volume[own], -volume[own]) @ inside)
