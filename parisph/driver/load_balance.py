"""The load balance of a run: work, particles, ghosts and messages of its ranks."""

from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.driver.simulation import Simulation

COUNTED = ("owned", "ghosts", "neighbours", "work")


class LoadBalance:
    """Counts the particles and messages of ranks from now on."""

    def __init__(self, simulation: Simulation) -> None:
        self._before = _so_far(simulation)

    def content(self, simulation: Simulation, comm: MPI.Comm) -> dict[str, Any]:
        """Return the entry `shares` of summary.json, the same on all ranks of `comm`. Collective there.

        {"max", "mean"} over the ranks now: owned particles, ghosts, neighbours (ranks that receive ghosts of this one),
        work (parallel.work). imbalance: the largest work over the mean. Per step: updates (messages to every
        neighbour), plans (particles change rank), lists (new neighbour lists).
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
