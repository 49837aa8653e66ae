"""What a part of the campaign is, how it is carried out, and the table of all of them."""

import shutil
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.launch import parisph

SHOWN = 20    # misbehaviours of a part that are printed


@dataclass(frozen=True)
class Part:
    """One kind of fault.

    what : a few words for the table
    attempts : how many the whole campaign makes
    make : function(count, random, folder) that makes `count` attempts in an empty folder and yields, for
        each, None if parisph behaved, or a line that says what it did. It chooses with `random`, a
        numpy.random.Generator, so that a seed repeats it.
    """

    what: str
    attempts: int
    make: Callable[[int, np.random.Generator, Path], Iterator[str | None]]


@dataclass(frozen=True)
class Row:
    """One line of the table; misbehaved : list of what went wrong; seconds : wall time."""

    name: str
    what: str
    attempts: int
    misbehaved: list
    seconds: float


def each_in_its_folder(count, folder, attempt):
    """Yield attempt(place) for `count` new folders; those in which parisph behaved are removed."""
    for number in range(count):
        place = folder / str(number)
        place.mkdir()
        found = attempt(place)
        if found is None:
            shutil.rmtree(place)
        yield found


def gone_on(folder, what, ranks=1, seconds=300.0):
    """Restart the run of a folder, or start it where it had not begun; return None, or what was wrong with that."""
    begun = (folder / "run" / "case.json").exists()
    words = [*(["restart", "run"] if begun else ["run", "case.py", "-o", "run"]), "-q"]
    done = parisph(*words, ranks=ranks, cwd=folder, timeout=seconds)
    if done.returncode != 0 or "Traceback" in done.stderr:
        return f"{what}: {words[0]} on {ranks} ranks ends with {done.returncode}: {done.stderr[-1000:]}"
    return None


def carry_out(name, part, count, seed, folder):
    """Make the attempts of a part, say on standard error what misbehaves, and return the Row."""
    begun, made, misbehaved = time.monotonic(), 0, []
    for found in part.make(count, np.random.default_rng(seed), folder):
        made += 1
        if found is not None:
            misbehaved.append(found)
            if len(misbehaved) <= SHOWN:
                print(f"{name}, attempt {made}: {found}", file=sys.stderr, flush=True)
    return Row(name, part.what, made, misbehaved, time.monotonic() - begun)


def text(rows):
    """Return the rows as a Markdown table."""
    lines = ["| part | what | attempts | misbehaved | s |", "|---|---|---|---|---|"]
    lines += [f"| {row.name} | {row.what} | {row.attempts} | {len(row.misbehaved)} | {row.seconds:.0f} |"
              for row in rows]
    return "\n".join(lines)
