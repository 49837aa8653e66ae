"""The README files are true: their cases and scripts run, their commands, options, files and links exist."""

import ast
import re
import shlex
import sys

import pytest

from parisph import cli, parser
from parisph.case.load import load, parameters
from tests.launch import ROOT, parisph, run, succeeded

README = ROOT / "README.md"
READMES = [README, *(path for folder in ("parisph", "cases", "run_scripts", "tests")
                     for path in sorted((ROOT / folder).rglob("README.md")))]
NAMES = [str(path.relative_to(ROOT)) for path in READMES]
TEXT = "\n".join(path.read_text(encoding="utf-8") for path in READMES)
PYTHON = re.findall(r"^```python\n(.*?)^```", TEXT, flags=re.M | re.S)
SHELL = [line for block in re.findall(r"^```sh\n(.*?)^```", TEXT, flags=re.M | re.S) for line in block.splitlines()]
CODE = re.findall(r"(?<!`)`([^`\n]+)`(?!`)", TEXT)
COMMANDS = [line for line in SHELL if re.search(r"\bparisph ", line)]
LINK = re.compile(r"(?<!`)\[[^\]\n]*\]\(([^)\s]+)\)")


def one(blocks, word):
    """Return the block that holds a word."""
    found = [block for block in blocks if word in block]
    assert len(found) == 1, f"{len(found)} blocks of the README files with {word!r}"
    return found[0]


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A folder with the README's case in it, as a reader would save it."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "sloshing.py").write_text(one(PYTHON, "def case("), encoding="utf-8")
    return folder


def test_case_runs_from_the_shell(first):
    case = load(first / "sloshing.py")
    assert len(one(PYTHON, "def case(").splitlines()) <= 22
    assert f"{case.numerics.spacing:g}" in TEXT
    done = parisph("run", "sloshing.py", "--set", "spacing=0.1", "--set", "end_time=0.1", cwd=first, timeout=200)
    assert done.returncode == 0, done.stderr
    assert "status          completed" in done.stdout and "runs/sloshing" in done.stdout


@pytest.mark.parametrize(("word", "says"), [
    ("study = Study(", "16 runs, 16 to do"), ("study = PatchStudy(", "Gradient beside walls: cube")])
def test_study_can_be_carried_out(tmp_path, word, says):
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    (tmp_path / "study.py").write_text(one(PYTHON, word), encoding="utf-8")
    done = parisph("study", "study.py", "--list", cwd=tmp_path)
    assert done.returncode == 0 and says in done.stdout, done.stderr


def test_script_runs_as_printed(first):
    script = one(PYTHON, "open_run")
    assert '{"end_time": 0.5}' in script
    # the same on fewer particles and for fewer steps
    script = script.replace('{"end_time": 0.5}', '{"end_time": 0.1, "spacing": 0.1}')
    script += (
        "assert summary['status'] == 'completed' and x.shape == u.shape == everywhere['x'].shape and len(p) == len(x)\n"
        "assert deepest > 3e3 and len(t) == len(pressure) == len(iterations) + 2 and "
        "flow.units('tap')['pressure'] == 'Pa'\n"
    )
    (first / "script.py").write_text(script, encoding="utf-8")
    for folder in ("runs/short", "runs/short.old"):    # twice, as a reader may
        succeeded(run([sys.executable, "script.py"], cwd=first, timeout=200))
        assert (first / folder / "summary.json").exists()


@pytest.mark.parametrize("word, check", [
    ("parts.SOURCES.register", "assert parts.SOURCES['weaker'].target"),
    ("EnergyLeft", "from parisph.case.probes import class_of; assert class_of('energy_left') is EnergyLeft"),
])
def test_part_is_registered_as_printed(word, check):
    succeeded(run([sys.executable, "-c", f"{one(PYTHON, word)}\n{check}"], timeout=200))


def test_names_are_offered_by_the_package():
    import parisph as package

    for block in PYTHON:
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and node.module == "parisph":
                assert {name.name for name in node.names} <= set(package.__all__)


@pytest.mark.parametrize("line", COMMANDS)
def test_command_is_understood(line, first):
    words = shlex.split(line, comments=True)
    words = words[words.index("parisph") + 1:]
    args = cli.parse(words)
    if getattr(args, "case", "").endswith(".py"):
        known = parameters(first / args.case if args.case == "sloshing.py" else ROOT / args.case)
        assert {text.partition("=")[0] for text in args.set} <= set(known)


@pytest.mark.parametrize("verb", sorted(set(re.findall(r"(?<!from )\bparisph ([a-z]+)", "\n".join([*CODE, *SHELL])))))
def test_verb_exists(verb):
    assert verb in _verbs()


@pytest.mark.parametrize("option", sorted(set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", " ".join([*CODE, *COMMANDS])))))
def test_option_exists(option):
    assert any(option in verb._option_string_actions for verb in _verbs().values())


def _verbs():
    """Return the verbs of the command line, each with its parser."""
    return next(action for action in parser.build()._actions if action.choices).choices


def test_commands_are_there():
    named = set(re.findall(r"run_scripts/[\w.]+", TEXT))
    assert {"run_scripts/demo", "run_scripts/test", "run_scripts/setup", "run_scripts/dam_break.slurm"} <= named


@pytest.mark.parametrize("path", sorted({
    path.rstrip(".") for path in re.findall(r"(?<![\w/.])(?:parisph|cases|run_scripts|tests)/[\w./]+", TEXT)}))
def test_file_exists(path):
    assert (ROOT / path).exists()


@pytest.mark.parametrize("module", sorted(set(re.findall(r"python -m (tests\.\w+)", TEXT))))
def test_campaign_exists(module):
    assert (ROOT / module.replace(".", "/") / "__main__.py").exists()


def slug(heading):
    """Return the anchor that a heading has on GitHub."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


def links(path):
    """Return the (file, anchor) that a README links to; not pages of the web."""
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
    found = [target.partition("#") for target in LINK.findall(text) if "://" not in target]
    return [((path.parent / name).resolve() if name else path, anchor) for name, _, anchor in found]


@pytest.mark.parametrize("path", READMES, ids=NAMES)
def test_links_lead_somewhere(path):
    for target, anchor in links(path):
        assert target.exists() and ROOT in target.parents, f"{path.relative_to(ROOT)} links to {target}"
        if anchor:
            headings = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), flags=re.M)
            assert anchor in map(slug, headings), f"{path.relative_to(ROOT)} links to {target.name}#{anchor}"


def test_every_readme_is_linked_from_the_first():
    seen, new = set(), {README}
    while new:
        seen |= new
        new = {target for path in new for target, _ in links(path) if target.name == "README.md"} - seen
    assert seen == set(READMES)


def test_figures_of_the_cases_are_those_that_their_pages_name():
    """The figures of a scene in both papers, as the table of the cases and the scene itself have them."""
    papers, found = {"Z14": "Zheng, Ma & Duan (2014)", "Z17": "Zheng et al. (2017)"}, 0
    for name, figures in re.findall(r"^\| `(\w+)\.py`: [^|]*\| (Z1[47] [^|]*) \|",
                                    (ROOT / "cases" / "README.md").read_text(encoding="utf-8"), re.MULTILINE):
        paper, _, places = figures.partition(" ")
        assert f"{papers[paper]}, {places}" in load(ROOT / "cases" / f"{name}.py").source, name
        found += 1
    assert found == 10


def test_readme_is_short_and_shows_a_picture():
    text = README.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 150
    pictures = [README.parent / name for name in re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)]
    assert pictures and all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    assert all(picture.stat().st_size < 150_000 for picture in pictures)


@pytest.mark.parametrize(("heading", "anchor"), [
    ("Limits in numbers", "limits-in-numbers"), ("Set-up", "set-up"), ("The `Case`, and (a)", "the-case-and-a"),
])
def test_slug_is_that_of_github(heading, anchor):
    assert slug(heading) == anchor
