"""Snapshots as VTK and ParaView read them: their own readers, in processes of their own.

A process can hold one HDF5 only, and VTK brings another one than h5py. Which Pythons have VTK may be said:

    pip install 'parisph[vtk]'                                              the one that runs the tests
    PARISPH_VTK_PYTHON=/path/python:/usr/bin/pvpython run_scripts/test tests/unit/test_vtk.py    others, also ParaView's
"""

import importlib.util
import json
import os
import sys

import numpy as np
import pytest
from mpi4py import MPI

from parisph.io import snapshot
from parisph.io.layout import INDEX
from parisph.io.store import Store
from parisph.io.wall_cells import WallCells
from tests.launch import run
from tests.owned_rows import OwnedRows

NAMED = os.environ.get("PARISPH_VTK_PYTHON")
PYTHONS = NAMED.split(os.pathsep) if NAMED else [sys.executable]
NO_VTK = not NAMED and importlib.util.find_spec("vtkmodules") is None

pytestmark = pytest.mark.skipif(NO_VTK,
                                reason="no VTK here: pip install 'parisph[vtk]', or name a Python that has it in "
                                               "PARISPH_VTK_PYTHON")

# Prints one JSON object about the file that it is given.
READ = """
import json, sys
from vtkmodules.vtkIOHDF import vtkHDFReader
reader = vtkHDFReader()
assert reader.CanReadFile(sys.argv[1])
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
def rows(array):
    return [array.GetTuple(number) for number in range(array.GetNumberOfTuples())]
points, fields = grid.GetPointData(), grid.GetFieldData()
def cell(number):
    found = grid.GetCell(number)
    return found.GetCellType(), found.GetNumberOfPoints(), found.GetPointId(0)
print(json.dumps({
    "class": grid.GetClassName(),
    "points": rows(grid.GetPoints().GetData()),
    "cells": [cell(number) for number in range(grid.GetNumberOfCells())],
    "arrays": {points.GetArrayName(number): rows(points.GetArray(number))
               for number in range(points.GetNumberOfArrays())},
    "body": rows(grid.GetCellData().GetArray("body")) if grid.GetCellData().HasArray("body") else None,
    "corners": [[grid.GetCell(number).GetPointId(k) for k in range(grid.GetCell(number).GetNumberOfPoints())]
                for number in range(grid.GetNumberOfCells())],
    "fields": {fields.GetArrayName(number): rows(fields.GetArray(number))
               for number in range(fields.GetNumberOfArrays())},
}))
"""

# Opens a file as File > Open does: ParaView finds the reader by the name of the file.
OPEN = """
import json, sys
try:
    from paraview import simple
except ImportError:
    print(json.dumps(None))
    sys.exit()
series = simple.OpenDataFile(sys.argv[1])
numbers = []
for time in series.TimestepValues:
    series.UpdatePipeline(time)
    numbers.append(series.GetDataInformation().GetNumberOfPoints())
print(json.dumps([list(series.TimestepValues), numbers]))
"""


def result(python, program, path):
    """Return what a program prints about a file."""
    done = run([python, "-c", program, path])
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("python", PYTHONS)
@pytest.mark.parametrize("dim", [2, 3])
def test_vtk_reads_points_cells_arrays_and_time(tmp_path, python, dim):
    particles = OwnedRows([23], 0, dim)
    snapshot.write(MPI.COMM_SELF, tmp_path / "a.vtkhdf", particles, 0.25, 7, ("u", "p", "normal"), {"case": "{}"})
    found = result(python, READ, tmp_path / "a.vtkhdf")
    assert found["class"].endswith("UnstructuredGrid") and found["fields"] == {"TimeValue": [[0.25]], "Step": [[7]]}
    assert found["cells"] == [[1, 1, number] for number in range(23)]    # type vertex, one point
    assert np.array(found["points"]).shape == (23, 3)
    np.testing.assert_array_equal(np.array(found["points"])[:, :dim], particles.x)
    assert not np.array(found["points"])[:, dim:].any()
    assert set(found["arrays"]) == {"id", "kind", "role", "velocity", "pressure", "normal"}
    for name, data in (("id", particles.id), ("kind", particles.kind), ("role", particles.role),
                       ("pressure", particles.p), ("velocity", particles.u), ("normal", particles.normal)):
        np.testing.assert_array_equal(np.array(found["arrays"][name])[:, : data[0].size],
                                      data.reshape(23, -1), err_msg=name)


@pytest.mark.parametrize("python", PYTHONS)
def test_vtk_reads_the_triangles_of_walls(tmp_path, python):
    particles = OwnedRows([23], 0, 3)
    ids = np.array([(19, 20, 21), (21, 20, 22)])
    walls = WallCells(ids, np.array([0, 2]))
    snapshot.write(MPI.COMM_SELF, tmp_path / "a.vtkhdf", particles, 0.25, 7, ("p",), {}, walls)
    found = result(python, READ, tmp_path / "a.vtkhdf")
    assert [kind for kind, _, _ in found["cells"]] == [1] * 23 + [5, 5]    # types vertex and triangle
    assert found["body"] == [[-1]] * 23 + [[0], [2]]
    np.testing.assert_array_equal(particles.id[found["corners"][23:]], ids)


@pytest.mark.parametrize("python", PYTHONS)
def test_paraview_opens_the_index_as_a_series(tmp_path, python):
    store = Store.create(MPI.COMM_SELF, tmp_path / "run", "{}")
    for step in range(3):
        store.snapshot(OwnedRows([20 + step], 0), 0.1 * step, step)
    store.close()
    found = result(python, OPEN, tmp_path / "run" / INDEX)
    if found is None:
        pytest.skip(f"{python} has VTK, but not ParaView")
    assert found == [[0.0, 0.1, 0.2], [20, 21, 22]]
