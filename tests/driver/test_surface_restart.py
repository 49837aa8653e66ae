"""A run with a Surface goes on from its folder alone: on more ranks, without the file and without the libraries."""

import h5py
import numpy as np
import pytest
from mpi4py import MPI

from parisph import Case, Fluid, Numerics, StillWater, Surface, Tank
from parisph.base.errors import StoreError
from parisph.io import reader, room_file
from tests.running import last_checkpoint
from tests.scenes import assert_same, on_ranks
from tests.triangles import LIBRARIES, sphere, write_stl

for name in LIBRARIES:
    pytest.importorskip(name, reason=f"{name} is not installed: pip install 'parisph[surfaces]'")

BODY = """
from parisph import *
from parisph import driver

def fall(end):
    return Case(title="Rock", fluid=Fluid(Box(width=0.6, height=0.5, breadth=0.6), 1000.0), gravity=(0.0, -9.81),
                walls=[Tank(width=1.2, height=0.8, breadth=0.6), Surface("rock.stl", name="rock")],
                numerics=Numerics(spacing=0.1, rtol=1e-13, time_step=0.01), end_time=end,
                output=Output(every=0.05, checkpoint_every=0.1))
"""
FIRST = """
driver.run(fall(0.2), comm, "whole", progress=False)
"""
THEN = """
import sys
for name in ("trimesh", "manifold3d", "pymeshlab"):
    sys.modules[name] = None    # as if they were not installed
driver.restart("whole/checkpoints/00000010.h5", comm, until=0.2, out="other", progress=False)
"""


def test_goes_on_without_the_file_and_the_libraries(tmp_path):
    write_stl(tmp_path / "rock.stl", sphere(3, 0.15, (0.75, 0.3, 0.05)))
    on_ranks(1, BODY + FIRST, tmp_path, timeout=300)
    (tmp_path / "rock.stl").unlink()
    on_ranks(2, BODY + THEN, tmp_path, timeout=300)
    (due, expected), (found, fields) = (last_checkpoint(tmp_path / run) for run in ("whole", "other"))
    assert (found["ranks"], found["step"]) == (2, due["step"]) == (2, 20)
    assert np.abs(expected["u"]).max() > 0.5
    assert_same(expected, fields, 1e-8, ("x", "u", "p"))
    with h5py.File(tmp_path / "whole" / "walls.h5") as whole, h5py.File(tmp_path / "other" / "walls.h5") as other:
        for name in ("nodes", "triangles", "body"):
            np.testing.assert_array_equal(whole[name], other[name])
    assert reader.open_run(tmp_path / "other").scene.surfaces[0].name == "rock"


def test_damaged_walls_are_refused(tmp_path):
    write_stl(tmp_path / "rock.stl", sphere(3, 0.15, (0.75, 0.3, 0.05)))
    case = Case(title="Rock", fluid=Fluid(StillWater(level=0.3), 1000.0), gravity=(0.0, -9.81), end_time=1.0,
                walls=[Tank(width=1.2, height=0.8, breadth=0.6), Surface(str(tmp_path / "rock.stl"))],
                numerics=Numerics(spacing=0.1))
    room_file.keep(MPI.COMM_SELF, tmp_path, case, "a")
    path = tmp_path / "walls.h5"
    data = bytearray(path.read_bytes())
    data[3000] ^= 1
    path.write_bytes(data)
    with pytest.raises(StoreError, match="walls.h5 is damaged"):
        room_file.remember(tmp_path, case)
