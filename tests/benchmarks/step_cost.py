"""Time per particle and step by phase, and the gain of more ranks, in the falling column.

    python tests/benchmarks/step_cost.py                            3,200 and 100,000 particles, 1 and 2 ranks
    python tests/benchmarks/step_cost.py --particles 3200 --ranks 1
    python tests/benchmarks/step_cost.py --whole                    whole runs with their probes and files

The first steps of a column are the cheapest: after the impact the preconditioner is built in most steps, and probes
and files cost as well. Each line is one run of its own. Timings on a shared machine are noisy: compare lines of one
call.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

WARM, STEPS = 10, 30
# of --whole: a scene and its parameters; the dam breaks to t sqrt(g/H) = 4, sloshing to t sqrt(g/d) = 50
WHOLE = (
    ("dam_break", {"spacing": 1 / 40, "jitter": 0.2, "end_time": 4.0}),
    ("dam_break", {"spacing": 1 / 80, "jitter": 0.2, "end_time": 4.0}),
    ("small_sloshing", {"spacing": 0.1}),
    ("small_sloshing", {"spacing": 0.05}),
    ("small_sloshing", {"spacing": 0.025}),
    ("dam_break_3d", {"spacing": 0.05}),
    ("spheric2", {"spacing": 0.055, "end_time": 1.0}),
)


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


def whole(scene, parameters, ranks):
    """Run a scene of cases/ to its end on some ranks; print its CPU time by phase, of the slowest rank."""
    settings = [f"{name}={value!r}" for name, value in parameters.items()]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        command = ["mpirun", "-n", str(ranks), sys.executable, "-m", "parisph", "run",
                   str(ROOT / "cases" / f"{scene}.py"), "--set", *settings, "-o", str(out)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=7200, cwd=folder)
        if done.returncode:
            raise SystemExit(done.stderr)
        found = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    scale = 1e6 / (found["steps"] * found["particles"])
    phases = "  ".join(f"{name} {seconds * scale:.2f}" for name, seconds in found["cpu_phases"].items())
    print(f"{scene}, {found['particles']} particles, {ranks} ranks: {found['cpu_seconds']:.1f} CPU s for "
          f"{found['steps']} steps, {found['cpu_seconds'] * scale:.2f} us per particle and step, "
          f"{found['iterations']['median']:.0f} iterations, {max(found['peak_memory_mb']):.0f} MB\n    {phases}",
          flush=True)


def main():
    """Print one line for each number of particles and of ranks, or for each whole run."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--particles", type=int, nargs="+", default=[3200, 100000])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--whole", action="store_true",
                        help="whole runs on the first of the ranks, with their probes and files")
    parser.add_argument("--measure", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        measure(args.measure)
        return
    if args.whole:
        for scene, parameters in WHOLE:
            whole(scene, parameters, args.ranks[0])
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
