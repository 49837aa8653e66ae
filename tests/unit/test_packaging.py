"""What `from parisph import ...` offers, and what goes with the package: types, citation."""

import importlib
import re

import pytest

import parisph
from tests.launch import ROOT

METHOD = ROOT / "parisph" / "methods" / "README.md"    # has the references


def test_the_package_claims_its_types():
    assert (ROOT / "parisph" / "py.typed").exists()


def test_citation_is_of_this_version():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (.*)$", text, re.M)[1] == parisph.__version__
    assert (set(re.findall(r"doi: (\S+)", text))
            <= set(re.findall(r"doi:([^\s,]+?)\.?\s", METHOD.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("name", [name for name in parisph.__all__ if name != "__version__"])
def test_public_name_is_that_of_its_module(name):
    assert getattr(parisph, name) is getattr(importlib.import_module(parisph._PUBLIC[name]), name)
    assert name in dir(parisph)


def test_unknown_name():
    with pytest.raises(ImportError, match="simulation"):
        from parisph import simulation  # noqa: F401
