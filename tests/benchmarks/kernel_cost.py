"""Where the CPU time of a step goes: solves, kernels, and the rest.

    python tests/benchmarks/kernel_cost.py                  the dam break with H/s = 40 and 80, from the impact on

That of solves is wall time: where other programs use the core, the rest is too small. Timings on a shared machine are
noisy: compare lines of one call.
"""

import argparse
import sys
import time
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

STEPS = 150
SHOWN = 0.02     # kernels that take less of a step are summed up


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
        position = simulation.method.flow.step.position_solve
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


def main():
    """Print the parts of steps."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--across", type=int, nargs="+", default=[40, 80], help="H/s of the dam breaks")
    args = parser.parse_args()
    from parisph import Simulation  # noqa: F401    whose modules Timed looks through

    timed = Timed()
    for across in args.across:
        step(across, timed)


if __name__ == "__main__":
    from parisph.base import environment

    environment.prepare()
    main()
