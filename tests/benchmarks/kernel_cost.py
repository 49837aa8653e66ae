"""Where the CPU time of a step goes: solves, kernels, and the rest; and that of a start.

    python tests/benchmarks/kernel_cost.py                  the dam break with H/s = 40 and 80, from the impact on
    python tests/benchmarks/kernel_cost.py --start          a run of two steps beside what it cannot do without

That of solves is wall time: where other programs use the core, the rest is too small. Timings on a shared machine are
noisy: compare lines of one call.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

STEPS = 150
SHOWN = 0.02     # kernels that take less of a step are summed up

LIBRARIES = "import numpy, h5py, numba, mpi4py.MPI, petsc4py.PETSc, pydantic"
KERNELS = 50     # as many as a dam break loads
# numba's own cache makes all its types and functions known when the first kernel is loaded; parisph's does not
TRIVIAL = "import numba\n" + "".join(
    f"@numba.njit(cache=True)\ndef f{n}(x):\n    for i in range(len(x)):\n        x[i] += {n}\n"
    for n in range(KERNELS))


class Timed:
    """Times all kernels that parisph's modules call from now on; seconds : of each so far, by its name."""

    def __init__(self):
        import numba

        self.seconds = defaultdict(float)
        wrapped = {}
        for name, module in list(sys.modules.items()):
            for key, value in list(vars(module).items()) if name.startswith("parisph.") else ():
                if isinstance(value, numba.core.registry.CPUDispatcher):
                    if id(value) not in wrapped:
                        wrapped[id(value)] = self._timed(value)
                    setattr(module, key, wrapped[id(value)])

    def _timed(self, kernel):
        name = f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.py_func.__name__}"

        def call(*arguments):
            start = time.thread_time()
            found = kernel(*arguments)
            self.seconds[name] += time.thread_time() - start
            return found
        call._numba_type_ = kernel._numba_type_    # what calls it may still be compiled
        return call


def step(across, timed):
    """Print the parts of a step of the dam break with H/s = across, in the mean of STEPS steps. timed : Timed"""
    from mpi4py import MPI

    from parisph import Simulation, load

    simulation = Simulation(load(ROOT / "cases" / "dam_break.py", {"spacing": 1 / across, "jitter": 0.2}),
                            MPI.COMM_WORLD)
    while simulation.time < simulation.case.end_time * 0.15:    # t sqrt(g/H) = 1.5
        simulation.advance()
    timed.seconds.clear()
    solves, start = 0.0, time.process_time()
    for _ in range(STEPS):
        report = simulation.advance()
        position = simulation.method.flow.position_solve
        solves += report.setup_seconds + report.solve_seconds + position.setup_seconds + position.solve_seconds
    total = time.process_time() - start
    n = simulation.particles.n_owned
    print(f"dam break, H/s = {across}, {n} particles: {1e3 * total / STEPS:.1f} ms a step, "
          f"{1e6 * total / STEPS / n:.1f} us per particle")
    kernels = sum(timed.seconds.values())
    large = {name: seconds for name, seconds in timed.seconds.items() if seconds >= SHOWN * total}
    lines = {"solves": solves, **dict(sorted(large.items(), key=lambda item: -item[1])),
             "other kernels": kernels - sum(large.values()), "rest": total - solves - kernels}
    for name, seconds in lines.items():
        print(f"    {name:40s} {1e3 * seconds / STEPS:6.2f} ms  {seconds / total:4.0%}", flush=True)
    simulation.destroy()


def start():
    """Print what a run of two steps takes from a start, and what its libraries and any fifty kernels take."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "trivial.py").write_text(TRIVIAL, encoding="utf-8")
        call = "import numpy, trivial; [getattr(trivial, f'f{n}')(numpy.zeros(1)) for n in range(%d)]"
        run = ["-m", "parisph", "run", str(ROOT / "cases" / "dam_break.py"), "-q", "--overwrite", "-o", "run", "--set",
               "spacing=0.025", "end_time=0.01"]
        programs = {"libraries": ["-c", LIBRARIES],
                    "and one kernel": ["-c", f"{LIBRARIES}; {call % 1}"],
                    f"and {KERNELS} kernels": ["-c", f"{LIBRARIES}; {call % KERNELS}"],
                    "a run of two steps": run}
        least = {}
        for repeat in range(4):    # the first fills caches
            for name, program in programs.items():
                seconds = _cpu([sys.executable, *program], folder)
                if repeat:
                    least[name] = min(least.get(name, seconds), seconds)
    for name, seconds in least.items():
        print(f"{name:20s} {seconds:5.2f} CPU s")


def _cpu(command, folder):
    """Run a command; return its CPU time [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise SystemExit(done.stderr)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    """Print the parts of steps, or those of a start."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--across", type=int, nargs="+", default=[40, 80], help="H/s of the dam breaks")
    parser.add_argument("--start", action="store_true", help="a start in place of steps")
    args = parser.parse_args()
    if args.start:
        start()
        return
    from parisph import Simulation  # noqa: F401    whose modules Timed looks through

    timed = Timed()
    for across in args.across:
        step(across, timed)


if __name__ == "__main__":
    from parisph.base import environment

    environment.prepare()
    main()
