"""The quick selection of the hard cases; `python -m tests.hard` computes all of them."""

import pytest

from tests.hard.scenes import QUICK
from tests.hard.table import text


@pytest.mark.parametrize("name", QUICK)
def test_quick_selection(name):
    found = QUICK[name].outcome(name)
    assert found.lines and found.met, text([found])
