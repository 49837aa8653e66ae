"""Settings for all tests: one thread a rank, parallel h5py. Before anything imports numpy. The order of files."""

import sys
from pathlib import Path

import pytest

from parisph.base import environment

environment.prepare()

# Files that begin, for a new clone on two processes: the first compiles the kernels of 3D, the second those of 2D, and
# neither waits for nor repeats what the other does. Then come the longest, which would be left over at the end.
FIRST = ("physics/test_turning_in_3d.py", "physics/test_rest.py", "cli/test_looking.py", "cli/test_unread.py",
         "cli/test_study.py", "cli/test_without_mpi.py", "cli/test_option_files.py", "cli/test_outside_parts.py",
         "driver/test_methods_on_ranks.py", "driver/test_one_rank.py", "driver/test_faults.py",
         "driver/test_load_balance.py", "driver/test_surface_restart.py", "physics/test_coarse_scenes.py")


def pytest_collection_modifyitems(items):
    """Put FIRST first. The rest stays in the order of folders and names."""
    folder = Path(__file__).parent
    place = {folder / name: k for k, name in enumerate(FIRST)}
    assert all(path.is_file() for path in place)
    items.sort(key=lambda item: place.get(item.path, len(FIRST)))


@pytest.fixture(autouse=True)
def _freed():
    """Free the Simulations that a test has made."""
    yield
    if "tests.scenes" in sys.modules:
        sys.modules["tests.scenes"].free()
