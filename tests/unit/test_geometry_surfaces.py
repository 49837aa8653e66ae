"""Surfaces from files of triangles: what is read, mended and refused, with number and place."""

import sys

import numpy as np
import pytest

from parisph.base import paths
from parisph.base.errors import CaseError
from parisph.case.surface_body import Surface
from parisph.geometry.surface_files import read, sound
from tests.launch import run, succeeded
from tests.triangles import LIBRARIES, box, sheet, sphere, volume, write_stl

CUBE = box((0.2, 0.3, 0.4), (1.0, 0.0, 0.0))


def libraries():
    for name in LIBRARIES:
        pytest.importorskip(name, reason=f"{name} is not installed: pip install 'parisph[surfaces]'")


@pytest.mark.parametrize("binary", [True, False])
def test_stl_file_gives_its_triangles_in_metres(tmp_path, binary):
    libraries()
    path = write_stl(tmp_path / "box.stl", 1000.0 * CUBE, binary)
    found = read(Surface(file=str(path), scale=0.001, at=(0.5, 0.0, -0.1)))
    assert found.closed and found.notes == () and len(found.points) == 8 and len(found.corners) == 12
    np.testing.assert_allclose(found.points.min(axis=0), [1.5, 0.0, -0.1], atol=1e-6)
    assert found.volume == pytest.approx(0.024, rel=1e-6)


def test_obj_file_gives_the_same_volume(tmp_path):
    libraries()
    path = tmp_path / "ball.obj"
    corners = sphere(2, 0.5)
    lines = ["v {} {} {}".format(*x) for x in corners.reshape(-1, 3)]
    lines += [f"f {k} {k + 1} {k + 2}" for k in range(1, 3 * len(corners), 3)]
    path.write_text("\n".join(lines) + "\n")
    assert read(Surface(file=str(path))).volume == pytest.approx(volume(corners), rel=1e-12)


def test_file_that_changed_after_the_case_was_made_is_refused(tmp_path):
    libraries()
    surface = Surface(file=str(write_stl(tmp_path / "box.stl", CUBE)), name="rock")
    write_stl(tmp_path / "box.stl", 2.0 * CUBE)
    with pytest.raises(CaseError, match="walls, rock: box.stl: has changed since the case was made"):
        read(surface)


def test_file_without_triangles_is_refused(tmp_path):
    libraries()
    (tmp_path / "a.stl").write_text("not triangles\n")
    with pytest.raises(CaseError, match=r"walls, surface: a\.stl: (cannot be read|has no) "):
        read(Surface(file=str(tmp_path / "a.stl")))


def test_path_is_relative_to_the_case_file_and_must_be_there(tmp_path):
    write_stl(tmp_path / "box.stl", CUBE)
    token = paths.FOLDER.set(tmp_path)
    try:
        surface = Surface(file="box.stl")
        with pytest.raises(CaseError, match="none.stl.*cannot be read .No such file"):
            Surface(file="none.stl")
        with pytest.raises(CaseError, match="must be a file of triangles that ends in .stl"):
            Surface(file="box.step")
    finally:
        paths.FOLDER.reset(token)
    assert surface.file == str(tmp_path / "box.stl") and len(surface.digest) == 32


def test_stored_surface_needs_no_file(tmp_path):
    path = write_stl(tmp_path / "box.stl", CUBE)
    surface = Surface(file=str(path), scale=0.5)
    path.unlink()
    assert Surface.model_validate_json(surface.model_dump_json()) == surface


def test_surface_that_is_inside_out_is_turned_with_a_note():
    found = sound(CUBE[:, ::-1], "rock")
    assert found.volume == pytest.approx(0.024, rel=1e-12)
    assert found.notes[0].startswith("rock: all triangles are reversed at (")


def test_reversed_triangles_are_turned_with_a_note_of_their_place():
    corners = CUBE.copy()
    corners[[3, 7]] = corners[[3, 7], ::-1]
    found = sound(corners, "rock")
    assert found.volume == pytest.approx(0.024, rel=1e-12)
    place = "({:g}, {:g}, {:g})".format(*CUBE[3].mean(axis=0))
    assert found.notes == (f"rock: 2 of 12 triangles are reversed at {place}, "
                           "({:g}, {:g}, {:g}); they were turned round".format(*CUBE[7].mean(axis=0)),)


def test_hole_inside_a_solid_keeps_its_inward_surface():
    found = sound(np.concatenate([box((1.0, 1.0, 1.0)), box((0.5, 0.5, 0.5), (0.25, 0.25, 0.25))[:, ::-1]]), "shell")
    assert found.notes == () and found.volume == pytest.approx(0.875, rel=1e-12)


def test_copies_of_triangles_are_left_out_with_a_note():
    found = sound(np.concatenate([CUBE, CUBE[4:6]]), "rock")
    assert len(found.corners) == 12
    assert found.notes[0].startswith("rock: 2 triangles are there twice at (")


def test_open_edges_of_a_solid_are_refused_with_number_place_and_size():
    with pytest.raises(CaseError) as told:
        sound(np.delete(CUBE, [0, 2], axis=0), "rock")
    assert str(told.value).startswith("rock: has 2 holes with 6 open edges at (")
    assert "the largest 0.5 m across; a solid must be closed" in str(told.value)


def test_edge_of_three_triangles_is_refused_with_its_place():
    fin = np.array([[(1.0, 0.0, 0.0), (1.0, 0.3, 0.0), (0.5, 0.2, 0.0)]])
    with pytest.raises(CaseError, match=r"at 1 edges more than two triangles meet at \(1, 0.15, 0\)"):
        sound(np.concatenate([CUBE, fin]), "rock")


def test_moebius_strip_is_refused():
    angle = np.linspace(0.0, 2.0 * np.pi, 13)
    way = np.stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], axis=1)
    middle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    low, high = middle - 0.3 * way, middle + 0.3 * way
    strip = np.concatenate([np.stack(part, axis=1) for part in (
        (low[:-1], low[1:], high[1:]), (low[:-1], high[1:], high[:-1]))])
    with pytest.raises(CaseError, match="one-sided|1 hole with"):
        sound(strip, "strip")


def test_bathymetry_is_an_open_bed_that_faces_up():
    bed = sheet(lambda x, y: 0.1 * np.sin(3.0 * x) * np.cos(2.0 * y), (-1.0, -1.0), (1.0, 2.0), (12, 15))
    found = sound(bed[:, ::-1], "bed")
    assert not found.closed
    assert found.notes[0].startswith("bed: all triangles are reversed")
    a, b, c = np.moveaxis(found.places, 1, 0)
    assert np.all(np.cross(b - a, c - a)[:, 2] > 0.0)


def test_bed_that_overhangs_or_has_a_hole_is_refused():
    bed = sheet(lambda x, y: 0.0 * x, (0.0, 0.0), (1.0, 1.0), (10, 10))
    folded = bed.copy()
    folded[..., 0] = np.where(bed[..., 0] > 0.7, 1.4 - bed[..., 0], bed[..., 0])
    folded[..., 2] = np.where(bed[..., 0] > 0.7, bed[..., 0] - 0.7, 0.0)
    with pytest.raises(CaseError, match="must not overhang"):
        sound(folded, "bed")
    with pytest.raises(CaseError, match="has 2 holes"):
        sound(np.delete(bed, 45, axis=0), "bed")


def test_runs_can_be_opened_after_a_surface_was_read(tmp_path):
    """pymeshlab, loaded before h5py, makes HDF5 unloadable; no test of its own process would notice."""
    libraries()
    path = write_stl(tmp_path / "box.stl", CUBE)
    succeeded(run([sys.executable, "-c", f"""
from parisph.case.surface_body import Surface
from parisph.geometry import surface_files
assert surface_files.crossing(Surface(file={str(path)!r}))[0] == 0
from parisph import open_run
"""]))
