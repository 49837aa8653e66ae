"""Titles, folder names and values from outside are shown by Markdown as they stand, and do not end a cell or a link."""

import pytest

from parisph.base.markdown import escaped, line, target


@pytest.mark.parametrize(("text", "due"), [
    ("H/L = 2, dam_break, 9.81 m/s2 (x > 0.5), +3%", "H/L = 2, dam_break, 9.81 m/s2 (x > 0.5), +3%"),
    ("a|b", r"a\|b"), ("[x](y)", r"\[x\](y)"), ("`rm`", r"\`rm\`"), ("<b>&amp;", r"\<b>\&amp;"), ("a\\|b", r"a\\\|b"),
    ("*a* _b_ c__d ~e~ $f$", r"\*a\* \_b\_ c\_\_d \~e\~ \$f\$"), ("a\nb\x1b\u2028", r"a\\nb\\x1b\\u2028"),
    ("- a", "- a"), ("-", "-"), ("\udce9", r"\\udce9"),
])
def test_a_text_inside_a_line(text, due):
    assert escaped(text) == due
    assert all(a == "\\" for a, b in zip(due, due[1:]) if b == "|"), "else it ends the cell"


@pytest.mark.parametrize(("text", "due"), [
    ("- a", r"\- a"), ("# a ##", r"\# a \#\#"), ("1. a", r"1\. a"), ("1.5 m", "1.5 m"),
    ("> a", r"\> a"), ("12)", r"12\)"),
    ("<!-- end of the gallery -->", r"\<!-- end of the gallery -->"), ("===", r"\==="), ("dam_break", "dam_break"),
])
def test_a_whole_line(text, due):
    assert line(text) == due


def test_a_target_of_a_link():
    assert target("pictures/a b (1)[2]<3>|4#5?6%7é.png") == (
        "pictures/a%20b%20%281%29%5B2%5D%3C3%3E%7C4%235%3F6%257%C3%A9.png")
    assert target("caf\udce9.png") == "caf%E9.png"    # a name in Latin-1
