"""doctor finds what is wrong, and says what to do."""

import sys

import pytest
from mpi4py import MPI

from parisph import doctor
from parisph.__main__ import main
from tests.launch import mpirun, parisph, succeeded


def by_name(findings):
    return {finding.name: finding for finding in findings}


def test_this_machine_is_fit():
    done = parisph("doctor", timeout=200)
    assert done.returncode == 0, done.stdout + done.stderr
    for word in ("PETSc", "hypre", "parallel", "numba", "numpy", "two ranks", "error"):
        assert word in done.stdout
    assert "PROBLEM" not in done.stdout and "parisph can run here." in done.stdout


def test_trial_on_three_ranks(tmp_path):
    done = succeeded(mpirun(3, ["-m", "parisph", "doctor", "--trial"], cwd=tmp_path))
    assert done.stdout.count('"ranks": 3') == 1 and '"file": true' in done.stdout
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def only_mpirun(tmp_path, monkeypatch):
    """Put a fake mpirun first on PATH, and let the libraries be fine."""
    def install(text):
        path = tmp_path / "mpirun"
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
        monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
        monkeypatch.setattr(doctor, "_LIBRARIES", ())
        return by_name(doctor.examine())["two ranks"]
    return install


@pytest.mark.parametrize(("script", "limit", "detail", "remedy"), [
    ('shift 2; "$@"; "$@"', doctor.LIMIT, "gave 1 rank", "different MPI libraries"),    # each process is alone
    ("sleep 100", 1.0, "no answer within 1 s", "by hand"),
    ("(echo 'some noise'; echo 'Error: no slots'; echo -------) >&2; exit 7", doctor.LIMIT, "Error: no slots", ""),
])
def test_mpirun_of_another_library_or_that_hangs_or_fails(only_mpirun, monkeypatch, script, limit, detail, remedy):
    monkeypatch.setattr(doctor, "LIMIT", limit)
    found = only_mpirun(script)
    assert not found.ok and detail in found.detail and "noise" not in found.detail and remedy in found.remedy


def test_no_mpirun(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(doctor, "_LIBRARIES", ())
    assert main(["doctor"]) == 1
    shown = capsys.readouterr().out
    assert "PROBLEM mpirun     not on PATH" in shown and "remedy:" in shown and "1 problem found." in shown


@pytest.mark.parametrize(("program", "says"), [
    ("echo 'ModuleNotFoundError: no numpy' >&2; exit 1", "ModuleNotFoundError: no numpy"),
    ("kill -SEGV $$", "ended with code -11"),
    ("echo '{half a line'", "ended with code 0"),
])
def test_library_that_fails_or_crashes(tmp_path, monkeypatch, program, says):
    python = tmp_path / "python"
    python.write_text(f"#!/bin/sh\n{program}\n")
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))
    found, = doctor._library("numpy", "numpy", {}, "pip install numpy")
    assert not found.ok and says in found.detail and found.remedy == "pip install numpy"


PETSC = {"PETSc": "3.26.1", "petsc4py": "3.26.1", "hypre": "3.0.0", "scalar": "float64", "integer": "int64"}


@pytest.mark.parametrize(("change", "ok", "word"), [
    ({}, True, "hypre 3.0.0"),
    ({"hypre": ""}, True, "version unknown"),
    ({"hypre": None}, False, "without hypre"),
    ({"scalar": "complex128"}, False, "complex128"),
    ({"PETSc": "3.9.4"}, False, "3.9.4"),
    ({"PETSc": "3.18.5"}, True, "3.18.5"),
])
def test_judging_petsc(change, ok, word):
    found_ok, detail, _ = doctor._judge_petsc({**PETSC, **change})
    assert found_ok == ok and word in detail


def test_judging_the_rest():
    for parallel in (False, True):
        assert doctor._judge_hdf5({"version": "1.14", "h5py": "3.11", "parallel": parallel})[0]
    right = {"ranks": 2, "iterations": 9, "error": 1e-9, "file": True}
    assert doctor._judge_trial(right)[0]
    for wrong in ({"error": 1e-3}, {"file": False}, {"ranks": 1}, {"error": float("nan")}):
        assert not doctor._judge_trial({**right, **wrong})[0]


def test_file_written_together_is_read_back_and_removed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert doctor._write_together(MPI.COMM_SELF)
    assert not list(tmp_path.iterdir())


KERNELS = {"kernels": 83, "bytes": 5_490_000, "damaged": [], "write": "/cache", "read": ["/cache"]}


@pytest.mark.parametrize(("change", "ok", "says"), [
    ({}, True, "83 compiled, 5.49 MB, in /cache"),
    ({"kernels": 0}, True, "none compiled yet; the first run takes a minute for it, and writes to /cache"),
    ({"damaged": ["/cache/a.kernel"]}, True, "; 1 damaged, which the next run compiles again (/cache/a.kernel)"),
    ({"write": None, "read": ["/theirs"]}, True, "in /theirs; there is no folder that can be written for further ones"),
    ({"write": None, "kernels": 0, "read": []}, False, "there is no folder that can be written for further ones"),
])
def test_judging_the_cache_of_kernels(change, ok, says):
    found_ok, detail, remedy = doctor._judge_kernels({**KERNELS, **change})
    assert found_ok == ok and says in detail and (ok or "set NUMBA_CACHE_DIR" in remedy)


def test_a_numpy_that_the_other_libraries_were_not_compiled_for(monkeypatch):
    """That one is the problem, and the remedy puts the right one back."""
    monkeypatch.setattr(doctor.surroundings, "numpy_due", lambda form: form.format("1.24.2"))
    error = "ValueError: numpy.dtype size changed, may indicate binary incompatibility"
    found = doctor._of_numpy([doctor.Finding("numpy", True, "2.4.6"), doctor.Finding("MPI", True, "fine"),
                              doctor.Finding("PETSc", False, error, doctor.PACKAGES),
                              doctor.Finding("HDF5", False, error, doctor.PACKAGES)])
    text = doctor.report(found)
    assert "PROBLEM numpy      2.4.6 is not the numpy (1.24.2) that PETSc and HDF5 were compiled for\n" in text
    assert "PROBLEM PETSc      cannot be loaded with this numpy\n" in text and doctor.PACKAGES not in text
    assert text.count(doctor.surroundings.numpy_remedy()) == 1 and text.count("see numpy") == 2


def absent(*names):
    modules = {name: module for name, module, _, _ in doctor._LIBRARIES}
    return lambda name, module, judges, remedy: [
        doctor.Finding(about, name not in names, modules[name], remedy, absent=name in names) for about in judges]


@pytest.mark.parametrize(("missing", "code", "says"), [
    (("MPI", "PETSc"), 0, "What works here: check, info, compare, reflection, plot, movie, report. What does not: run"),
    (("MPI", "PETSc", "HDF5"), 0, "What works here: check. What"),
    (("PETSc",), 1, "PROBLEM PETSc"),
    (("MPI", "PETSc", "numba"), 1, "PROBLEM numba"),
])
def test_a_machine_without_mpi_is_a_state_and_no_problem(monkeypatch, capsys, missing, code, says):
    monkeypatch.setattr(doctor, "_library", absent(*missing))
    monkeypatch.setattr(doctor, "_two_ranks", lambda launcher: doctor.Finding("two ranks", True, "fine"))
    assert main(["doctor"]) == code
    shown = capsys.readouterr().out
    assert says in shown and ("PROBLEM" in shown) == bool(code)
