"""The first run on a machine: kernels are compiled once, wherever they can be kept."""

import os
import shutil
import sys

import pytest

from parisph.kernels import cache
from tests.launch import ROOT, mpirun, run

PROGRAM = """
import sys
from mpi4py import MPI
from parisph.driver import Simulation
from tests.scenes import scene
s = Simulation(scene("hydrostatic", {"preset": "violent"}, spacing=0.25), MPI.COMM_WORLD)
s.advance()
print("stepped", flush=True)
"""
# Kernels that exchange particles cannot be compiled by a rank alone, so each compiles them.
EACH = ("halo.",)


def test_one_rank_compiles_for_all(tmp_path):
    """From an empty cache on three ranks; then once more, when nothing is left to compile."""
    (tmp_path / "program.py").write_text(PROGRAM)
    settings = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "NUMBA_DEBUG_CACHE": "1"}
    for first in (True, False):
        done = mpirun(3, ["program.py"], timeout=240, cwd=tmp_path, **settings)
        assert done.returncode == 0 and done.stdout.count("stepped") == 3, done.stderr
        # lines of the ranks may run into each other: count what was said, not lines
        saved = [part.split("'")[1].rpartition("/")[2] for part in done.stdout.split("data saved to ")[1:]]
        again = {name for name in saved if saved.count(name) > 1 and not name.startswith(EACH)}
        assert not again and bool(saved) is first


@pytest.mark.skipif(os.geteuid() != 0 or shutil.which("setpriv") is None, reason="only root can become nobody")
def test_read_only_install_without_a_home(tmp_path):
    package, work = tmp_path / "package", tmp_path / "work"
    shutil.copytree(ROOT / "parisph", package / "parisph", ignore=shutil.ignore_patterns("__pycache__"))
    work.mkdir()
    for folder in (tmp_path, *tmp_path.parents[:2]):
        folder.chmod(0o755)
    work.chmod(0o777)
    program = "import os\nfrom parisph.kernels import cache, smoothing\nsmoothing.quartic_weight(0.5, 1.0)\n" \
              "print(cache.folder(), len(os.listdir(cache.folder())) > 0)"
    done = run(["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", sys.executable, "-c", program], cwd=work,
               HOME="/nonexistent", XDG_CACHE_HOME="/nonexistent", TMPDIR=str(work), PYTHONPATH=str(package))
    assert done.returncode == 0, done.stderr
    place, filled = done.stdout.split()
    assert place.startswith(str(work / "parisph-kernels-65534")) and filled == "True"


def test_private_folder_is_not_shared(tmp_path):
    path = cache.private_folder(tmp_path)
    assert path.stat().st_mode & 0o777 == 0o700 and cache.private_folder(tmp_path) == path
    path.chmod(0o777)
    other = cache.private_folder(tmp_path)
    assert other != path and other.stat().st_mode & 0o777 == 0o700
