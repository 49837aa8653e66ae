"""Files that are wrong by construction: stored cases, references, truths, folders that are no runs."""

import copy
import json
import os

import numpy as np

from tests.faults import bad_cases
from tests.faults.attempt import Attempt

WRONG = (True, "1.0", "wide", [], {}, [[1]], 1e300, -1e200, "x" * 100_000)    # for any number
SMALL = (0, -1.0, 5e-324)                                                     # and for one that is greater than 0
NUMBERS = ("fluid.shape.height", "fluid.density", "walls.width", "numerics.spacing", "numerics.cfl", "end_time")
WORDS = ("title", "numerics.method", "numerics.preset", "fluid.shape.kind", "frame.kind")
NEEDED = ("title", "fluid", "gravity", "numerics", "end_time", "fluid.shape", "fluid.density", "fluid.shape.width",
          "numerics.spacing")
REFERENCES = {    # content, of which some lines are good, and what must be said
    b"": "no line with the names", b"\xff\xfe\x00t,pressure\n0,1\n1,2\n": "UTF-8",
    np.random.default_rng(0).bytes(4000): "UTF-8|not text", b"t,pressure\n": "empty",
    b"t,pressure\n0,1\n": "two samples", b"t,pressure,t\n0,1,0\n1,2,1\n": "two columns",
    b"t,pressure,\n0,1,\n1,2,\n": "column 3 has no name",
    b",pressure\n0,1\n1,2\n": "column 1 has no name", b"t\n0\n1\n": "a time and a value",
    b"t,pressure\n0,1\n0,2\n": "times that increase",
    b"t,pressure\n0,a\n1,2\n": "line 2", b"t,pressure\na,1\n1,2\n": "line 2", b"t,pressure\n0,1\n1\n": "line 3",
    b"t,pressure\n0,1,2\n1,2\n": "line 2",
    b"t,pressure\n0,1e300\n1,2\n": "line 2", b"t,pressure\n0,inf\n1,2\n": "line 2",
    b"t,pressure\n-inf,1\n1,2\n": "line 2",
    b"t,pressure\n8,1\n9,2\n": "share fewer than two", b"t,pressure\n0,0\n0.1,0\n": "no meaning",
    b't,pressure\n0,"1\n1,2\n': "line 2",
    b"t,pressure\n0,1\x00\n1,2\n": "not text", b"t,pressure\n" + b"1" * 200_000 + b",1\n": "line 2",
    b"t;pressure\n0;1,5\n1;2.5\n": "line 3 one with a point",
    b"\x1b[2J,pressure\n0,1\n1,2\n3,4\n\x1b,1\n": "line 5", b"t" * 300_000 + b"\n": "line 1|a time and a value",
    b"t,pressure\n0,\n1,nan\n": "empty",
    b"#only a comment\n": "no line with the names", b"t,pressure\n" + b"\n" * 100_000: "empty",
    b"PK\x03\x04" + bytes(300): "not text",
}


def stored(random, number):
    """A stored case with one change; without its digest, so that the change itself must be seen."""
    kinds = (_wrong_number, _small_number, _wrong_word, _without, _unknown, _changed_unsealed, _as_text)
    what, says, change = kinds[number % len(kinds)](random)

    def make(path, sound):
        content = json.loads((sound / "case.json").read_text())
        path.write_bytes(change(content))

    verb = "run" if random.random() < 0.3 else "check"
    return Attempt(f"case.json: {what}", [verb, "bad/case.json"], says, {"bad/case.json": make})


def _unsealed(content):
    return {name: value for name, value in copy.deepcopy(content).items() if name != "digest"}


def _edited(edit):
    """Return what makes a file of a stored case without its digest, after edit(content)."""
    def change(content):
        content = _unsealed(content)
        edit(content)
        return json.dumps(content).encode()
    return change


def _place(content, name):
    *path, last = name.split(".")
    for part in path:
        content = content[part]
    return content, last


def _put(name, value):
    def edit(content):
        place, last = _place(content, name)
        place[last] = value
    return f"{name} = {str(value)[:40]!r}", [name.split(".")[-1]], _edited(edit)


def _wrong_number(random):
    return _put(str(random.choice(NUMBERS)), WRONG[int(random.integers(len(WRONG)))])


def _small_number(random):
    return _put(str(random.choice(NUMBERS)), SMALL[int(random.integers(len(SMALL)))])


def _wrong_word(random):
    values = (1, True, None, [], {}, "no such\n", "\x1b[2J", "x" * 100_000, "\ud800")
    what, says, change = _put(str(random.choice(WORDS)), values[int(random.integers(len(values)))])
    return what, [*says, "frame", "shape", "Invalid JSON"], change


def _without(random):
    name = str(random.choice(NEEDED))

    def edit(content):
        place, last = _place(content, name)
        del place[last]
    return f"no {name}", [name.split(".")[-1]], _edited(edit)


def _unknown(random):
    name = ("salt", "", "a\nb", "\x1b[2J", "x" * 100_000, "Title")[int(random.integers(6))]
    place = ("fluid", "numerics", "output", "walls")[int(random.integers(4))]
    return f"{place} has {name[:20]!r}", ["has no field"], _edited(lambda content: content[place].update({name: 1}))


def _changed_unsealed(random):
    """A legal change, but the digest is that of the case before it."""
    def change(content):
        content["end_time"] *= 0.5
        return json.dumps(content).encode()
    return "changed under its digest", ["digest"], change


def _as_text(random):
    end = float(random.random())
    makers = {
        "cut short": lambda text: text[: int(end * (len(text) - 2))], "empty": lambda text: b"",
        "a list": lambda text: b"[]", "a number": lambda text: b"3", "null": lambda text: b"null",
        "nested too deeply": lambda text: b"[" * 100_000, "nested objects": lambda text: b'{"a":' * 100_000,
        "two of one name": lambda text: text.replace(b'"end_time"', b'"title": "again", "end_time"', 1),
        "UTF-16": lambda text: text.decode().encode("utf-16"),
        "with a null character": lambda text: text.replace(b'"title"', b'"ti\0tle"', 1),
        "binary": lambda text: bytes(range(256)) * 9,
        "a huge integer": lambda text: text.replace(b'"end_time":', b'"end_time": ' + b"9" * 10_000 + b', "x":', 1),
        "nan": lambda text: text.replace(b'"end_time":', b'"end_time": NaN, "x":', 1),
        "Python": lambda text: b"def case():\n    pass\n",
        "of a later release": lambda text: text.replace(b'"schema": 3', b'"schema": 99', 1),
        "another encoding": lambda text: text.replace(b"title", b"t\xeftle", 1),
        "schema as text": lambda text: text.replace(b'"schema": 3', b'"schema": "one"', 1),
    }
    what = str(random.choice(sorted(makers)))
    return what, ["bad/case.json"], lambda content: makers[what](json.dumps(_unsealed(content)).encode())


def reference(random, number):
    """A series to compare with that is none."""
    contents = list(REFERENCES)
    content = contents[number % len(contents)]
    return Attempt(f"reference {content[:40]!r}", ["compare", "{run}", "bad.csv", "--probe", "P2"],
                   REFERENCES[content].split("|"), {"bad.csv": content}, codes=(2, 5))


def truth(random, number):
    """The truth of a probe that is none; in a case that is run, or checked."""
    # these are sound truths
    contents = [content for content in REFERENCES if not content.startswith((b"t,pressure\n0,0", b"t,pressure\n8,1"))]
    content = contents[int(random.integers(len(contents)))]
    text = bad_cases.source(probes="[Energy('energy', truth=Truth('bad.csv', 't', 'pressure'))]")
    verb = "run" if random.random() < 0.3 else "check"
    return Attempt(f"truth {content[:40]!r}", [verb, "bad_case.py"], ["truth"],
                   {"bad_case.py": text, "bad.csv": content})


def folder(random, number):
    """What is no run, where one is asked for."""
    def pipe(path, sound):
        os.mkfifo(path)

    def link(path, sound):
        path.symlink_to(path.name)

    makers = {
        "nothing": {}, "an empty folder": {"bad": None}, "a file": {"bad": "x"}, "a pipe": {"bad": pipe},
        "a link to itself": {"bad": link}, "a folder as case.json": {"bad/case.json": None},
        "a pipe as case.json": {"bad/case.json": pipe}, "an empty case.json": {"bad/case.json": ""},
        "a list as case.json": {"bad/case.json": "[]"}, "binary as case.json": {"bad/case.json": bytes(range(256))},
        "no object": {"bad/case.json": "3"}, "deep JSON": {"bad/case.json": "[" * 100_000},
        "an empty object": {"bad/case.json": "{}"}, "a link as case.json": {"bad/case.json": link},
        "only snapshots": {"bad/snapshots/000000.vtkhdf": "x"},
        "only probes": {"bad/probes/a.csv": "time,step,p\n0,0,1\n"},
    }
    what = str(random.choice(sorted(makers)))
    words = (["info", "bad"], ["info", "bad", "--json"], ["plot", "bad"], ["plot", "bad", "--time", "1"],
             ["plot", "bad", "--probe", "a"], ["movie", "bad"], ["compare", "bad", "bad.csv"], ["restart", "bad"],
             ["restart", "bad", "-o", "new"], ["restart", "bad/case.json"])
    chosen = words[int(random.integers(len(words)))]
    return Attempt(f"{' '.join(chosen)} of {what}", chosen, ["bad"], {**makers[what], "bad.csv": "t,p\n0,1\n1,2\n"},
                   codes=(2, 5))


def checkpoint(random, number):
    """What is no checkpoint, to restart from."""
    data = random.bytes(int(random.integers(0, 5000)))
    return Attempt(f"restart from {len(data)} random bytes", ["restart", "bad.h5", "-o", "new"], ["bad.h5"],
                   {"bad.h5": (b"\x89HDF\r\n\x1a\n" if number % 2 else b"") + data}, codes=(2, 5))
