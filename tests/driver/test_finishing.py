"""A run that was killed at an unlucky moment is finished by a restart, and nothing that it did not write is touched."""

import json
import os
import shutil

import numpy as np
import pytest
from mpi4py import MPI

from parisph import CaseError, load
from parisph import __main__ as entry
from parisph.io import checkpoint, reader, snapshot
from tests.owned_rows import OwnedRows
from tests.scenes import run_alone

CASE = '''
from parisph import Box, Case, Energy, Fluid, Numerics, Output, Tank

def case(end_time: float = 0.02, every: float = 0.004) -> Case:
    return Case(
        title="small", fluid=Fluid(Box(width=0.5, height=1.0), density=1000.0), walls=Tank(width=2.0, height=2.0),
        gravity=(0.0, -9.81), numerics=Numerics(spacing=0.1, time_step=0.002),
        output=Output(checkpoint_every=0.01, every=every), end_time=end_time, probes=[Energy("energy")],
    )
'''


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A run of ten steps, with snapshots at 0, 4, ... 20 ms and checkpoints at 10 and 20 ms."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "small.py").write_text(CASE)
    assert entry.main(["run", str(folder / "small.py"), "-o", str(folder / "run"), "-q"]) == 0
    return folder / "run"


@pytest.fixture
def run(finished, tmp_path, monkeypatch, capfd):
    """A copy of that run beside its case, in the current folder."""
    shutil.copytree(finished.parent, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    capfd.readouterr()
    return tmp_path / "run"


def restart(*words):
    return entry.main(["restart", "run", "-q", *words])


def check_whole(run, steps=10):
    """The run is complete: every step and snapshot once, and a summary."""
    found = reader.open_run(run)
    np.testing.assert_array_equal(found.steps["step"], np.arange(1, steps + 1))
    np.testing.assert_array_equal(found.probe("energy")["step"], np.arange(steps + 1))
    np.testing.assert_allclose(found.times, 0.004 * np.arange(steps // 2 + 1), rtol=1e-12)
    assert found.summary["status"] == "completed" and found.summary["steps"] == steps
    assert [found.snapshot(k)["step"] for k in range(len(found))] == list(range(0, steps + 1, 2))
    assert not (run / "run.lock").exists()


def test_killed_before_its_summary(run):
    before = json.loads((run / "summary.json").read_text())
    last = checkpoint.paths(run / "checkpoints")[-1]
    written = last.stat().st_mtime_ns
    (run / "summary.json").unlink()
    assert restart() == 0
    check_whole(run)
    after = json.loads((run / "summary.json").read_text())
    assert last.stat().st_mtime_ns == written
    for name in ("energy_drift", "volume_drift", "particles", "run"):
        assert after[name] == pytest.approx(before[name]) if name != "run" else after[name] == before[name]


@pytest.mark.parametrize("left", [
    ("case.json",), ("case.json", "steps.csv", "probes", "snapshots/000000.vtkhdf", "flow.hdf.series")])
def test_killed_before_its_first_checkpoint(run, left):
    for path in sorted(run.rglob("*"), reverse=True):
        if path.is_file() and not any(str(path.relative_to(run)).startswith(name) for name in left):
            path.unlink()
    assert restart() == 0
    check_whole(run)


def test_killed_after_its_last_checkpoint_but_one(run):
    checkpoint.paths(run / "checkpoints")[-1].unlink()
    (run / "summary.json").unlink()
    late = (run / "snapshots/000004.vtkhdf").read_bytes()
    assert restart() == 0
    check_whole(run)
    aside = run / "replaced" / "1"
    assert sorted(str(path.relative_to(aside)) for path in aside.rglob("*.*")) == [
        "probes/energy.csv", "snapshots/000003.vtkhdf", "snapshots/000004.vtkhdf",
        "snapshots/000005.vtkhdf", "steps.csv"]
    assert (aside / "snapshots/000004.vtkhdf").read_bytes() == late
    assert reader.open_run(run).about["run"] == json.loads((run / "case.json").read_text())["run"]


@pytest.mark.parametrize("damage", ["gone", "empty", "foreign", "short"])
def test_snapshots_are_found_without_the_index(run, damage):
    index = run / "flow.hdf.series"
    content = json.loads(index.read_text())
    if damage == "gone":
        index.unlink()
    elif damage == "empty":
        index.write_text("")
    elif damage == "foreign":
        index.write_text(json.dumps({**content, "run": "f00", "digest": None}))
    else:
        index.write_text(json.dumps({**content, "files": content["files"][:1], "digest": None}))
    before = {path.name: path.read_bytes() for path in (run / "snapshots").iterdir()}
    assert restart("--until", "0.028") == 0
    check_whole(run, 14)
    assert {name: (run / "snapshots" / name).read_bytes() for name in before} == before


def test_files_of_others_are_never_touched(run):
    checkpoint.paths(run / "checkpoints")[-1].unlink()
    mine = {"notes.txt": b"mine", "snapshots/000009.vtkhdf": b"not HDF5", "snapshots/picture.png": b"png",
            "snapshots/.hidden.tmp": b"x", "probes/other.csv": b"a,b", "checkpoints/readme.tmp": b"y",
            ".a.csv.tmp_backup": b"z", ".steps.csv.tmp.old": b"z", "probes/.energy.csv.tmp.2024": b"z",
            "probes/.mine.csv.tmp": b"z", "checkpoints/.mine.h5.tmp": b"z"}
    for name, content in mine.items():
        (run / name).write_bytes(content)
    foreign = run / "snapshots" / "000007.vtkhdf"
    snapshot.write(MPI.COMM_SELF, foreign, OwnedRows([30], 0), 0.019, 9, ("u",), {"run": "another"})
    there = foreign.read_bytes()
    assert restart() == 0
    for name, content in mine.items():
        assert (run / name).read_bytes() == content, name
    assert foreign.read_bytes() == there
    found = reader.open_run(run)
    assert len(found) == 6 and found.summary["status"] == "completed"
    assert [found.snapshot(k)["step"] for k in range(6)] == [0, 2, 4, 6, 8, 10]


def test_copies_of_checkpoints_are_neither_removed_nor_taken_for_the_last(run):
    last = checkpoint.paths(run / "checkpoints")[-1]
    copies = [run / "checkpoints" / name for name in ("00000003.h5", "1.h5", "9.h5", "\u00b2.h5", "000000011.h5",
                                                      "mine.h5")]
    for path in copies:
        shutil.copy(last, path)
    assert restart("--until", "0.044") == 0
    check_whole(run, 22)
    assert all(path.read_bytes() == copies[0].read_bytes() for path in copies)
    # and of its own the run keeps the last two, those of the restart and those from before it
    assert {path.name for path in checkpoint.paths(run / "checkpoints")} == {"00000003.h5",
                                                                             "00000020.h5", "00000022.h5"}


@pytest.mark.parametrize("name", ["snapshots", "checkpoints", "probes", "replaced"])
def test_a_linked_folder_is_refused(run, name, capfd):
    elsewhere = run.parent / "elsewhere"
    (run / name).mkdir(exist_ok=True)
    (run / name).rename(elsewhere)
    (run / name).symlink_to(elsewhere)
    before = {path: path.read_bytes() for path in elsewhere.rglob("*") if path.is_file()}
    assert restart("--until", "0.024") == 5
    assert f"{name} is a symbolic link" in capfd.readouterr().err
    assert {path: path.read_bytes() for path in elsewhere.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("name",
                         ["run.log", "steps.csv", "probes/energy.csv", "case.json", ".case.json.tmp", "summary.json",
                          "flow.hdf.series", "checkpoints/.00000012.h5.tmp", "snapshots/.000006.vtkhdf.tmp",
                          ".steps.csv.tmp"])
def test_a_linked_file_is_never_written_through(run, name):
    target = run.parent / "target"
    path = run / name
    target.write_bytes(path.read_bytes() if path.exists() else b"mine")
    path.unlink(missing_ok=True)
    path.symlink_to(target)
    before = target.read_bytes()
    assert restart("--until", "0.024") in (0, 5)
    assert target.read_bytes() == before


def test_a_missing_series_is_said(run, capfd):
    (run / "steps.csv").unlink()
    assert restart("--until", "0.024") == 0
    assert "steps.csv is missing: it begins again after step 10" in capfd.readouterr().err
    assert "lines up to step 10 are missing" in (run / "steps.csv").read_text().splitlines()[0]
    assert list(reader.open_run(run).steps["step"]) == [11, 12]


@pytest.mark.parametrize("name, damage, says", [
    ("steps.csv", lambda text: text.replace("\n", "\n\0", 5), "steps.csv is damaged"),
    ("probes/energy.csv", lambda text: text.replace("time,step,kinetic", "time,step,cinetic"),
     "energy.csv is damaged: it has changed"),
    ("probes/energy.csv", lambda text: text.replace("# run ", "# run f"), "energy.csv is of another run"),
    ("case.json", lambda text: text[:100], "case.json is damaged"),
    ("case.json", lambda text: text.replace('"run": "', '"run": "f'),
     "case.json is damaged: it does not match its digest"),
    ("case.json", lambda text: json.dumps({**json.loads(text), "run": "f", "digest": None}), "is of another run"),
    ("steps.csv", lambda text: text.replace("0.002,1,", "0.0021,1,"), "steps.csv is damaged: it has changed"),
])
def test_damaged_files_are_named_before_anything_is_touched(run, capfd, name, damage, says):
    (run / name).write_text(damage((run / name).read_text()))
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file() and path.name != "run.log"}
    assert restart("--until", "0.024") == 5
    said = capfd.readouterr().err
    assert says in said and said.count("parisph: error: ") == 1 and "Traceback" not in said
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file() and path.name != "run.log"} == before


def test_a_missing_case_is_written_again(run, capfd):
    before = (run / "case.json").read_text()
    (run / "case.json").unlink()
    assert restart("--until", "0.024") == 0
    assert "run/case.json is missing: it is written again from the checkpoint" in capfd.readouterr().err
    check_whole(run, 12)
    after, due = json.loads((run / "case.json").read_text()), json.loads(before)
    assert (after.pop("end_time"), due.pop("end_time")) == (0.024, 0.02)
    assert len(after["made"].pop("restarts")) == 1 and after.pop("made_digest") != due.pop("made_digest")
    assert after.pop("digest") and due.pop("digest") and after == due
    assert restart("--until", "0.028") == 0
    check_whole(run, 14)


def test_a_missing_case_is_not_written_to_the_files_of_another_run(run, capfd):
    (run / "case.json").unlink()
    (run / "steps.csv").write_text((run / "steps.csv").read_text().replace("# run ", "# run f"))
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    for _ in range(2):
        assert restart("--until", "0.024") == 5
        assert "steps.csv is of another run" in capfd.readouterr().err
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before


def test_a_restart_says_what_it_moved_and_where_it_begins(run):
    shutil.rmtree(run / "checkpoints")
    assert restart() == 0
    check_whole(run)
    log = (run / "run.log").read_text().split("continuing in", 1)[-1]
    assert "no checkpoint found in run/checkpoints: the run begins again at t = 0 s" in log
    assert "were moved to run/replaced/1\n" in log and (run / "replaced/1/summary.json").exists()
    checkpoint.paths(run / "checkpoints")[-1].unlink()
    assert restart() == 0
    log = (run / "run.log").read_text().split("replaced/1\n")[-1]
    assert "were moved to run/replaced/2\n" in log and "no checkpoint" not in log


def test_after_an_interruption_only_the_summary_is_replaced(run):
    for name, until in (("replaced/1", "0.024"), ("replaced/2", "0.028")):
        assert restart("--until", until) == 0
        log = (run / "run.log").read_text().split("continuing in")[-1]
        assert (f"only the earlier summary was moved to run/{name}; no other result is replaced\n" in log
                and "computed again" not in log)
        assert [path.name for path in (run / name).rglob("*")] == ["summary.json"]


def test_a_restart_says_what_is_continued_where(run):
    assert restart("--until", "0.024") == 0
    assert "the checkpoint run/checkpoints/00000010.h5, t = 0.02 s, is continued in run\n" in (
        run / "run.log").read_text()
    assert restart("--until", "0.028", "-o", "longer") == 0
    log = (run.parent / "longer" / "run.log").read_text()
    assert ("the checkpoint run/checkpoints/00000012.h5, t = 0.024 s, is continued in longer; "
            "earlier results are in run\n") in log
    np.testing.assert_array_equal(reader.open_run("longer").steps["step"], [13, 14])
    assert reader.open_run("longer").summary["steps"] == 14    # from t = 0


@pytest.mark.parametrize("make, says", [(lambda path: path.symlink_to("mine"), "is a symbolic link"),
                                        (os.mkfifo, "is not a regular file"), (os.mkdir, "is not a regular file")])
def test_a_log_that_cannot_be_continued_is_named_before_anything_is_touched(run, capfd, make, says):
    checkpoint.paths(run / "checkpoints")[-1].unlink()
    (run / "run.log").unlink()
    make(run / "run.log")
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    assert restart() == 5
    said = capfd.readouterr().err
    assert f"run.log {says}" in said and "move it away" in said
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before
    (run / "run.log").rmdir() if make is os.mkdir else (run / "run.log").unlink()
    assert restart() == 0
    check_whole(run)


def lengthen(path):
    """Make a JSON file as large as that of a case with a motion of many samples."""
    path.write_text(path.read_text() + 17_000_000 * " ")


def test_a_run_with_a_long_case_is_restarted_before_its_first_checkpoint_and_repeated(run):
    shutil.rmtree(run / "checkpoints")
    lengthen(run / "case.json")
    assert entry.main(["run", "run/case.json", "-o", "again", "-q"]) == 0
    check_whole(run.parent / "again")
    assert restart() == 0
    check_whole(run)


def test_a_checkpoint_of_another_run_is_refused_beside_a_long_case(run, capfd):
    case = json.loads((run / "case.json").read_text())
    (run / "case.json").write_text(json.dumps({**case, "run": "another", "digest": None}))
    lengthen(run / "case.json")
    assert restart("--until", "0.024") == 5
    assert "00000010.h5 is of another run than its folder: it has been copied there" in capfd.readouterr().err


def test_a_stored_case_that_no_run_writes_is_refused_unread(run, capfd):
    os.truncate(run / "case.json", 10**9)
    assert entry.main(["check", "run/case.json"]) == 2
    assert (capfd.readouterr().err
            == "parisph: error: run/case.json: cannot be read: it has 1 GB, at most 128 MB are read\n")


def test_a_case_of_a_newer_release_is_refused_in_plain_words(run, capfd):
    content = json.loads((run / "case.json").read_text())
    (run / "case.json").write_text(json.dumps({**content, "schema": 99, "digest": None}))
    for words, code in ((["run", "run/case.json", "-o", "again"], 2), (["info", "run"], 5)):
        assert entry.main(words) == code
        assert "newer parisph" in capfd.readouterr().err
    assert not os.path.exists("again")


def test_overwrite_moves_the_old_run_aside(run, capfd):
    before = {path.relative_to(run): path.read_bytes() for path in run.rglob("*") if path.is_file()}
    words = ["run", "small.py", "-o", "run", "-q", "--set", "end_time=0.004"]
    assert entry.main(words) == 2
    assert "--overwrite" in capfd.readouterr().err
    for name in ("run.old", "run.old-2"):
        assert entry.main([word for word in (*words, "--overwrite") if word != "-q"]) == 0
        assert f"the earlier run was moved to {name}\n" in capfd.readouterr().err
        assert f" INFO the earlier run was moved to {name}\n" in (run / "run.log").read_text()
        assert (run.parent / name / "summary.json").exists()
    old = run.parent / "run.old"
    assert {path.relative_to(old): path.read_bytes() for path in old.rglob("*") if path.is_file()} == before
    # and back again where the new run does not begin
    assert entry.main([*words, "--overwrite", "--", "-pressure_ksp_type", "nonsense"]) == 2
    assert reader.open_run(run).summary["status"] == "completed" and not (run.parent / "run.old-3").exists()


def test_a_folder_behind_a_link_is_moved_aside_under_its_own_name(run):
    (run.parent / "links").mkdir()
    (run.parent / "links" / "here").symlink_to(run)
    assert entry.main(["run", "small.py", "-o", "links/here", "-q", "--overwrite"]) == 0
    assert f"the earlier run was moved to {run.resolve()}.old\n" in (run / "run.log").read_text()


def test_a_script_is_told_how_to_move_the_old_run_aside(run):
    with pytest.raises(CaseError, match=r"run holds a run already: give another folder .* \(in Python: "
                                        r"overwrite=True\)"):
        run_alone(load("small.py"), "run")


OCCUPIED = ["steps.csv", "probes/energy.csv", "summary.json", "run.log", "flow.hdf.series", "checkpoints/00000020.h5",
            "snapshots/a.png", "peaks/a.vtkhdf"]


@pytest.mark.parametrize("name", OCCUPIED)
def test_what_lies_in_a_folder_without_a_run_is_never_overwritten(run, name, capfd):
    theirs = run.parent / "theirs" / name
    theirs.parent.mkdir(parents=True)
    theirs.write_text("theirs")
    for words in (["run", "small.py"], ["restart", "run", "--until", "0.024"]):
        assert entry.main([*words, "-q", "-o", "theirs"]) == 2
        said = capfd.readouterr().err
        assert (f"theirs has no case.json, but it holds {name.partition('/')[0]}, which" in said
                and said.count("parisph: error: ") == 1)
        assert ("--overwrite" in said) == (words[0] == "run")    # which restart does not have
        assert ([path for path in (run.parent / "theirs").rglob("*") if path.is_file()] == [theirs]
                and theirs.read_text() == "theirs")
    assert entry.main(["run", "small.py", "-q", "-o", "theirs", "--overwrite"]) == 0
    assert (run.parent / "theirs.old" / name).read_text() == "theirs"
    assert " INFO the earlier content was moved to theirs.old\n" in (run.parent / "theirs/run.log").read_text()
    check_whole(run.parent / "theirs")


def test_a_link_and_a_run_without_its_case_are_in_the_way_too_but_empty_folders_are_not(run, capfd):
    (run / "case.json").unlink()
    (run.parent / "linked").mkdir()
    (run.parent / "linked" / "steps.csv").symlink_to("nowhere")
    for name in ("run", "linked"):
        assert entry.main(["run", "small.py", "-q", "-o", name]) == 2
        assert f"{name} has no case.json, but it holds " in capfd.readouterr().err
    for name in ("probes", "snapshots", "checkpoints"):    # what a kill at the start leaves
        (run.parent / "begun" / name).mkdir(parents=True)
    assert entry.main(["run", "small.py", "-q", "-o", "begun"]) == 0
    assert entry.main(["run", "small.py", "-q", "-o", "run", "--overwrite"]) == 0
    check_whole(run)


def test_the_current_folder_is_not_moved_aside(run, monkeypatch, capfd):
    monkeypatch.chdir(run / "probes")
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    for out in (".", ".."):
        (run / "probes" / "steps.csv").write_text("mine")
        assert entry.main(["run", "../../small.py", "-q", "-o", out, "--overwrite"]) == 2
        assert "contains the current folder, and cannot be moved aside" in capfd.readouterr().err
        (run / "probes" / "steps.csv").unlink()
        assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before


def test_a_folder_in_use_is_refused(run, capfd):
    from parisph.io.lock import Lock

    held = Lock(run)
    for words in (["restart", "run", "--until", "0.03"], ["run", "small.py", "-o", "run", "--overwrite"]):
        assert entry.main(words) == 5
        said = capfd.readouterr().err
        assert "run is in use by process" in said and said.count("error") == 1
    held.release()


def test_snapshots_name_their_run(run):
    identity = json.loads((run / "case.json").read_text())["run"]
    assert snapshot.read_attributes(run / "snapshots/000000.vtkhdf")["run"] == identity
    assert json.loads((run / "summary.json").read_text())["run"] == identity
    for name in ("steps.csv", "probes/energy.csv"):
        assert f"# run {identity}\n" in (run / name).read_text()
