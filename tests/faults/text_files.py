"""Damaged, missing and foreign CSV and JSON files of a run: one clear error, or the right answer."""

import contextlib
import io
import os
import shutil

import numpy as np

from parisph import __main__ as entry
from parisph.base.errors import ParisphError
from parisph.io import reader
from parisph.io.layout import INDEX

CASE = """
from tests.scenes import scene
def case(end_time: float = 0.1):
    return scene("dam_break", spacing=0.1, end_time=end_time, snapshot_every=0.05).changed(
        **{"output.checkpoint_every": 0.05})
"""
FILES = ("case.json", "summary.json", "steps.csv", "probes/P2.csv", "probes/energy.csv", INDEX)
LONGEST = 1500    # characters of a message


def make(count, random, folder):
    """See table.Part."""
    (folder / "case.py").write_text(CASE)
    for name in ("sound", "other"):
        code, said = _command(["run", str(folder / "case.py"), "-o", str(folder / name), "-q"])
        if code != 0:
            raise RuntimeError(said)
    kinds = list(DAMAGES)
    for attempt in range(count):
        run = folder / "run"
        shutil.copytree(folder / "sound", run)
        name, kind = str(random.choice(FILES)), kinds[attempt % len(kinds)]
        what = f"{name} {kind}"
        if DAMAGES[kind](run / name, random, folder / "other" / name):
            yield _judge(run, folder / "sound", random, what)
        else:
            yield None    # it says the same as before
        shutil.rmtree(run)


def _judge(run, sound, random, what):
    """Look at the run, and go on with it; neither may be wrong in silence."""
    words = [["info", str(run)], ["info", str(run), "--json"],
             ["plot", str(run), "--probe", "P2", "-o", str(run.parent / "p.png")],
             ["restart", str(run), "-q", "--until", "0.06"]][int(random.integers(4))]
    wrong = _values(run, sound)
    if wrong:
        return f"{what}: {wrong}"
    before = _contents(run)
    code, said = _command(words)
    if code not in (0, 2, 5) or "Traceback" in said or "Warning" in said:
        return f"{what}: {words[0]} ends with {code}: {said[-500:]}"
    if code != 0 and (said.count("parisph: error: ") != 1 or len(said) > LONGEST):
        return f"{what}: {words[0]} says {said[-500:]!r}"
    if code != 0 and _contents(run) != before:
        return f"{what}: {words[0]} refuses, but changes the folder: {said[-500:]!r}"
    return None


def _contents(run):
    """Return {name: content} of all files of a run; the log may get lines at any time."""
    return {str(path.relative_to(run)): path.read_bytes() for path in run.rglob("*") if path.is_file()
            and path.name != "run.log"}


def _values(run, sound):
    """Return what is read otherwise than it was written, None if all is right or refused."""
    due = reader.open_run(sound)
    for ask in (lambda run: run.steps, lambda run: run.probe("P2"), lambda run: run.probe("energy"),
                lambda run: run.summary, lambda run: list(run.times)):
        try:
            found = ask(reader.open_run(run))
        except ParisphError:
            continue
        expected = ask(due)
        same = str(found) == str(expected) if isinstance(expected, np.ndarray) else found == expected
        if found is not None and not same:
            return f"was read as {str(found)[:300]}, not {str(expected)[:300]}"
    return None


def _command(words):
    """Carry out a command line in this process; return its exit code and what it said."""
    out = io.StringIO()
    with contextlib.redirect_stderr(out), contextlib.redirect_stdout(io.StringIO()):
        try:
            code = entry.main(words)
        except BaseException as fault:    # main must never let one through
            return -1, f"{type(fault).__name__}: {fault}"
    return code, out.getvalue()


# Each damages a file, and returns whether anything has changed.

def _truncate(path, random, other):
    os.truncate(path, int(random.integers(0, path.stat().st_size - 1)))
    return True


def _zero(path, random, other):
    data = bytearray(path.read_bytes())
    at = int(random.integers(0, max(1, len(data) - 64)))
    data[at:at + 64] = bytes(len(data[at:at + 64]))
    path.write_bytes(data)
    return True


def _noise(path, random, other):
    data = bytearray(path.read_bytes())
    at = int(random.integers(0, max(1, len(data) - 64)))
    data[at:at + 64] = random.bytes(64)
    path.write_bytes(data)
    return True


def _empty(path, random, other):
    path.write_bytes(b"")
    return True


def _missing(path, random, other):
    path.unlink()
    return True


def _foreign(path, random, other):
    shutil.copy(other, path)
    return True


def _folder(path, random, other):
    path.unlink()
    path.mkdir()
    return True


def _line_gone(path, random, other):
    lines = path.read_text().splitlines(keepends=True)
    del lines[int(random.integers(0, len(lines) - 1))]
    path.write_text("".join(lines))
    return path.suffix == ".csv" or not path.read_text().startswith("{")


def _line_twice(path, random, other):
    lines = path.read_text().splitlines(keepends=True)
    at = int(random.integers(0, len(lines)))
    path.write_text("".join([*lines[:at + 1], *lines[at:]]))
    return True


def _lines_swapped(path, random, other):
    lines = path.read_text().splitlines(keepends=True)
    a, b = random.choice(len(lines), 2, replace=False)
    lines[a], lines[b] = lines[b], lines[a]
    path.write_text("".join(lines))
    return True


DAMAGES = {
    "cut short": _truncate, "with 64 zeros in it": _zero, "with 64 random bytes in it": _noise, "empty": _empty,
    "gone": _missing, "of another run": _foreign, "a folder": _folder, "with a line gone": _line_gone,
    "with a line twice": _line_twice, "with two lines swapped": _lines_swapped,
}
