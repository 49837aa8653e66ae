"""One rank of a user's own script fails or ends: the others are ended if they wait for it, and only then."""

import pytest

from tests.launch import mpirun
from tests.scenes import PROGRAM

QUICK = "from parisph.parallel import guard\nguard.PATIENCE = 2.0\n"    # for ranks that wait in vain
SCRIPT = PROGRAM + """
import time
from parisph import ParisphError
def fail():
    {what}
s = Simulation(scene("dam_break", spacing=0.1), comm)
acceleration = s.method.flow.body
def force(x, t):
    if s.steps == 3 and comm.rank in {inside}:
        fail()
    return acceleration(x, t)
s.method.flow.body = force
for _ in range(8):
    if s.steps == 4 and comm.rank in {between}:
        fail()
    s.advance()
{after}
"""
SOON = 100.0    # [s] for all ranks to be gone, with the start of Python and the load of parisph


def carried_out(folder, what="pass", inside=(), between=(), after=""):
    """Run the script on two ranks, which must end; return (exit code, output)."""
    (folder / "script.py").write_text(QUICK + SCRIPT.format(what=what, inside=inside, between=between, after=after))
    done = mpirun(2, ["script.py"], cwd=folder, timeout=SOON)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(("what", "says", "code"), [
    ("sys.exit(7)", "SystemExit: 7", 7), ("raise ParisphError('mine alone')", "ParisphError: mine alone", 1),
])
def test_failure_inside_a_call(tmp_path, what, says, code):
    found, said = carried_out(tmp_path, what, inside=[1])
    assert found == code and says in said and "in force" in said and "in fail" in said
    assert "an error on rank 1 alone, in Simulation.advance: stopping all 2 ranks" in said


@pytest.mark.parametrize(("what", "after", "says"), [
    ("sys.exit(0)", "", "rank 1 has ended, and rank 0 waits for it in Simulation.advance"),
    ("raise ValueError('on one rank')", "", "ValueError: on one rank"),
    ("pass", "if comm.rank == 1: raise ValueError('at the end')\ntime.sleep(300)",
     "rank 1 ends with an error, while others continue"),
])
def test_failure_between_calls_or_while_the_others_do_something_else(tmp_path, what, after, says):
    code, said = carried_out(tmp_path, what, between=[1], after=after)
    assert code != 0 and says in said and "stopping all 2 ranks" in said


@pytest.mark.parametrize("alone", [0, 1])
def test_rank_that_still_works_after_the_others_have_ended_is_left_alone(tmp_path, alone):
    after = f"import time\nif comm.rank == {alone}:\n    time.sleep(5)\n    print('pictures made', flush=True)"
    code, said = carried_out(tmp_path, after=after)
    assert code == 0 and "pictures made" in said and "ended" not in said


@pytest.mark.parametrize("caught", [False, True])
def test_error_on_all_ranks_is_left_to_the_user(tmp_path, caught):
    what = "raise ParisphError('on all ranks')"
    script = (SCRIPT.replace("    s.advance()\n", "    try: s.advance()\n    except ParisphError: break\n")
              if caught else SCRIPT)
    (tmp_path / "script.py").write_text(script.format(what=what, inside=[0, 1], between=[],
                                                      after="print('end', comm.rank)"))
    done = mpirun(2, ["script.py"], cwd=tmp_path)
    assert done.returncode == (0 if caught else 1) and "stopping all" not in done.stderr
    assert done.stdout.count("end") == (2 if caught else 0)


def test_script_on_one_rank_raises_as_ever(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT.format(what="raise ValueError('alone')", inside=[0],
                                                      between=[], after=""))
    done = mpirun(1, ["script.py"], cwd=tmp_path)
    assert done.returncode == 1 and "ValueError: alone" in done.stderr and "stopping all" not in done.stderr


EARLY = """
import sys, time
from mpi4py import MPI
from parisph.driver import Simulation
from tests.scenes import scene
comm = MPI.COMM_WORLD
if comm.rank == 1:
    {what}
time.sleep({late})
Simulation(scene("dam_break", spacing=0.1), comm)
"""


@pytest.mark.parametrize(("what", "ranks", "late", "says"), [
    ("raise ValueError('too early')", 2, 0, "ValueError: too early"),
    ("raise ValueError('too early')", 3, 0, "ValueError: too early"),
    ("sys.exit(3)", 2, 0, "rank 1 has ended, and rank 0 waits for it in its first call"),
    ("sys.exit(3)", 3, 3, "rank 1 has ended, and rank"),
])
def test_rank_that_ends_before_its_first_call(tmp_path, what, ranks, late, says):
    (tmp_path / "script.py").write_text(QUICK + EARLY.format(what=what, late=late))
    done = mpirun(ranks, ["script.py"], cwd=tmp_path, timeout=SOON)
    assert done.returncode != 0 and says in done.stderr and f"stopping all {ranks} ranks" in done.stderr


@pytest.mark.parametrize("own", [False, True])
def test_ranks_that_work_apart_are_left_alone(tmp_path, own):
    """One rank ends early, or fails in a job of its own, while another takes any message that comes."""
    (tmp_path / "script.py").write_text(QUICK + f"""
import time
from mpi4py import MPI
from parisph.driver import Simulation
from tests.scenes import scene
comm = MPI.COMM_WORLD
if {own}:
    Simulation(scene("dam_break", spacing=0.1), MPI.COMM_SELF)
if comm.rank == 1:
    time.sleep(5)
    assert not comm.Iprobe(MPI.ANY_SOURCE, MPI.ANY_TAG)
    print("worked on", flush=True)
elif {own}:
    raise ValueError("my own")
""")
    done = mpirun(2, ["script.py"], cwd=tmp_path)
    assert "worked on" in done.stdout and "stopping all" not in done.stderr
    assert (done.returncode != 0) == own
