"""What goes with the package: types, citation."""

import re

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
