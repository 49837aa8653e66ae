"""A process that is killed at any moment leaves its last checkpoint whole."""

import subprocess
import sys
import time

import numpy as np
import pytest
from mpi4py import MPI

from parisph.io import checkpoint
from parisph.io.store import Store
from tests.launch import clean_environment
from tests.owned_rows import OwnedRows

WRITER = """
import sys
from mpi4py import MPI
from parisph.io.store import Store
from tests.launch import clean_environment
from tests.owned_rows import OwnedRows

store = Store.create(MPI.COMM_SELF, sys.argv[1], '{"title": "kill"}')
store.add_series("steps", {"dt": "s"})
particles = OwnedRows([20000], 0)
step = 0
while True:
    particles.p[:] = step
    store.append(0.1 * step, step, {"steps": (0.1,)})
    store.checkpoint(particles, 0.1 * step, step, 0.1, {})
    if step == 0:
        print("ready", flush=True)
    step += 1
"""


@pytest.mark.parametrize("trial", range(6))
def test_kill_9_leaves_whole_checkpoints(tmp_path, trial):
    process = subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path / "run")], env=clean_environment(),
                               stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(np.random.default_rng(trial).uniform(0.0, 0.15))
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    found = checkpoint.paths(tmp_path / "run" / "checkpoints")
    assert 1 <= len(found) <= 3  # between the new name and the removal of the oldest there are three
    for path in found:
        loaded = checkpoint.read(MPI.COMM_SELF, path)
        assert loaded.step == int(path.stem) and loaded.total == 20000
        np.testing.assert_array_equal(loaded.arrays["p"], loaded.step)
    last = found[-1]
    store = Store.resume(MPI.COMM_SELF, tmp_path / "run", loaded.case, loaded.time, loaded.step,
                         checkpoints=loaded.state["checkpoints"])
    store.add_series("steps", {"dt": "s"})
    store.checkpoint(OwnedRows([20000], 0), loaded.time + 0.1, loaded.step + 1, 0.1, {})
    store.close()
    assert len(checkpoint.paths(last.parent)) == checkpoint.KEEP
    assert not list((tmp_path / "run").rglob(".*"))  # what the killed process left half written
