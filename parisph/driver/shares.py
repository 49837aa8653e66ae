"""How a run is shared among its ranks: work, particles, ghosts and messages."""

from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.driver.simulation import Simulation

COUNTED = ("owned", "ghosts", "neighbours", "work")


class Shares:
    """Counts what ranks have and send, from a moment on.

    simulation : at that moment
    """

    def __init__(self, simulation: Simulation) -> None:
        self._before = _so_far(simulation)

    def content(self, simulation: Simulation, comm: MPI.Comm) -> dict[str, Any]:
        """Return the entry `shares` of summary.json, the same on all ranks of `comm`. Collective there.

        As they are now, {"max", "mean"} over the ranks: owned particles, ghosts, neighbours (the ranks that one sends
        ghosts to), work (parallel.work); and imbalance, the largest work over the mean. Per step since the start:
        updates (messages to every neighbour), plans (particles change rank) and lists (neighbours are found anew).
        """
        s = simulation
        p, domain = s.particles, s.domain
        everyone = np.array(comm.allgather((p.n_owned, p.n_ghost, domain.receivers, domain.work)), float)
        found: dict[str, Any] = {name: {"max": float(column.max()), "mean": float(column.mean())}
                                 for name, column in zip(COUNTED, everyone.T, strict=True)}
        work = found["work"]
        found["imbalance"] = work["max"] / work["mean"] if work["mean"] else 1.0
        steps, *counts = (now - then for now, then in zip(_so_far(s), self._before, strict=True))
        for name, count in zip(("updates", "plans", "lists"), counts, strict=True):
            found[name] = count / steps if steps else None
        return found


def _so_far(simulation: Simulation) -> tuple[int, int, int, int]:
    domain = simulation.domain
    return simulation.steps, domain.n_updates, domain.n_plans, domain.n_lists
