"""info, plot, movie and compare on a small run, as from a shell and without MPI's launcher."""

import json
import os
import re
import resource
import shutil

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, PressureTap, Tank, Volume
from parisph.__main__ import main
from parisph.base import json_digest
from parisph.geometry import build as geometry
from parisph.io import info, reader
from parisph.io.files import write_json
from parisph.io.store import Store, provenance
from parisph.parallel.particles import Particles

CASE = Case(title="small tank", fluid=Fluid(Box(width=1.0, height=0.5), density=1000.0), gravity=(0.0, -9.81),
            walls=Tank(width=1.0, height=1.0), numerics=Numerics(spacing=0.1), end_time=1.0,
            probes=[PressureTap("P2", at=(1.0, 0.1)), Volume("volume")])
SUMMARY = {"status": "completed", "method": "ISPH_R", "ranks": 2, "particles": 3200, "steps": 1250, "time": 1.0,
           "iterations": {"median": 11, "p99": 21, "max": 30}, "volume_drift": -0.0042, "energy_drift": -0.07,
           "errors": {"P2": {"relative_l2": 0.0123},
                      "gauge_at_the_left": {"relative_l2": None, "reason": "share fewer than two samples"}}}


@pytest.fixture
def folder(tmp_path):
    return written(tmp_path / "run")


def written(folder, peak=5, keep_peak=False):
    """Write a run of 11 steps of .1 s and return its folder.

    p = 0 but for the tap, which rises to its peak in step `peak` and falls again; a snapshot every other step.
    """
    particles = Particles(MPI.COMM_SELF, 2)
    particles.assign(geometry.build(CASE))
    store = Store.create(MPI.COMM_SELF, folder, CASE.model_dump_json(),
                         provenance("ISPH_R", "-ksp_type gmres", PETSc="3.18.5"))
    store.add_series("steps", {"dt": "s", "iterations": ""})
    store.add_series("probes/P2", {"pressure": "Pa"})
    store.add_series("probes/volume", {"volume": "m2"})
    for step in range(11):
        store.append(0.1 * step, step,
                     {"steps": (0.1, 9), "probes/P2": (100.0 - 20 * abs(step - peak),), "probes/volume": (0.5,)})
        if step % 2:
            store.snapshot(particles, 0.1 * step, step)
        if keep_peak and step == peak:
            store.peak(particles, 0.1 * step, step, "P2", 100.0, keep=False)
    store.summary(SUMMARY)
    store.close()
    return folder


def lines_of(capsys):
    return capsys.readouterr().out.strip().splitlines()


def test_info_says_how_it_went(folder, capsys):
    assert main(["info", str(folder)]) == 0
    words = {" ".join(line.split()) for line in lines_of(capsys)}
    assert {"small tank", "status completed", "particles 3,200", "steps 1,250", "iterations median 11, p99 21, max 30",
            "volume drift -0.42%", "error of P2 0.0123 (relative L2)",
            "error of gauge_at_the_left not judged: share fewer than two samples", "probe P2: pressure [Pa]"} <= words
    assert any(word.startswith("snapshots 5, t = 0.1 to 0.9 s") for word in words)
    assert any(word == "petsc_options -ksp_type gmres" for word in words)


def test_info_says_which_options_of_petsc_a_run_ended_with(folder, capsys):
    summary = json.loads((folder / "summary.json").read_text())
    summary["versions"] = json.loads(reader.open_run(folder).about["versions"])
    for end, said in (("-ksp_type gmres", 0), ("-ksp_type gmres -pc_type ilu", 1)):
        write_json(folder / "summary.json", {**summary, "petsc_options": end})
        assert main(["info", str(folder)]) == 0
        found = [" ".join(line.split()) for line in lines_of(capsys)]
        assert found.count(f"at the end {end}") == said
        # the summary of this folder is of two ranks, its snapshots of one; versions are the same
        assert [line for line in found if line.startswith("at the end") and "-ksp" not in line] == ["at the end 2"]


def test_info_says_method_and_ranks_once(folder, capsys):
    assert main(["info", str(folder)]) == 0
    text = capsys.readouterr().out
    assert text.count("\nmethod ") == text.count("\nparisph_version ") == 1
    (folder / "summary.json").unlink()    # then the snapshots tell it
    assert main(["info", str(folder)]) == 0
    assert capsys.readouterr().out.count("\nmethod ") == 1


def test_energy_of_a_driven_fluid_does_not_drift(folder):
    def lines(**more):
        return [" ".join(line.split()) for line in info.table({**SUMMARY, **more})]

    assert "energy drift -7.00%" in lines() and "energy drift -7.00%" in lines(driven=False)
    assert ("energy change -7.00%" in lines(driven=True)
            and not any("energy drift" in line for line in lines(driven=True)))


def test_energy_in_motion_in_words():
    motion = {"start": 4.0, "end": 3.5, "high": 4.25, "high_time": 0.5, "drift": -0.125, "unit": "J/m"}
    line, = [line for line in info.table({"energy_in_motion": motion})]
    assert (line.split(maxsplit=2)[2]
            == "4 J/m at the start, 3.5 J/m at the end (drift -12.50% of it), highest 4.25 J/m at 0.5 s")


def test_a_summary_from_anybody_writes_no_lines_of_its_own():
    lines = info.table({**SUMMARY, "status": "completed\nenergy drift    +0.00%\x1b[1A"})
    assert lines[0] == "status          completed\n    energy drift    +0.00%\\x1b[1A"


def test_info_and_plot_name_a_damaged_snapshot(folder, capsys):
    """What can be known without it is still shown."""
    path = folder / "snapshots" / "000000.vtkhdf"
    path.write_bytes(path.read_bytes().replace(b"gmres", b"bcgsl"))
    assert main(["info", str(folder)]) == 5
    out, said = capsys.readouterr()
    assert "particles       3,200" in out and "snapshots       5" in out and "petsc_options" not in out
    assert said == f"parisph: error: {path} is damaged: its content does not match the digest at its end\n"
    assert main(["plot", str(folder), "--time", "0.1", "-o", str(folder / "a.png")]) == 5
    assert said == capsys.readouterr().err
    assert not (folder / "a.png").exists()


def flipped(path):
    content = path.read_bytes()
    path.write_bytes(content[:3000] + bytes([content[3000] ^ 1]) + content[3001:])


@pytest.mark.parametrize(("change", "says"), [
    (lambda run: flipped(run / "snapshots/000003.vtkhdf"), "snapshots/000003.vtkhdf is damaged"),
    (lambda run: (run / "snapshots/000004.vtkhdf").unlink(), "there is no file .*snapshots/000004.vtkhdf"),
    (lambda run: shutil.copy(run / "snapshots/000001.vtkhdf", run / "snapshots/000002.vtkhdf"),
     "000002.vtkhdf is the snapshot of 0.3 s"),
    (lambda run: shutil.copy(written(run / "other") / "snapshots/000002.vtkhdf", run / "snapshots"),
     "000002.vtkhdf is of another run"),
    (lambda run: flipped(run / "peaks/P2.vtkhdf"), "peaks/P2.vtkhdf is damaged"),
    (lambda run: shutil.copy(run / "peaks/P2.vtkhdf", run / "peaks/volume.vtkhdf"),
     "volume.vtkhdf is not the flow at the peak of volume"),
])
def test_info_checks_every_snapshot_and_peak(tmp_path, capsys, change, says):
    folder = written(tmp_path / "run", keep_peak=True)
    assert main(["info", str(folder)]) == 0 and capsys.readouterr().err == ""
    change(folder)
    assert main(["info", str(folder)]) == 5
    out, said = capsys.readouterr()
    assert "snapshots       5" in out and "petsc_options" in out    # what can be known is still shown
    assert re.fullmatch(f"parisph: error: .*{says}.*\n", said)


def test_info_names_several_damaged_snapshots(folder, capsys, monkeypatch):
    monkeypatch.setattr(reader, "FEW", 3)
    for path in sorted(folder.glob("snapshots/*")):
        flipped(path)
    assert main(["info", str(folder)]) == 5
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith("parisph: error: ") and said[3:] == ["and 2 more files"]
    assert all(f"00000{number}.vtkhdf is damaged" in said[number] for number in range(3))


@pytest.mark.parametrize("entry", [
    {"time": "x"}, {"steps": [1]}, {"left": [1]}, {"iterations": {"median": "x"}}, {"warnings": 5},
    {"volume_drift": 10**400}, {"energy_in_motion": {"start": 1.0}}, {"volume_range": {"low": "x"}}, {"errors": [0.1]},
    {"errors": {"P2": {"relative_l2": "x"}}},
])
@pytest.mark.parametrize("digest", [True, False])
def test_info_of_a_summary_with_entries_of_the_wrong_kind(folder, capsys, entry, digest):
    content = {**SUMMARY, **entry, "run": reader.open_run(folder).identity}
    (folder / "summary.json").write_text(json.dumps(json_digest.with_digest(content) if digest else content))
    assert main(["info", str(folder)]) == 5
    assert (capsys.readouterr().err
            == f"parisph: error: {folder}/summary.json is damaged: its entries are not those of a summary\n")


def test_info_as_json_and_of_an_unfinished_run(folder, capsys):
    assert main(["info", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == SUMMARY
    (folder / "summary.json").unlink()
    assert main(["info", str(folder)]) == 0
    assert "no summary.json" in capsys.readouterr().out


@pytest.mark.parametrize(("words", "name"), [
    ([], "overview.png"),
    (["--time", "0.24"], "flow_pressure_0.3000s.png"),
    (["--peak", "P2", "--surface"], "flow_pressure_0.5000s.png"),
    (["--field", "speed", "--normalise"], "flow_speed_0.9000s.png"),
    (["--probe", "P2", "--probe", "volume"], "probes_P2_volume.png"),
    (["--time", "0.5", "--zoom", "0.2", "0.8", "-0.1", "0.5", "--limits", "-1", "2.5", "--cmap", "magma"],
     "flow_pressure_0.5000s.png"),
    (["--time", "0.5", "--probe", "P2"], "flow_pressure_0.5000s.png probes_P2.png"),
])
def test_plot_names_the_pictures_it_made(folder, capsys, words, name):
    assert main(["plot", str(folder), *words]) == 0
    paths = [folder / one for one in name.split()]
    assert lines_of(capsys) == [str(path) for path in paths]
    assert all(path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 5000 for path in paths)


@pytest.mark.parametrize(("words", "name"), [
    (["plot"], "overview.png"), (["plot", "--time", "0.24"], "flow_pressure_0.3000s.png"),
    (["plot", "--probe", "P2"], "probes_P2.png"),
    (["compare", "REFERENCE", "--probe", "P2", "--plot", "FILE"], "compared.pdf"),
    (["movie", "-o", "FILE"], "flow_pressure.gif"),
])
def test_a_picture_is_never_written_through_a_link(folder, reference, words, name):
    target = folder.with_name("target.txt")
    target.write_bytes(b"mine")
    (folder / name).symlink_to(target)
    words = [{"REFERENCE": reference, "FILE": str(folder / name)}.get(word, word) for word in words]
    assert main([words[0], str(folder), *words[1:]]) == 0
    assert target.read_bytes() == b"mine"
    assert not (folder / name).is_symlink() and (folder / name).stat().st_size > 1000
    assert not [path for path in folder.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize(("words", "name"), [(["plot", "--probe", "P2"], "a.png"), (["movie"], "a.gif")])
def test_a_picture_that_cannot_be_written_leaves_the_old_one(folder, capsys, words, name):
    """A real refusal by the kernel, as on a full disk."""
    path = folder / name
    path.write_bytes(b"old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, hard))
    try:
        assert main([words[0], str(folder), *words[1:], "-o", str(path)]) == 5
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert f"{path}: File too large" in capsys.readouterr().err
    assert path.read_bytes() == b"old" and not [path for path in folder.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize(("words", "ending"), [(["plot", "--probe", "P2"], "png"), (["movie"], "gif")])
@pytest.mark.parametrize(("make", "says"), [(os.mkfifo, "it is not a regular file"), (os.mkdir, "it is a folder")])
def test_a_picture_replaces_no_pipe_and_no_folder(folder, capsys, words, ending, make, says):
    path = folder / f"there.{ending}"
    make(path)
    before = path.lstat()
    assert main([words[0], str(folder), *words[1:], "-o", str(path)]) == 5
    assert f"{path}: {says}" in capsys.readouterr().err and path.lstat().st_ino == before.st_ino


@pytest.mark.parametrize(("time", "shown"),
                         [("99", 0.9), ("-1", 0.1), ("1.01", 0.9), ("0.99", None), ("0.9", None), ("0.24", None)])
def test_plot_warns_of_a_time_outside_the_run(folder, capsys, time, shown):
    assert main(["plot", str(folder), "--time", time]) == 0
    said = capsys.readouterr().err
    if shown is None:
        assert said == ""
    else:
        assert (f"--time {float(time):g} s is outside the run" in said
                and f"0.1 to 0.9 s: the picture is of {shown:g} s" in said)


def test_plot_lays_the_probes_of_several_runs_over_each_other(folder, capsys):
    other = shutil.copytree(folder, folder.with_name("other"))
    assert main(["plot", str(folder), str(other)]) == 0
    assert main(["plot", str(folder), str(other), "--probe", "P2", "--normalise"]) == 0
    assert lines_of(capsys) == [str(folder / "probes_run_other.png"), str(folder / "probes_P2_run_other.png")]
    assert main(["plot", str(folder), str(other), "--time", "0.5"]) == 2
    assert "only probes can be drawn for several runs" in capsys.readouterr().err
    assert main(["plot", str(folder), str(folder.with_name("none")), "--probe", "P2"]) == 5


def test_plot_says_how_far_from_the_peak_the_picture_is(tmp_path, capsys):
    assert main(["plot", str(written(tmp_path / "run", peak=6)), "--peak", "P2"]) == 0
    said = capsys.readouterr().err
    assert "no snapshot at the peak of P2, t = 0.6 s: the nearest one is drawn, 0.1 s " in said


@pytest.mark.parametrize("script", ["cat > /dev/null; echo no room >&2; exit 3", "exit 3"])
def test_movie_of_an_ffmpeg_that_fails(folder, tmp_path, capsys, monkeypatch, script):
    program = tmp_path / "bin" / "ffmpeg"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)
    assert main(["movie", str(folder), "-o", str(tmp_path / "a.mp4")]) == 5
    said = capsys.readouterr().err
    assert (f"parisph: error: cannot write the movie {tmp_path}/a.mp4: ffmpeg ended with code 3" in said
            and "Traceback" not in said)
    assert "(no room)" in said or "no room" not in script
    assert not [path for path in tmp_path.iterdir() if path.suffix == ".mp4"]


@pytest.mark.parametrize("words", [[], ["--slow", "2", "--fps", "5", "--frame", "world", "--zoom", *"0101"]])
def test_movie(folder, tmp_path, capsys, words):
    assert main(["movie", str(folder), "-o", str(tmp_path / "a.gif"), *words]) == 0
    assert lines_of(capsys) == [str(tmp_path / "a.gif")]
    assert (tmp_path / "a.gif").read_bytes()[:4] == b"GIF8"


@pytest.fixture
def reference(tmp_path):
    """The tap's own series, 2 % too high, with its peak at .52 s."""
    t = np.linspace(0.02, 1.02, 51)
    path = tmp_path / "reference.csv"
    np.savetxt(path, np.transpose([t, 1.02 * (100.0 - 200 * np.abs(t - 0.52)), t]), delimiter=",",
               header="t,p,other", comments="")
    return str(path)


def test_compare_finds_a_known_error_and_shift(folder, reference, capsys):
    words = ["compare", str(folder), reference, "--probe", "P2", "--json"]
    assert main([*words, "--shift", "0.02"]) == 0
    assert json.loads(capsys.readouterr().out)["relative_l2"] == pytest.approx(0.02 / 1.02, rel=1e-6)
    assert main([*words, "--best-shift", "0.1"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["shift"] == pytest.approx(0.02, abs=2e-3)
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["relative_l2"] > 0.05
    assert main([*words, "--shift", "0.02", "--scale", str(1 / 1.02)]) == 0
    assert json.loads(capsys.readouterr().out)["relative_l2"] < 1e-9


def test_compare_draws_what_it_compares(folder, reference, tmp_path, capsys):
    words = ["compare", str(folder), reference, "--probe", "P2"]
    assert main([*words, "--plot", str(tmp_path / "both.png"), "--best-shift", "0.1"]) == 0
    assert ((tmp_path / "both.png").read_bytes().startswith(b"\x89PNG")
            and "relative L2 error" in capsys.readouterr().out)
    assert main([*words, "--plot", str(tmp_path / "both.unknown")]) == 5
    assert "cannot write the picture" in capsys.readouterr().err


def test_compare_in_words(folder, reference, capsys):
    assert main(["compare", str(folder), reference, "--probe", "P2", "--shift", "0.02"]) == 0
    said = capsys.readouterr().out
    assert ("relative L2 error  0.01961 of the reference" in said
            and "P2, pressure against the column p over t: " in said and "note" not in said)


def test_compare_says_where_the_shift_ends_and_the_level_is_another(folder, reference, capsys):
    words = ["compare", str(folder), reference, "--probe", "P2"]
    assert main([*words, "--best-shift", "0.01"]) == 0
    assert "note: the best shift is at its limit of 0.01 s: allow more with --best-shift" in capsys.readouterr().out
    assert main([*words, "--offset", "1000"]) == 0
    found = re.search(r"note: the mean of the run is .*unit or level meant\? --offset (\S+) ", capsys.readouterr().out)
    assert found and float(found[1]) == pytest.approx(-1000.0, rel=0.01)
    assert main([*words, "--best-shift", "0.05", "--offset", str(1000 + float(found[1]))]) == 0
    assert "note" not in capsys.readouterr().out


@pytest.mark.parametrize(("head", "column"), [
    ("time,step,pressure", "pressure"), ("time,step,other,pressure", "pressure"), ("time,step,p,q", "p"),
    ("step,t,p", "p"),
])
def test_compare_takes_the_column_of_values(folder, tmp_path, capsys, head, column):
    """As in the files of parisph's own probes, where the second column is the step."""
    names = head.split(",")
    path = tmp_path / "other.csv"
    lines = [[{"step": step, "t": 0.1 * step, "time": 0.1 * step, column: 100.0 - 20 * abs(step - 5)}.get(name, -7.0)
              for name in names]
             for step in range(11)]
    np.savetxt(path, lines, delimiter=",", header=head, comments="")
    words = ["--time", "t"] if "t" in names else []
    assert main(["compare", str(folder), str(path), "--probe", "P2", "--json", *words]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["value"], found["time"]) == (column, words[-1] if words else "time")
    assert found["relative_l2"] < 1e-12


def test_compare_with_a_series_without_values(folder, tmp_path, capsys):
    (tmp_path / "other.csv").write_text("time,step\n0,0\n1,1\n")
    assert main(["compare", str(folder), str(tmp_path / "other.csv"), "--probe", "P2"]) == 2
    assert "a series needs a time and a value" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "code", "says"), [
    (["plot", "--time", "1", "--peak", "P2"], 2, "--time and --peak both"),
    (["plot", "--normalise"], 2, "--normalise does not apply to the whole run"),
    (["plot", "--normalise", "--surface"], 2, "give --time, --peak, --field or --probe"),
    (["plot", "--time", "1", "--probe", "P2", "-o", "x.png"], 2, "two pictures"),
    (["plot", "--probe", "P9"], 2, "no probe 'P9' (it has: P2, volume)"),
    (["plot", "--peak", "P9"], 2, "no probe 'P9'"),
    (["plot", "--field", "salt"], 2, "no quantity 'salt'"),
    (["plot", "-o", "x"], 2, "x: must end in a kind of picture, such as .png"),
    (["plot", "--probe", "P2", "-o", "x.unknown"], 5, "cannot write the picture"),
    (["movie", "-o", "x.txt"], 2, "ends in .gif or .mp4"),
    (["plot", "--time", "1", "--limits", "5", "2"], 2, "--limits: 5 to 2 is not a range"),
    (["plot", "--limits", "5"], 2, "--limits: expected 2 arguments"),
    (["plot", "--zoom", "0", "1", "0.5", "0.2"], 2, "--zoom, up: 0.5 to 0.2 is not a range"),
    (["plot", "--zoom", "7", "8", "0", "1", "--time", "1"], 2, "--zoom 7 8 0 1: nothing is there"),
    (["plot", "--cmap", "viridiss"], 2, "no colour map 'viridiss' in matplotlib: try viridis"),
    (["plot", "--field", "role", "--cmap", "magma"], 2, "--cmap does not apply to the field role"),
    (["plot", "--frame", "sea"], 2, "--frame: invalid choice: 'sea'"),
    (["movie", "--fps", "-3"], 2, "--fps -3: must be a number greater than 0"),
    (["movie", "--slow", "inf"], 2, "--slow: 'inf': must be a finite number"),
    (["compare"], 2, "has the probes P2, volume: choose one with --probe"),
    (["compare", "--probe", "P9"], 2, "there is no 'P9'"),
    (["compare", "--probe", "P2", "--column", "u"], 2, "P2 has the columns pressure; there is no 'u'"),
    (["compare", "--probe", "P2", "--value", "q"], 2, "no column 'q' (it has: t, p, other): choose one with --value"),
    (["compare", "--probe", "P2", "--time", "q"], 2, "has no column 'q' (it has: t, p, other): choose one with --time"),
    (["compare", "--probe", "P2", "--shift", "9"], 2, "share fewer than two samples"),
    (["compare", "--probe", "P2", "--shift", "1e20"], 2, "share fewer than two samples"),
    (["compare", "--probe", "P2", "--best-shift", "-1"], 2, "best_shift = -1: must be at least 0"),
    (["compare", "--probe", "P2", "--time-scale", "0"], 2, "time_scale = 0: must be greater than 0"),
    (["compare", "--probe", "P2", "--scale", "1e30"], 5, "reaches more than 1e+30 when scaled"),
    (["report", "--into", "page.md", "-o", "pictures"], 2, "-o: with --into the pictures go beside the file"),
    (["restart", "none/00000001.h5", "-o", "new"], 5, "there is no checkpoint none/00000001.h5"),
])
def test_what_cannot_be_done_is_said(folder, reference, monkeypatch, capsys, words, code, says):
    monkeypatch.chdir(folder.parent)
    given = {"compare": ["run", reference], "restart": []}.get(words[0], ["run"])
    assert main([words[0], *given, *words[1:]]) == code
    assert says in capsys.readouterr().err
    assert {path.name for path in folder.parent.iterdir()} == {"run", "reference.csv"}
