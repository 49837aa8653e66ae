"""The scenes of cases/ for tests: loaded by name, run in this process or on several ranks."""

import json
from textwrap import indent

import numpy as np
from mpi4py import MPI

from parisph import Energy, driver
from parisph.case.load import load
from parisph.case.model import Model
from parisph.case.schema import Box, Case, Fluid, Numerics, Tank
from parisph.case.stored import to_json
from parisph.io.checkpoint import Checkpoint
from parisph.io.reader import open_run
from parisph.watch import instruments
from tests.launch import ROOT, mpirun

# The head of a program that runs on several ranks.
PROGRAM = """
import sys
import numpy as np
from mpi4py import MPI
from parisph.driver import Simulation
from tests.scenes import scene
comm = MPI.COMM_WORLD
"""


def scene(name, numerics=None, **sets):
    """Return the Case of cases/NAME.py with some of its parameters set, and some of its Numerics changed."""
    case = load(ROOT / "cases" / f"{name}.py", [f"{key}={value}" for key, value in sets.items()])
    return case.changed(**{f"numerics.{key}": value for key, value in (numerics or {}).items()})


def water(shape, tank, numerics, **about):
    """Return the Case of water of a shape, or in a Box of these fields, between walls, or in a Tank of these fields.

    numerics : the spacing, or a dict of fields; about : further fields of the case, and of its Fluid
    """
    of_fluid = {name: about.pop(name) for name in set(Fluid.model_fields) & set(about)}
    shape = Box(*shape) if isinstance(shape, tuple) else shape
    walls = Tank(*tank) if isinstance(tank, tuple) and not isinstance(tank[0], Model) else tank
    numerics = Numerics(**(numerics if isinstance(numerics, dict) else {"spacing": numerics}))
    fluid = shape if isinstance(shape, Fluid) else Fluid(shape, **{"density": 1000.0, **of_fluid})
    return Case(**{"title": "water", "fluid": fluid, "walls": walls,
                   "gravity": (0.0, -9.81), "end_time": 1.0, "numerics": numerics, **about})


_MADE: list[driver.Simulation] = []


def simulated(case, steps=0, **options):
    """Return a Simulation of a case on this rank after some steps, which is freed after the test (see conftest.py)."""
    _MADE.append(driver.Simulation(case, MPI.COMM_SELF, **options))
    for _ in range(steps):
        _MADE[-1].advance()
    return _MADE[-1]


def at_end(case):
    """Return a Simulation in the same way, at the end of the case."""
    simulation = simulated(case)
    while not simulation.finished():
        simulation.advance()
    return simulation


def saved(s):
    """Return a checkpoint of a simulation on one rank, its state as JSON gives it back."""
    p = s.particles
    arrays = {name: np.array(getattr(p, name)) for name in p.fields.migrating}
    return Checkpoint(s.time, s.steps, s.dt or 0.0, to_json(s.case), json.loads(json.dumps(s.method.state())),
                      p.dim, arrays, 0, p.n_owned)


def sampled(simulation, *probes):
    """Yield {probe: its values} now and after each step until the end, and the report of that step, None of now.

    probes : in place of those of the case
    """
    case, report = simulation.case.changed(probes=probes) if probes else simulation.case, None
    samplers = instruments.build(case, simulation.comm)
    while True:
        yield instruments.sample_all(samplers, simulation.particles, simulation.domain, simulation.time), report
        if simulation.finished():
            return
        report = simulation.advance()


def at_start(case):
    """Return {probe: its values} of a case with the pressure of its start."""
    simulation = simulated(case)
    simulation.solve_start()
    return next(sampled(simulation))[0]


def budget(case):
    """Yield the works of each step of a run, and the gain of energy by the probe [J/m]."""
    before = None
    for found, report in sampled(simulated(case), Energy("energy")):
        if report is not None:
            yield report.works, found["energy"][2] - before
        before = found["energy"][2]


def free():
    """Free what `simulated` has made."""
    while _MADE:
        _MADE.pop().destroy()


def run_alone(case, folder, *words, **options):
    """Run a case into a folder, on this rank and without a progress line; return the summary."""
    return driver.run(case, MPI.COMM_SELF, folder, *words, progress=False, **options)


def ran(case, folder, *words):
    """Run a case in the same way, and return its Run."""
    run_alone(case, folder, *words)
    return open_run(folder)


def restart_alone(place, **options):
    """Go on with a run, in the same way."""
    return driver.restart(place, MPI.COMM_SELF, progress=False, **options)


def made_motion(folder):
    """Write a roll of 4 degrees, from rest and to rest, as the measured motion that cases/lateral_roll.py needs."""
    t = np.linspace(0.0, 8.35, 836)
    degrees = 4.0 * np.sin(np.pi * t / t[-1])**3 * np.sin(2.0 * np.pi * t / 1.63)
    lines = "".join(f"{time},{angle}\n" for time, angle in zip(t, degrees))
    (folder / "04a_spheric10_water_lateral_roll_motion.csv").write_text("t_s,roll_deg\n" + lines)


def on_ranks(n, body, folder, timeout=120):
    """Run PROGRAM + body on n ranks in a folder; raise AssertionError with its output if it fails."""
    path = folder / f"program{n}.py"
    path.write_text(PROGRAM + body)
    done = mpirun(n, [path], timeout=timeout, cwd=folder)
    assert done.returncode == 0, f"{n} ranks:\n{done.stdout}\n{done.stderr}"
    return done.stdout


def on_one_and_more(body, folder, most=3, timeout=120):
    """Run PROGRAM + body with a `comm` of one and of two ranks, and of three if that is the `most`, in one launch: to
    start ranks takes longer than most bodies."""
    comms = "everyone.Split(everyone.rank // 2)," + (" everyone" if most == 3 else "")
    return on_ranks(3, f"everyone = comm\nfor comm in ({comms}):\n{indent(body, '    ')}", folder, timeout)


STEPS = """
from pathlib import Path
from parisph.case.stored import from_json
for path in sorted(Path().glob("*.json")):
    s = Simulation(from_json(path.read_text()), comm)
    for _ in range({steps}):
        s.advance()
    s.complete({fields})
    found = s.gather(*{fields})
    if comm.rank == 0:
        np.savez(f"{{path.stem}}-{{comm.size}}.npz", **found)
    s.destroy()
"""


def after_steps(cases, steps, fields, folder, most=2):
    """Return {(name, ranks): fields of all particles} after steps of each Case of a dict, on 1 and 2 ranks, or to 3."""
    found = {}
    for name, case in cases.items():
        (folder / f"{name}.json").write_text(to_json(case))
        if most == 2:    # of three ranks, one is alone while two are at work
            s = simulated(case, steps)
            s.complete(fields)
            found[name, 1] = s.gather(*fields)
    body = STEPS.format(steps=steps, fields=fields)
    on_ranks(2, body, folder, 300) if most == 2 else on_one_and_more(body, folder, timeout=300)
    return found | {(name, n): np.load(folder / f"{name}-{n}.npz") for name in cases
                    for n in range(1, most + 1) if (name, n) not in found}


def on_two_and_then(n, body, first, then, folder):
    """Run PROGRAM + body, then `first` on two ranks and after it `then` on n, 1 or 3, in one launch."""
    others = "everyone" if n == 3 else "everyone.Split(everyone.rank)"
    return on_ranks(max(n, 2), f"""{body}
everyone, comm = comm, comm.Split(comm.rank // 2)
if everyone.rank < 2:
{indent(first, "    ")}
everyone.Barrier()
comm = {others}
if everyone.rank < {n}:
{indent(then, "    ")}
""", folder)


def assert_same(one, more, most=1e-9, fields=("x", "u", "p")):
    """Assert that fields of two flows differ by less than `most`, and that their particles have the same roles."""
    if "role" in one:
        np.testing.assert_array_equal(more["role"], one["role"])
    for field in fields:
        assert difference(more[field], one[field]) < most, field


def difference(a, b):
    """Return the largest difference of two arrays, relative to the largest value of the second."""
    return np.abs(a - b).max() / np.abs(b).max()
