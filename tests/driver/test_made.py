"""How a run was made is in its files, in `info` and in the report, and is no part of the case or its digest."""

import hashlib
import html
import json
import re

import pytest

from parisph import Roll, StoreError, load
from parisph.base.json_digest import with_digest, without_digest
from parisph.case.stored import from_json, to_json
from parisph.io import info
from parisph.io.files import read_json
from parisph.io.reader import open_run
from parisph.report import conditions, page
from tests.launch import ROOT, parisph
from tests.scenes import restart_alone, run_alone

FILE = """
from parisph import Airy, Box, Case, Energy, Fluid, Numerics, Sway, Tank
def case(depth: float = 0.5, amplitude: float = 0.01, preset: str = "gentle", pair: tuple[float, float] = (1.0, 2.0)):
    return Case(title="Swayed", fluid=Fluid(Box(width=1.0, height=depth), density=1e3),
                walls=Tank(width=1.0, height=0.75), frame=Sway(amplitude, 4.0), gravity=(0.0, -9.81),
                numerics=Numerics(spacing=0.125, preset=preset, time_step=0.01), probes=[Energy("energy")],
                end_time=0.02)
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a case file, its run by the command line, and a run of the case.json of that run."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "swayed.py").write_text(FILE)
    parisph("run", "swayed.py", "--set", "amplitude=0.03", "-o", "first", "-q", cwd=folder)
    run_alone(load(folder / "first" / "case.json"), folder / "second")
    return folder


def test_the_files_tell_case_file_parameters_date_machine_and_command(place):
    made = json.loads((place / "first" / "case.json").read_text())["made"]
    assert made["parameters"] == {"depth": 0.5, "amplitude": 0.03, "preset": "gentle", "pair": [1.0, 2.0]}
    assert made["given"] == ["amplitude"] and made["case_file"] == "swayed.py" and made["ranks"] == 1
    assert made["case_digest"] == hashlib.blake2b(FILE.encode(), digest_size=16).hexdigest()
    assert re.fullmatch(r"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00", made["date"]) and made["host"] and made["cores"] >= 1
    assert made["command"] == "parisph run swayed.py --set amplitude=0.03 -o first -q"
    run = open_run(place / "first")
    assert run.made == made
    told = info.describe(run)
    assert "parameters      depth = 0.5, amplitude = 0.03 (given), preset = gentle" in told
    assert "case file       swayed.py, digest " in told and f"made            {made['date']} on " in told


def test_a_run_of_a_stored_case_says_so_and_keeps_the_parameters(place):
    made = open_run(place / "second").made
    assert made["parameters"]["amplitude"] == 0.03 and made["case_file"].endswith("first/case.json")
    assert made["repeats"]["run"] == open_run(place / "first").identity and not made["edited"]
    assert made["repeats"]["case_file"] == "swayed.py"
    log = (place / "second" / "run.log").read_text()
    assert re.search("the case is that of the run [0-9a-f]{16} in .*first/case.json, which swayed.py has made\n", log)


def test_a_run_that_no_case_file_has_made_is_repeated(place, tmp_path):
    """As that of a script, or of an earlier release."""
    run_alone(load(place / "swayed.py").of({}), tmp_path / "first")
    run_alone(load(tmp_path / "first" / "case.json"), tmp_path / "second")
    log = (tmp_path / "second" / "run.log").read_text()
    assert re.search("the case is that of the run [0-9a-f]{16} in .*first/case.json\n", log)
    assert "made by an unknown case file" in info.describe(open_run(tmp_path / "second"))


def test_it_is_no_part_of_the_case_and_of_its_digest(place):
    own, again = load(place / "swayed.py", ["amplitude=0.03"]), load(place / "first" / "case.json")
    assert own.origin["given"] == ["amplitude"] and own == own.of({}) and to_json(own) == to_json(own.of({}))
    assert again.resolved(own.complete_numerics()).model_dump() == own.resolved(own.complete_numerics()).model_dump()
    assert own.changed(end_time=1.0).origin["changed"] == ["end_time"]
    made = [with_digest({"run": "a", "title": "b", "made": {"date": date}}) for date in ("now", "then")]
    assert made[0]["digest"] == made[1]["digest"] and [without_digest(one)[1] for one in made] == [True, True]
    made[0]["made"]["date"] = "never"
    assert not without_digest(made[0])[1]


@pytest.mark.parametrize("made", [
    None, 3, [], "x", {}, {"parameters": 3, "given": 4, "restarts": [1, {}], "repeats": 7, "changed": {}}])
def test_what_is_no_record_is_passed_over(place, tmp_path, made):
    content = {**read_json(place / "first" / "case.json"), "made": made}
    assert from_json(json.dumps(content)).title == "Swayed"
    (tmp_path / "case.json").write_text(json.dumps(content))
    run = open_run(tmp_path)
    assert "Swayed" in info.describe(run) and load(tmp_path / "case.json").origin["edited"]
    assert conditions.parameters(run.case).rows == () and conditions.making(run.case, {}).rows


def test_a_restart_adds_itself_and_the_record_survives_the_loss_of_case_json(place):
    second = place / "second"
    before = open_run(second).made
    (second / "case.json").unlink()
    restart_alone(second, until=0.03)
    made = open_run(second).made
    assert {**before, "restarts": made["restarts"]} == made and len(made["restarts"]) == 1
    assert made["restarts"][0]["date"] >= before["date"] and "restarted " in info.describe(open_run(second))
    text = (second / "case.json").read_text()
    (second / "case.json").write_text(text.replace(before["date"], "2001-01-01"))
    with pytest.raises(StoreError, match="does not match its digest"):
        open_run(second)
    (second / "case.json").write_text(text)


def test_the_report_has_the_physics_first_and_versions_last(place):
    text = html.unescape(page.write(place / "first").read_text())
    places = [text.index(f"<td>{name}</td>") for name in (
        "tank, width", "tank, height", "fluid, depth", "motion of the tank, in whose frame the flow is, amplitude",
        "spacing", "particles", "duration", "steps", "method", "amplitude", "case file", "machine",
        "PETSc options", "numpy")]
    assert places == sorted(places)
    assert places[-5] < text.index("<details>") < places[-4]
    cells = dict(re.findall(r'data-from="case.json: (.*?)" title=".*?">(.*?)</td>', text))
    told = {"walls/width": "1 m", "walls/height": "0.75 m", "fluid/shape/height": "0.5 m", "frame/amplitude": "0.03 m",
            "frame/frequency": "4 rad/s", "end_time": "0.02 s", "made/parameters/amplitude": "0.03",
            "made/case_file": "swayed.py"}
    assert {name: cells[name] for name in told} == told


def test_waves_are_told_with_height_period_and_length():
    rows = {row[0].text: row[1].text for row in conditions.conditions(
        json.loads(load(ROOT / "cases" / "submerged_bar.py").model_dump_json()), {}).rows}
    told = {"fluid, level": "0.4 m", "wave of piston": "stream_function", "wave of piston, height": "0.02 m",
            "wave of piston, period": "2.02 s", "wave of piston, length": "3.74 m"}
    assert {name: rows[name] for name in told} == told


def test_parameters_that_json_lacks_are_kept_as_text(tmp_path):
    (tmp_path / "dam.py").write_text(FILE.replace("pair: tuple[float, float] = (1.0, 2.0)", "stop=(1.0, float('inf'))"))
    case = load(tmp_path / "dam.py")
    assert json.loads(json.dumps(case.origin, allow_nan=False))["parameters"]["stop"] == [1.0, "inf"]


def test_the_amplitude_of_a_roll_is_an_angle(place):
    case = load(place / "swayed.py").changed(frame=Roll(amplitude=0.07, period=2.0))
    rows = {row[0].text: row[1].text for row in conditions.conditions(json.loads(case.model_dump_json()), {}).rows}
    frame = "motion of the tank, in whose frame the flow is"
    assert (rows[frame], rows[f"{frame}, amplitude"], rows[f"{frame}, period"]) == ("roll", "0.07 rad", "2 s")
