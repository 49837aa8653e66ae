"""The first run on a machine: kernels are compiled once, wherever they can be kept.

That one rank compiles for all is seen by tests/validation/cold_start.py, which takes a minute.
"""

import shutil
import subprocess
import sys

import pytest
from mpi4py import MPI

from parisph.base.errors import SolverDiverged
from parisph.case.schema import Box
from parisph.driver import Simulation, warmup
from parisph.geometry import scene_checks
from parisph.kernels import cache, jit, processor
from tests.launch import HANGS, ROOT, clean_environment
from tests.others import NOBODY, as_user, open_folder
from tests.scenes import scene


def test_read_only_install_without_a_home():
    user = as_user(NOBODY)
    program = "import os\nfrom parisph.kernels import jit, selfcheck\nselfcheck.stores_hold()\n" \
              "print(jit.FOLDERS.write, len(os.listdir(jit.FOLDERS.write)) > 0)"
    with open_folder() as folder:
        package, work = folder / "package", folder / "work"
        shutil.copytree(ROOT / "parisph", package / "parisph", ignore=shutil.ignore_patterns("__pycache__"))
        work.mkdir()
        work.chmod(0o777)
        variables = clean_environment(HOME="/nonexistent", XDG_CACHE_HOME="/nonexistent", TMPDIR=str(work),
                                      PYTHONPATH=str(package))
        done = subprocess.run([sys.executable, "-c", program], cwd=work, env=variables, capture_output=True, text=True,
                              timeout=HANGS, **user)
    assert done.returncode == 0, done.stderr
    place, filled = done.stdout.split()
    assert place.startswith(str(work / "parisph-kernels-65534")) and filled == "True"


def test_private_folder_is_not_shared(tmp_path):
    path = cache.private_folder(tmp_path)
    assert path.stat().st_mode & 0o777 == 0o700 and cache.private_folder(tmp_path) == path
    path.chmod(0o777)
    other = cache.private_folder(tmp_path)
    assert other != path and other.stat().st_mode & 0o777 == 0o700


def test_small_scene_is_of_the_same_kind():
    """What it compiles is what the run needs: the method, the preset, 2D or 3D, and a closed tank or not. No user has a
    warning about it."""
    open_case = scene("dam_break", {"preset": "violent", "method": "ISPH"}, spacing=0.1)
    full_case = open_case.changed(**{"fluid.shape": Box(width=2.0, height=2.0)})
    small, full = (warmup.small(case, case.numerics.resolved()) for case in (open_case, full_case))
    assert small.numerics.method == "ISPH" and small.numerics.kappa == open_case.numerics.resolved().kappa
    assert not small.closed and full_case.closed and full.closed
    deep, fine = (warmup.small(case, case.numerics.resolved())
                  for case in (scene("dam_break_3d"), scene("dam_break_3d", spacing=0.02)))
    assert warmup.mark_of(deep) == warmup.mark_of(fine) != warmup.mark_of(small)
    assert (small.dim, deep.dim) == (2, 3)
    assert not [warning for made in (small, full, deep) for warning in scene_checks.warnings(made)]


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """A cache without kernels. Return the case, and what makes its small scene and counts how often."""
    monkeypatch.setattr(jit, "FOLDERS", cache.Folders(tmp_path, (tmp_path,)))
    case = scene("hydrostatic")

    def go(make, **changes):
        numerics = case.numerics.resolved().model_copy(update=changes)
        warmup.on_one_rank_first(MPI.COMM_SELF, make, case, numerics)
        return (tmp_path / warmup.mark_of(warmup.small(case, numerics))).exists()
    return go


def test_a_small_scene_that_fails_is_no_reason_to_fail_and_is_tried_again(empty):
    def make(case, comm):
        made.append(case)
        raise SolverDiverged("as small as that")

    made = []
    assert [empty(make), empty(make)] == [False, False] and len(made) == 2


def test_a_small_scene_is_left_out_where_it_has_been_stepped(empty, monkeypatch):
    def make(case, comm):
        made.append(case)
        return Simulation(case, comm)

    made = []
    assert [empty(make), empty(make)] == [True, True] and len(made) == 1
    assert empty(make, kappa=0.5) and len(made) == 2, "other numerics may need other kernels"
    monkeypatch.setattr(processor, "identity", lambda: ("another", "processor"))
    assert empty(make) and len(made) == 3
