"""What a step asks of MPI on a few ranks: sends, bytes and collectives of each phase, and of the parts of the solver.

    python run_scripts/studies/cost_model/messages.py --dim 2 --ranks 2 4 -o messages_2d.json
    python run_scripts/studies/cost_model/messages.py --dim 3 --ranks 2 4 --column 16 -o messages_3d.json

It counts all calls of parisph, PETSc and hypre, with count_mpi.c in front of the MPI library; it needs a C compiler.
Counts do not depend on the machine's speed, so the ranks may be more than the cores. On two ranks each exchange is one
send of each rank: the sends are the rounds of exchanges, which more ranks have as well.
"""

import argparse
import ctypes
import json
import os
import shutil
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

from run_scripts.studies.cost_model import multigrid  # noqa: E402

SOURCE = Path(__file__).with_name("count_mpi.c")
WARM, STEPS = 10, 20
WHAT = ("sends", "bytes", "collectives")


class Counter:
    """Counts of this process, by name: {name: [sends, bytes, collectives]}."""

    def __init__(self) -> None:
        self._ask = ctypes.CDLL(None).mpi_counted
        self.found: dict[str, list[int]] = {}

    def now(self) -> list[int]:
        """Return the counts so far."""
        counts = (ctypes.c_long * len(WHAT))()
        self._ask(counts)
        return list(counts)

    @contextmanager
    def of(self, name: str):
        """Context whose calls of MPI are added to a name."""
        before = self.now()
        yield
        total = self.found.setdefault(name, [0] * len(WHAT))
        self.found[name] = [a + b - c for a, b, c in zip(total, self.now(), before)]


def count(dim: int, column: int) -> None:
    """Count in a dam break on the ranks of this process's world; print the mean of the ranks as JSON."""
    from mpi4py import MPI

    from parisph import Simulation
    from parisph.base.log import Timers
    from parisph.parallel.halo import Halo

    counter, timed, update = Counter(), Timers.__call__, Halo.update

    def updated(self, *names):
        with counter.of("updates"):
            update(self, *names)

    @contextmanager
    def counted(self, phase):
        with counter.of(phase), timed(self, phase):
            yield

    s = Simulation(multigrid.dam_break(dim, column, snapshot_every=10), MPI.COMM_WORLD, ["-pressure_pc_type", "hypre"])
    for _ in range(WARM):
        s.advance()
    Timers.__call__, Halo.update = counted, updated
    iterations = built = steps = 0
    while steps < STEPS:
        plans, before = s.domain.n_plans, dict(counter.found)
        report = s.advance()
        if s.domain.n_plans > plans:    # a step in which particles change rank takes more, and has its own line
            counter.found = before
            continue
        steps, iterations, built = steps + 1, iterations + report.iterations, built + report.rebuilt
        iterations += report.position_iterations or 0
    Timers.__call__, Halo.update = timed, update
    found = {"step": {name: [value / STEPS for value in values] for name, values in counter.found.items()}}
    counter.found = {}
    with counter.of("plan"):
        s.domain.redistribute(force=True)
    solver = _solver_parts(s, counter)
    mine = {**{f"step/{name}": values for name, values in found["step"].items()}, **counter.found}
    everyone = s.comm.gather((mine, s.domain.receivers, s.particles.n_ghost))
    if s.comm.rank == 0:
        names = list(mine)
        mean = {name: [sum(one[0].get(name, [0] * 3)[k] for one in everyone) / s.comm.size for k in range(3)]
                for name in names}
        print(json.dumps({"dim": dim, "ranks": s.comm.size, "particles": s.particles.n_global,
                          "iterations": iterations / STEPS, "built": built / STEPS,
                          "neighbours": sum(one[1] for one in everyone) / s.comm.size,
                          "ghosts": sum(one[2] for one in everyone) / s.comm.size, **solver, "counts": mean}))
    s.destroy()


def _solver_parts(s, counter):
    """Count in one product with the matrix, one cycle and one set-up of the multigrid, and in 5 and 10 iterations."""
    from parisph.pressure import options as opts

    ksp, system = s.method.solver._ksp, s.method.solver._system
    pc, x, y = ksp.getPC(), system.x.duplicate(), system.b.duplicate()
    x.set(1.0)
    system.matrix.mult(x, y)    # the first one may set things up
    with counter.of("product"):
        system.matrix.mult(x, y)
    with counter.of("halo update"):
        s.domain.update("p")
    pc.apply(x, y)
    with counter.of("kept cycle"):
        pc.apply(x, y)
    pc.setReusePreconditioner(False)
    system.matrix.scale(1.0)    # a new state: PETSc would keep what it has
    ksp.setOperators(system.matrix, system.matrix)
    with opts.defaults(opts.PREFIX, s.method.solver._chosen), counter.of("set-up"):
        pc.setUp()
    pc.apply(x, y)
    with counter.of("cycle"):
        pc.apply(x, y)
    made = {}
    for most in (5, 10):
        ksp.setTolerances(rtol=1e-300, max_it=most)
        x.set(0.0)
        with counter.of(f"{most} iterations"):
            ksp.solve(system.b, x)
        made[most] = ksp.getIterationNumber()
    return {"iterations of 5": made[5], "iterations of 10": made[10]}


def built(folder: Path) -> Path:
    """Build the counting library in a folder."""
    library = folder / "libcount_mpi.so"
    words = ["-O2", "-shared", "-fPIC", str(SOURCE), "-o", str(library)]
    for compiler in filter(None, map(shutil.which, ("mpicc", "cc"))):    # Open MPI's handles need no header
        if subprocess.run([compiler, *words], capture_output=True).returncode == 0:
            return library
    raise SystemExit("messages: no C compiler (mpicc, cc) builds count_mpi.c")


def main() -> None:
    """Run on each number of ranks and print what was counted."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--dim", type=int, choices=(2, 3), default=2)
    parser.add_argument("--ranks", type=int, nargs="+", default=[2, 4])
    parser.add_argument("--column", type=int, default=64, help="particles in the width of the column")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--count", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.count:
        count(args.dim, args.column)
        return
    with tempfile.TemporaryDirectory() as folder:
        library = built(Path(folder))
        lines = [json.loads(_on_ranks(ranks, args, library).splitlines()[-1]) for ranks in args.ranks]
    levels = multigrid.measured(["--measure", "--dim", str(args.dim), "--scene", str(args.column)])["levels"]
    for line in lines:
        line["levels"] = len(levels)
        print(json.dumps(line, indent=1))
    if args.output:
        args.output.write_text(json.dumps(lines, indent=1) + "\n", encoding="utf-8")


def _on_ranks(ranks, args, library):
    own = [sys.executable, __file__, "--count", "--dim", str(args.dim), "--column", str(args.column)]
    surroundings = {**os.environ, "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1",
                    "OMP_NUM_THREADS": "1"}
    done = subprocess.run(["mpirun", "-n", str(ranks), "env", f"LD_PRELOAD={library}", *own], env=surroundings,
                          capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


if __name__ == "__main__":
    main()
