"""Rules of style that a tool checks: see [tool.ruff] and [tool.mypy] in pyproject.toml. Public functions have types."""

import ast
import subprocess
import sys

import pytest

from tests.launch import ROOT

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def said(*words):
    """Return what a Python tool prints about the clone if it finds a fault, else nothing."""
    done = subprocess.run([sys.executable, "-m", *words], cwd=ROOT, capture_output=True, text=True, timeout=300)
    return "" if done.returncode == 0 else done.stdout + done.stderr


def test_ruff_finds_no_fault():
    assert said("ruff", "check", "--no-cache", "parisph", "tests", "cases", "run_scripts") == ""


def test_mypy_finds_no_fault(tmp_path):
    assert said("mypy", "--no-error-summary", "--cache-dir", str(tmp_path)) == ""


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
