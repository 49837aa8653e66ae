"""The cache of compiled kernels: what is damaged is compiled again, and what cannot be kept is no reason to stop."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from parisph.kernels import cache, jit, kept
from tests.launch import HANGS, clean_environment

X, WHOLE = np.array([1.0, 2.0]), np.array([1, 2])


@pytest.fixture(autouse=True)
def nothing_told(monkeypatch):
    monkeypatch.setattr(kept.Kept, "_told", set())


def hits(folders, x=X):
    """Make a kernel anew, as in another process, and use it; return how often it came from the cache."""
    def doubled(x):
        return 2 * x[0]

    before, jit.FOLDERS = jit.FOLDERS, folders
    try:
        kernel = jit.kernel(doubled)
    finally:
        jit.FOLDERS = before
    assert kernel(x) == 2 * x[0]
    return sum(kernel.stats.cache_hits.values())


def only(folder):
    return cache.Folders(folder, (folder,))


def files(folder):
    return sorted(folder.rglob(f"*{kept.ENDING}"))


def cut(content, other):
    return content[:len(content) // 2]


DAMAGE = {
    "cut": cut, "empty": lambda content, other: b"", "another": lambda content, other: other,
    "garbled": lambda content, other: content[:500] + b"\x93" + content[501:], "bytes more": lambda c, other: c + b"\0",
    "rubbish": lambda content, other: b"title = 'a case'\n", "pickle of another release": lambda content, other: None,
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_damaged_is_compiled_again_and_told_once(tmp_path, caplog, damage):
    assert [hits(only(tmp_path)), hits(only(tmp_path), WHOLE), hits(only(tmp_path))] == [0, 0, 1]
    first, second = files(tmp_path)
    content = {path: path.read_bytes() for path in (first, second)}
    for path, other in ((first, second), (second, first)):
        changed = DAMAGE[damage](content[path], content[other])
        path.write_bytes(kept.sealed(path.name, b"cos\nnothing\n.") if changed is None else changed)
    assert len(kept.state(only(tmp_path))["damaged"]) == (0 if damage.startswith("pickle") else 2)
    assert [hits(only(tmp_path)), hits(only(tmp_path), WHOLE)] == [0, 0]
    line, = caplog.messages
    assert "a compiled kernel in the cache is damaged" in line and str(tmp_path) in line
    assert [hits(only(tmp_path)), hits(only(tmp_path), WHOLE)] == [1, 1] and len(caplog.messages) == 1
    assert kept.state(only(tmp_path))["damaged"] == [] and kept.state(only(tmp_path))["kernels"] == 2


def test_what_is_sound_but_cannot_be_used_is_compiled_again(tmp_path, caplog, monkeypatch):
    hits(only(tmp_path))
    with monkeypatch.context() as patch:
        patch.setattr(numba.core.compiler.CompileResult, "_rebuild", lambda *args: 1 / 0)
        assert hits(only(tmp_path)) == 0
    assert "damaged" in caplog.text and hits(only(tmp_path)) == 1


def test_a_folder_that_cannot_be_written_is_read(tmp_path, caplog):
    """That of another user, who has installed parisph for all: complete, or not."""
    theirs, own = tmp_path / "theirs", tmp_path / "own"
    hits(only(theirs))
    assert hits(cache.Folders(None, (theirs,))) == 1 and not caplog.messages
    both = cache.Folders(own, (own, theirs))
    assert hits(both) == 1 and not files(own)
    assert hits(both, WHOLE) == 0 and len(files(own)) == 1 and len(files(theirs)) == 1
    assert both.first(files(theirs)[0].relative_to(theirs)) == files(theirs)[0] and both.first("nothing") is None


def test_folders_are_found_by_whether_they_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "given"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    name = cache.folders(2).write.name
    assert cache.folders(2) == only(tmp_path / "given" / name), "what is given and can be written is used alone"
    monkeypatch.setattr(cache, "_can_be_made", lambda path: path.is_relative_to(tmp_path / "home"))
    found = cache.folders(2)    # the one that is there is read, though it cannot be written now
    assert found.write == tmp_path / "home" / "parisph" / name == found.read[0]
    assert tmp_path / "given" / name in found.read
    monkeypatch.setattr(cache, "_can_be_made", lambda path: False)
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path))
    assert cache.folders(2).write is None and tmp_path / "given" / name in cache.folders(2).read


@pytest.mark.parametrize("writing", ["mkdir", "write_bytes"])
def test_a_full_disk_is_told_once_and_the_run_goes_on(tmp_path, caplog, monkeypatch, writing):
    def fail(path, *args, **options):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    folders = only(tmp_path / "kernels")
    monkeypatch.setattr(Path, writing, fail)
    assert [hits(folders), hits(folders, WHOLE)] == [0, 0]
    line, = caplog.messages
    assert f"cannot be kept in {folders.write} (No space left on device)" in line and "NUMBA_CACHE_DIR" in line
    monkeypatch.undo()
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_no_folder_at_all_is_told(caplog):
    assert hits(cache.Folders(None, ())) == 0 and "no folder for compiled kernels is writable" in caplog.text


def test_files_of_an_earlier_source_are_removed(tmp_path):
    hits(only(tmp_path))
    new, = files(tmp_path)
    start, stamp, key, ending = new.name.rsplit(".", 3)
    old = new.rename(new.with_name(f"{start}.00000000.{key}.{ending}"))
    assert hits(only(tmp_path)) == 0 and not old.exists() and new.exists()


def test_a_kernel_that_is_known_by_its_address_is_not_kept(tmp_path):
    """In another process another function may be at that address."""
    helper = jit.uncached(lambda x: x)

    def applied(f, x):
        return f(x)

    files_of = kept.Kept(applied, only(tmp_path))
    files_of.save(("type(CPUDispatcher(<function f at 0x7f00>))",), 1)
    assert helper(1) == 1 and not files(tmp_path)


PROCESS = """
import os, sys
import numpy as np
from parisph.kernels import jit
from slow import doubled
if sys.argv[1] == "stuck":    # as it writes, until it is killed
    os.replace = lambda *names: (print("writes", flush=True), sys.stdin.read())
print(doubled(np.array([1.0, 2.0])), doubled(np.array([3])))
print(sum(doubled.stats.cache_hits.values()))
"""
SLOW = """
from parisph.kernels.jit import kernel
@kernel
def doubled(x):
    return 2 * x[0]
"""


def test_two_processes_fill_one_cache_and_one_is_killed_as_it_writes(tmp_path):
    (tmp_path / "slow.py").write_text(SLOW)
    variables = clean_environment(NUMBA_CACHE_DIR=str(tmp_path / "kernels"))

    def begin(how):
        return subprocess.Popen([sys.executable, "-c", PROCESS, how], cwd=tmp_path, env=variables, text=True,
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    stuck = begin("stuck")
    try:
        assert stuck.stdout.readline() == "writes\n"
        assert begin("").communicate(timeout=HANGS)[0] == "2.0 6\n0\n"
    finally:
        stuck.kill()
        stuck.communicate()
    two, three = begin(""), begin("")
    assert [process.communicate(timeout=HANGS)[0] for process in (two, three)] == ["2.0 6\n2\n"] * 2
    assert len(list(tmp_path.rglob("*.tmp"))) == 1, "what the killed one has left, which nobody reads"
