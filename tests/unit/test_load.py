"""Case files: found, run with --set, and their errors told with file and line."""

import os

import pytest

from parisph import CaseError, load
from parisph.base.text import is_plain
from parisph.case.load import arguments, parameters
from parisph.study import set_words

TEMPLATE = '''"""A case."""
from parisph import Box, Case, Fluid, Numerics, ProbeArray, Profiles, SurfaceGauge, Tank, Truth

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
        file.write_text(text or TEMPLATE.format(parameters=parameters, body=body, title=title, probes=probes),
                        encoding="utf-8")
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
    ("float", "1/24", 1 / 24), ("float", "-1e-3", -1e-3), ("int", "-7", -7), ("bool", "false", False),
    ("bool", "Yes", True), ("str", "1/24", "1/24"), ("float | None", "none", None), ("float | None", "0.5", 0.5),
    ("Optional[int]", "None", None), ("tuple[float, ...]", "(1, 1/2,3)", (1.0, 0.5, 3.0)),
    ("tuple[int, str]", "1, a", (1, "a")), ("float | str", "x", "x"), ("float | str", "2", 2.0),
    ("tuple[float, float]", "0.1,0.2", (0.1, 0.2)),
])
@pytest.mark.parametrize("future", ["", "from __future__ import annotations\n"])
def test_values_take_the_type_of_the_parameter(write, kind, text, value, future):
    source = future + "from typing import Optional\n" + TEMPLATE.format(
        parameters=f"spacing: float = 0.1, a: {kind} = 0", body="pass", title="repr(a)", probes="()")
    assert load(write(text=source), [f"a={text}"]).title == repr(value)


@pytest.mark.parametrize("text, rule", [("none", "none"), ("None", "none"), ("gap", "gap"), ("", None)])
def test_none_is_a_word_where_it_is_one(write, text, rule):
    """No text gives what the preset has."""
    file = write(parameters="spacing: float = 0.1, surface_rule: str | None = 'gap'", title="repr(surface_rule)")
    assert load(file, [f"surface_rule={text}"]).title == repr(rule)
    assert set_words.value("surface_rule", text) == rule
    assert set_words.value("kappa", "none") is None


@pytest.mark.parametrize("parameter, text, value", [
    ("name=3", "name=4", "4"), ("name: str = ''", "name=a=b", "'a=b'")])
def test_type_of_the_default_and_equals_sign_in_a_value(write, parameter, text, value):
    assert load(write(parameters=f"spacing=0.1, {parameter}", title="repr(name)"), [text]).title == value


@pytest.mark.parametrize("sets, message", [
    (["spacin=1"], r"no parameter 'spacin'; did you mean 'spacing'\? Its parameters and their defaults: spacing=0.1"),
    (["spacing"], "must be name=value"), (["=1"], "must be name=value"),
    (["spacing=abc"], r"--set spacing=abc: must be a number, as the default 0.1 is \('abc' is not a number; "
                      r"write one such as 0.02, 1/40 or 2\*pi\)$"),
    (["spacing=none"], r"--set spacing=none: must be a number, as the default 0.1 is \(none is not allowed here\)$"),
    (["spacing=sine(1)"], r"unknown function in 'sine\(1\)'; known are sin, cos, tan, sinh, cosh, tanh, exp, log, "
                          r"sqrt, abs, minimum, maximum, where\)$"),
    (["spacing=nan"], "must be a number"),
    (["spacing=-1"], r"my_case.py, line 8: Numerics.spacing = -1.0: must be greater than 0"),
    (["spacing=0.1", "spacing=0.2"], "--set spacing is given twice: 0.1 and 0.2"),
    (["x" * 9999 + "=1"], r"no parameter 'x*[.]{3}x*'"),
    (["spacing=" + "9" * 9999], r"--set spacing=9*[.]{3}9*: must be a number"),
    (["n=" + "9" * 9999], "must be a whole number"), (["odd=1"], "a parameter of type .* cannot be set from text"),
])
def test_bad_sets(write, sets, message):
    with pytest.raises(CaseError, match=message) as error:
        load(write(parameters="spacing: float = 0.1, n: int = 1, odd: [1, 2] = 3"), sets)
    assert len(str(error.value)) < 1000


@pytest.mark.parametrize("kind, text", [
    ("int", "1.5"), ("bool", "maybe"), ("tuple[float, float]", "1"), ("tuple[float, ...]", "1,b"),
    ("float | None", "x"), ("dict", "a"),
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
    ("def case(*a):\n    pass\n", r"the parameter \*a of case\(...\) cannot be set by name"),
    ("def case(a, /):\n    pass\n", r"the parameter a of case\(...\) cannot be set by name"),
    ("case = {}\n", r"`case` is a dict, not a plain function; write: def case\(...\) -> Case"),
    ("async def case():\n    pass\n", "`case` is a function, not a plain function"),
    ("case = dict.fromkeys\n", "the parameter iterable of case.* cannot be set by name"),
    ("case = min\n", "`case` is <built-in function min>, whose parameters cannot be found"),
    ("class case:\n    pass\n", "returned a case; it must return a Case"),
    ("import functools\ncase = functools.partial(dict, a=1)\n", "whose parameters cannot be found|returned a dict"),
    ("class Own(BaseException):\n    pass\ndef case():\n    raise Own('mine')\n", r"my_case.py, line 4: Own: mine"),
    ("def case():\n    raise GeneratorExit\n", r"my_case.py, line 2: GeneratorExit$"),
    ("class Mute(Exception):\n    def __str__(self):\n        raise ValueError\nraise Mute\n",
     r"line 4: Mute: its message cannot be shown"),
    ("def case():\n    raise ValueError('a\\n' * 5000)\n", r"line 2: ValueError: a a a.*[.]{3}"),
    ("def case():\n    return case()\n", "line 2: RecursionError"),
    ("def case():\n    raise MemoryError\n", "line 2: MemoryError$"),
    ("def __getattr__(name):\n    raise SystemExit\n", "has no function case"),
    ("class Liar:\n    @property\n    def __class__(self):\n        raise SystemExit(3)\ndef case():\n"
     "    return Liar()\n", "line 4: SystemExit|returned a Liar"),
    ("class Own(type):\n    @property\n    def __name__(cls):\n        raise SystemExit\n"
     "class It(metaclass=Own):\n    pass\ndef case():\n    return It()\n", "returned a It; it must"),
    ("class Own(type):\n    @property\n    def __name__(cls):\n        raise SystemExit\n"
     "class It(Exception, metaclass=Own):\n    pass\nraise It('mine')\n", "line 7: It: mine"),
    ("class End(Exception):\n    def __str__(self):\n        raise SystemExit\nraise End\n",
     "line 4: End: its message cannot be shown"),
    ("class End:\n    def __repr__(self):\n        raise SystemExit\ndef case(*, a=End(), **b):\n    pass\n",
     r"the parameter \*\*b of"),
    ("class End:\n    @property\n    def __signature__(self):\n        raise SystemExit\n"
     "    def __call__(self):\n        pass\ncase = End()\n", "line 4: SystemExit|whose parameters cannot be found"),
    ("def case(a: 'exit()' = 1):\n    return a\n", "returned a int"),
    ("import sys\ndel sys.path[0]\n", "has no function case"),
    ("x = '\0'\n", "it is not text: see character 5"),
    ("(" * 5000, "syntax error|MemoryError|RecursionError"),
    ("def f():\n    return [][1]\n\ndef case():\n    return f()\n", r"my_case.py, line 2: IndexError"),
    ("raise SystemExit(3)\n", r"my_case.py, line 1: SystemExit"),
])
def test_bad_files(write, text, message):
    with pytest.raises(CaseError, match=message) as error:
        load(write(text=text))
    assert "\n" not in str(error.value)


def test_a_partial_and_an_object_serve_as_case(write):
    source = TEMPLATE.format(parameters="spacing: float = 0.1, name: str = 'a'", body="pass", title="name", probes="()")
    partial = write(text=source + "\nimport functools\ncase = functools.partial(case, name='b')\n")
    assert load(partial).title == "b" and load(partial, ["spacing=1/20"]).numerics.spacing == 0.05
    made = ("\nof = case\nclass Scene:\n    def __call__(self, spacing: float = 0.1):\n        return of(spacing)\n"
            "case = Scene()\n")
    assert load(write(text=source + made), ["spacing=1/20"]).numerics.spacing == 0.05


def test_an_interruption_inside_a_case_stays_one(write):
    for text in ("raise KeyboardInterrupt\n", "def case():\n    raise KeyboardInterrupt\n"):
        with pytest.raises(KeyboardInterrupt):
            load(write(text=text))


@pytest.mark.parametrize("name, message", [
    ("", "CASE = '': must not be empty"), (" ", "must not be empty"),
    ("a\nb.py", r"CASE = 'a\\nb.py': must be text without line breaks"), ("a\0.py", "without line breaks or control"),
    ("\udcff.py", "without line breaks or control"), ("x" * 300 + ".py", "is too long: a name has at most 255 bytes"),
    ("x/" * 3000, "is too long: .* a path 4095"), (".", "is a folder; give a case file"),
    ("/dev/null", "is not a regular file"), ("pipe", "is not a regular file"), (3, "must be a text or a pathlib.Path"),
    (None, "must be a text"),
])
def test_odd_names(tmp_path, monkeypatch, name, message):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    with pytest.raises(CaseError, match=message) as error:
        load(name)
    assert len(str(error.value)) < 400 and is_plain(str(error.value))


def test_a_byte_order_mark_is_no_part_of_a_case(write):
    file = write()
    file.write_text("\ufeff" + file.read_text(encoding="utf-8"), encoding="utf-8")
    assert load(file).title == "test"


@pytest.mark.parametrize("content, size, says", [
    (b"", 10**12, "case.py: cannot be read: it has 1 TB, at most 16 MB are read"), (b"\xff\xfe\x00", 3, "case.py")])
def test_a_case_file_has_a_size_and_is_text(tmp_path, content, size, says):
    file = tmp_path / "case.py"
    file.write_bytes(content)
    os.truncate(file, size)
    with pytest.raises(CaseError, match=says):
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
        ("t,h\n0,1\n1,2\n", "truth.value = 'eta': .* has no such column; it has t, h"),
        ("t,eta\n0,a\n1,2\n", "line 2 holds something that is not"), ("t,eta\n0,1\n", "at least two"),
        ("t,eta\n1,1\n0,1\n", "increasing"), ("t,eta\n0,1\n1,nan\n", "line 3 .* finite"),
        ("", "no line with the names of columns"), ("t,eta\n0,1\n1\n", "line 3 has 1 value, and there are 2 columns"),
        ("t,eta,t\n0,1,2\n1,2,3\n", "two columns are named 't'"), ("t,eta,\n0,1,\n1,2,\n", "column 3 has no name"),
        ("t,eta\n0,1e200\n1,2\n", "line 2 .* finite number of at most 1e.30"),
        ("t,eta\n0,\"1\n1,2\n", "line 2 is not one of a CSV file"), ("t,eta\n0,1\0\n1,2\n", "it is not text"),
        ("t,eta\n0," + "1" * 10**6, "line 2 is not one of a CSV file|finite"),
    ):
        data.write_text(text, encoding="utf-8")
        with pytest.raises(CaseError, match=message):
            load(file)
    data.write_text("# made up\nt,eta\n0,1\n1,2\n", encoding="utf-8")
    assert load(file).probes[0].truth.file == str(data)
    both = "Truth('eta.csv', time='t', value='eta', others=(Truth('other.csv', 't', 'eta', name='other'),))"
    file = write(probes=f"[SurfaceGauge('g', 0.5, {both})]")
    with pytest.raises(CaseError, match="other.csv.*cannot be read"):
        load(file)
    (tmp_path / "other.csv").write_text(data.read_text())
    assert load(file).probes[0].truth.others[0].file == str(tmp_path / "other.csv")


def test_files_of_further_profiles_are_found_and_checked_too(write, tmp_path):
    columns = "time='t', x='x', value='eta'"
    for others, message in ((f"Profiles('b.csv', {columns}, name='b')", "probe 'g'.*b.csv.*cannot be read"),
                            (f"Profiles('b.csv', {columns})", "others have the names")):
        truth = f"Profiles('a.csv', {columns}, others=({others},))"
        file = write(probes=f"[ProbeArray('g', [SurfaceGauge('x', 0.5)], truth={truth})]")
        (tmp_path / "a.csv").write_text("t,x,eta\n0,0,1\n0,1,1\n")
        with pytest.raises(CaseError, match=message):
            load(file)
    (tmp_path / "b.csv").write_text((tmp_path / "a.csv").read_text())
    file = write(probes=f"[ProbeArray('g', [SurfaceGauge('x', 0.5)], truth="
                        f"Profiles('a.csv', {columns}, others=(Profiles('b.csv', {columns}, name='b'),)))]")
    truth = load(file).probes[0].truth
    assert [truth.file, truth.others[0].file] == [str(tmp_path / name) for name in ("a.csv", "b.csv")]


def test_a_truth_shows_little_of_a_file_that_is_none(write, tmp_path):
    secret = "secret" * 1000
    (tmp_path / "eta.csv").write_text(secret + "," + "b" * 9999 + "\n1,2\n", encoding="utf-8")
    with pytest.raises(CaseError) as error:
        load(write(probes="[SurfaceGauge('g', 0.5, Truth('eta.csv', time='t', value='eta'))]"))
    assert "it has secret" in str(error.value) and len(str(error.value).partition("it has ")[2]) <= 80


@pytest.mark.parametrize("name, message", [
    (".", "it is a folder"), ("/dev/zero", "it is not a regular file"), ("pipe", "it is not a regular file"),
    ("loop", "loop|symbolic links"), ("big", "at most 16 MB are read"), ("x" * 300, "is too long"),
    ("", "it is a folder"),
])
def test_a_truth_is_a_regular_file_of_some_size(write, tmp_path, name, message):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    with open(tmp_path / "big", "wb") as empty:
        empty.truncate(10**12)
    with pytest.raises(CaseError, match=f"probe 'g': truth.file = .*({message})"):
        load(write(probes=f"[SurfaceGauge('g', 0.5, Truth({name!r}, time='t', value='eta'))]"))


def test_arguments_are_what_load_passes(write):
    file = write(parameters="spacing: float = 0.1, name: str | None = None, at: tuple[float, float] = (1.0, 2.0)")
    assert arguments(file) == {"spacing": 0.1, "name": None, "at": (1.0, 2.0)}
    assert arguments(file, ["spacing=1/40", "at=0,3"]) == {"spacing": 0.025, "name": None, "at": (0.0, 3.0)}
    with pytest.raises(CaseError, match="no parameter 'depth'"):
        arguments(file, {"depth": 1.0})


def test_parameters(write):
    file = write(parameters="spacing: float = 0.1, name: str | None = None")
    assert parameters(file) == {"spacing": (0.1, "a number"), "name": (None, "a text or none")}
