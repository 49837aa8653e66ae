"""A run read back as numpy arrays, as a notebook does."""

import json
import os
import sys
import types

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import CaseError, MissingLibrary, StoreError
from parisph.base.json_digest import with_digest
from parisph.case.stored import from_json, to_json
from parisph.io import checkpoint, snapshot
from parisph.io.info import describe
from parisph.io.reader import open_run
from parisph.io.store import Store, provenance
from tests import watched
from tests.owned_rows import OwnedRows, everything

CASE = to_json(watched.scene([]).model_copy(update={"title": "made up"}))


@pytest.mark.parametrize("make, message", [
    (os.mkfifo, "it is not a regular file"), (os.mkdir, "it is a folder"),
    (lambda path: path.symlink_to(path), "it has no case.json"),
])
def test_what_is_no_file_is_not_waited_for(tmp_path, make, message):
    make(tmp_path / "case.json")
    with pytest.raises(StoreError, match=message):
        open_run(tmp_path)


@pytest.fixture
def folder(tmp_path):
    store = Store.create(MPI.COMM_SELF, tmp_path / "run", CASE, provenance("ISPH_R", "-ksp_type gmres", petsc="3.18.5"))
    store.add_series("steps", {"dt": "s", "iterations": ""}, "one line a step")
    store.add_series("probes/P2", {"pressure": "Pa"}, "pressure tap at (2, 0.05) m")
    particles = OwnedRows([30], 0)
    for step in range(4):
        particles.p = np.full(30, float(step))
        store.append(0.5 * step, step, {"steps": (0.5, 9), "probes/P2": (100.0 * step,)})
        store.snapshot(particles, 0.5 * step, step)
    store.snapshot(particles, 1.5, 3)  # the same time again
    store.summary({"steps": np.int64(4), "volume_drift": np.float64(np.nan), "phases": {"solve": (1.0, 2.0)}})
    store.close()
    return tmp_path / "run"


def test_a_run_gives_its_case_summary_times_and_series(folder):
    run = open_run(folder)
    assert run.case["title"] == "made up"
    assert run.summary == {"steps": 4, "volume_drift": None, "phases": {"solve": [1.0, 2.0]}}
    np.testing.assert_array_equal(run.times, [0.0, 0.5, 1.0, 1.5])
    assert run.probe_names == ["P2"] and run.units("P2")["pressure"] == "Pa"
    np.testing.assert_array_equal(run.probe("P2")["pressure"], [0.0, 100.0, 200.0, 300.0])
    np.testing.assert_array_equal(run.steps["iterations"], 9)
    assert run.about["method"] == "ISPH_R" and run.about["petsc_options"] == "-ksp_type gmres"
    assert json.loads(run.about["versions"])["petsc"] == "3.18.5" and run.about["ranks"] == 1


@pytest.mark.parametrize("which, step", [(0, 0), (-1, 3), (2, 2), (0.0, 0), (0.7, 1), (99.0, 3)])
def test_a_snapshot_by_number_or_nearest_time(folder, which, step):
    found = open_run(folder).snapshot(which)
    truth = everything(30)
    assert found["step"] == step and np.all(found["p"] == step)
    np.testing.assert_array_equal(found["id"], np.arange(30))
    np.testing.assert_array_equal(found["x"], truth["x"][np.argsort(truth["id"])])


def test_what_is_not_there_is_named(folder, tmp_path):
    run = open_run(folder)
    with pytest.raises(CaseError, match="no probe 'P9' .it has: P2"):
        run.probe("P9")
    with pytest.raises(StoreError, match="4 snapshots, there is no number 4"):
        run.snapshot(4)
    with pytest.raises(StoreError, match="no case.json"):
        open_run(tmp_path)


def test_a_snapshot_that_is_not_what_was_written_is_refused(folder):
    run, path = open_run(folder), folder / "snapshots/000002.vtkhdf"
    content = path.read_bytes()
    for place in (40, len(content) // 2, content.index(b"made up"), len(content) - 3):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1:])
        with pytest.raises(StoreError, match="000002.vtkhdf (is damaged|is not a whole file)"):
            run.snapshot(2)
    path.write_bytes(content)
    run.snapshot(2)
    path.write_bytes((folder / "snapshots/000001.vtkhdf").read_bytes())
    with pytest.raises(StoreError, match="000002.vtkhdf is the snapshot of 0.5 s, not of 1 s"):
        run.snapshot(2)
    path.unlink()
    with pytest.raises(StoreError, match="there is no file .*000002.vtkhdf"):
        run.snapshot(2)


def test_a_snapshot_of_another_run_is_refused(tmp_path):
    path = tmp_path / "a.vtkhdf"
    snapshot.write(MPI.COMM_SELF, path, OwnedRows([30], 0), 0.5, 1, ("u",), {"run": "one"})
    assert snapshot.read(path, 0.5, "one")["step"] == 1
    with pytest.raises(StoreError, match="a.vtkhdf is of another run"):
        snapshot.read(path, 0.5, "two")


def test_a_sound_file_that_is_no_snapshot_is_refused(folder, tmp_path):
    path = checkpoint.write(MPI.COMM_SELF, tmp_path, OwnedRows([30], 0), 0.5, 1, 0.1, CASE, {}, {})
    with pytest.raises(StoreError, match="00000001.h5 is not a snapshot of parisph"):
        snapshot.read(path)
    with pytest.raises(StoreError, match="000000.vtkhdf is an HDF5 file, but not a checkpoint"):
        checkpoint.read(MPI.COMM_SELF, folder / "snapshots/000000.vtkhdf")


def test_the_rest_of_a_run_can_be_read_beside_a_damaged_snapshot(folder):
    (folder / "snapshots/000000.vtkhdf").write_bytes(b"damaged")
    run = open_run(folder)
    assert len(run) == 4 and run.snapshot(3)["step"] == 3
    with pytest.raises(StoreError, match="000000.vtkhdf is not a whole file of parisph"):
        run.about


def test_missing_snapshots_are_said_when_a_run_is_opened(folder, caplog):
    """Their numbers stay, so that no other snapshot is taken for a missing one."""
    with caplog.at_level("WARNING", "parisph"):
        assert open_run(folder).missing == [] and caplog.text == ""
        (folder / "snapshots/000002.vtkhdf").unlink()
        run = open_run(folder)
    assert f"{folder} lacks 1 of its 4 snapshots; the first is {folder}/snapshots/000002.vtkhdf" in caplog.text
    assert run.missing == [folder / "snapshots/000002.vtkhdf"] and run.snapshot(3)["step"] == 3
    with pytest.raises(StoreError, match="there is no file .*000002.vtkhdf"):
        run.snapshot(2)


def test_an_earlier_run_is_never_written_over(folder):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with pytest.raises(StoreError, match="holds a run already"):
        Store.create(MPI.COMM_SELF, folder, CASE)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_an_unknown_field_is_refused_before_anything_is_touched(tmp_path):
    with pytest.raises(StoreError, match="no field 'salinity' for snapshots .there are: "):
        Store.create(MPI.COMM_SELF, tmp_path / "new", CASE, fields=("u", "salinity"))
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("damage", [lambda path: path.unlink(), lambda path: path.write_text("{"),
                                    lambda path: path.write_text("[]"),
                                    lambda path: path.write_text(path.read_text().replace('"run": "', '"run": "f')),
                                    lambda path: path.write_text(
                                        path.read_text().replace('"digest"', '"digesu"').replace("1.0", "1.1"))])
def test_without_its_index_a_run_finds_its_snapshots(folder, damage):
    """The files themselves say which they are and of what time; a foreign or damaged one is no part of the run."""
    damage(folder / "flow.hdf.series")
    other = Store.create(MPI.COMM_SELF, folder.parent / "other", CASE)
    other.snapshot(OwnedRows([30], 0), 0.7, 9)
    (folder / "snapshots/000009.vtkhdf").write_bytes((folder.parent / "other/snapshots/000000.vtkhdf").read_bytes())
    (folder / "snapshots/000010.vtkhdf").write_bytes(b"nothing")
    run = open_run(folder)
    np.testing.assert_array_equal(run.times, [0.0, 0.5, 1.0, 1.5])
    assert [run.snapshot(k)["step"] for k in range(4)] == [0, 1, 2, 3]


@pytest.mark.parametrize("name, content, says", [
    ("case.json", "{", "case.json is damaged: it is not JSON"),
    ("case.json", "[1]", "case.json is damaged: it contains a list"),
    ("case.json", '{"schema": 99}', "newer parisph"),
    ("case.json", '{"title": "only"}', "case.json is damaged, or is not the case of a run: Case.fluid is missing"),
    ("case.json", "\xff\x00", "case.json is damaged"),
    ("summary.json", "", "summary.json is damaged: it is not JSON"),
    ("summary.json", '{"run": "other"}', "summary.json is damaged: it has no digest"),
    ("summary.json", '{"a": 1}', "summary.json is damaged: it has no digest"),
    ("summary.json", json.dumps(with_digest({"run": "other"})), "summary.json is of another run"),
    ("summary.json", json.dumps(with_digest({"steps": 4})), "summary.json is of another run"),
    ("steps.csv", "", "steps.csv is damaged: it has no columns"),
    ("steps.csv", "time,step,dt\n0,0\n", "steps.csv is damaged: line 2 does not have 3 values"),
    ("steps.csv", "time,step,dt\n0,0,1\n0.1,1,1\n0.3,3,1\n", "line 4 step 3 at 0.3 s follows step 1"),
    ("steps.csv", "# run other\ntime,step,dt\n", "steps.csv is of another run"),
    ("steps.csv", "time,step,dt\n0,0,1\0\n", "damaged: line 2"),
    ("steps.csv", None, "there is no .*steps.csv: it was removed or moved away"),
    ("probes/P2.csv", "time,step,pressure\n0.1,1,2\n0.1,1,2\n", "P2.csv is damaged: in line 3"),
    ("probes/P2.csv", "a,b\n", "do not begin with time, step"),
    *((name, os.mkfifo, "it is not a regular file") for name in ("steps.csv", "probes/P2.csv")),
])
def test_what_is_damaged_or_of_another_run_is_named(folder, name, content, says):
    path = folder / name
    path.unlink()
    if isinstance(content, str):
        path.write_text(content, encoding="latin-1")
    elif content:
        content(path)
    with pytest.raises(StoreError, match=says):
        run = open_run(folder)
        run.summary, run.steps, run.probe("P2")


def unsealed(text):
    """Return the JSON text of an object without its digest, as after an edit by hand."""
    return json.dumps({name: value for name, value in json.loads(text).items() if name != "digest"})


@pytest.mark.parametrize("name", ["steps.csv", "probes/P2.csv"])
def test_a_series_that_was_changed_after_the_end_is_refused(folder, name):
    path = folder / name
    path.write_text(path.read_text().replace("1.0,2,", "1.1,2,"))
    with pytest.raises(StoreError, match="has changed since the run ended"):
        open_run(folder).steps, open_run(folder).probe("P2")
    (folder / "summary.json").unlink()    # without it nothing is known
    assert len(open_run(folder).steps) == len(open_run(folder).probe("P2")) == 4


@pytest.mark.parametrize(("change", "says"), [
    (str, "does not match its digest"), (lambda text: text.replace('"digest"', '"digesu"'), "has no digest"),
    (lambda text: json.dumps({**json.loads(text), "digest": None}), "has no digest"),
])
def test_a_summary_that_was_changed_or_has_lost_its_digest_is_refused(folder, change, says):
    path = folder / "summary.json"
    path.write_text(change(path.read_text()).replace('"steps": 4', '"steps": 5'))
    with pytest.raises(StoreError, match=f"summary.json is damaged: it {says}"):
        open_run(folder).summary


def test_a_summary_of_a_run_from_before_schemas_needs_no_digest(folder):
    text = (folder / "case.json").read_text()
    (folder / "case.json").write_text(json.dumps({name: value for name, value in json.loads(text).items()
                                                  if name not in ("schema", "digest")}))
    (folder / "summary.json").write_text('{"steps": 4}')
    assert open_run(folder).summary == {"steps": 4}


def test_a_case_of_another_run_is_noticed(folder):
    """Even if nothing but the snapshots is read."""
    text = (folder / "case.json").read_text()
    (folder / "case.json").write_text(json.dumps({**json.loads(text), "run": "other", "digest": None}))
    with pytest.raises(StoreError, match="case.json is of another run than the snapshots"):
        open_run(folder)


def test_a_case_that_this_release_would_not_run_is_still_read(folder):
    text = (folder / "case.json").read_text().replace('"spacing": 0.05', '"spacing": 0.0501')
    (folder / "case.json").write_text(text)
    with pytest.raises(StoreError, match="case.json is damaged: it does not match its digest"):
        open_run(folder)
    (folder / "case.json").write_text(unsealed(text))
    assert open_run(folder).case["numerics"]["spacing"] == 0.0501


def test_fluid_in_a_polygon_that_crosses_itself_is_read_in_a_run_but_not_computed_anew(folder):
    content = json.loads((folder / "case.json").read_text())
    content["fluid"]["shape"] = {"kind": "polygon", "points": [(0.0, 0.0), (1.0, 0.5), (1.0, 0.0), (0.0, 0.25)]}
    text = unsealed(json.dumps(content))
    with pytest.raises(CaseError, match="give the points in order along one line"):
        from_json(text)
    (folder / "case.json").write_text(text)
    assert open_run(folder).case["fluid"]["shape"]["kind"] == "polygon"
    assert "made up" in describe(open_run(folder))


def test_a_run_its_tables_and_snapshots_show_what_they_are(folder):
    run = open_run(folder)
    assert repr(run) == (f"<run {folder}: 'made up', status goes on, or was killed, snapshots 4, t = 0 to 1.5 s, "
                         "probes P2>")
    assert repr(run.probe("P2")) == "<P2: 4 rows, t = 0 to 1.5 s: time [s], step, pressure [Pa]>"
    assert repr(run.steps).startswith("<steps: 4 rows, t = 0 to 1.5 s: time [s], step, dt [s], iterations")
    assert repr(run.snapshot()).startswith("<snapshot at t = 1.5 s, step 3: 30 particles: ")
    run.case["title"] = "<b>made up</b>"
    pages = run._repr_html_(), run.probe("P2")._repr_html_(), run.snapshot()._repr_html_()
    assert "&lt;b&gt;made up" in pages[0] and "<th>pressure [Pa]</th>" in pages[1] and "<td>30 x 2</td>" in pages[2]


def test_tables_are_arrays_and_go_to_pandas(folder, monkeypatch):
    table = open_run(folder).probe("P2")
    assert type(table["pressure"]) is np.ndarray and table[1:]["pressure"].tolist() == [100.0, 200.0, 300.0]
    assert len(table[table["time"] > 0.6]) == 2 and table[0]["step"] == 0 and table.units["pressure"] == "Pa"
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingLibrary, match="pandas is not installed; write pip install pandas"):
        table.to_pandas()

    class Frame(dict):
        attrs = {}
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=Frame))
    frame = table.to_pandas()
    assert list(frame) == ["time", "step", "pressure"] and frame.attrs["units"]["time"] == "s"
    assert frame["pressure"].tolist() == [0.0, 100.0, 200.0, 300.0]
