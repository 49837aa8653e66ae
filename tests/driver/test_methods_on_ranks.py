"""Every method is the same flow on 1, 2 and 3 ranks, and a step talks no more than it has to."""

import json

import numpy as np
import pytest

from parisph.case.methods import METHODS
from tests.launch import ROOT, parisph, succeeded
from tests.scenes import after_steps, assert_same, on_ranks, scene


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    # symmetric gradients of disordered particles are not fit for walls: they are compared on a lattice
    cases = {name: scene("dam_break", {"rtol": 1e-13}, spacing=0.1, method=name,
                         jitter=0.0 if name == "Z17_ISPH" else 0.2) for name in METHODS}
    return after_steps(cases, 10, ("x", "u", "p", "role"), tmp_path_factory.mktemp("methods"), most=3)


@pytest.mark.parametrize("name", METHODS)
def test_ranks_agree(results, name):
    one = results[name, 1]
    assert np.abs(one["u"]).max() > 1e-3
    for ranks in (2, 3):
        assert_same(one, results[name, ranks])


def test_a_weakly_compressible_run_is_stored_continued_and_drawn(tmp_path):
    """Densities are in its checkpoint; nothing that looks at a run asks for a pressure solve."""
    for words in (("run", ROOT / "cases" / "dam_break.py", "--set", "method=SPH", "spacing=0.1", "end_time=0.2", "-o",
                   "run"),
                  ("restart", "run", "--until", "0.1", "-o", "more"), ("info", "more"),
                  ("plot", "run", "-o", "run.png")):
        succeeded(parisph(*words, cwd=tmp_path, timeout=120))
    assert (tmp_path / "run.png").stat().st_size > 10_000


ADAPTIVE = """
s = Simulation(scene("dam_break", spacing=0.1, method="SPH", time_step="none"), comm)
times = [s.advance() and s.time for _ in range(30)]
assert comm.allgather(times) == [times] * comm.size
"""


def test_adaptive_steps_of_weakly_compressible_fluid_are_the_same_on_all_ranks(tmp_path):
    on_ranks(3, ADAPTIVE, tmp_path)


COUNTED = """
import json
from collections import Counter
from parisph.parallel.halo import Halo

TALK = {"Allreduce", "allreduce", "Allgather", "allgather", "Allgatherv", "Bcast", "bcast", "Barrier", "Alltoall",
        "gather", "reduce"}
seen = Counter()

def note(frame, event, function):
    talks = event == "c_call" and getattr(function, "__name__", "") in TALK
    if talks and isinstance(getattr(function, "__self__", None), MPI.Comm):
        seen["collectives"] += function.__self__.size > 1

update = Halo.update
def counted(self, *names):
    seen["messages"] += 1
    return update(self, *names)
Halo.update = counted

s = Simulation(scene("dam_break", spacing=0.05, jitter=0.2, time_step=0.004), comm)
for _ in range(40):
    s.advance()
found = []
while len(found) < 20:
    plans = s.domain.n_plans
    seen.clear()
    sys.setprofile(note)
    s.advance()
    sys.setprofile(None)
    if s.domain.n_plans == plans:    # moving particles to other ranks takes more
        found.append(dict(seen))
if comm.rank == 0:
    print(json.dumps(found))
"""


def test_a_violent_step_has_ten_collectives_and_twelve_messages_beside_krylov(tmp_path):
    """A sweep that parts crowded particles takes one of each more."""
    found = json.loads(on_ranks(2, COUNTED, tmp_path).splitlines()[-1])
    assert min(step["collectives"] for step in found) == 10 and min(step["messages"] for step in found) == 12
    assert max(step["collectives"] for step in found) <= 12 and max(step["messages"] for step in found) <= 14
