"""Kernels must compute what they say, on every processor and with every compiler."""

import json
import subprocess
import sys

import numba
import pytest

from parisph import Simulation, load
from parisph.base.errors import ParisphError
from parisph.kernels import jit, selfcheck  # noqa: F401  (jit decides what numba may use)
from tests.launch import ROOT, clean_environment


def test_stores_under_a_condition_leave_the_rest_alone():
    assert selfcheck.stores_hold()


def test_wide_vectors_are_left_out():
    assert "+avx512" not in (numba.config.CPU_FEATURES or "")


@pytest.mark.parametrize("asked", [None, "+sse2"])
def test_choice_of_the_user_wins(asked):
    program = ("import json, numba\nbefore = numba.config.CPU_FEATURES\n"
               "from parisph.kernels import processor\nprocessor.leave_out_avx512()\n"
               "print(json.dumps([before, numba.config.CPU_FEATURES]))")
    environment = clean_environment()
    environment.pop("NUMBA_CPU_FEATURES", None)
    if asked:
        environment["NUMBA_CPU_FEATURES"] = asked
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=environment, capture_output=True, text=True, timeout=60)
    before, after = json.loads(done.stdout)
    assert before == asked and (asked is None or after == asked) and "+avx512" not in (after or "")


def test_simulation_refuses_wrong_code(monkeypatch):
    from mpi4py import MPI

    monkeypatch.setattr(selfcheck, "stores_hold", lambda: False)
    with pytest.raises(ParisphError, match="wrong machine code"):
        Simulation(load(ROOT / "cases" / "hydrostatic.py"), MPI.COMM_SELF)
