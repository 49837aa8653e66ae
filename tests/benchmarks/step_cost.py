"""Time per particle and step by phase, and the gain of more ranks, in the falling column.

    python tests/benchmarks/step_cost.py                            3,200 and 100,000 particles, 1 and 2 ranks
    python tests/benchmarks/step_cost.py --particles 3200 --ranks 1

Each line is one run of its own. Timings on a shared machine are noisy: compare lines of one call.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

WARM, STEPS = 10, 30


def measure(particles):
    """Run WARM + STEPS steps on the ranks of this process's world; print the result as JSON on rank 0."""
    from mpi4py import MPI

    from parisph import Simulation, load

    column = round((particles / 2) ** 0.5)  # fluid particles in its width, twice as many in its height
    case = load(ROOT / "cases" / "dam_break.py", {"spacing": 0.5 / column, "jitter": 0.2})
    simulation = Simulation(case, MPI.COMM_WORLD)
    for _ in range(WARM):
        simulation.advance()
    simulation.timers.seconds.clear()
    simulation.comm.Barrier()
    start, iterations, rebuilt = time.perf_counter(), [], 0
    for _ in range(STEPS):
        report = simulation.advance()
        iterations.append(report.iterations)
        rebuilt += report.rebuilt
    wall = time.perf_counter() - start
    phases = {name: value["max"] for name, value in simulation.timers.reduce(simulation.comm).items()}
    if simulation.comm.rank == 0:
        n = simulation.particles.n_global
        scale = 1e6 / (STEPS * n)
        print(json.dumps({"particles": n, "ranks": simulation.comm.size, "us": wall * scale,
                          "phases": {name: value * scale for name, value in phases.items()},
                          "iterations": sorted(iterations)[STEPS // 2], "rebuilt": rebuilt / STEPS}))
    simulation.destroy()


def main():
    """Print one line for each number of particles and of ranks."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--particles", type=int, nargs="+", default=[3200, 100000])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--measure", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        measure(args.measure)
        return
    for particles in args.particles:
        first = None
        for ranks in args.ranks:
            command = ["mpirun", "-n", str(ranks), sys.executable, __file__, "--measure", str(particles)]
            done = subprocess.run(command, capture_output=True, text=True, timeout=1800)
            if done.returncode:
                raise SystemExit(done.stderr)
            found = json.loads(done.stdout.strip().splitlines()[-1])
            first = first or found["us"]
            phases = "  ".join(f"{name} {value:.2f}" for name, value in found["phases"].items())
            print(f"{found['particles']} particles, {ranks} ranks: {found['us']:.2f} us per particle and step, "
                  f"gain {first / found['us']:.2f}, {found['iterations']} iterations, preconditioner built in "
                  f"{found['rebuilt']:.0%} of the steps\n    {phases}", flush=True)


if __name__ == "__main__":
    main()
