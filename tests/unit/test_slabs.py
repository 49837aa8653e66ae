"""Files of arrays on a disk that is too small for them."""

import subprocess
import sys

import pytest

from tests.launch import clean_environment

WRITER = """
import resource, sys
from pathlib import Path
import numpy as np
from mpi4py import MPI
from parisph.base.errors import StoreError
from parisph.io import slabs

path, length, most = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
arrays = [slabs.Slab("particles/x", np.zeros((1000, 2)), 0, 1000)]
decorate = lambda file: file.attrs.update(case="c" * length, time=0.5)
resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
try:
    slabs.write(MPI.COMM_SELF, path, arrays, decorate)
    print("written")
except StoreError as error:
    print(error)
"""


@pytest.mark.parametrize("length, most, says", [
    (19_000_000, 5_000_000, "File too large"), (19_000_000, 18_900_000, "File too large"),
    (19_000_000, 19_050_000, "File too large"), (19_000_000, 30_000_000, "written"), (1000, 2_000_000, "written"),
    (1000, 10_000, "File too large"),
])
def test_a_long_case_on_a_full_disk_is_an_error_and_ends_no_process(tmp_path, length, most, says):
    """A real refusal by the kernel; HDF5 must not run into it, because HDF5 1.10 then ends the process."""
    done = subprocess.run([sys.executable, "-c", WRITER, str(tmp_path / "a.h5"), str(length), str(most)],
                          env=clean_environment(), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr[-500:]
    assert done.stdout.strip().endswith(says)
    assert [path.name for path in tmp_path.iterdir()] == (["a.h5"] if says == "written" else [])
