"""Check whether parisph can run on this machine: library versions, compiled kernels, and a real solve on two ranks.

Each library is loaded in a separate process with a time limit, so that a crash or a hang is reported like any other
problem.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import metadata, util
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from parisph.base import environment, launch, libraries, surroundings
from parisph.base.errors import ParisphError
from parisph.base.memory import amount

if TYPE_CHECKING:
    from mpi4py import MPI

LIMIT = 60.0              # [s] for each process
EXACT = 1e-6              # largest relative error of the trial solve, whose tolerance is 1e-10
OLDEST_PETSC = (3, 18)

NOT_ON_A_LAPTOP = ("MPI", "PETSc", "HDF5")    # may be absent where no case runs

PACKAGES = "run_scripts/setup installs it on Debian; on a cluster load its module"

Answer: TypeAlias = dict[str, Any]               # of a process that has loaded a library
Judgement: TypeAlias = tuple[bool, str, str]     # ok, detail and remedy of a Finding


@dataclass(frozen=True)
class Finding:
    """The result of one check; `remedy` says what to do if it is not ok.

    absent : whether a library is not installed; a laptop needs only some
    """

    name: str
    ok: bool
    detail: str
    remedy: str = ""
    absent: bool = False


def examine() -> list[Finding]:
    """Return the Findings about this machine. Not collective: starts its own ranks."""
    findings = [Finding("python", True, f"{sys.version.split()[0]}, {sys.executable}")]
    findings += _of_numpy([finding for entry in _LIBRARIES for finding in _library(*entry)])
    launcher = shutil.which("mpirun") or shutil.which("mpiexec")
    if _cannot_run(findings):
        findings = [replace(finding, ok=finding.ok or (finding.absent and finding.name in NOT_ON_A_LAPTOP))
                    for finding in findings]
        if not _is_there("matplotlib"):
            findings.append(Finding("matplotlib", True, "not installed", absent=True))
        return findings
    if launcher is None:
        return findings + [Finding("mpirun", False, "not on PATH", PACKAGES)]
    findings.append(Finding("mpirun", True, launcher))
    if all(finding.ok for finding in findings if finding.name in ("MPI", "PETSc", "HDF5")):
        findings.append(_two_ranks(launcher))
    return findings


def report(findings: Sequence[Finding]) -> str:
    """Return the findings as text, one per line, each problem with its remedy."""
    lines = []
    for finding in findings:
        state = "PROBLEM" if not finding.ok else "-" if finding.absent else "ok"
        lines.append(f"{state:<8}{finding.name:<11}{finding.detail}")
        if finding.remedy and not finding.ok:
            lines.append(f"{'':<8}{'remedy:':<11}{finding.remedy}")
    problems = sum(not finding.ok for finding in findings)
    if problems:
        lines.append(f"{problems} problem{'s' * (problems > 1)} found.")
    else:
        lines.append(_without_mpi(findings) if _cannot_run(findings) else "parisph can run here.")
    return "\n".join(lines)


def _cannot_run(findings: Sequence[Finding]) -> bool:
    """Return whether neither MPI nor PETSc is installed, as on a laptop for looking at runs."""
    return {"MPI", "PETSc"} <= {finding.name for finding in findings if finding.absent}


def _without_mpi(findings: Sequence[Finding]) -> str:
    """Return what parisph can do without MPI, and what it needs for the rest."""
    absent = {finding.name for finding in findings if finding.absent}
    look, rest = ("info", "compare", "reflection"), ("plot", "movie", "report")
    works = ["check", *(look if "HDF5" not in absent else ()), *(rest if not {"HDF5", "matplotlib"} & absent else ())]
    lines = [f"This machine has no MPI and no PETSc. What works here: {', '.join(works)}. What does not: run, restart, "
             "study."]
    if {"HDF5", "matplotlib"} & absent:
        lines.append("To look at runs: pip install 'parisph[look]'")
    lines.append(f"To run cases: {libraries.SETUP}")
    return "\n".join(lines)


def _is_there(name: str) -> bool:
    try:
        return util.find_spec(name) is not None
    except ImportError:
        return False


def trial(comm: "MPI.Comm") -> dict[str, Any]:
    """Solve a small system, write a file together and read it again. Collective.

    Uses the current folder, which all ranks must share. Returns "ranks", "iterations", "error" and "file" (whether the
    file was read as written) as a dict, the same on every rank. Raises SolverDiverged, or StoreError if the file cannot
    be written or read, on every rank.
    """
    from parisph.pressure import trial as pressure

    result = pressure.solve(comm)
    result["file"] = _write_together(comm)
    return result


# ---- a library in a separate process (`python -m parisph.doctor NAME`)

def _ask_numpy() -> Answer:
    import numpy

    return {"version": numpy.__version__}


def _ask_numba() -> Answer:
    from parisph.kernels import jit, kept, selfcheck

    found = kept.state(jit.FOLDERS)
    return {"version": metadata.version("numba"), "works": selfcheck.stores_hold(), **found}


def _ask_mpi() -> Answer:
    import mpi4py
    from mpi4py import MPI

    return {"version": MPI.Get_library_version().split("\n")[0].split(",")[0].strip("\0 "),
            "mpi4py": mpi4py.__version__}


def _ask_petsc() -> Answer:
    if not _is_there("petsc4py"):    # the import would first complain about mpi4py
        raise ModuleNotFoundError("No module named 'petsc4py'")
    from parisph.pressure import trial as pressure

    return pressure.versions()


def _ask_hdf5() -> Answer:
    import h5py

    return {"version": h5py.version.hdf5_version, "h5py": h5py.__version__, "parallel": bool(h5py.get_config().mpi)}


_QUESTIONS = {"numpy": _ask_numpy, "numba": _ask_numba, "MPI": _ask_mpi, "PETSc": _ask_petsc, "HDF5": _ask_hdf5}


# ---- judges: answer -> (ok, detail, remedy) of a Finding

def _judge_numba(answer: Answer) -> Judgement:
    return answer["works"], answer["version"] + ("" if answer["works"] else ", makes wrong machine code"), (
        "unset NUMBA_CPU_FEATURES and NUMBA_CPU_NAME, or install another release of numba")


def _judge_kernels(answer: Answer) -> Judgement:
    """Judge the cache of compiled kernels, from the answer of numba."""
    count, damaged, write = answer["kernels"], len(answer["damaged"]), answer["write"]
    detail = f"{count} compiled, {amount(answer['bytes'])}" if count else "none compiled yet"
    if damaged:
        detail += f"; {damaged} damaged, which the next run compiles again ({answer['damaged'][0]})"
    if write is None:
        places = f" in {' and '.join(answer['read'])}" if count else ""
        return count > 0, f"{detail}{places}; there is no folder that can be written for further ones", (
            "set NUMBA_CACHE_DIR to a folder that you can write; without it every run compiles for a minute")
    where = f", in {write}" if count else f"; the first run takes a minute for it, and writes to {write}"
    return True, f"{detail}{where}", ""


def _judge_petsc(answer: Answer) -> Judgement:
    hypre = {None: "without hypre", "": "hypre (version unknown)"}.get(answer["hypre"], f"hypre {answer['hypre']}")
    detail = f"{answer['PETSc']} ({answer['scalar']}, {answer['integer']}), {hypre}; petsc4py {answer['petsc4py']}"
    if answer["scalar"] != "float64":
        return False, detail, "load a PETSc built for real numbers in double precision, with its petsc4py"
    if tuple(int(n) for n in answer["PETSc"].split(".")[:2]) < OLDEST_PETSC:
        return False, detail, f"PETSc {'.'.join(map(str, OLDEST_PETSC))} or later is needed"
    return answer["hypre"] is not None, detail, "load a PETSc built with hypre (configure --download-hypre)"


def _judge_hdf5(answer: Answer) -> Judgement:
    kind = "parallel" if answer["parallel"] else "serial"    # parisph writes in parallel with both
    return True, f"{answer['version']}, {kind}; h5py {answer['h5py']}", ""


# (name, Python module, {name of a Finding: its judge}, remedy if it cannot be loaded)
_LIBRARIES = (
    ("numpy", "numpy", {"numpy": lambda answer: (True, answer["version"], "")}, "pip install numpy"),
    ("numba", "numba", {"numba": _judge_numba, "kernels": _judge_kernels},
     "pip install numba, in a release that supports this numpy"),
    ("MPI", "mpi4py", {"MPI": lambda answer: (True, f"{answer['version']}; mpi4py {answer['mpi4py']}", "")}, PACKAGES),
    ("PETSc", "petsc4py", {"PETSc": _judge_petsc}, PACKAGES),
    ("HDF5", "h5py", {"HDF5": _judge_hdf5}, PACKAGES),
)


def _library(name: str, module: str, judges: Mapping[str, Callable[[Answer], Judgement]],
             if_missing: str) -> list[Finding]:
    """Return the Findings about one library."""
    try:
        answer = _run([sys.executable, "-m", "parisph.doctor", name])
    except ParisphError as error:
        if re.search(rf"ModuleNotFoundError: No module named '{module}\b", str(error)):
            return [Finding(name, False, f"not installed ({module})", if_missing, absent=True)]
        return [Finding(name, False, str(error), if_missing)]
    return [Finding(about, *judge(answer)) for about, judge in judges.items()]


def _of_numpy(findings: list[Finding]) -> list[Finding]:
    """Return the findings, with one about numpy if libraries were compiled for another one."""
    unfit = [finding.name for finding in findings if not finding.ok and surroundings.is_another_numpy(finding.detail)]
    if not unfit:
        return findings
    remedy = surroundings.numpy_remedy()
    found = []
    for finding in findings:
        if finding.name == "numpy":
            due = surroundings.numpy_due(" ({})")
            detail = f"{finding.detail} is not the numpy{due} that {' and '.join(unfit)} were compiled for"
            finding = Finding("numpy", False, detail, remedy)
        elif finding.name in unfit:
            finding = Finding(finding.name, False, "cannot be loaded with this numpy", "see numpy")
        found.append(finding)
    return found


def _two_ranks(launcher: str) -> Finding:
    """Return the Finding about a solve and a file of two ranks, on the loopback interface."""
    try:
        answer = _run([launcher, "-n", "2", sys.executable, "-m", "parisph", "doctor", "--trial"])
    except ParisphError as error:
        return Finding("two ranks", False, str(error), f"try by hand: {launcher} -n 2 parisph doctor --trial")
    return Finding("two ranks", *_judge_trial(answer))


def _judge_trial(answer: Answer) -> Judgement:
    detail = (f"solved together in {answer['iterations']} iterations, error {answer['error']:.0e}; "
              f"file {'written and read' if answer['file'] else 'came back different'}")
    if answer["ranks"] != 2:
        return False, f"mpirun -n 2 gave {answer['ranks']} rank(s)", (
            "mpirun and mpi4py belong to different MPI libraries: put the mpirun of mpi4py's library first on PATH")
    return answer["error"] < EXACT and answer["file"], detail, "PETSc or HDF5 is broken: reinstall it or load another"


def _run(command: Sequence[str]) -> Answer:
    """Run a command in an empty folder; return the JSON of its last line. Raises ParisphError."""
    with tempfile.TemporaryDirectory(prefix="parisph-doctor-") as folder:
        try:
            done = launch.run(command, LIMIT, environment.for_own(), cwd=folder)
        except subprocess.TimeoutExpired:
            raise ParisphError(f"no answer within {LIMIT:.0f} s") from None
    lines = done.stdout.strip().splitlines()
    try:
        answer: Answer = json.loads(lines[-1])
    except (IndexError, ValueError):
        raise ParisphError(_cause(done)) from None
    return answer


def _cause(done: subprocess.CompletedProcess[str]) -> str:
    """Return the most informative line of a failed process's output."""
    lines = [line.strip() for line in done.stderr.splitlines() if line.strip(" -")]
    errors = [line for line in lines if "Error" in line or "error:" in line]
    return (errors or lines or [f"ended with code {done.returncode} without a message"])[-1]


def _write_together(comm: "MPI.Comm") -> bool:
    """Write a row from each rank to one file, and read all of them on each rank. Collective."""
    import h5py
    import numpy as np

    from parisph.io import digest, slabs

    path = comm.bcast(Path(f"parisph-doctor-{os.getpid()}.h5").absolute())
    slabs.write(comm, path, [slabs.Slab("rank", np.array([comm.rank], np.int32), comm.rank, comm.size)],
                lambda file: None)
    digest.check_together(comm, path)
    with h5py.File(path, "r") as file:
        same = list(file["rank"][:]) == list(range(comm.size))
    same = all(comm.allgather(same))
    if comm.rank == 0:
        path.unlink()
    return same


if __name__ == "__main__":
    print(json.dumps(_QUESTIONS[sys.argv[1]]()))
