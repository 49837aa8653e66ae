"""Tests in this folder run on every rank at once: `mpirun -n 2 python -m pytest tests/parallel`.

The ranks agree on the outcome of each test, and one that hangs is ended with a traceback from
each rank: a collective that one rank misses would otherwise wait forever, and say nothing.
"""

import faulthandler
import os
import time

import pytest
from mpi4py import MPI

from parisph.parallel import guard

WHOLE_TEST = 300.0    # [s] a test may take this long, also where it compiles its kernels
OTHER_RANKS = 120.0    # [s] a rank that has ended a test waits this long for the others

guard.PATIENCE = OTHER_RANKS    # the agreement below says more of a test that fails on one rank

_world = MPI.COMM_WORLD
_failure = pytest.StashKey()


@pytest.fixture(scope="session")
def comm():
    """A communicator of all ranks, apart from the one by which the ranks agree on outcomes."""
    own = _world.Dup()
    yield own
    own.Free()


def pytest_configure(config):
    # A copy of standard error that pytest does not capture.
    config.unheard = os.fdopen(os.dup(2), "w")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if report.failed:
        item.stash[_failure] = report.longreprtext
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    if _world.size > 1:
        faulthandler.dump_traceback_later(WHOLE_TEST, exit=True, file=item.config.unheard)
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item):
    """Before the fixtures go (some are collective), hear whether all ranks have passed."""
    faulthandler.cancel_dump_traceback_later()
    failed = _world.size > 1 and _failed_ranks(item)
    result = yield
    if failed and _failure not in item.stash:
        pytest.fail(f"failed on rank {', '.join(map(str, failed))} (see standard error)", pytrace=False)
    return result


def _failed_ranks(item):
    """Return the ranks on which the test failed; end the job if some rank does not answer."""
    mine = item.stash.get(_failure, None)
    if mine is not None and _world.rank > 0:
        _say(item, mine)
    flags = bytearray(_world.size)
    request = _world.Iallgather(bytes([mine is not None]), flags)
    deadline = time.monotonic() + OTHER_RANKS
    while not request.Test():
        if time.monotonic() > deadline:
            here = mine if mine and _world.rank == 0 else "failed" if mine else "passed"
            _say(item, here + "\n... on this rank; other ranks hang in this test, and all are ended.")
            _world.Abort(1)
        time.sleep(0.001)
    return [rank for rank, flag in enumerate(flags) if flag]


def _say(item, text):
    print(f"\n---- rank {_world.rank}: {item.nodeid}\n{text}\n", file=item.config.unheard, flush=True)
