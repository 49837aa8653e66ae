"""What grows with the number of ranks, beside messages to neighbours: its order, how often, and what it takes.

    python run_scripts/studies/cost_model/growth.py --ranks 10000

What a rank does alone is timed here; what it waits for is taken from latency and bandwidth, with log2(ranks) messages
for a collective, and all that arrives at the bandwidth.
"""

import argparse
import pickle
import sys
from collections.abc import Callable
from math import ceil, log2
from pathlib import Path
from time import perf_counter

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

from parisph.base import markdown  # noqa: E402
from parisph.parallel.partition import split  # noqa: E402
from run_scripts.studies.cost_model.partitions import Column, OneForAll  # noqa: E402

OWN = 1000      # particles of this rank
NONE = float("nan")    # it depends on the disk


def seconds(work: Callable[[], object], times: int = 5) -> float:
    """Return the shortest time of some calls [s]."""
    found = []
    for _ in range(times):
        start = perf_counter()
        work()
        found.append(perf_counter() - start)
    return min(found)


def entries(ranks: int, latency: float, bandwidth: float) -> list[tuple[str, str, str, str, float]]:
    """Return (what, where, order, how often, seconds) of everything that grows; latency [s], bandwidth [bytes/s]."""
    hops = ceil(log2(ranks)) * latency
    gathered = hops + 8.0 * ranks / bandwidth
    numbers, few = np.ones(ranks, np.int64), np.zeros(6, np.int64)
    added = seconds(lambda: np.cumsum(numbers))
    counted = seconds(lambda: np.bincount(few, minlength=ranks))
    named = seconds(lambda: np.repeat(np.arange(ranks), numbers))
    objects = [pickle.dumps({"predict": 1.0, "redistribute": 1.0, "solve": 1.0, "correct": 1.0})] * ranks
    read = seconds(lambda: [pickle.loads(one) for one in objects])
    column = Column(2, 1e7)
    cells, work = (np.repeat(array[:50], 20)[:OWN] for array in (column.cells, column.counts))
    cut = seconds(lambda: split(OneForAll(ranks), cells, work, column.grid.end))
    rounds = ceil(log2(column.grid.end)) + 3
    rows = 5.0 * 8.0 * 4.0    # bytes that a rank may send for its probes
    return [
        ("sum or maximum of numbers", "survey, solver, reports, isolated rows", "log P", "10 a step", 10 * hops),
        ("sums of Krylov and multigrid", "PETSc, hypre", "log P", "3 an iteration", 3 * hops),
        ("layouts of a matrix", "PETSc (createAIJ)", "P memory, P time", "a step", 2 * gathered),
        ("who asks whom for marks", "pressure/groups.py", "P memory, P time", "a step", 2 * gathered + counted),
        ("rounds of marks", "pressure/groups.py", "sqrt P rounds of log P (2D)", "a step", np.sqrt(ranks) * 2 * hops),
        ("rows of probes", "watch/sampling.py", "P memory, P time", "a sample",
         2 * gathered + rows * ranks / bandwidth),
        ("offsets of all ranks", "parallel/particles.py", "P memory, P time", "a plan", gathered + added),
        ("work of all ranks", "parallel/domain.py", "P memory, P time", "a plan", gathered + added),
        ("how many go where", "parallel/messages.py, migrate.py, halo.py", "P memory, P time", "2 a plan",
         2 * (gathered + counted + named)),
        ("new cuts", "parallel/partition.py", "P memory, P log(cells) time", "where work is uneven",
         cut + rounds * (hops + 16.0 * ranks / bandwidth)),
        ("objects of timers", "base/log.py, driver/phases.py", "P memory, P time", "3 a checkpoint",
         3 * (read + gathered)),
        ("shares, memory", "driver/shares.py, summary.py", "P memory, P time", "at the end", 2 * (read + gathered)),
        ("digests of a checkpoint", "io/digest.py", "P time, each rank reads its part", "a checkpoint", read),
        ("mesh of walls that are no tank", "parallel/wall_elements.py", "all nodes on every rank", "a plan", NONE),
        ("one file that all open", "io/slabs.py, io/checkpoint.py", "P opens", "a snapshot, a checkpoint", NONE),
        ("Python's modules, compiled kernels", "import, numba's cache", "P reads of thousands of files", "at the start",
         NONE),
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--ranks", type=int, default=10_000)
    parser.add_argument("--latency", type=float, default=1.5, help="of a message [us]")
    parser.add_argument("--bandwidth", type=float, default=2.0, help="of a rank [GB/s]")
    args = parser.parse_args()
    lines = [(*words, "-" if np.isnan(time) else f"{1e3 * time:.2g}")
             for *words, time in entries(args.ranks, 1e-6 * args.latency, 1e9 * args.bandwidth)]
    print(markdown.table(["what", "where", "order", "how often", f"ms at {args.ranks} ranks"], lines))


if __name__ == "__main__":
    main()
