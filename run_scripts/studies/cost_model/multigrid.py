"""Levels, entries and cost of the multigrid on one rank, by hypre's own figures, against the number of unknowns.

    python run_scripts/studies/cost_model/multigrid.py --dim 2 --unknowns 1e4 1e5 1e6 -o multigrid_2d.json
    python run_scripts/studies/cost_model/multigrid.py --dim 3 --scene 16 35 -o multigrid_scene.json

The matrix is that of a Laplacian with weights 1/r^2 on neighbours within 2.1 spacings of a jittered lattice, with p = 0
above its uppermost layer: the pressure equation without walls. --scene takes the first matrix of the dam break instead,
with so many particles in the width of the column. Solver and options are those of a run. Seconds are CPU time.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path
from time import process_time

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

HYPRE = ["-pressure_pc_type", "hypre", "-pressure_pc_hypre_boomeramg_print_statistics", "1"]
REACH, JITTER = 2.1, 0.2    # spacings
SCENES = {2: "dam_break.py", 3: "dam_break_3d.py"}


def dam_break(dim: int, column: int, **settings: float):
    """Return the Case of the dam break in 2D or 3D, with so many particles in the width of its column."""
    from parisph import load

    return load(ROOT / "cases" / SCENES[dim], {"spacing": 0.5 / column, "jitter": JITTER, **settings})


def lattice_matrix(dim: int, unknowns: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (indptr, indices, values) of a Laplacian on a jittered lattice of unit spacing, in the order of cells."""
    from parisph.kernels.cells import neighbour_lists
    from parisph.parallel.partition import Grid

    side = round(unknowns ** (1.0 / dim))
    x = np.stack(np.meshgrid(*[np.arange(side) + 0.5] * dim, indexing="ij"), -1).reshape(-1, dim)
    x += np.random.default_rng(0).uniform(-0.5 * JITTER, 0.5 * JITTER, x.shape)
    x = x[np.argsort(Grid.covering(np.zeros(dim), np.full(dim, float(side)), 4.7).keys(x))]
    indptr, near = neighbour_lists(x, len(x), REACH)
    rows = np.repeat(np.arange(len(x)), np.diff(indptr))
    weights = 1.0 / ((x[near] - x[rows]) ** 2).sum(axis=1)
    centre = np.bincount(rows, weights, len(x)) * np.where(x[:, -1] > side - 1.0, 1.5, 1.0)    # p = 0 above
    rows, columns = np.append(rows, np.arange(len(x))), np.append(near, np.arange(len(x)))
    order = np.argsort(rows, kind="stable")
    return np.append(0, np.cumsum(np.diff(indptr) + 1)), columns[order], np.append(-weights, centre)[order]


def solve_lattice(dim: int, unknowns: float) -> None:
    """Set up and solve once from zero, as the first step of a run; print the cost as JSON."""
    from mpi4py import MPI

    from parisph.pressure.solver import PressureSolver

    matrix = lattice_matrix(dim, unknowns)
    n = len(matrix[0]) - 1
    solver = PressureSolver(MPI.COMM_SELF, HYPRE)
    rhs = np.random.default_rng(1).normal(size=n)
    seconds = []
    for slack in (1.0, 100.0):    # the second one has its preconditioner: two tolerances give the cost of an iteration
        start = process_time()
        _, record = solver.solve(*matrix, rhs, None) if slack == 1.0 else solver.solve_again(rhs, None, slack)
        seconds.append((process_time() - start, record.iterations, record.setup_seconds))
    (first, many, set_up), (second, few, _) = seconds
    print("\n" + json.dumps({"unknowns": n, "entries": len(matrix[1]), "iterations": many,
                             "us_iterations": 1e6 * second / (few * n),
                             "us_setup": 1e6 * (first - second * many / few) / n, "setup_wall": set_up}))


def solve_scene(dim: int, column: int) -> None:
    """Compute the pressure at the start of the dam break; print the numbers of unknowns as JSON."""
    from mpi4py import MPI

    from parisph import Simulation

    s = Simulation(dam_break(dim, column), MPI.COMM_SELF, HYPRE)
    s.solve_start()
    print("\n" + json.dumps({"unknowns": s.particles.n_global}))


def levels_in(text: str) -> list[dict[str, int]]:
    """Return the levels that hypre printed last: rows and entries of each."""
    block = text.rsplit("Operator Matrix Information", 1)[-1].split("Interpolation Matrix Information")[0]
    lines = re.findall(r"^\s*(\d+)\s+(\d+)\s+(\d+)\s+[\d.]+\s", block, re.MULTILINE)
    return [{"rows": int(rows), "entries": int(entries)} for _, rows, entries in lines]


def measured(words: list[str]) -> dict:
    """Run this file with some words in a process of its own; return its figures with those of hypre."""
    done = subprocess.run([sys.executable, __file__, *words], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    levels = levels_in(done.stdout)
    found = json.loads(next(line for line in reversed(done.stdout.splitlines()) if line.startswith("{")))
    return {**found, "levels": levels,
            "grid complexity": sum(level["rows"] for level in levels) / levels[0]["rows"],
            "operator complexity": sum(level["entries"] for level in levels) / levels[0]["entries"]}


def main() -> None:
    """Print one line for each matrix."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--dim", type=int, choices=(2, 3), default=2)
    parser.add_argument("--unknowns", type=float, nargs="+", default=[1e4, 1e5])
    parser.add_argument("--scene", type=int, nargs="+", help="particles in the width of the column")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        solve_scene(args.dim, args.scene[0]) if args.scene else solve_lattice(args.dim, args.unknowns[0])
        return
    option, values = ("--scene", args.scene) if args.scene else ("--unknowns", args.unknowns)
    found = []
    for value in values:
        found.append(measured(["--measure", "--dim", str(args.dim), option, str(value)]))
        print(json.dumps(found[-1]), flush=True)
    if args.output:
        args.output.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
