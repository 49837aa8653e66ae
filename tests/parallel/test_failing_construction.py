"""A Simulation that cannot be made gives back what it took: communicators, PETSc's objects, options."""

import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, ParisphError, Tank
from parisph.case import geometry
from parisph.driver import Simulation, simulation, warmup
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
    PETSc.Vec().createMPI(4, comm=own).destroy()    # PETSc keeps its copy of a communicator, if at all, from here on
    yield own, lambda: copies
    own.Free()
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
    monkeypatch.setattr(geometry, "build", _fails)
    return {}, "this part fails"


@pytest.mark.parametrize(("place", "count"), [
    (bad_geometry, 1000), (bad_particles, 50), (bad_option, 20), (bad_method, 20), (bad_warm_up, 20)])
def test_failures_leave_nothing(counted, monkeypatch, place, count):
    """A thousand of the quickest: an MPI library runs out of communicators."""
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
