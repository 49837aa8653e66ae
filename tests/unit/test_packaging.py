"""What goes with the package: types, citation."""

import ast
import importlib
import re

import pytest

import parisph
from tests.launch import ROOT

METHOD = ROOT / "parisph" / "methods" / "README.md"    # has the references
STUBS = sorted((ROOT / "parisph").rglob("*.pyi"))


def names_of(stub):
    """Return the names that a stub declares."""
    found = set()
    for node in ast.parse(stub.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            found |= {alias.asname for alias in node.names if alias.asname}
        elif isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            found.add(node.name)
        elif isinstance(node, ast.AnnAssign):
            found.add(node.target.id)
    return found


def test_the_package_claims_its_types():
    assert (ROOT / "parisph" / "py.typed").exists()
    assert names_of(ROOT / "parisph" / "__init__.pyi") == set(parisph.__all__)


@pytest.mark.parametrize("stub", STUBS, ids=lambda path: path.name)
def test_a_stub_declares_what_is_there(stub):
    module = ".".join(stub.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    assert not [name for name in names_of(stub) if not hasattr(importlib.import_module(module), name)]


def test_citation_is_of_this_version():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (.*)$", text, re.M)[1] == parisph.__version__
    assert (set(re.findall(r"doi: (\S+)", text))
            <= set(re.findall(r"doi:([^\s,]+?)\.?\s", METHOD.read_text(encoding="utf-8"))))
