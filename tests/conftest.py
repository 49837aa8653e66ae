"""Settings for all tests: one thread a rank, parallel h5py. Before anything imports numpy."""

import sys

import pytest

from parisph.base import environment

environment.prepare()


@pytest.fixture(autouse=True)
def _freed():
    """Free the Simulations that a test has made."""
    yield
    if "tests.scenes" in sys.modules:
        sys.modules["tests.scenes"].free()
