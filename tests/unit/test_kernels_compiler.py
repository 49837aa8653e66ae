"""Compiled kernels must be correct, on every processor and with every compiler."""

import ast
import gc
import subprocess
import sys

import numba
import numpy as np
import pytest
from numba.extending import overload

from parisph import Simulation, load
from parisph.base.errors import ParisphError
from parisph.kernels import cache, jit, processor, selfcheck
from tests.launch import ROOT, clean_environment


def test_stores_under_a_condition_leave_the_rest_alone():
    assert selfcheck.stores_hold()


@pytest.mark.parametrize("before", [True, False])
def test_garbage_is_not_collected_while_kernels_compile_and_as_before_afterwards(before):
    collected = []

    def helped(x):
        """What `overload` gives compiled code to."""

    @jit.uncached
    def fine(x):
        return helped(x)

    @overload(helped)
    def _(x):
        collected.append(gc.isenabled())
        return lambda x: x + 1

    @jit.uncached
    def faulty(x):
        return x.nothing

    was = gc.isenabled()
    try:
        (gc.enable if before else gc.disable)()
        assert fine(1) == 2 and set(collected) == {False} and gc.isenabled() == before
        with pytest.raises(numba.TypingError):
            faulty(1)
        assert gc.isenabled() == before
    finally:
        (gc.enable if was else gc.disable)()


def test_parts_of_kernels_are_compiled_for_calls_from_python_only_when_these_come():
    @jit.inlined
    def doubled(x):
        """Return 2 x."""
        return 2.0 * x

    @jit.uncached
    def both(x):
        return doubled(x[0]) + doubled(x[1])

    assert both(np.array([1.0, 2.0])) == 6.0 and "alone" not in vars(doubled)
    assert doubled(4.0) == 8.0 and doubled.alone.signatures and doubled.__doc__ == "Return 2 x."


KERNELS = """
import numpy as np
from parisph.kernels.jit import kernel, subkernel

@subkernel
def square(x):
    return x * x

@kernel
def squares(x):
    out = np.empty_like(x)    # which is counted
    for i in range(len(x)):
        out[i] = square(x[i])
    return out
"""
USE = """
import sys
import numpy as np
from parisph.kernels import jit
from kernels import squares

@jit.uncached
def total(x):
    return squares(x).sum()

x = np.array([1.0, 2.0])
{first}
sums = [total(x)] if {compiles} else []
print(squares(x).tolist(), sums, sum(squares.stats.cache_hits.values()), "numba.np.linalg" in sys.modules)
"""


def test_kernels_from_the_cache_are_loaded_without_what_a_compiler_needs(tmp_path):
    """And numba gets it if it compiles another kernel that calls them, before or after they are loaded."""
    (tmp_path / "kernels.py").write_text(KERNELS)
    found = []
    for first, compiles in [("squares(x)", False), ("squares(x)", False), ("squares(x)", True), ("", True)]:
        done = subprocess.run([sys.executable, "-c", USE.format(first=first, compiles=compiles)],
                              cwd=tmp_path, env=clean_environment(NUMBA_CACHE_DIR=str(tmp_path / "cache")),
                              capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        found.append(done.stdout.strip())
    assert found == ["[1.0, 4.0] [] 0 True", "[1.0, 4.0] [] 1 False", *["[1.0, 4.0] [5.0] 1 True"] * 2]


THREADED = """
import numba
import numpy as np
from parisph.kernels.jit import kernel

@numba.njit(parallel=True)
def halves(x):
    for i in numba.prange(len(x)):
        x[i] *= 0.5

@kernel
def quarters(x):
    halves(x)
    halves(x)

x = np.ones(8)
quarters(x)
print(x.sum(), sum(quarters.stats.cache_hits.values()))
"""


def test_a_kernel_of_a_user_with_threads_comes_back_from_the_cache(tmp_path):
    """numba prepares threads before it reads machine code that needs them."""
    (tmp_path / "threaded.py").write_text(THREADED)
    for hits in range(2):
        done = subprocess.run([sys.executable, "threaded.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60,
                              env=clean_environment(NUMBA_CACHE_DIR=str(tmp_path / "cache")))
        assert done.stdout.split() == ["2.0", str(hits)], done.stderr


@pytest.mark.parametrize(("host", "asked", "due"), [
    ({"avx2": True, "avx512f": True, "avx512vl": True, "sse4a": False}, None, "+avx2,-avx512f,-avx512vl,-sse4a"),
    ({"avx2": True, "avx10.1-512": True}, None, "+avx2,-avx10.1-512"),
    ({"avx2": True, "avx512f": False}, None, None),
    ({"neon": True}, None, None),
    ({"avx2": True, "avx512f": True}, "+sse2", "+sse2"),    # the user's choice wins
])
def test_avx512_is_left_out_where_it_is(monkeypatch, host, asked, due):
    monkeypatch.setattr(processor.llvm, "get_host_cpu_features", lambda: host)
    monkeypatch.setattr(numba.config, "CPU_FEATURES", asked)
    processor.leave_out_avx512()
    assert numba.config.CPU_FEATURES == due


def test_kernels_leave_it_out_when_they_are_imported():
    program = ("import llvmlite.binding as llvm, numba\n"
               "llvm.get_host_cpu_features = lambda: {'avx2': True, 'avx512f': True}\nimport parisph.kernels.jit\n"
               "print(numba.config.CPU_FEATURES)")
    environment = clean_environment()
    environment.pop("NUMBA_CPU_FEATURES", None)
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=environment, capture_output=True,
                          text=True, timeout=60)
    assert done.stdout.strip() == "+avx2,-avx512f"


@pytest.mark.parametrize(("asked", "due"), [(None, 2), ("1", 1)])
def test_level_of_the_optimiser_is_ours_or_the_users(asked, due):
    program = "import parisph.kernels.jit, numba\nprint(int(numba.config.OPT), parisph.kernels.jit.FOLDERS.write)"
    environment = clean_environment()
    environment.pop("NUMBA_OPT", None)
    environment.update({} if asked is None else {"NUMBA_OPT": asked})
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=environment, capture_output=True,
                          text=True, timeout=60)
    level, folder = done.stdout.split(maxsplit=1)
    assert int(level) == due and (folder.strip() == str(jit.FOLDERS.write)) == (due == int(numba.config.OPT))


def test_simulation_refuses_wrong_code(monkeypatch):
    from mpi4py import MPI

    monkeypatch.setattr(selfcheck, "stores_hold", lambda: False)
    with pytest.raises(ParisphError, match="wrong machine code"):
        Simulation(load(ROOT / "cases" / "hydrostatic.py"), MPI.COMM_SELF)


def _taken_from_elsewhere(path):
    """Yield (file, name) of what compiled functions of a file take from files of other folders than the kernels'."""
    tree = ast.parse(path.read_text())
    origin = {name.asname or name.name: node.module for node in tree.body if isinstance(node, ast.ImportFrom)
              for name in node.names if node.module.startswith("parisph.")}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and {"kernel", "subkernel", "inlined"} & {
                mark.id for mark in node.decorator_list if isinstance(mark, ast.Name)}:
            for name in {part.id for statement in node.body for part in ast.walk(statement)
                         if isinstance(part, ast.Name)} & origin.keys():
                if not origin[name].startswith("parisph.kernels"):
                    yield origin[name].removeprefix("parisph.").replace(".", "/") + ".py", name


def test_the_folder_of_compiled_kernels_goes_by_all_files_that_they_are_made_of():
    """numba looks at the file of a kernel alone: what it takes from others would stay as it was."""
    found = {file: name for path in (ROOT / "parisph").rglob("*.py") for file, name in _taken_from_elsewhere(path)}
    assert found.keys() == set(cache.ELSEWHERE), found
