"""Runs of earlier releases, of each version of the files (tests/old_runs), are read as new ones, and go on."""

import shutil

import numpy as np
import pytest
from mpi4py import MPI

from parisph import StoreError
from parisph.io import checkpoint, info, snapshot
from parisph.io.reader import open_run
from parisph.pictures import overview
from tests.launch import ROOT
from tests.running import last_checkpoint
from tests.scenes import restart_alone, saved, scene, simulated

ALL = sorted(path.name.partition(".")[0] for path in (ROOT / "tests" / "old_runs").glob("*.tar.xz"))
WITHOUT_VOLUMES, WITHOUT_DIGESTS = ALL[0], "2026-11-21-ac580d7"    # the commits that have made them
HALF_CELLS = 5.25    # of the walls beside 4 x 8 particles, with that of the corner, without water lines


@pytest.fixture
def old(request, tmp_path):
    return unpacked(request.param, tmp_path)


def unpacked(name, folder):
    """Unpack a stored run: four steps of 0.01 s of a column of water, three snapshots, two checkpoints."""
    shutil.unpack_archive(ROOT / "tests" / "old_runs" / f"{name}.tar.xz", folder / "run")
    return folder / "run"


@pytest.mark.parametrize("old", ALL, indirect=True)
def test_a_run_of_an_earlier_release_is_read_whole(old, caplog, request):
    run = open_run(old)
    run.check()
    assert run.times.tolist() == [0.0, 0.02, 0.04] and run.probe_names == ["P2", "energy", "volume"]
    last = run.snapshot()
    fluid = last["kind"] == 0
    assert fluid.sum() == 32 and last["u"][fluid, 1].min() < -0.3 and last["p"].max() > 1e3
    assert run.steps["step"].tolist() == [1, 2, 3, 4] and run.probe("P2")["time"][-1] == pytest.approx(0.04)
    told = info.describe(run) + info.provenance(run)
    assert "completed" in told and "3, t = 0 to 0.04 s" in told and "petsc" in told
    if request.node.callspec.params["old"] in ALL[:2]:    # a picture takes a second, and reads no more
        overview.plot_small(run, -1, old / "small.png", "pressure")
    assert caplog.messages == []


@pytest.mark.parametrize("old", ALL[2::2], indirect=True)    # and WITHOUT_DIGESTS below
def test_a_run_of_an_earlier_release_goes_on(old):
    before = open_run(old).steps["dt"]
    summary = restart_alone(old, until=0.06)
    run = open_run(old)
    run.check()
    assert summary["status"].startswith("completed") and summary["steps"] == 6
    np.testing.assert_allclose(run.times, [0.0, 0.02, 0.04, 0.06])
    assert run.steps["step"].tolist() == [1, 2, 3, 4, 5, 6] and run.steps["dt"][:4].tolist() == before.tolist()
    # one row of cells is deep enough, at the wall, and the column begins to fall
    assert abs(summary["volume_drift"]) < 0.01 and abs(summary["energy_drift"]) < 0.005
    fluid = run.snapshot()["kind"] == 0
    assert run.snapshot()["u"][fluid, 1].min() == pytest.approx(run.snapshot(-2)["u"][fluid, 1].min() * 1.5, rel=0.2)
    _, fields = last_checkpoint(old)
    assert fields["beside"].sum() == pytest.approx(HALF_CELLS, abs=1e-12)    # the old one did not have them


@pytest.mark.parametrize(("name", "sets"), [
    ("dam_break", {"spacing": 0.1}), ("dam_break", {"spacing": 0.1, "jitter": 0.4}),
    ("sloshing_3d", {"spacing": 0.25})])
def test_a_run_without_the_half_cells_of_its_start_goes_on_as_if_it_knew_them(name, sets):
    s = simulated(scene(name, {"rtol": 1e-12}, **sets), 6)
    start = saved(s)
    due = start.arrays.pop("beside")
    again = simulated(s.case, start=start)
    order, other = np.argsort(s.particles.id), np.argsort(again.particles.id)
    np.testing.assert_allclose(again.particles.beside[other], due[order], rtol=0, atol=1e-6)
    assert np.count_nonzero(due == 0.0) > 10 and due.max() > 0.4
    for one in (s, again):
        one.advance()
    for name in ("x", "u", "spare"):
        value, due = (getattr(one.particles, name)[np.argsort(one.particles.id)] for one in (again, s))
        np.testing.assert_allclose(value, due, rtol=0, atol=1e-6 * max(0.1, np.abs(due).max()))
    assert s.particles.spare.max() > 0.0


def test_what_cannot_go_on_names_the_version_that_can_and_a_remedy(tmp_path):
    old = unpacked(WITHOUT_VOLUMES, tmp_path)
    before = {path: path.read_bytes() for path in old.rglob("*") if path.is_file()}
    with pytest.raises(StoreError, match=r"lacks the volumes of its particles.* git checkout 6d557b4\n"
                                         rf"To repeat the run with this one: parisph run {old}/case.json"):
        restart_alone(old, until=0.06)
    assert {path: path.read_bytes() for path in old.rglob("*") if path.is_file()} == before


def test_columns_that_have_gone_are_kept_in_a_copy(tmp_path):
    old = unpacked(WITHOUT_DIGESTS, tmp_path)
    steps = old / "steps.csv"
    steps.write_text("".join(f"{line},{'gone' if line.startswith('time') else 7}\n"
                             for line in steps.read_text().splitlines() if not line.startswith("#")))
    before = steps.read_bytes()
    restart_alone(old, until=0.05)
    assert "gone" not in open_run(old).steps.dtype.names
    assert any(path.read_bytes() == before for path in old.glob("replaced/*/steps.csv"))


@pytest.mark.parametrize("name", ["snapshots/000001.vtkhdf", "checkpoints/00000004.h5"])
def test_a_file_of_a_later_run_needs_its_digest_there_too(tmp_path, name):
    old, later = unpacked(WITHOUT_DIGESTS, tmp_path / "a"), unpacked(ALL[-1], tmp_path / "b")
    (old / name).write_bytes((later / name).read_bytes().rpartition(b"\nparisph digest")[0])
    with pytest.raises(StoreError, match="has no digest at its end"):
        checkpoint.read(MPI.COMM_SELF, old / name) if "checkpoints" in name else snapshot.read(old / name, early=True)
    (later / name).write_bytes((old / name).read_bytes())
    with pytest.raises(StoreError, match="has no digest at its end"):
        checkpoint.read(MPI.COMM_SELF, later / name) if "checkpoints" in name else open_run(later).check()
