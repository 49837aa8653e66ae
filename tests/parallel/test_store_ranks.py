"""Snapshots and checkpoints from any number of ranks, and errors that reach all of them."""

import json
import os
import resource
import tempfile
from pathlib import Path
from time import sleep

import h5py
import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import StoreError
from parisph.base.fields import FIELDS
from parisph.io import checkpoint, digest, files, slabs, snapshot
from parisph.io.store import Store
from parisph.io.wall_cells import WallCells
from parisph.parallel.particles import Particles
from tests.owned_rows import OwnedRows, everything

WORLD = MPI.COMM_WORLD
CASE = json.dumps({"title": "made up", "fluid": {"density": 1000.0}})


@pytest.fixture
def folder():
    """A folder that all ranks share, removed at the end."""
    holder = tempfile.TemporaryDirectory() if WORLD.rank == 0 else None
    yield Path(WORLD.bcast(holder.name if holder else None))
    WORLD.barrier()
    if holder:
        holder.cleanup()


def first_ranks(count):
    """A communicator of the first `count` ranks; None on the others."""
    comm = WORLD.Split(0 if WORLD.rank < count else MPI.UNDEFINED, WORLD.rank)
    return None if comm == MPI.COMM_NULL else comm


def spreads(size):
    """Ways to spread 11 particles over ranks: evenly, all on the first, all on the last."""
    even = [11 // size + (rank < 11 % size) for rank in range(size)]
    return [even, [11] + [0] * (size - 1), [0] * (size - 1) + [11]]


@pytest.mark.parametrize("way", range(3))
@pytest.mark.parametrize("dim", [2, 3])
def test_snapshot_has_every_row_once_however_spread(folder, way, dim):
    particles = OwnedRows(spreads(WORLD.size)[way], WORLD.rank, dim)
    snapshot.write(WORLD, folder / "a.vtkhdf", particles, 0.25, 7, ("u", "p", "normal"), {"case": CASE})
    truth = everything(11, dim)
    order = np.argsort(truth["id"])
    found = snapshot.read(folder / "a.vtkhdf")
    assert (found["time"], found["step"]) == (0.25, 7)
    for name in ("x", "u", "p", "normal", "id", "kind", "role"):
        np.testing.assert_array_equal(found[name], truth[name][order], err_msg=name)
    with h5py.File(folder / "a.vtkhdf", "r") as file:
        np.testing.assert_array_equal(file["VTKHDF/Offsets"][()], np.arange(12))
        np.testing.assert_array_equal(file["VTKHDF/Connectivity"][()], np.arange(11))
        np.testing.assert_array_equal(file["VTKHDF/Types"][()], np.ones(11))
        assert file["VTKHDF/Points"].shape == (11, 3)


@pytest.mark.parametrize("way", range(3))
def test_snapshots_have_the_triangles_of_walls_between_the_rows_of_their_nodes(folder, way):
    particles = OwnedRows(spreads(WORLD.size)[way], WORLD.rank, 3)
    # nodes have the ids 5 to 10, and 12 is missing: a triangle without one of its nodes is left out
    ids = np.array([(5, 6, 7), (7, 6, 8), (10, 12, 9), (8, 9, 10)])
    snapshot.write(WORLD, folder / "a.vtkhdf", particles, 0.25, 7, (), {}, WallCells(ids, np.array([0, 0, 3, 3])))
    with h5py.File(folder / "a.vtkhdf", "r") as file:
        group = {name: data[()] for name, data in file["VTKHDF"].items() if isinstance(data, h5py.Dataset)}
        body, row_ids = file["VTKHDF/CellData/body"][()], file["VTKHDF/PointData/id"][()]
    assert (group["NumberOfPoints"], group["NumberOfCells"], group["NumberOfConnectivityIds"]) == (11, 14, 20)
    assert group["Offsets"][0] == 0 and group["Offsets"][-1] == 20 and len(group["Offsets"]) == 15
    corners = np.split(group["Connectivity"], group["Offsets"][1:-1])
    assert [len(cell) for cell in corners] == np.where(group["Types"] == 5, 3, 1).tolist()
    vertices = [cell[0] for cell in corners if len(cell) == 1]
    np.testing.assert_array_equal(vertices, np.arange(11))
    triangles = {tuple(row_ids[cell].tolist()): int(number) for cell, number in zip(corners, body) if len(cell) == 3}
    assert triangles == {(5, 6, 7): 0, (7, 6, 8): 0, (8, 9, 10): 3}
    np.testing.assert_array_equal(body[group["Types"] == 1], -1)


@pytest.mark.parametrize("way", range(3))
def test_checkpoint_is_read_on_any_number_of_ranks(folder, way):
    truth = everything(11)
    for writers in range(1, WORLD.size + 1):
        comm = first_ranks(writers)
        if comm:
            particles = OwnedRows(spreads(writers)[way], comm.rank)
            checkpoint.write(comm, folder, particles, 1.5, writers, 0.001, CASE, {"last": np.float64(0.1)}, {})
        WORLD.barrier()
        for readers in range(1, WORLD.size + 1):
            comm = first_ranks(readers)
            if comm:
                found = checkpoint.read(comm, folder / f"{writers:08d}.h5")
                share = np.array_split(np.arange(11), readers)[comm.rank]
                assert found.offset == share[0] and found.total == 11 and found.dim == 2
                assert (found.time, found.step, found.dt, found.case) == (1.5, writers, 0.001, CASE)
                assert found.state == {"last": 0.1, "checkpoints": [f"{writers:08d}.h5"]}
                assert set(found.arrays) == {name for name, field in FIELDS.items() if field.migrates}
                for name, data in found.arrays.items():
                    np.testing.assert_array_equal(data, truth[name][share], err_msg=name)
                    assert data.dtype == FIELDS[name].dtype
        WORLD.barrier()


def test_more_ranks_than_particles(folder):
    counts = [1] + [0] * (WORLD.size - 1)
    checkpoint.write(WORLD, folder, OwnedRows(counts, WORLD.rank), 0.0, 0, 0.1, CASE, {}, {})
    found = checkpoint.read(WORLD, folder / "00000000.h5")
    assert len(found.arrays["x"]) == (WORLD.rank == 0)
    assert found.arrays["x"].shape[1:] == (2,)


def test_particles_go_into_a_checkpoint_and_come_back(folder):
    """The container of a run, with ghosts or without: only owned rows are written, and `assign` takes what is read."""
    particles = Particles(WORLD, 2)
    source = OwnedRows(spreads(WORLD.size)[1], WORLD.rank)  # all on the first rank
    particles.assign({name: getattr(source, name) for name in FIELDS})
    checkpoint.write(WORLD, folder, particles, 0.0, 0, 0.1, CASE, {}, {})
    found = checkpoint.read(WORLD, folder / "00000000.h5")
    again = Particles(WORLD, 2)
    again.assign(found.arrays)
    assert again.n_global == 11 and again.offset == found.offset
    share = np.array_split(np.arange(11), WORLD.size)[WORLD.rank]
    np.testing.assert_array_equal(again.u, everything(11)["u"][share])
    snapshot.write(WORLD, folder / "a.vtkhdf", again, 0.0, 0, ("u",), {})
    np.testing.assert_array_equal(snapshot.read(folder / "a.vtkhdf")["id"], np.arange(11))


@pytest.mark.parametrize("way", range(3))
def test_a_file_has_the_same_digest_on_any_number_of_ranks(folder, way, monkeypatch):
    monkeypatch.setattr(digest, "CHUNK", 1000)
    snapshot.write(WORLD, folder / "a.vtkhdf", OwnedRows(spreads(WORLD.size)[way], WORLD.rank), 0.25, 7, ("u",), {})
    digest.check(folder / "a.vtkhdf")    # each rank alone
    for readers in range(1, WORLD.size + 1):
        comm = first_ranks(readers)
        if comm:
            digest.check_together(comm, folder / "a.vtkhdf")
    WORLD.barrier()
    if WORLD.rank == WORLD.size - 1:
        flip(folder / "a.vtkhdf", 5003)
    WORLD.barrier()
    with pytest.raises(StoreError, match="a.vtkhdf is damaged: its content does not match the digest"):
        digest.check_together(WORLD, folder / "a.vtkhdf")
    with pytest.raises(StoreError, match="a.vtkhdf is damaged: its content does not match the digest"):
        digest.check(folder / "a.vtkhdf")


def flip(path, place):
    """Flip one bit of the byte at `place`."""
    with open(path, "r+b") as file:
        file.seek(place)
        byte = file.read(1)[0]
        file.seek(place)
        file.write(bytes([byte ^ 4]))


def sealed(path, change):
    """Change the HDF5 part of a file by change(h5py.File) and give it the digest of what it then is."""
    os.truncate(path, path.stat().st_size - digest.LENGTH)
    with h5py.File(path, "r+") as file:
        change(file)
    digest.append(MPI.COMM_SELF, path)


def in_rows(path):
    with h5py.File(path, "r") as file:
        place = file["particles/u"].id.get_offset() + 8 * 13 + 3
    flip(path, place)


def in_case(path):
    flip(path, path.read_bytes().index(b"made up"))


def in_attributes_heap(path):
    """Zero a block of the strings, which HDF5 1.10 then reads forever."""
    content = path.read_bytes()
    place = content.index(b"GCOL")
    path.write_bytes(content[:place] + bytes(512) + content[place + 512:])


def is_foreign(path):
    h5py.File(path, "w").close()
    digest.append(MPI.COMM_SELF, path)


FAULTS = [
    (in_rows, "is damaged"), (in_case, "is damaged"), (in_attributes_heap, "is damaged"),
    (lambda path: os.truncate(path, path.stat().st_size // 2), "no digest at its end"),
    (lambda path: os.truncate(path, path.stat().st_size - 1), "no digest at its end"),
    (lambda path: path.unlink(), "there is no file"),
    (lambda path: path.write_text("not HDF5"), "no digest at its end"),
    (lambda path: h5py.File(path, "w").close(), "no digest at its end"),
    (is_foreign, "not a checkpoint of parisph"),
    (lambda path: sealed(path, lambda file: file.attrs.update(version=3)),
     "version 3 of the format, this parisph reads up to 2"),
    (lambda path: sealed(path, lambda file: file["particles"].pop("volume")), "lacks the volumes"),
    (lambda path: sealed(path, lambda file: file.attrs.pop("dt")), "not a whole checkpoint"),
    (lambda path: sealed(path, lambda file: file.attrs.update(step=7)), "is the checkpoint of step 7"),
]


@pytest.mark.parametrize(("fault", "message"), FAULTS)
def test_a_bad_checkpoint_is_refused_on_every_rank(folder, fault, message):
    path = folder / "00000003.h5"
    checkpoint.write(WORLD, folder, OwnedRows(spreads(WORLD.size)[0], WORLD.rank), 0.0, 3, 0.1, CASE, {}, {})
    checkpoint.read(WORLD, path)
    if WORLD.rank == 0:
        fault(path)
    WORLD.barrier()
    with pytest.raises(StoreError, match=f"00000003.h5.*{message}|{message}.*00000003.h5"):
        checkpoint.read(WORLD, path)


def test_a_checkpoint_of_another_run_is_refused_on_every_rank(folder):
    for name in ("a", "b"):
        case = json.dumps({"run": name, "title": "the same"})
        if WORLD.rank == 0:
            (folder / name / "checkpoints").mkdir(parents=True)
            (folder / name / "case.json").write_text(case)
        WORLD.barrier()
        for step in (3, 5):
            checkpoint.write(WORLD, folder / name / "checkpoints", OwnedRows(spreads(WORLD.size)[0], WORLD.rank), 0.0,
                             step, 0.1, case, {}, {})
    last = folder / "a" / "checkpoints" / "00000005.h5"
    assert checkpoint.read(WORLD, last).step == 5
    if WORLD.rank == 0:
        os.replace(folder / "b" / "checkpoints" / "00000005.h5", last)
    WORLD.barrier()
    with pytest.raises(StoreError,
                       match="00000005.h5 is of another run .* newest sound one beside it is .*00000003.h5"):
        checkpoint.read(WORLD, last)


@pytest.mark.parametrize("failing", ["layout", "rows", "digest", "publish"])
def test_a_full_disk_on_one_rank_is_raised_on_all_and_the_old_file_stays(folder, failing, monkeypatch):
    particles = OwnedRows(spreads(WORLD.size)[0], WORLD.rank)
    checkpoint.write(WORLD, folder, particles, 0.0, 1, 0.1, CASE, {}, {})
    before = (folder / "00000001.h5").read_bytes()
    WORLD.barrier()

    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    if failing == "layout":
        monkeypatch.setattr(os, "posix_fallocate", full)
    elif failing == "publish":
        monkeypatch.setattr(slabs, "publish", full)
    elif WORLD.rank == WORLD.size - 1:  # only one rank fails, among its rows or with its share of the digest
        monkeypatch.setattr(*((slabs, "_write_own") if failing == "rows" else (digest, "_chunks")), full)
    particles.u += 1.0
    with pytest.raises(StoreError, match="cannot write .*/00000001.h5: .*No space left"):
        checkpoint.write(WORLD, folder, particles, 0.0, 1, 0.1, CASE, {}, {})
    WORLD.barrier()
    assert (folder / "00000001.h5").read_bytes() == before
    assert not list(folder.glob(".*"))


@pytest.mark.parametrize("rank", [0, -1])
def test_a_limit_of_the_system_is_raised_on_all(folder, rank):
    """A real refusal by the kernel: one rank may write no file beyond 64 KiB."""
    limited = WORLD.rank == rank % WORLD.size
    particles = OwnedRows([4000] * WORLD.size, WORLD.rank)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    if limited:
        resource.setrlimit(resource.RLIMIT_FSIZE, (65536, hard))
    try:
        with pytest.raises(StoreError, match="cannot write .*00000001.h5"):
            checkpoint.write(WORLD, folder, particles, 0.0, 1, 0.1, CASE, {}, {})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    checkpoint.write(WORLD, folder, particles, 0.0, 1, 0.1, CASE, {}, {})  # and the next one works again
    assert checkpoint.read(WORLD, folder / "00000001.h5").total == 4000 * WORLD.size


def test_an_error_of_rank_0_in_a_series_or_folder_reaches_all(folder):
    store = Store.create(WORLD, folder / "run", CASE)
    store.add_series("steps", {"dt": "s"})
    with pytest.raises(Exception, match="1 values a line, got 2"):
        store.append(0.0, 0, {"steps": (1.0, 2.0)})
    if WORLD.rank == 0:
        (folder / "taken").write_text("a file where the folder should be")
    WORLD.barrier()
    with pytest.raises(StoreError, match="taken"):
        Store.create(WORLD, folder / "taken", CASE)
    with pytest.raises(StoreError, match="holds a run already"):
        Store.create(WORLD, folder / "run", CASE)
    store.close()


def test_a_run_is_resumed_on_other_ranks_where_its_checkpoint_ends(folder):
    run = folder / "run"
    writers = first_ranks(max(1, WORLD.size - 1))
    if writers:
        store = Store.create(writers, run, CASE)
        store.add_series("probes/P2", {"pressure": "Pa"})
        particles = OwnedRows(spreads(writers.size)[0], writers.rank)
        for step in range(5):
            store.snapshot(particles, 0.1 * step, step)
            store.append(0.1 * step, step, {"probes/P2": (10.0 * step,)})
            if step in (1, 3):
                store.checkpoint(particles, 0.1 * step, step, 0.1, {})
        store.close()
    WORLD.barrier()
    found = checkpoint.read(WORLD, run / "checkpoints" / "00000001.h5")
    store = Store.resume(WORLD, run, found.case, found.time, found.step)
    store.add_series("probes/P2", {"pressure": "Pa"})
    store.append(0.2, 2, {"probes/P2": (-1.0,)})
    store.snapshot(OwnedRows(spreads(WORLD.size)[0], WORLD.rank), 0.15, 2)
    store.close()
    assert [path.name for path in checkpoint.paths(run / "checkpoints")] == ["00000001.h5"]
    found = snapshot.listed(run / "flow.hdf.series", store.run)
    assert list(found.values()) == [0.0, 0.1, 0.15]
    assert sorted(path.name for path in (run / "snapshots").iterdir()) == [Path(name).name for name in found]
    aside = run / "replaced" / "1"
    assert sorted(str(path.relative_to(aside)) for path in aside.rglob("*.*")) == [
        "checkpoints/00000003.h5", "snapshots/000002.vtkhdf", "snapshots/000003.vtkhdf", "snapshots/000004.vtkhdf"]
    assert (run / "probes/P2.csv").read_text().splitlines()[-3:] == ["0.0,0,0.0", "0.1,1,10.0", "0.2,2,-1.0"]
    WORLD.barrier()
    with pytest.raises(StoreError, match="another run"):
        Store.resume(WORLD, run, json.dumps({"title": "other"}), 0.1, 1)


def test_together_passes_on_the_lowest_ranks_cause():
    def fail():
        raise PermissionError(13, "Permission denied")

    with pytest.raises(StoreError, match="cannot write here: .*Permission denied"):
        files.together(WORLD, "write here", fail if WORLD.rank == WORLD.size - 1 else lambda: 1)
