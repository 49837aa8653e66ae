"""Memory over many steps: is it flat? The violent dam break, whose surface, lists and ghosts change all the time.

    python tests/benchmarks/memory.py                                     5,000 steps at 1/40 on one rank
    mpirun -n 2 python tests/benchmarks/memory.py --steps 5000 --spacing 1/80
    python tests/benchmarks/memory.py --dim 3 --steps 20 --spacing 1/58   100,000 particles in 3D

Prints the resident memory of every rank as it goes, the growth from the first fifth to the last, and the greatest
memory of all ranks with the number of particles: two spacings give the memory of a particle.
"""

import argparse
import gc
import sys
from fractions import Fraction
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from parisph.base import environment  # noqa: E402

environment.prepare()

SAMPLES = 50
SCENES = {2: "dam_break.py", 3: "dam_break_3d.py"}


def resident():
    """Return the resident memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def peak():
    """Return the greatest resident memory that this process had [MB]."""
    status = Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in status if line.startswith("VmHWM:")).split()[1]) * 1024 / 1e6


def main():
    """Advance the dam break, sample, and print."""
    from mpi4py import MPI

    from parisph import Simulation, load

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--steps", type=int, default=5000)
    parser.add_argument("--spacing", default="1/40", help="over H")
    parser.add_argument("--dim", type=int, choices=(2, 3), default=2)
    args = parser.parse_args()
    comm = MPI.COMM_WORLD
    case = load(Path(__file__).resolve().parents[2] / "cases" / SCENES[args.dim],
                {"spacing": float(Fraction(args.spacing)), "end_time": 1e4, "snapshot_every": 100.0,
                 "jitter": 0.2})
    simulation, every, found = Simulation(case, comm), max(1, args.steps // SAMPLES), []
    for step in range(1, args.steps + 1):
        simulation.advance()
        if step % every == 0:
            gc.collect()
            found.append(comm.gather(resident()))
            if comm.rank == 0 and (step // every) % 5 == 0:
                print(f"step {step:6d}  {'  '.join(f'{mb:7.1f}' for mb in found[-1])} MB", flush=True)
    most, particles = comm.gather(peak()), simulation.particles.n_global
    simulation.destroy()
    if comm.rank == 0:
        print(f"{particles} particles, at most {sum(most):.1f} MB on {comm.size} ranks")
        fifth = max(1, len(found) // 5)
        for rank, series in enumerate(zip(*found)):
            first, last = sum(series[:fifth]) / fifth, sum(series[-fifth:]) / fifth
            print(f"rank {rank}: {first:.1f} MB in the first fifth, {last:.1f} MB in the last, "
                  f"growth {last - first:+.1f} MB, "
                  f"{1e3 * (series[-1] - series[fifth]) / (args.steps * 4 / 5):+.2f} kB a step")


if __name__ == "__main__":
    main()
