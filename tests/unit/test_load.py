"""Case files: found, run with --set, and their errors told with file and line."""

import pytest

from parisph import CaseError, load
from parisph.case.load import arguments, parameters

TEMPLATE = '''"""A case."""
from parisph import Box, Case, Fluid, Numerics, SurfaceGauge, Tank, Truth

def case({parameters}) -> Case:
    {body}
    return Case(
        title={title}, fluid=Fluid(Box(1.0, 1.0), density=1000.0), walls=Tank(1.0, 2.0), gravity=(0.0, -9.81),
        numerics=Numerics(spacing=spacing), probes={probes}, end_time=1.0,
    )
'''


@pytest.fixture
def write(tmp_path):
    def write(parameters="spacing: float = 0.1", body="pass", title="'test'", probes="()", text=None):
        file = tmp_path / "my_case.py"
        file.write_text(text or TEMPLATE.format(parameters=parameters, body=body, title=title, probes=probes), encoding="utf-8")
        return file
    return write


def test_defaults_and_sets(write):
    file = write()
    assert load(file).numerics.spacing == 0.1
    assert load(file, ["spacing=0.05"]).numerics.spacing == 0.05
    assert load(str(file), {"spacing": 0.05}).numerics.spacing == 0.05
    assert load(file.with_suffix("")).title == "test"
    assert not list(file.parent.glob("__pycache__"))


@pytest.mark.parametrize("kind, text, value", [
    ("float", "1/24", 1 / 24), ("float", "-1e-3", -1e-3), ("int", "-7", -7), ("bool", "false", False), ("bool", "Yes", True),
    ("str", "1/24", "1/24"), ("float | None", "none", None), ("float | None", "0.5", 0.5), ("Optional[int]", "None", None),
    ("tuple[float, ...]", "(1, 1/2,3)", (1.0, 0.5, 3.0)), ("tuple[int, str]", "1, a", (1, "a")), ("float | str", "x", "x"),
    ("float | str", "2", 2.0), ("tuple[float, float]", "0.1,0.2", (0.1, 0.2)),
])
@pytest.mark.parametrize("future", ["", "from __future__ import annotations\n"])
def test_values_take_the_type_of_the_parameter(write, kind, text, value, future):
    source = future + "from typing import Optional\n" + TEMPLATE.format(
        parameters=f"spacing: float = 0.1, a: {kind} = 0", body="pass", title="repr(a)", probes="()")
    assert load(write(text=source), [f"a={text}"]).title == repr(value)


def test_without_annotation_the_default_tells_the_type(write):
    file = write(parameters="spacing=0.1, n=3", title="repr(n)")
    assert load(file, ["n=4"]).title == "4"


def test_equals_sign_in_a_value(write):
    assert load(write(parameters="spacing: float = 0.1, name: str = ''", title="name"), ["name=a=b"]).title == "a=b"


@pytest.mark.parametrize("sets, message", [
    (["spacin=1"], r"no parameter 'spacin'; did you mean 'spacing'\? Its parameters and their defaults: spacing=0.1"),
    (["spacing"], "must be name=value"),
    (["=1"], "must be name=value"),
    (["spacing=abc"], r"--set spacing=abc: must be a number, as the default 0.1 is"),
    (["spacing=nan"], "must be a number"),
    (["spacing=-1"], r"my_case.py, line 8: Numerics.spacing = -1.0: must be greater than 0"),
    (["spacing=0.3"], r"my_case.py, line 6: numerics.spacing = 0.3: must divide .* nearest that fit are 0.25 and 0.3333"),
])
def test_bad_sets(write, sets, message):
    with pytest.raises(CaseError, match=message):
        load(write(), sets)


@pytest.mark.parametrize("kind, text", [
    ("int", "1.5"), ("bool", "maybe"), ("tuple[float, float]", "1"), ("tuple[float, ...]", "1,b"), ("float | None", "x"), ("dict", "a"),
])
def test_bad_values_name_the_type(write, kind, text):
    with pytest.raises(CaseError, match=r"--set a=.*: must be .* as the default 0 is"):
        load(write(parameters=f"spacing: float = 0.1, a: {kind} = 0"), [f"a={text}"])


@pytest.mark.parametrize("text, message", [
    ("def case(:\n", r"my_case.py, line 1: syntax error"),
    ("x = 1\ny = 1/0\n", r"my_case.py, line 2: ZeroDivisionError"),
    ("import nowhere_to_be_found\n", r"my_case.py, line 1: ModuleNotFoundError"),
    ("x = 1\n", r"has no function case"),
    ("def case():\n    return 3\n", r"returned a int; it must return a Case"),
    ("def case(a):\n    pass\n", r"parameter 'a' of case\(...\) needs a default"),
    ("def case(*a):\n    pass\n", r"parameter 'a' of case\(...\) needs a default"),
    ("def f():\n    return [][1]\n\ndef case():\n    return f()\n", r"my_case.py, line 2: IndexError"),
    ("raise SystemExit(3)\n", r"my_case.py, line 1: SystemExit"),
])
def test_bad_files(write, text, message):
    with pytest.raises(CaseError, match=message) as error:
        load(write(text=text))
    assert "\n" not in str(error.value)


def test_file_that_is_not_text(tmp_path):
    file = tmp_path / "case.py"
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(CaseError, match="case.py"):
        load(file)


def test_missing_file_lists_what_is_there(write, tmp_path):
    write()
    with pytest.raises(CaseError, match=r"no such case file; .* has my_case.py"):
        load(tmp_path / "other.py")
    with pytest.raises(CaseError, match="no such case file"):
        load(tmp_path / "nowhere" / "other.py")
    with pytest.raises(CaseError, match="folder"):
        load(tmp_path)


def test_neighbours_of_the_file_can_be_imported(write, tmp_path):
    (tmp_path / "my_neighbour_numbers.py").write_text("S = 0.2\n", encoding="utf-8")
    source = TEMPLATE.format(parameters="spacing: float = S", body="pass", title="'t'", probes="()")
    assert load(write(text="from my_neighbour_numbers import S\n" + source)).numerics.spacing == 0.2


def test_stored_case(write, tmp_path):
    case = load(write())
    stored = tmp_path / "case.json"
    stored.write_text(case.model_dump_json(), encoding="utf-8")
    assert load(stored) == case
    with pytest.raises(CaseError, match="takes no --set"):
        load(stored, ["spacing=0.05"])
    stored.write_text("{", encoding="utf-8")
    with pytest.raises(CaseError, match="case.json"):
        load(stored)


def test_truth_files_are_found_beside_the_case_and_checked(write, tmp_path):
    probes = "[SurfaceGauge('g', 0.5, Truth('eta.csv', time='t', value='eta'))]"
    file = write(probes=probes)
    with pytest.raises(CaseError, match="probe 'g'.*eta.csv.*cannot be read"):
        load(file)
    data = tmp_path / "eta.csv"
    for text, message in (
        ("t,h\n0,1\n1,2\n", "no column 'eta'; its columns are t, h"), ("t,eta\n0,a\n1,2\n", "not a number"),
        ("t,eta\n0,1\n", "at least two"), ("t,eta\n1,1\n0,1\n", "increasing"), ("t,eta\n0,1\n1,nan\n", "finite"), ("", "no column"),
        ("t,eta\n0,1\n1\n", "not a number"),
    ):
        data.write_text(text, encoding="utf-8")
        with pytest.raises(CaseError, match=message):
            load(file)
    data.write_text("# made up\nt,eta\n0,1\n1,2\n", encoding="utf-8")
    assert load(file).probes[0].truth.file == str(data)


def test_arguments_are_what_load_passes(write):
    file = write(parameters="spacing: float = 0.1, name: str | None = None, at: tuple[float, float] = (1.0, 2.0)")
    assert arguments(file) == {"spacing": 0.1, "name": None, "at": (1.0, 2.0)}
    assert arguments(file, ["spacing=1/40", "at=0,3"]) == {"spacing": 0.025, "name": None, "at": (0.0, 3.0)}
    with pytest.raises(CaseError, match="no parameter 'depth'"):
        arguments(file, {"depth": 1.0})


def test_parameters(write):
    file = write(parameters="spacing: float = 0.1, name: str | None = None")
    assert parameters(file) == {"spacing": (0.1, "a number"), "name": (None, "a text or none")}
