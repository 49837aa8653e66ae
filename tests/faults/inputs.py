"""Bad input: one error of a sane length that names the field or the path, and nothing else.

No traceback, no warning of Python or numpy, nothing left behind, at most 20 s and 1 GB. Most attempts
are made in one process that goes on (`answer`), some in a process of their own, as from a shell, and a few on two
ranks.
"""

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

from parisph import __main__ as entry
from parisph.base.text import is_plain
from tests.faults import bad_cases, bad_files, bad_words
from tests.faults.answering import Answering
from tests.launch import clean_environment, mpirun, parisph

SECONDS, MEMORY = 20.0, 1e9     # for one attempt [s], [bytes]
COMPILE = 300.0                 # for the sound run [s]
LONGEST, WIDEST = 2000, 400     # characters of a message, and of one of its lines
# What is tried, in turn: the more there is of a kind, the more often.
KINDS = (bad_cases.field, bad_words.line, bad_cases.field, bad_files.stored, bad_cases.file, bad_words.setting,
         bad_cases.field, bad_words.name, bad_files.reference, bad_words.line, bad_cases.field, bad_files.folder,
         bad_words.value, bad_cases.mutated, bad_files.stored, bad_files.truth, bad_cases.field, bad_words.setting,
         bad_files.checkpoint, bad_files.folder, bad_words.long_name, bad_words.line)
# shares of the attempts in a process of their own; and, of runs and restarts, on two ranks
OWN, RANKS = 0.1, 0.1
SOUND = """
from tests.faults.dam import dam
def case():
    return dam(spacing=0.1, end_time=0.3, snapshot_every=0.1)
"""


def make(count, random, folder):
    """See table.Part."""
    turns = dict.fromkeys(KINDS, 0)
    for kind in turns:
        turns[kind] = int(random.integers(1000))
    with Answering("tests.faults.inputs") as worker:
        sound = _sound(folder)
        before = _tree(sound)
        for number in range(count):
            kind = KINDS[number % len(KINDS)]
            attempt = kind(random, turns[kind])
            turns[kind] += 1
            place = folder / f"try{number}"
            place.mkdir()
            attempt.prepare(place, sound)
            found = _judge(attempt, place, *_carry_out(attempt, random.random(2), worker, place, sound))
            if found is None and _tree(sound) != before:
                found, before = f"{attempt.what}: has changed a sound run", _tree(sound)
            yield found
            shutil.rmtree(place)


def _sound(folder):
    """Make the run that commands may look at; the first one on a machine compiles the kernels."""
    (folder / "sound.py").write_text(SOUND)
    done = parisph("run", "sound.py", "-o", "sound", "-q", timeout=COMPILE, cwd=folder)
    if done.returncode != 0:
        raise RuntimeError(f"no sound run: {done.stderr}")
    return folder / "sound"


def _carry_out(attempt, chance, worker, place, sound):
    """Carry out an attempt in one way or another, by two random numbers from 0 to 1.

    Returns (files before, what was said of the attempt: see `answer`, or a text if there is no answer).
    """
    words = [word.replace("{run}", str(sound)) for word in attempt.words]
    before = _tree(place)
    possible = not any("\0" in word or len(word) > 100_000
                       or any("\ud800" <= character <= "\udc7f" for character in word) for word in words)
    if possible and chance[0] < RANKS and words and words[0] in ("run", "restart"):
        return before, _on_two_ranks(words, place)
    if possible and chance[1] < OWN:
        return before, _by_itself(words, place)
    error, said = worker.ask({"words": words, "folder": str(place)})
    return before, f"{error}: {said}" if error else said


def _judge(attempt, place, before, said):
    """Return None if parisph behaved, else what it did."""
    if isinstance(said, str):
        return f"{attempt.what}: {said}"
    message = said["err"]
    left = sorted(_tree(place) - before)
    faults = {
        f"exit code {said['code']}": said["code"] not in attempt.codes,
        "not one error": sum(line.startswith("parisph: error: ") for line in message.split("\n")) != 1,
        "a traceback": "Traceback" in message,
        "a warning": "Warning" in message or "warning" in message,
        "something on standard output": bool(said["out"].strip()),
        f"{len(message)} characters": len(message) > LONGEST,
        "a long line": max(map(len, message.split("\n"))) > WIDEST,
        "control characters": not all(is_plain(line) for line in message.split("\n")),
        f"none of {attempt.says}": not any(text in message for text in attempt.says),
        f"{left} left behind": bool(left),
        f"{said['seconds']:.0f} s": said["seconds"] > SECONDS,
        f"{said['bytes'] / 1e6:.0f} MB": said["bytes"] > MEMORY,
    }
    wrong = [fault for fault, there in faults.items() if there]
    return f"{attempt.what}: {', '.join(wrong)}: {message[-600:]!r}" if wrong else None


def _tree(folder):
    return {(path.relative_to(folder), path.stat(follow_symlinks=False).st_size if path.is_file() else 0)
            for path in folder.rglob("*")}


def answer(question):
    """Carry out a command line in this process; return dict: code, out, err, seconds, bytes (of memory that it took).

    question : dict of words and folder, the current one
    """
    os.chdir(question["folder"])
    _reset_peak()
    begun = time.monotonic()
    with tempfile.TemporaryFile("w+", errors="replace") as out, tempfile.TemporaryFile("w+", errors="replace") as err:
        with _redirected(out, 1), _redirected(err, 2), warnings.catch_warnings():
            for category in (RuntimeWarning, UserWarning, SyntaxWarning, FutureWarning):
                warnings.simplefilter("always", category)
            try:
                code = entry.main(question["words"])
            except BaseException as error:
                code = f"{type(error).__name__}: {error}"
        texts = [_text(file) for file in (out, err)]
    return {"code": code, "out": texts[0], "err": texts[1], "seconds": time.monotonic() - begun,
            "bytes": _status("VmHWM")}


@contextlib.contextmanager
def _redirected(file, number):
    """Send what this process writes to a standard stream into a file, that of C code too."""
    stream = (sys.stdin, sys.stdout, sys.stderr)[number]
    stream.flush()
    kept = os.dup(number)
    os.dup2(file.fileno(), number)
    try:
        yield
    finally:
        stream.flush()
        os.dup2(kept, number)
        os.close(kept)


def _text(file):
    file.seek(0)
    return file.read(10**6)


def _reset_peak():
    Path("/proc/self/clear_refs").write_text("5")    # the peak begins at what is in use


def _status(name, process="self"):
    """Return a size in bytes from the status of a process; 0 of one that has ended."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next((1024.0 * int(line.split()[1]) for line in lines if line.startswith(name)), 0.0)


def _by_itself(words, place):
    begun = time.monotonic()
    with tempfile.TemporaryFile("w+", errors="replace") as out, tempfile.TemporaryFile("w+", errors="replace") as err:
        process = subprocess.Popen([sys.executable, "-m", "parisph", *words], cwd=place, env=clean_environment(),
                                   stdin=subprocess.DEVNULL, stdout=out, stderr=err)
        peak = 0.0
        while process.poll() is None and time.monotonic() < begun + 2.0 * SECONDS:
            # not `ru_maxrss`, which begins at the memory of the process that forked
            peak = max(peak, _status("VmHWM", process.pid))
            time.sleep(0.01)
        if process.poll() is None:
            process.kill()
            process.wait()
            return f"hang: no end after {2.0 * SECONDS:g} s"
        texts = [_text(file) for file in (out, err)]
    return {"code": process.returncode, "out": texts[0], "err": texts[1], "seconds": time.monotonic() - begun,
            "bytes": peak}


def _on_two_ranks(words, place):
    begun = time.monotonic()
    try:
        done = mpirun(2, ["-m", "parisph", *words], timeout=2.0 * SECONDS, cwd=place)
    except subprocess.TimeoutExpired:
        return f"hang on two ranks: no end after {2.0 * SECONDS:g} s"
    said = done.stderr.partition("-------")[0]    # below it is what mpirun says of a program that fails
    return {"code": done.returncode, "out": done.stdout.partition("-------")[0], "err": said,
            "seconds": time.monotonic() - begun, "bytes": 0.0}
