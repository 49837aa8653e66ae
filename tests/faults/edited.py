"""A case.json that was edited before a restart: the edit is taken or refused, and no text is lost."""

import json
import shutil

from parisph.base.errors import ParisphError
from parisph.io import reader
from tests.faults import text_files

LONGEST = 2000    # characters of a message
# (place, value, whether a restart takes it). The run ends at END.
END, LONGER, UNTIL = 0.1 / 9.81**0.5, 0.04, 0.038    # [s]
EDITS = (
    (("end_time",), LONGER, True), (("title",), "Another", True), (("output", "every"), 0.01, True),
    (("output", "every"), None, True), (("output", "times"), [0.9 * END], True),
    (("output", "checkpoint_every"), 1.0, True),
    (("end_time",), 0.5 * END, False), (("end_time",), -1.0, False), (("end_time",), "long", False),
    (("output", "every"), 0.0, False), (("output", "budget"), True, False), (("output", "fields"), ["u"], False),
    (("probes",), [], False), (("probes", 0, "name"), "other", False), (("fluid", "density"), 900.0, False),
    (("gravity",), [0.0, -1.0], False), (("numerics", "cfl"), 0.1, False), (("numerics", "spacing"), 0.05, False),
    (("asked", "preset"), "gentle", False), (("walls", "lid"), False, False), (("salt",), 1, False),
    (("schema",), 99, False), (("schema",), None, False), (("run",), "another", False), (("run",), None, False),
    (("made",), None, True), (("made", "parameters"), {"end_time": 7}, True), (("made",), [1], True),
)
LAYOUTS = {"indented by 1": {"indent": 1}, "in one line": {"separators": (",", ":")}, "sorted": {"sort_keys": True}}


def make(count, random, folder):
    """See table.Part."""
    (folder / "case.py").write_text(text_files.CASE)
    code, said = text_files._command(["run", str(folder / "case.py"), "-o", str(folder / "sound"), "-q"])
    if code != 0:
        raise RuntimeError(said)
    for attempt in range(count):
        run = folder / "run"
        shutil.copytree(folder / "sound", run)
        yield _attempt(run, random, EDITS[attempt % len(EDITS)])
        shutil.rmtree(run)


def _attempt(run, random, edit):
    (*path, last), value, taken = edit
    content = json.loads((run / "case.json").read_text())
    seal = "without its digest" if random.random() < 0.7 else "under its digest"
    part = content
    for key in path:
        part = part[key]
    changed = part[last] != value if isinstance(last, int) or last in part else True
    part[last] = value
    if seal == "without its digest":
        content.pop("digest")
    elif changed:
        taken = False
    layout = sorted(LAYOUTS)[int(random.integers(len(LAYOUTS)))]
    text = json.dumps(content, **LAYOUTS[layout])
    (run / "case.json").write_text(text)
    what = f"{'.'.join(map(str, (*path, last)))} = {value!r}, {seal}, {layout}"
    until = random.random() < 0.5
    before = text_files._contents(run)
    words = ["restart", str(run), "-q", *(["--until", str(UNTIL)] if until else [])]
    code, said = text_files._command(words)
    if code not in (0, 2, 5) or "Traceback" in said or "Warning" in said:
        return f"{what}: ends with {code}: {said[-500:]}"
    if code != 0:
        return _refused(run, what, said, before, taken and (until or last == "end_time"))
    if not taken and not (until and value == 0.5 * END and seal == "without its digest"):    # --until goes before it
        return f"{what}: is taken"
    return _taken(run, what, text, path, last, value, until)


def _refused(run, what, said, before, due):
    """Judge a refusal. due : whether the edit is one that is taken, and leaves something to do"""
    if due:
        return f"{what}: is refused: {said[-400:]}"
    if said.count("parisph: error: ") != 1 or len(said) > LONGEST:
        return f"{what}: says {said[-500:]!r}"
    return None if text_files._contents(run) == before else f"{what}: is refused, but files have changed"


def _taken(run, what, text, path, last, value, until):
    try:
        found = reader.open_run(run)
        found.check()
        steps = found.steps["step"]
    except ParisphError as error:
        return f"{what}: leaves a run that cannot be read: {error}"
    kept = [one.read_text() for one in run.glob("replaced/*/case.json")]
    if "digest" not in json.loads(text) and kept != [text]:
        return f"{what}: the edited text is not in replaced/N"
    if [*steps] != list(range(1, len(steps) + 1)):
        return f"{what}: steps are {steps}"
    now = found.case
    for key in path:
        now = now[key]
    if path[:1] != ["made"] and last != "made" and not (until and last == "end_time") and now[last] != value:
        return f"{what}: is {now[last]!r} afterwards"
    return None
