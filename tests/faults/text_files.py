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
from tests.launch import contents

CASE = """
from tests.faults.dam import dam
def case(end_time: float = 0.1):
    return dam(spacing=0.1, end_time=end_time, snapshot_every=0.05).changed(
        **{"output.checkpoint_every": 0.05})
"""
FILES = ("case.json", "summary.json", "steps.csv", "probes/P2.csv", "probes/energy.csv", INDEX)
LONGEST = 1500    # characters of a message
WITHOUT = "with a line gone"


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
        DAMAGES[kind](run / name, random, folder / "other" / name)
        # a JSON file may say the same without a line
        same = kind == WITHOUT and not name.endswith(".csv") and (run / name).read_text().startswith("{")
        yield None if same else _judge(run, folder / "sound", random, f"{name} {kind}")
        shutil.rmtree(run)


def _judge(run, sound, random, what):
    """Look at the run, and go on with it; neither may be wrong in silence."""
    words = [["info", str(run)], ["info", str(run), "--json"],
             ["plot", str(run), "--probe", "P2", "-o", str(run.parent / "p.png")],
             ["restart", str(run), "-q", "--until", "0.06"]][int(random.integers(4))]
    wrong = _values(run, sound)
    if wrong:
        return f"{what}: {wrong}"
    before = contents(run, but="run.log")
    code, said = _command(words)
    if code not in (0, 2, 5) or "Traceback" in said or "Warning" in said:
        return f"{what}: {words[0]} ends with {code}: {said[-500:]}"
    if code != 0 and (said.count("parisph: error: ") != 1 or len(said) > LONGEST):
        return f"{what}: {words[0]} says {said[-500:]!r}"
    if code != 0 and contents(run, but="run.log") != before:
        return f"{what}: {words[0]} refuses, but changes the folder: {said[-500:]!r}"
    return None


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


def _bytes(make):
    """Return what overwrites 64 bytes of a file by make(random, how many there are)."""
    def change(path, random, other):
        data = bytearray(path.read_bytes())
        at = int(random.integers(0, max(1, len(data) - 64)))
        data[at:at + 64] = make(random, len(data[at:at + 64]))
        path.write_bytes(data)
    return change


def _lines(pick):
    """Return what puts the lines pick(random, number of lines) in place of all lines of a file."""
    def change(path, random, other):
        lines = path.read_text().splitlines(keepends=True)
        path.write_text("".join(lines[k] for k in pick(random, len(lines))))
    return change


def _without(random, n):
    gone = int(random.integers(0, n - 1))
    return [k for k in range(n) if k != gone]


def _twice(random, n):
    return np.sort([*range(n), int(random.integers(0, n))])


def _swapped(random, n):
    order, two = np.arange(n), random.choice(n, 2, replace=False)
    order[two] = two[::-1]
    return order


DAMAGES = {
    "cut short": lambda path, random, other: os.truncate(path, int(random.integers(0, path.stat().st_size - 1))),
    "with 64 zeros in it": _bytes(lambda random, n: bytes(n)),
    "with 64 random bytes in it": _bytes(lambda random, n: random.bytes(64)),
    "empty": lambda path, random, other: path.write_bytes(b""), "gone": lambda path, random, other: path.unlink(),
    "of another run": lambda path, random, other: shutil.copy(other, path),
    "a folder": lambda path, random, other: (path.unlink(), path.mkdir()), WITHOUT: _lines(_without),
    "with a line twice": _lines(_twice), "with two lines swapped": _lines(_swapped),
}
