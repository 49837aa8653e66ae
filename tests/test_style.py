"""Rules of style that a tool checks: see [tool.ruff] and [tool.mypy] in pyproject.toml. Public functions have types."""

import ast
import re
import subprocess
import sys

import pytest

import parisph
from tests.launch import ROOT

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def said(*words):
    """Return what a Python tool prints about the clone if it finds a fault, else nothing."""
    done = subprocess.run([sys.executable, "-m", *words], cwd=ROOT, capture_output=True, text=True, timeout=300)
    return "" if done.returncode == 0 else done.stdout + done.stderr


def test_ruff_finds_no_fault():
    assert said("ruff", "check", "--no-cache", "parisph", "tests", "cases", "run_scripts") == ""


# A user's file, with the mypy error of each line that has one.
USE = """\
Box(1.0, 0.5)
Box(width=1, height=0.5, at=(0, 1))
Box(widht=1.0)    # call-arg
Box(1.0, "0.5")    # arg-type
Box(1.0, 0.5).widht    # attr-defined
Box(1.0, 0.5).width = 2.0    # misc
Tank(3.0, 1.0, Lid(0.5), no_slip=("bottom",))
Numerics(0.1, "ISPH", time_step=None)
Numerics()    # call-arg
Numerics(spacng=0.1)    # call-arg
Profile([(0.0, 0.0), (1.0, 0.1)], name="beach")
Series("paddle.csv", time="t", value="x", rate=True)
SolitaryWave(0.05, 0.25, "cnoidal")    # arg-type
PressureTap("P1", (0.0, 0.1), radius=0.01)
parisph.Bxo    # attr-defined
Case("Water", fluid=Fluid(Box(1.0, 0.4), 1000.0), gravity=(0.0, "-9.81"), numerics=Numerics(0.1), end_time=1.0)
case = Case("Water", fluid=[Fluid(Box(1.0, 0.4), density=1000.0)], walls=(Tank(1.0, 0.6), Plate(((0, 0), (1, 1)))),
            gravity=(0.0, -9.81), numerics=Numerics(spacing=0.1), absorb=Sponge(0.0, 1.0), probes=[Energy("e")],
            end_time=1.0)
case.changed(end_time=2.0).numerics.spacing + 1.0
Numerics(0.1).cfl + 1.0    # operator
Numerics(0.1).resolved().cfl + 1.0
RunUp("up", points=[(1.0, 0.0), (1.0, 1.0)])
Study(case="tank.py", spacings=[0.1, 0.05], variants=[Variant(methods=["ISPH"])], histories=["P1"])
Study(case="tank.py", varients=[])    # call-arg
PatchStudy(fields=["x"], sweeps=[Sweep(spacings=[0.1], jitters=[0.0])], histograms=[Histogram(0.1, 0.2)])
Sweep([0.1], jitters=0.2)    # arg-type
"""


def test_mypy_finds_no_fault_but_those_of_a_user(tmp_path):
    file = tmp_path / "use.py"
    lines = ["import parisph", f"from parisph import {', '.join(parisph.__all__)}",
             "from parisph.study import Histogram, PatchStudy, Study, Sweep, Variant", *USE.splitlines()]
    file.write_text("\n".join(lines), encoding="utf-8")
    found = said("mypy", "--no-error-summary", "--cache-dir", str(tmp_path / "cache"), "parisph", str(file))
    assert re.findall(r"^(.*?):(\d+): error: .*\[([a-z-]+)\]$", found, re.M) == [
        (str(file), str(number), line.partition("    # ")[2])
        for number, line in enumerate(lines, start=1) if "    # " in line], found


def untyped(text):
    """Return the lines and names of the public functions, and of those of public classes, that lack a type."""
    return [f"{node.lineno}: {node.name}" for node in _public(ast.parse(text).body)
            if node.returns is None or any(part.annotation is None for part in _arguments(node))]


def _public(body):
    for node in body:
        special = getattr(node, "name", "").startswith("__")
        if isinstance(node, FUNCTIONS) and (special or not node.name.startswith("_")):
            yield node
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from _public(node.body)


def _arguments(function):
    a = function.args
    given = [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, (a.vararg, a.kwarg))]
    return [part for part in given if part.arg not in ("self", "cls")]


@pytest.mark.parametrize("path", sorted((ROOT / "parisph").rglob("*.py")), ids=lambda path: str(path.relative_to(ROOT)))
def test_public_functions_have_types(path):
    assert untyped(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(("text", "names"), [
    ("def f(a): pass", ["1: f"]), ("def f() -> None: pass", []), ("def f(): pass", ["1: f"]),
    ("def _f(a): pass", []), ("def f(a: int, *b, c=1) -> int: pass", ["1: f"]),
    ("class A:\n    def f(self) -> None: pass\n    def g(self, a) -> None: pass", ["3: g"]),
    ("class A:\n    def __init__(self, a: int): pass", ["2: __init__"]), ("class _A:\n    def f(self, a): pass", []),
    ("def f() -> None:\n    def inside(a): pass", []),
])
def test_a_missing_type_is_found(text, names):
    assert untyped(text) == names
