"""Output whose reader leaves, as in `parisph run CASE | head`: the run goes on to its end, and nothing is said."""

import json
import shutil
import signal
import sys

import pytest

from tests.launch import run, succeeded

CASE = """
from tests.scenes import scene
def case(end_time: float = 0.3):
    return scene("dam_break", spacing=0.05, end_time=end_time)
"""
PARISPH = (sys.executable, "-m", "parisph")
ONE, TWO = (), (shutil.which("mpirun") or "mpiexec", "-n", "2")


def unread(folder, *words, both=True, launcher=ONE, **settings):
    """Run `parisph WORDS` into a pipe whose reader leaves at once; return CompletedProcess of what is still said."""
    pipe = '"$@" 2>&1 | true' if both else '"$@" | true'
    return run(["bash", "-c", f"{pipe}; exit ${{PIPESTATUS[0]}}", "-", *launcher, *PARISPH, *words], 120,
               folder, **settings)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "case.py").write_text(CASE)
    return tmp_path


@pytest.mark.parametrize(("launcher", "both"), [(ONE, True), (ONE, False), (TWO, True)])
def test_a_run_comes_to_its_end(folder, launcher, both):
    """With both streams the progress is lost to it in the middle: PETSc used to end the run there.

    Open MPI's `mpirun` may itself end by the signal, whatever it has started (6 of 60 runs of `echo`): the summary,
    which is written last, says what became of the ranks.
    """
    codes = (0, 128 + signal.SIGPIPE) if launcher else (0,)
    done = unread(folder, "run", "case.py", "-o", "run", both=both, launcher=launcher)
    assert done.returncode in codes
    assert [line for line in done.stderr.splitlines() if not line.startswith(("Dam break", "t ", "compil"))] == []
    assert json.loads((folder / "run" / "summary.json").read_text())["status"] == "completed"
    done = unread(folder, "restart", "run", "--until", "0.12", launcher=launcher)
    assert done.returncode in codes and done.stderr == ""
    assert json.loads((folder / "run" / "summary.json").read_text())["time"] == pytest.approx(0.12, abs=0.01)


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize(("words", "code"), [
    (("check", "case.py"), 0), (("run", "-h"), 0), (("check", "none.py"), 2), (("plot", "none"), 5),
])
def test_an_error_keeps_its_code(folder, words, code, unbuffered):
    done = unread(folder, *words, PYTHONUNBUFFERED=unbuffered)
    assert (done.returncode, done.stderr) == (code, "")


def test_looking_at_a_run(folder):
    assert run([*PARISPH, "run", "case.py", "-o", "run", "-q"], 120, folder).returncode == 0
    for words in (("info", "run"), ("info", "run", "--json"), ("plot", "run"), ("plot", "run", "--peak", "P1"),
                  ("compare", "run", "run/probes/P1.csv", "--probe", "P1")):
        for unbuffered in ("", "1") if words[0] == "info" else ("",):
            done = unread(folder, *words, PYTHONUNBUFFERED=unbuffered)
            assert (done.returncode, done.stderr) == (0, ""), words


def test_petsc_leaves_the_signal_to_the_program(tmp_path):
    """Whatever the program has chosen: to be told (Python's way), or to be ended."""
    for chosen in ("SIG_IGN", "SIG_DFL"):
        (tmp_path / "program.py").write_text(
            f"import signal; signal.signal(signal.SIGPIPE, signal.{chosen})\n"
            "import parisph.parallel.petsc\n"
            "line = next(line for line in open('/proc/self/status') if line.startswith('SigCgt'))\n"
            "caught = int(line.split()[1], 16) >> (signal.SIGPIPE - 1) & 1\n"
            f"assert not caught and signal.getsignal(signal.SIGPIPE) == signal.{chosen}\n")
        succeeded(run([sys.executable, "program.py"], 60, tmp_path))


@pytest.mark.parametrize(("to", "code"),
                         [(">&-", 0), ("2>&-", 0), (">&- 2>&-", 0), ("2>/dev/full", 0), (">/dev/full", 5)])
def test_output_that_is_closed_or_full(folder, to, code):
    """The run is complete in any case; what cannot be printed is one line, if there is where to print it."""
    done = run(["bash", "-c", f'"$@" {to}', "-", *PARISPH, "run", "case.py", "-o", "run"], 120, folder)
    assert done.returncode == code and "Traceback" not in done.stderr
    assert ("parisph: error: cannot write the output: No space left on device" in done.stderr) == (code == 5)
    assert json.loads((folder / "run" / "summary.json").read_text())["status"] == "completed"


@pytest.mark.parametrize("to", ["2>&-", "2>/dev/full"])
def test_an_error_that_cannot_be_printed_keeps_its_code(folder, to):
    assert run(["bash", "-c", f'"$@" {to}', "-", *PARISPH, "check", "none.py"], 120, folder).returncode == 2
