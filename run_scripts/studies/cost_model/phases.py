"""What a step costs on one rank, by phase, from two runs that differ in their particles.

    parisph run cases/dam_break_3d.py --set spacing=1/44 jitter=0.2 end_time=1.86 -o large -- -pressure_pc_type hypre
    parisph run cases/dam_break_3d.py --set spacing=1/10 jitter=0.2 end_time=2 -o small
    python run_scripts/studies/cost_model/phases.py large small -o phases_3d.json

CPU time, of all steps: before, during and after the impact. The large run gives the cost of a particle of the fluid
together with the walls, of which many are dry, and the small one what a step costs beside that. Ghosts have no lists:
what they add to those of particles is timed on a lattice.
"""

import argparse
import json
import sys
from pathlib import Path
from time import process_time

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[3])]

from scaling_measures import PHASES, shares, step_cpu_ms  # noqa: E402

from parisph.io.reader import open_run  # noqa: E402
from parisph.kernels.cells import neighbour_lists  # noqa: E402
from parisph.methods.lengths import NEAR  # noqa: E402

SIDES = {2: 150, 3: 28}    # particles along a lattice on which ghosts are timed


def ghost_us(dim: int) -> float:
    """Return the CPU time [us] that new lists take for each particle without one: the shortest of some trials."""
    x = np.stack(np.meshgrid(*[np.arange(SIDES[dim]) + 0.5] * dim, indexing="ij"), -1).reshape(-1, dim)
    times = []
    for _ in range(10):
        start = process_time()
        neighbour_lists(x, 1, NEAR)
        times.append(process_time() - start)
    return 1e6 * min(times[1:]) / len(x)    # the first one may compile


def main() -> None:
    """Print the costs as JSON, and write them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("large", type=Path)
    parser.add_argument("small", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    args = parser.parse_args()
    run, small = open_run(args.large), open_run(args.small).summary
    summary, steps = run.summary, run.steps
    scale = 1e6 / (summary["steps"] * summary["fluid_particles"])
    us = {phase: scale * summary["cpu_phases"][phase] for phase in PHASES}
    found = {
        "fluid": summary["fluid_particles"], "walls": summary["wall_particles"], "steps": summary["steps"],
        "us": us, "us_all": sum(us.values()),
        "us_ghost": ghost_us(run.scene.dim),
        "overhead_ms": step_cpu_ms(small) - 1e-3 * sum(us.values()) * small["fluid_particles"],
        "small": small["fluid_particles"],
        "iterations": float(np.median(steps["iterations"])),
        "position_iterations": float(np.median(steps["position_iterations"])),
        "built": float(np.mean(steps["rebuilt"] == "True")), "updates": shares("updates")(summary),
        "plans": shares("plans")(summary), "lists": shares("lists")(summary),
    }
    text = json.dumps(found, indent=1)
    print(text)
    if args.output:
        args.output.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
