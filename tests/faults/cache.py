"""The cache of compiled kernels: damaged files, a full disk, no permission, two processes at once, a kill while it is
filled. The run goes on as without, and one line at most tells why it takes longer."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from parisph.kernels import kept
from tests.faults import damage
from tests.faults.folders import _give, _mount, _restrict
from tests.launch import clean_environment
from tests.others import open_folder

SECONDS = 120.0
MOST = 2          # files that are damaged or missing in an attempt: each takes up to some seconds to compile
SAME = 1e-10      # of results: a kernel that is compiled alone may add its terms in another order
BREAKAGE = ("zeroed blocks", "flipped bits", "overwritten bytes", "cut short", "swapped blocks", "lost bytes",
            "inserted bytes", "another file", "end of another file", "rubbish")
TOLD = {"damaged": "is damaged", "full": "cannot be kept in", "read-only": "can be kept in no folder"}


def make(count, random, folder):
    """See table.Part. Nobody may not enter the folder that is given, so this has one of its own."""
    with open_folder() as own:
        yield from _make(count, random, own)


def _make(count, random, folder):
    known, sound = folder / "known", folder / "kernels"
    damage.copy_kernels(known)
    done = damage.sound_run(folder, NUMBA_CACHE_DIR=str(known), NUMBA_DEBUG_CACHE="1")
    for part in re.split(r"\[cache\] data (?:loaded from|saved to) '", done.stdout)[1:]:
        path = Path(part.partition("'")[0])    # that of a kernel that the run needs
        (sound / path.relative_to(known)).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, sound / path.relative_to(known))
    due = _results(folder / "sound")
    for attempt in range(count):
        kind = (_damaged, _damaged, _full, _read_only, _at_once, _killed)[attempt % 6]
        place = folder / str(attempt)
        shutil.copytree(sound, place / "kernels")
        try:
            found = kind(place, random, due)
        except subprocess.TimeoutExpired:
            found = f"no end after {SECONDS:g} s"
        finally:
            if os.path.ismount(place / "kernels"):
                subprocess.run(["umount", "--lazy", place / "kernels"], check=True)
        yield None if found is None else f"{kind.__name__.strip('_')}: {found}"
        shutil.rmtree(place)


def _damaged(place, random, due):
    chosen = _chosen(place, random)
    others = [path.read_bytes() for path in _files(place)[:5]]
    for path in chosen:
        path.write_bytes(damage.damaged(str(random.choice(BREAKAGE)), path.read_bytes(), others, random))
    found = _judge(place, *_run(place), due, "damaged")
    left = [path for path in chosen if kept.opened(path.name, path.read_bytes()) is None]
    return found or (f"{left} are damaged still" if left else None)


def _full(place, random, due):
    missing = _remove(place, random)
    kept_there = place / "copy"
    (place / "kernels").rename(kept_there)
    (place / "kernels").mkdir()
    size = sum(path.stat().st_size + 4096 for path in kept_there.rglob("*")) // 1024 + int(random.integers(1, 8))
    if not _mount(place / "kernels", size):    # no right to
        return None
    shutil.copytree(kept_there, place / "kernels", dirs_exist_ok=True)
    (place / "kernels" / "ballast").write_bytes(b"")
    with open(place / "kernels" / "ballast", "wb", buffering=0) as file:
        try:
            while file.write(bytes(4096)):
                pass
        except OSError:
            pass
    return _judge(place, *_run(place), due, "full") or (f"{missing} are there" if _files(place, missing) else None)


def _read_only(place, random, due):
    """Complete, of another user."""
    for path in (place / "kernels").rglob("*"):
        path.chmod(0o555 if path.is_dir() else 0o444)
    os.chmod(place, 0o755)
    os.chmod(place / "kernels", 0o555)
    (place / "work").mkdir()
    _give(place / "work")
    said = _run(place, preexec_fn=lambda: _restrict(None), cwd=place / "work", HOME="/nonexistent",
                XDG_CACHE_HOME="/nonexistent", TMPDIR=str(place / "work"))
    written = [path.name for path in (place / "work").rglob(f"*{kept.ENDING}")]
    return _judge(place / "work", *said, due, None) or (f"compiles {written}" if written else None)


def _at_once(place, random, due):
    _remove(place, random)
    both = [_begin(place, out=f"run{number}") for number in (0, 1)]
    return next(filter(None, (_judge(place, process.wait(SECONDS), log.read_text(), due, None, f"run{number}")
                              for number, (process, log) in enumerate(both))), None)


def _killed(place, random, due):
    _remove(place, random)
    process, _ = _begin(place, out="killed")
    time.sleep(float(random.uniform(1.0, 5.0)))
    process.kill()
    process.wait()
    return _judge(place, *_run(place), due, None)


def _begin(place, out="run", preexec_fn=None, cwd=None, **settings):
    """Start a run; return the process and the file of what it says."""
    shutil.copy(place.parent / "case.py", cwd or place)
    log = place / f"{out}.txt"
    with open(log, "w") as file:
        process = subprocess.Popen([sys.executable, "-m", "parisph", "run", "case.py", "-o", out, "-q"],
                                   cwd=cwd or place, stdin=subprocess.DEVNULL, stdout=file, stderr=file,
                                   preexec_fn=preexec_fn,
                                   env=clean_environment(NUMBA_CACHE_DIR=str(place / "kernels"), **settings))
    return process, log


def _run(place, **how):
    process, log = _begin(place, **how)
    try:
        return process.wait(SECONDS), log.read_text()
    finally:
        process.kill()


def _judge(place, code, said, due, told, out="run"):
    """Return None if parisph behaved, else what it did; told : what one line must tell, None for nothing."""
    if code != 0 or "Traceback" in said:
        return f"exit code {code}: {said[-500:]}"
    if [said.count(word) for word in TOLD.values()] != [int(word == told) for word in TOLD]:
        return f"says {said[:600]!r}"
    found = _results(place / out)
    same = len(found) == len(due) and all(one.shape == two.shape and np.allclose(one, two, SAME, SAME)
                                          for one, two in zip(found, due, strict=True))
    return None if same else "other results"


def _results(run):
    """Return what a run has computed: the numbers of its probes."""
    return [np.loadtxt([line for line in path.read_text().splitlines() if not line.startswith("#")][1:], delimiter=",",
                       ndmin=2) for path in sorted((run / "probes").glob("*.csv"))]


def _files(place, names=None):
    found = sorted((place / "kernels").rglob(f"*{kept.ENDING}"))
    return found if names is None else [path for path in found if path.name in names]


def _chosen(place, random):
    """Return the files of some kernels, all of which the run needs."""
    return list(random.choice(_files(place), int(random.integers(1, MOST + 1)), replace=False))


def _remove(place, random):
    """Remove some; return their names."""
    chosen = _chosen(place, random)
    for path in chosen:
        path.unlink()
    return {path.name for path in chosen}
