"""A Simulation that cannot be made gives back what it took: communicators, PETSc's objects, options."""

from pathlib import Path

import pytest
from mpi4py import MPI

from parisph import Box, Case, CaseError, Fluid, Numerics, ParisphError, Tank
from parisph.driver import Simulation, simulation, warmup
from parisph.geometry import build as geometry
from parisph.parallel.guard import Guard
from parisph.parallel.petsc import PETSc

SMALL = Case(title="small", fluid=Fluid(Box(width=1.0, height=0.5), density=1000.0), gravity=(0.0, -9.81),
             walls=Tank(width=1.0, height=1.0), numerics=Numerics(spacing=0.25, time_step=0.01), end_time=0.1)


@pytest.fixture
def counted(comm):
    """A communicator whose copies, and theirs, are counted: (communicator, function that tells how many there are)."""
    copies = 0

    def copied(*_):
        nonlocal copies
        copies += 1
        return True

    def freed(*_):
        nonlocal copies
        copies -= 1

    key = MPI.Comm.Create_keyval(copied, freed)
    own = comm.Dup()
    own.Set_attr(key, True)
    Guard.of(own)    # keeps one copy as long as the communicator lives
    PETSc.Vec().createMPI(4, comm=own).destroy()    # PETSc may do so too
    yield own, lambda: copies
    own.Free()
    assert copies == -1, "every copy is freed, and the communicator, which was none"
    MPI.Comm.Free_keyval(key)


def _fails(*_, **__):
    raise RuntimeError("this part fails")


def bad_option(monkeypatch):
    return dict(petsc_options=["-pressure_pc_type", "nonsense"]), "nonsense"


def bad_geometry(monkeypatch):
    monkeypatch.setattr(geometry, "build", _fails)
    return {}, "this part fails"


def bad_particles(monkeypatch):
    monkeypatch.setattr(geometry, "build", lambda *_: {"u": [1.0]})
    return {}, "x is missing"


def bad_method(monkeypatch):
    """After the solver has been made."""
    def fails(*_, **__):
        raise ParisphError("no such method")
    monkeypatch.setattr(simulation, "Projection", fails)
    return {}, "no such method"


def bad_warm_up(monkeypatch):
    """What no rank but the first sees; alone it has nothing to warm up."""
    monkeypatch.setattr(warmup, "_step", _fails)
    monkeypatch.setattr(warmup, "mark_of", lambda scene: Path("no mark"))
    monkeypatch.setattr(geometry, "build", _fails)
    return {}, "this part fails"


@pytest.mark.parametrize(("place", "count"), [
    (bad_geometry, 200), (bad_particles, 50), (bad_option, 20), (bad_method, 20), (bad_warm_up, 20)])
def test_failures_leave_nothing(counted, monkeypatch, place, count):
    """Many of the quickest: an MPI library runs out of communicators, also of those that are not copies."""
    comm, copies = counted
    options, message = place(monkeypatch)
    before, database = copies(), PETSc.Options().getAll()
    for _ in range(count):
        with pytest.raises(ParisphError, match=message):
            Simulation(SMALL, comm, **options)
    assert copies() == before
    assert PETSc.Options().getAll() == database


def test_one_that_is_made_gives_back_all_too(counted):
    comm, copies = counted
    before = copies()
    made = Simulation(SMALL, comm)
    made.advance()
    assert copies() > before
    made.destroy()
    made.destroy()
    assert copies() == before


@pytest.mark.parametrize(("values", "options", "says"), [
    ({"end_time": lambda rank: 0.1 + rank, "walls.width": lambda rank: 1.0 + 0.25 * rank}, None,
     "in walls, end_time: make it"),
    ({}, lambda rank: ["-pressure_ksp_rtol", f"1e-{6 + rank}"], "in petsc_options"),
])
def test_case_that_differs_from_rank_to_rank_is_refused(counted, values, options, says):
    """A script makes its case on each rank: by host, clock or random numbers they differ, and wait for each other
    forever."""
    comm, copies = counted
    before = copies()
    case = SMALL.changed(**{name: value(comm.rank) for name, value in values.items()})
    given = dict(petsc_options=options and options(comm.rank))
    if comm.size == 1:
        Simulation(case, comm, **given).destroy()
    else:
        with pytest.raises(CaseError, match=f"rank 1: another case than on rank 0, {says}"):
            Simulation(case, comm, **given)
    assert copies() == before
