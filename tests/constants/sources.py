"""The tuned numbers of parisph, as its sources say.

A number that was chosen by measurement or by judgement has a comment of one form at the end of its line:

    REACH = 1.9    # tuned 1 to 2.6: radius of the neighbours that push, in spacings; judged

LOW and HIGH are the least and the greatest value that the study tries, then comes what the number is, and its source.
"""

import ast
import io
import re
import tokenize
from dataclasses import dataclass
from pathlib import Path

from tests.launch import ROOT

COMMENT = re.compile(r"# tuned (\S+) to (\S+): (.+); ([^;]+)")
FACTORS = {0.5: "half", 2.0: "double"}


@dataclass(frozen=True)
class Tuned:
    """A tuned number.

    name : with the names of what it is inside, as "GAP.enter"; file : relative to parisph/
    line, start, end : its place there, the line from 1 on, and the bytes of that line
    value, low, high : what it is, and the range in which it is tried; what, source : words
    """

    name: str
    file: str
    line: int
    start: int
    end: int
    value: float
    low: float
    high: float
    what: str
    source: str

    @property
    def key(self) -> str:
        """File and name, which no other one has."""
        return f"{self.file}:{self.name}"

    def times(self, factor: float) -> float:
        """Return a multiple of the value, of its type, within the range."""
        return type(self.value)(min(max(factor * self.value, self.low), self.high))


def listed(root: Path = ROOT / "parisph") -> list[Tuned]:
    """Return the tuned numbers in the sources below a folder. Raises ValueError for a comment that is not as it should
    be."""
    return [one for path in sorted(root.rglob("*.py")) for one in of_text(path.read_text(encoding="utf-8"),
                                                                          path.relative_to(root).as_posix())]


def of_text(text: str, file: str) -> list[Tuned]:
    """Return the tuned numbers of one source. file : its name"""
    if "# tuned " not in text:
        return []
    numbers, found = dict(_numbers(ast.parse(text), ())), []
    for line, comment in _comments(text):
        said, here = COMMENT.fullmatch(comment), [(path, one) for one, path in numbers.items() if one.lineno == line]
        if said is None or len(here) != 1:
            raise ValueError(f"{file}:{line}: a tuned number is one number in a line, with the comment "
                             f'"# tuned LOW to HIGH: WHAT; SOURCE": {comment}')
        (path, number), (low, high, what, source) = here[0], said.groups()
        found.append(Tuned(".".join(path).removeprefix("PRESETS.").lstrip("_"), file, line, number.col_offset,
                           number.end_col_offset, number.value, float(low), float(high), what, source))
        if not found[-1].low <= number.value <= found[-1].high:
            raise ValueError(f"{file}:{line}: {number.value} is not within {low} to {high}")
    return found


def replaced(text: str, tuned: Tuned, value: float) -> str:
    """Return a source with another value of a tuned number."""
    lines = text.encode().splitlines(keepends=True)
    line = lines[tuned.line - 1]
    lines[tuned.line - 1] = line[:tuned.start] + repr(value).encode() + line[tuned.end:]
    return b"".join(lines).decode()


def dependents(file: str, root: Path = ROOT / "parisph") -> set[str]:
    """Return the files below root that import a file, or one that does, and itself: what it is compiled into."""
    users: dict[str, set[str]] = {}
    for path in root.rglob("*.py"):
        for name in _imported(ast.parse(path.read_bytes())):
            users.setdefault(name, set()).add(path.relative_to(root).as_posix())
    found, new = set(), {file}
    while new:
        found |= new
        new = {user for one in new for user in users.get(one.removesuffix(".py").replace("/", "."), ())} - found
    return found


def _imported(tree):
    """Return the modules that a module imports from parisph, and what may be one, without the package's name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "parisph":
            module = node.module.removeprefix("parisph").lstrip(".")
            yield module
            yield from (f"{module}.{alias.name}" for alias in node.names)


def _comments(text):
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and token.string.startswith("# tuned "):
            yield token.start[0], token.string


def _numbers(node, path):
    """Yield each number of a tree, with the names of what it is inside."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield node, path
    if isinstance(node, (ast.Assign, ast.AnnAssign)):
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        path = (*path, getattr(target, "id", ""))
    elif isinstance(node, ast.keyword):
        path = (*path, node.arg or "")
    if isinstance(node, ast.Dict):
        for key, value in zip(node.keys, node.values):
            yield from _numbers(value, path if key is None else (*path, str(getattr(key, "value", ""))))
        return
    for child in ast.iter_child_nodes(node):
        yield from _numbers(child, path)
