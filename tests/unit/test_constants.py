"""The page of the tuned numbers says what the sources say, and each number of methods and kernels says what it is."""

import ast

import pytest

from tests.constants import page, sources
from tests.constants.sources import Tuned
from tests.launch import ROOT

FILES = sorted(path for name in ("methods", "kernels") for path in (ROOT / "parisph" / name).glob("*.py"))
TEXT = '''A = dict(b=1, c=math.pi / 6.0)
D = {"e": {"f": 2}}    # tuned 1 to 3: what; judged
G = Gap(
    enter=2.5,    # tuned 1.25 to 4: what; it is; Z14
)
'''


def test_page_says_what_the_sources_and_the_study_say():
    assert page.PAGE.read_text(encoding="utf-8") == page.text(), "run python -m tests.constants page"


def test_names_are_unique():
    keys = [one.key for one in sources.listed()]
    assert len(keys) == len(set(keys)) > 100


def test_numbers_are_found_and_replaced_where_they_are():
    integer, angle = sources.of_text(TEXT, "a.py")
    assert integer == Tuned("D.e.f", "a.py", 2, 16, 17, 2, 1.0, 3.0, "what", "judged")
    assert (angle.key, angle.value, angle.what, angle.source) == ("a.py:G.enter", 2.5, "what; it is", "Z14")
    assert [integer.times(0.5), integer.times(2.0), angle.times(2.0)] == [1, 3, 4.0]
    assert sources.replaced(TEXT, angle, 4.0) == TEXT.replace("enter=2.5", "enter=4.0")


@pytest.mark.parametrize("line", ["A = 1.0    # tuned 1 to 2", "A = 3.0    # tuned 1 to 2: a; b",
                                  "A, B = 1.0, 2.0    # tuned 1 to 2: a; b"])
def test_a_comment_that_is_wrong_is_an_error(line):
    with pytest.raises(ValueError, match="^a.py:1: "):
        sources.of_text(line + "\n", "a.py")


def test_what_a_number_is_compiled_into_is_known():
    found = sources.dependents("kernels/moments.py")
    assert {"kernels/moments.py", "kernels/harmonic.py", "kernels/harmonic_gradient.py"} < found    # through harmonic
    assert "kernels/cells.py" not in found


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_numbers_of_a_module_say_what_they_are(path):
    """A comment stands in their line, or above them and the lines that belong with them."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    silent = [node.lineno for node in ast.parse(text).body if isinstance(node, (ast.Assign, ast.AnnAssign))
              if any(isinstance(part, ast.Constant) and isinstance(part.value, float) for part in ast.walk(node))
              if not any("#" in line for line in lines[node.lineno - 2:node.end_lineno])]
    assert silent == []


def test_an_effect_is_what_chance_does_not_explain():
    starts = [{"P2": value} for value in (0.9, 1.0, 1.1) * 4]
    one, base = Tuned("A", "a.py", 1, 0, 1, 2.0, 1.0, 4.0, "what", "judged"), {"dam": starts, "wave": [{"error": 1.0}]}

    def words(half, double):
        tried = {0.5: 1.0, 2.0: 4.0}
        found = {("a.py:A", factor): {"value": 2.0, "tried": tried[factor], "found": what}
                 for factor, what in ((0.5, half), (2.0, double))}
        return page.effect(one, {("base", 1.0): {"found": base}, **found})

    same = {"dam": starts[:3], "wave": [{"error": 1.0}]}
    assert words(same, same) == "none, unused"
    assert words(same, {"dam": starts[1:4], "wave": [{"error": 1.04}]}) == "none"
    assert words({"wave": [{"error": 1.2}]}, same) == "half (1): standing wave: error 1 to 1.2 (20.0)"
    assert words(same, {"dam": [{"P2": 1.15}] * 3}) == "double (4): perhaps dam break: P2 1 to 1.15 (2.7)"
    assert words(same, {"dam": ["SolverDiverged: fast", *starts[:2]]}) == "double (4): dam break fails (1 of 3)"
    assert page.effect(one, {}) == "not measured"
