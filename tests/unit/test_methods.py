"""A method is named twice: where a case is checked, and where its parts are known."""

from parisph.case.presets import METHODS
from parisph.methods.schemes import SCHEMES


def test_every_method_that_a_case_may_ask_for_is_known():
    assert set(METHODS) == set(SCHEMES)
    assert METHODS[0] == "ISPH_R", "the default"
