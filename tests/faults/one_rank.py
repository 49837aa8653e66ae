"""Something fails on one of two ranks: in a stage of the step or a body force, in a script or in `parisph run`, or
between two calls."""

import shutil
import subprocess
import sys
import time

from parisph.io import reader
from tests.faults.table import each_in_its_folder, gone_on
from tests.launch import clean_environment
from tests.scenes import PROGRAM

CASE = """
from tests.faults.dam import dam
def case():
    return dam(spacing=0.05, end_time=0.2).changed(**{"output.checkpoint_every": 0.05})
"""
# What is carried out, and what must be told of it; the traceback besides.
FAULTS = {
    "sys.exit()": "SystemExit", "sys.exit(3)": "SystemExit: 3", "sys.exit('enough')": "enough",
    "raise MemoryError('no room')": "MemoryError: no room", "raise KeyboardInterrupt": "KeyboardInterrupt",
    "raise ParisphError('mine')": "mine", "raise SolverDiverged('mine too')": "mine too",
    "raise ValueError('wrong')": "ValueError: wrong",
}
IN_A_STEP = (
    "driver.simulation:Simulation._force", "methods.projection:Projection._predict", "methods.surfaces:AngularGap.find",
    "methods.projection:Projection._assemble", "methods.projection:Projection._matrix",
    "pressure.solver:PressureSolver.solve", "parallel.domain:Domain.refresh", "parallel.halo:Halo.update",
    "methods.projection:Projection._correct_velocity", "methods.projection:Projection._move",
    "methods.projection:Projection._report",
)
AROUND_A_STEP = ("driver.summary:Account.step", "driver.probing:Watch.after_step", "io.store:Store.append_all",
                 "io.store:Store.checkpoint")
BETWEEN = "between two calls"
FAILING = """
import importlib, sys, time
from mpi4py import MPI
from parisph.base.errors import ParisphError, SolverDiverged
from parisph.driver import warmup

begun = False
def fail():
    open("failed", "w").close()
    {fault}

def also(original):
    def begin(*args):
        global begun
        original(*args)
        begun = True
    return begin
warmup.on_one_rank_first = also(warmup.on_one_rank_first)    # whose own scene must not fail

def failing(original):
    calls = 0
    def call(*args, **options):
        nonlocal calls
        calls += begun and MPI.COMM_WORLD.rank == {rank}
        if calls == {calls}:
            fail()
        return original(*args, **options)
    return call

where = {where!r}
if ":" in where:
    module, _, name = where.partition(":")
    owner, _, name = name.rpartition(".")
    owner = getattr(importlib.import_module("parisph." + module), owner)
    setattr(owner, name, failing(getattr(owner, name)))
"""
SCRIPT = PROGRAM + FAILING + """
from parisph import load
s = Simulation(load("case.py"), comm)
while not s.finished():
    if where == "between two calls" and s.steps == {calls} and comm.rank == {rank}:
        fail()
    s.advance()
"""
COMMAND = FAILING + """
from parisph.__main__ import main
sys.exit(main(["run", "case.py", "-o", "run", "-q"]))
"""
START = 200.0      # [s] until the failure
GONE = 60.0        # [s] from there until all processes are gone


def make(count, random, folder):
    """See table.Part."""
    yield from each_in_its_folder(count, folder, lambda place: _attempt(place, random))


def _attempt(folder, random):
    (folder / "case.py").write_text(CASE)
    script = bool(random.integers(2))
    places = (*IN_A_STEP, BETWEEN, BETWEEN, BETWEEN) if script else (*IN_A_STEP, *AROUND_A_STEP)
    where, fault = str(random.choice(places)), str(random.choice(list(FAULTS)))
    values = dict(where=where, fault=fault, rank=int(random.integers(2)), calls=int(random.integers(1, 8)))
    what = (f"{fault} on rank {values['rank']} in {where}, time {values['calls']}, "
            f"{'a script' if script else 'parisph run'}")
    (folder / "program.py").write_text((SCRIPT if script else COMMAND).format(**values))
    code, said = _carried_out(folder)
    if code is None:
        return f"{what}: {said}"
    silent = where == BETWEEN and "exit" in fault    # a program that ends on purpose is not wrong by itself
    if code == 0 or (not silent and ("Traceback" not in said or FAULTS[fault] not in said)):
        return f"{what}: exit code {code}: {said[-1000:]}"
    return None if script else _finish(folder, what)


def _carried_out(folder):
    """Run the program on two ranks; return (exit code, what it said), or (None, why) if it does not end in time."""
    command = [shutil.which("mpirun"), "-n", "2", sys.executable, "program.py"]
    with open(folder / "output.txt", "w") as output:
        process = subprocess.Popen(command, cwd=folder, env=clean_environment(), start_new_session=True,
                                   stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)
    try:
        deadline = time.monotonic() + START
        while not (folder / "failed").exists():
            if process.poll() is not None or time.monotonic() > deadline:
                return None, f"never comes to the fault: {(folder / 'output.txt').read_text()[-1000:]}"
            time.sleep(0.05)
        code = process.wait(GONE)
        return code, (folder / "output.txt").read_text()
    except subprocess.TimeoutExpired:
        return None, f"ranks are left after {GONE:g} s"
    finally:
        if process.poll() is None:
            process.terminate()    # mpirun ends its ranks
            process.wait()


def _finish(folder, what):
    wrong = gone_on(folder, what)    # or begun, if it failed while the scene was built
    status = None if wrong else reader.open_run(folder / "run").summary["status"]
    return wrong or (None if status == "completed" else f"{what}: status {status}")
