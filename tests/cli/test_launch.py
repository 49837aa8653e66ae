"""What a process of parisph finds in its environment, and how it starts others."""

import os
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest

from parisph.base import environment, launch
from parisph.case.load import load
from tests.launch import ROOT, clean_environment, mpirun, run


def test_prepare_sets_one_thread_and_leaves_what_the_user_chose():
    variables = {"NUMBA_NUM_THREADS": "4"}
    environment.prepare(variables)
    assert variables["NUMBA_NUM_THREADS"] == "4" and variables["OMP_NUM_THREADS"] == "1"
    assert variables["H5PY_ALWAYS_USE_MPI"] == "1"


@pytest.mark.parametrize(("variables", "ranks"), [
    ({}, (0, 1)),
    ({"OMPI_COMM_WORLD_RANK": "3", "OMPI_COMM_WORLD_SIZE": "4", "SLURM_PROCID": "0", "SLURM_STEP_NUM_TASKS": "2"},
     (3, 4)),
    ({"PMI_RANK": "1", "PMI_SIZE": "2"}, (1, 2)),
    ({"SLURM_PROCID": "5", "SLURM_STEP_NUM_TASKS": "8"}, (5, 8)),
    ({"SLURM_PROCID": "0", "SLURM_NTASKS": "8"}, (0, 1)),    # the batch script itself
])
def test_launched(variables, ranks):
    assert environment.launched(variables) == ranks


def test_for_launching_takes_out_an_outer_launcher_and_keeps_the_user():
    outer = {"OMPI_COMM_WORLD_SIZE": "2", "PMIX_RANK": "1", "OMPI_MCA_ess_base_vpid": "1", "SLURM_JOB_ID": "7",
             "OMPI_MCA_mpi_yield_when_idle": "0", "PATH": "/bin", "OMPI_MCA_pml": "ob1"}
    before = dict(outer)
    inner = environment.for_launching(outer)
    assert outer == before
    assert not {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "OMPI_MCA_ess_base_vpid", "SLURM_JOB_ID"} & set(inner)
    assert inner["PATH"] == "/bin" and inner["OMPI_MCA_pml"] == "ob1" and inner["OMPI_MCA_mpi_yield_when_idle"] == "0"
    assert inner["OMPI_MCA_rmaps_base_oversubscribe"] == "1" and inner["NUMBA_NUM_THREADS"] == "1"
    assert ("OMPI_ALLOW_RUN_AS_ROOT" in inner) == (os.geteuid() == 0)


def test_only_a_process_without_a_launcher_starts_mpi_without_a_daemon():
    name, = environment.ALONE
    ranks = {"OMPI_COMM_WORLD_RANK": "0", "OMPI_COMM_WORLD_SIZE": "2"}
    for given, due in (({}, "1"), ({name: "0"}, "0"), (ranks, None)):
        environment.prepare(given)
        assert given.get(name) == due
    assert name not in environment.for_launching({name: "1"})


def sourced(**settings):
    """Return the variables that run_scripts/env sets in an otherwise empty shell."""
    done = subprocess.run(["bash", "-c", '. "$0/run_scripts/env"; env', ROOT],
                          env={"PATH": os.environ["PATH"], **settings},
                          capture_output=True, text=True, check=True, timeout=20)
    found = dict(line.split("=", 1) for line in done.stdout.splitlines())
    return {name: value for name, value in found.items() if name.startswith("OMPI_")}


def test_env_file_says_the_same_as_the_package():
    as_root = environment.AS_ROOT if os.geteuid() == 0 else {}
    assert sourced() == {**environment.ONE_MACHINE, **as_root}
    assert sourced(SLURM_JOB_ID="7") == as_root
    assert sourced(OMPI_MCA_mpi_yield_when_idle="0")["OMPI_MCA_mpi_yield_when_idle"] == "0"


def test_mpirun_inside_mpirun(tmp_path):
    """A test, or doctor, may itself run under mpirun.

    One rank of each speaks: a line and its end reach mpirun apart, and those of two ranks may be mixed.
    """
    inner = tmp_path / "inner.py"
    inner.write_text("from mpi4py import MPI\ntotal = MPI.COMM_WORLD.allreduce(1)\n"
                     "if MPI.COMM_WORLD.rank == 0: print('inner', total)\n")
    outer = tmp_path / "outer.py"
    outer.write_text("import sys\nfrom mpi4py import MPI\nfrom tests.launch import mpirun\n"
                     "if MPI.COMM_WORLD.rank == 0: print(mpirun(2, [sys.argv[1]]).stdout)\n")
    done = mpirun(2, [outer, inner])
    assert done.returncode == 0 and done.stdout.split() == ["inner", "2"], done.stderr


SLEEPS = 300.0    # [s]


def test_a_hang_is_ended_with_its_children(tmp_path):
    program = tmp_path / "hang.py"
    program.write_text("import time\nfrom mpi4py import MPI\nif MPI.COMM_WORLD.rank == 0:\n"
                       f"    MPI.COMM_WORLD.recv(source=1)\ntime.sleep({SLEEPS})\n")
    start = time.monotonic()
    with pytest.raises(subprocess.TimeoutExpired):
        mpirun(2, [program], timeout=6, cwd=tmp_path)
    while _processes_of(program) and time.monotonic() - start < SLEEPS:
        time.sleep(0.1)
    assert time.monotonic() - start < SLEEPS, "they have ended by themselves"


def _processes_of(program):
    """Return the processes that live and have the path of a program in their command line."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if str(program).encode() in path.read_bytes().split(b"\0"):    # it is empty of one that has ended
                found.append(path.parent.name)
        except OSError:     # gone meanwhile
            continue
    return found


def test_launch_kills_what_ignores_a_gentle_end(monkeypatch):
    monkeypatch.setattr(launch, "GRACE", 0.5)
    stubborn = "trap '' TERM; echo here; sleep 600"    # a shell is there soon, on a busy machine too
    with pytest.raises(subprocess.TimeoutExpired) as caught:
        launch.run(["sh", "-c", stubborn], 2, clean_environment())
    assert caught.value.output == "here\n"


@pytest.mark.parametrize("script", ["setup", "test", "demo", "env", "dam_break.slurm"])
def test_scripts_are_valid_shell(script):
    assert run(["bash", "-n", ROOT / "run_scripts" / script]).returncode == 0


@pytest.fixture(scope="module")
def small_clone(tmp_path_factory):
    """A folder with run_scripts/test and a few tests, of which one fails on rank 1 alone."""
    folder = tmp_path_factory.mktemp("clone")
    files = {
        "run_scripts/test": (ROOT / "run_scripts" / "test").read_text(), "run_scripts/setup": "#!/bin/sh\n",
        ".venv/bin/activate": f"PATH={shlex.quote(os.path.dirname(sys.executable))}:$PATH\n",
        "tests/test_a.py": "def test_alone(): pass\n",
        "tests/parallel/test_b.py": "import os\ndef test_ranks(): pass\n"
                                    "def test_bad(): assert os.environ.get('OMPI_COMM_WORLD_RANK', "
                                    "os.environ.get('PMI_RANK')) != '1'\n",
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (folder / "run_scripts" / "setup").chmod(0o755)
    return folder


@pytest.mark.parametrize(("name", "code", "says"), [
    ("alone", 0, "test: all passed"), ("ranks", 0, "test: all passed"), ("alone or ranks", 0, "test: all passed"),
    ("bad", 1, "FAILED, tests on two ranks: exit code 1"), ("ranks or bad", 1, "FAILED, tests on two ranks"),
    ("nothing", 1, "no test was run"),
])
def test_selected_tests_are_judged(small_clone, name, code, says):
    """To leave no test for the ranks is no failure of mpirun, and hides none."""
    done = run(["bash", "run_scripts/test", "-k", name], cwd=small_clone)
    assert done.returncode == code and says in done.stdout + done.stderr
    assert ("non-zero" in done.stderr) <= ("bad" in name)


@pytest.mark.parametrize("script", ["demo", "dam_break.slurm"])
def test_scripts_set_only_what_their_case_has(script):
    lines = [line for line in (ROOT / "run_scripts" / script).read_text().splitlines() if "parisph run cases/" in line]
    assert lines
    for line in lines:
        words = line.split()
        case = next(word for word in words if word.startswith("cases/"))
        load(ROOT / case, [value for option, value in zip(words, words[1:]) if option == "--set"])


def test_ci_runs_the_tests():
    assert (ROOT / ".ci" / "run").read_text().rstrip().endswith('run_scripts/test"')
