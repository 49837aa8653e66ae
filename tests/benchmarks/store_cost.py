"""What a snapshot and a checkpoint cost, and which share of it their digest has.

    python tests/benchmarks/store_cost.py                             100,000 particles on one rank
    mpirun -n 2 python tests/benchmarks/store_cost.py -n 1e6 -o DIR   on the disk of DIR

Writes and reads by turns with and without digest; prints the least of all times, and their median.
"""

import argparse
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from parisph.base import environment  # noqa: E402

environment.prepare()


def main():
    """Write and read both kinds of files, and print."""
    from mpi4py import MPI

    from parisph.io import checkpoint, snapshot
    from tests.owned_rows import OwnedRows

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("-n", "--particles", type=float, default=1e5)
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="where to write (default: the folder for temporary files)")
    args = parser.parse_args()
    comm, total = MPI.COMM_WORLD, int(args.particles)
    particles = OwnedRows([total // comm.size + (rank < total % comm.size) for rank in range(comm.size)], comm.rank)
    holder = tempfile.TemporaryDirectory(dir=args.output) if comm.rank == 0 else None
    folder = Path(comm.bcast(holder.name if holder else None))
    actions = {
        "write a snapshot": lambda: snapshot.write(comm, folder / "a.vtkhdf", particles, 0.1, 1, ("u", "p"),
                                                   {"case": "{}"}),
        "write a checkpoint": lambda: checkpoint.write(comm, folder, particles, 0.1, 1, 0.1, "{}", {}, {}),
        "read the checkpoint": lambda: checkpoint.read(comm, folder / "00000001.h5"),
        "read the snapshot (each rank all of it)": lambda: snapshot.read(folder / "a.vtkhdf"),
    }
    for name, action in actions.items():
        _report(comm, name, *_compared(comm, action, args.repeats))
    comm.barrier()
    if holder:
        holder.cleanup()


def _compared(comm, action, repeats):
    """Return two lists of times [s]: with the digests, and without them."""
    from parisph.io import digest

    functions = {name: getattr(digest, name) for name in ("append", "check", "check_together")}
    with_digest, without = [], []
    for number in range(repeats + 1):
        # the last file that is written has its digest
        for times, left_out in ((without, True), (with_digest, False)):
            for name, function in functions.items():
                setattr(digest, name, (lambda *words: None) if left_out else function)
            comm.barrier()
            begun = perf_counter()
            action()
            comm.barrier()
            if number > 0:
                times.append(perf_counter() - begun)
    return with_digest, without


def _report(comm, name, with_digest, without):
    if comm.rank == 0:
        print(f"{name:<40}{1e3 * min(with_digest):7.1f} ms, without digest {1e3 * min(without):7.1f} ms, ratio "
              f"{min(with_digest) / min(without):.2f} (medians {1e3 * median(with_digest):.1f}, "
              f"{1e3 * median(without):.1f}, {median(with_digest) / median(without):.2f})", flush=True)


if __name__ == "__main__":
    main()
