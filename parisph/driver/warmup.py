"""Compile the kernels on one rank, so the others can load them."""

import hashlib
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from mpi4py import MPI

from parisph.base.errors import ParisphError, agree
from parisph.case.numerics import ResolvedNumerics
from parisph.case.schema import Box, Case, Fluid, Obstacle, StillWater, Tank
from parisph.kernels import jit, processor
from parisph.parallel import halo
from parisph.pressure import matrices
from parisph.watch import instruments
from parisph.watch.probes.energy_probe import Energy
from parisph.watch.probes.volume import Volume

CELLS = 8      # spacings: sides of the small tank
FILLED = 6     # spacings: sides of the body of fluid in it
STEP = 1e-3    # [s]: very short


def on_one_rank_first(comm: MPI.Comm, make: Callable[[Case, MPI.Comm], Any], case: Case,
                      numerics: ResolvedNumerics) -> None:
    """Take one step of a small scene on rank 0, which fills the cache of compiled kernels. Collective.

    The other ranks wait and then load the kernels from the cache. Otherwise each would compile all of them, which takes
    a minute, in 3D two. It is skipped if it was done before.

    make : function (case, comm) -> Simulation
    case, numerics : the scene whose kernels are needed

    Raises ParisphError on every rank: something other than the scene failed on rank 0, such as the compiler.
    """
    problem = None
    if comm.rank == 0:
        try:
            scene = small(case, numerics)
            name = mark_of(scene)
            if jit.FOLDERS.first(name) is None:
                _step(make(scene, MPI.COMM_SELF))
                if jit.FOLDERS.write is not None:
                    with suppress(OSError):    # a full disk: the next run tries again
                        (jit.FOLDERS.write / name).touch()
        except ParisphError:
            pass    # the real scene reports the same error on all ranks
        except Exception as error:
            problem = error
    comm.Barrier()    # other threads of waiting ranks run in it, but not in the sums of `agree`
    agree(comm, problem)


def mark_of(scene: Case) -> str:
    """Return the name of the file that marks the kernels of a small scene as compiled. Not collective.

    It depends on the processor and the release of numba, as do the kernels.
    """
    key = (scene.model_dump_json(), *processor.identity())
    return f"ready-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}"


def small(case: Case, numerics: ResolvedNumerics) -> Case:
    """Return a scene of few particles that needs the same kernels: closed if the case is closed, in 3D if it is.

    Its spacing is 1 m, so that cases that differ only by their spacing share it.
    """
    side = float(CELLS)
    filled = side if case.closed else float(FILLED)
    water = StillWater(level=side) if case.closed else Box(width=filled, height=filled)
    tank = Tank(width=side, height=side, lid=True, breadth=filled if case.dim == 3 else None)
    block = Obstacle(Box(width=2.0, height=2.0, at=(0.5 * (filled - 1.0), 0.0)))
    return Case(
        title="small", fluid=Fluid(water, density=1000.0), walls=(tank, block), gravity=(0.0, -1.0),
        probes=(Volume("volume"), Energy("energy")), end_time=1.0,
        numerics=numerics.model_copy(update={"spacing": 1.0, "time_step": STEP, "max_time_step": None, "jitter": 0.0}),
    )


def _step(simulation: Any) -> None:
    try:
        matrices.compile_for_ranks()
        halo.compile_for_ranks()
        simulation.advance()
        samplers = instruments.build(simulation.case, simulation.comm)
        instruments.sample_all(samplers, simulation.particles, simulation.domain, simulation.time)
    finally:
        simulation.destroy()
