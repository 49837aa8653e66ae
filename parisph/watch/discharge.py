"""The probe of water that passes a line (2D)."""

from collections.abc import Sequence

import numpy as np

from parisph.case import probes
from parisph.watch.passages import Passages
from parisph.watch.sampling import Sampler, Scene, View


class Flux(Sampler):
    """Rate of the water that passes a line, and the volume that has passed.

    The rate is the sum of volume times velocity across the line of the fluid beside it, with a hat function of the
    distance as weight: on a lattice of the spacing these add up to 1 wherever the line lies.
    """

    columns = {"rate": "m^2/s", "total": "m^2"}
    dims = (2,)

    def __init__(self, probe: probes.Flux, scene: Scene) -> None:
        super().__init__(probe, scene)
        self._start, along = np.array(probe.start), np.subtract(probe.end, probe.start)
        self._length = float(np.hypot(*along))
        self._along = along / self._length
        self._across = np.array([self._along[1], -self._along[0]])
        self._passages: Passages | None = None
        ends = " to ".join(f"({x:g}, {y:g})" for x, y in (probe.start, probe.end))
        self.title = f"Water that passes the line from {ends} m, positive from its left to its right"

    def follow(self, passages: Passages) -> None:
        """See Sampler: the total is counted in every step."""
        self._passages = passages

    def sums(self, view: View) -> Sequence[float]:
        p, s = view.particles, self.scene.spacing
        off = p.x - self._start
        away, share = np.abs(off @ self._across), off @ self._along
        near = np.flatnonzero(view.fluid & (away < s) & (share >= 0.0) & (share <= self._length))
        rate = (p.volume[near] * (1.0 - away[near] / s) / s) @ (p.u[near] @ self._across)
        return float(rate), self._passages.mine(self.probe) if self._passages is not None else 0.0

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> np.ndarray:
        return sums
