"""Folders that go bad under a run: a full disk, files removed, permission gone. The first cause is said, once."""

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

from tests.faults.damage import copy_kernels
from tests.launch import clean_environment
from tests.others import NOBODY, become, open_folder

SECONDS = 200.0
CASE = """
from tests.faults.dam import dam
def case():
    return dam(spacing=0.05, end_time=1000.0, snapshot_every=0.05).changed(
        **{"output.checkpoint_every": 0.1})
"""
CAUSES = {
    "the disk is full": r"File too large|No space left",
    "the folder is removed": r"No such file|gone|removed",
    "snapshots are removed": r"No such file",
    "checkpoints are removed": r"No such file",
    "the folder may not be written": r"Permission denied",
    "snapshots may not be written": r"Permission denied",
    "a file stands where snapshots should be": r"Not a directory|not a directory|File exists",
}


def make(count, random, folder):
    """See table.Part. Nobody may not enter the folder that is given, so this has one of its own."""
    with open_folder() as own:
        yield from _make(count, random, own)


def _make(count, random, folder):
    kernels = folder / "kernels"
    copy_kernels(kernels)
    (folder / "home").mkdir()
    _give(kernels)
    _give(folder / "home")
    names = list(CAUSES)
    for attempt in range(count):
        place = folder / str(attempt)
        place.mkdir()
        found = _attempt(place, names[attempt % len(names)], int(random.integers(1, 3)),
                         float(random.uniform(0.0, 1.0)), kernels, random)
        _open_up(place)
        if os.path.ismount(place):
            subprocess.run(["umount", "--lazy", place], check=True)    # a rank may take a moment to end
        shutil.rmtree(place)
        yield found


def _attempt(folder, damage, ranks, moment, kernels, random):
    limit = None
    if damage == "the disk is full":
        size = int(random.choice([40, 300, 700]))
        if not _mount(folder, size):    # no right to: then a limit of the process, which MPI's own files cannot bear
            ranks, limit = 1, 1024 * size
    what = f"{ranks} ranks, {damage} after {moment:.2f} s"
    (folder / "case.py").write_text(CASE)
    _give(folder)
    words = [sys.executable, "-m", "parisph", "run", "case.py", "-o", "run", "-q"]
    if ranks > 1:
        words = [shutil.which("mpirun"), "-n", str(ranks), *words]
    home = folder.parent / "home"
    with open(folder.parent / f"{folder.name}.txt", "w+") as out:
        process = subprocess.Popen(words, cwd=folder,
                                   env=clean_environment(HOME=str(home), TMPDIR=str(home),
                                                         NUMBA_CACHE_DIR=str(kernels)),
                                   stdout=out, stderr=out, stdin=subprocess.DEVNULL, start_new_session=True,
                                   preexec_fn=lambda: _restrict(limit))
        try:
            code = _wait(process, folder, damage, moment)
        except subprocess.TimeoutExpired:
            return f"{what}: still runs after {SECONDS:g} s"
        finally:
            _end(process)
        out.seek(0)
        said = out.read()
    return _judge(what, damage, code, said)


def _wait(process, folder, damage, moment):
    """Do the damage once the run goes on, and wait for its end."""
    if damage != "the disk is full":
        deadline = time.monotonic() + SECONDS
        while (not (folder / "run" / "checkpoints" / "00000000.h5").exists() and time.monotonic() < deadline
               and process.poll() is None):
            time.sleep(0.01)
        time.sleep(moment)
        DO[damage](folder / "run")
    return process.wait(SECONDS)


def _judge(what, damage, code, said):
    if code != 5:
        return f"{what}: exit code {code}: {said[-600:]}"
    if said.count("parisph: error: ") != 1 or "Traceback" in said or "Logging error" in said:
        return f"{what}: says {said[-600:]!r}"
    error = said.partition("parisph: error: ")[2]
    return None if re.search(CAUSES[damage], error, re.IGNORECASE) else f"{what}: does not say why: {error[:300]!r}"


def _mount(folder, kilobytes):
    """Put a small file system on a folder; return whether that is allowed."""
    words = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(folder)]
    return os.geteuid() == 0 and subprocess.run(words, capture_output=True).returncode == 0


def _remove(folder):
    # the run goes on writing, so what has been emptied may be filled again
    while folder.exists():
        shutil.rmtree(folder, ignore_errors=True)


def _put_file(run):
    (run / "snapshots").rename(run.parent / "moved")
    (run / "snapshots").write_text("in the way")


DO = {
    "the folder is removed": _remove,
    "snapshots are removed": lambda run: _remove(run / "snapshots"),
    "checkpoints are removed": lambda run: _remove(run / "checkpoints"),
    "the folder may not be written": lambda run: [os.chmod(path, 0o555)
                                                  for path in (run / "snapshots", run / "checkpoints", run)],
    "snapshots may not be written": lambda run: os.chmod(run / "snapshots", 0o555),
    "a file stands where snapshots should be": _put_file,
}


def _restrict(limit):
    """In the new process: become nobody (no permission stops root), and perhaps write no long files."""
    if os.geteuid() == 0:
        become(NOBODY)
    if limit is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))


def _give(folder):
    """Give a folder and all in it to who runs the case."""
    if os.geteuid() == 0:
        for path in (folder, *folder.rglob("*")):
            os.chown(path, NOBODY, NOBODY)


def _open_up(folder):
    for path in (folder, *folder.rglob("*")):
        if path.is_dir():
            os.chmod(path, 0o755)


def _end(process):
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()
