"""A restart takes edits of case.json that change no result, and refuses all others before it touches anything."""

import json
import shutil

import pytest

from parisph import CaseError, StoreError
from parisph.io.reader import open_run
from tests.launch import contents
from tests.scenes import restart_alone, run_alone, scene

END = 0.02


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """The folder of a run of ten steps."""
    folder = tmp_path_factory.mktemp("edited") / "run"
    case = scene("dam_break", spacing=0.25).changed(**{"end_time": END, "numerics.time_step": 0.002,
                                                       "output.every": 0.01})
    run_alone(case, folder)
    return folder


@pytest.fixture
def run(ended, tmp_path):
    return shutil.copytree(ended, tmp_path / "run")


def edit(run, /, seal=False, **values):
    """Edit case.json as by hand; seal : whether the line with the digest stays. Return the new text."""
    content = json.loads((run / "case.json").read_text())
    for name, value in values.items():
        *path, last = name.split("__")
        part = content
        for key in path:
            part = part[int(key) if key.isdecimal() else key]
        part[last] = value
    if not seal:
        del content["digest"]
    text = json.dumps(content, indent=1)
    (run / "case.json").write_text(text)
    return text


def test_edits_of_end_and_output_are_taken_and_the_edited_text_is_kept(run):
    text = edit(run, end_time=0.03, title="Longer", output__every=0.005)
    restart_alone(run)
    found = open_run(run)
    assert found.case["end_time"] == 0.03 and found.case["title"] == "Longer" and found.steps["time"][-1] > 0.0295
    assert [round(time, 9) for time in found.times] == [0.0, 0.01, 0.02, 0.024, 0.03]    # of the nearest steps
    assert (run / "replaced" / "1" / "case.json").read_text() == text
    log = (run / "run.log").read_text()
    assert f"{run}/case.json was edited, and the restart goes on with end_time = 0.03" in log
    assert f"has no digest, as after an edit: it is written again, and a copy is in {run}/replaced/1" in log
    with pytest.raises(CaseError, match="ask for more with --until"):    # the edit has become the run's own case
        restart_alone(run)


@pytest.mark.parametrize("values", [
    {"end_time": 7.0}, {"output__every": None}, {"output__times": [0.018]}, {"output__checkpoint_every": 1.0},
    {"made": None}, {"made": [1]}, {"made__parameters": {"end_time": 7}},
])
def test_until_goes_before_an_edited_end_and_other_edits_that_are_taken(run, values):
    edit(run, **values)
    assert restart_alone(run, until=0.024)["time"] == pytest.approx(0.024)


@pytest.mark.parametrize(("values", "says"), [
    ({"fluid__density": 900.0}, r"fluid.density = 900.0 \(was 1000.0\)"),
    ({"numerics__spacing": 0.2}, r"numerics.spacing = 0.2 \(was [0-9.]+\)"),
    ({"numerics__cfl": 0.1, "asked__cfl": 0.1}, r"numerics.cfl = 0.1 \(was [0-9.]+\)"),
    ({"probes": []}, r"probes = \(\) \(was "), ({"probes__0__name": "Q"}, r"probes.0.name = 'Q' \(was 'P1'\)"),
    ({"gravity": [0.0, -1.6], "end_time": 1.0}, "gravity = .*-1.6"), ({"output__budget": True}, "output.budget = True"),
])
@pytest.mark.parametrize("elsewhere", [False, True])
def test_other_edits_are_refused_with_two_remedies(run, tmp_path, values, says, elsewhere):
    edit(run, **values)
    before = contents(run, but="run.log")
    with pytest.raises(CaseError, match=f"(?s)case.json was edited: {says}.*\\.\nA restart takes edits of end_time, "
                                        ".*from its start: parisph run .*case.json -o DIR\n.*move"):
        restart_alone(run, until=0.03, out=tmp_path / "other" if elsewhere else None)
    assert contents(run, but="run.log") == before and not (tmp_path / "other").exists()


def test_the_remedies_of_a_refusal_work(run, tmp_path):
    edit(run, fluid__density=900.0, end_time=0.004)
    from parisph import load
    assert load(run / "case.json").density == 900.0
    (run / "case.json").rename(tmp_path / "mine.json")
    restart_alone(run, until=0.022)
    assert open_run(run).case["fluid"]["density"] == 1000.0


def test_a_digest_that_does_not_fit_says_what_to_do(run):
    edit(run, seal=True, end_time=0.03)
    before = contents(run, but="run.log")
    with pytest.raises(StoreError, match='does not match its digest, or it was edited: then remove the line "digest"'):
        restart_alone(run)
    assert contents(run, but="run.log") == before
    edit(run)    # as it says
    assert restart_alone(run)["time"] == pytest.approx(0.03)


def test_what_parisph_wrote_itself_is_no_edit(run):
    """A run that was killed after its restart has written the new end, and before its first checkpoint."""
    from parisph.base.json_digest import with_digest
    content = json.loads((run / "case.json").read_text())
    (run / "case.json").write_text(json.dumps(with_digest({**content, "end_time": 0.024})))
    assert restart_alone(run)["time"] == pytest.approx(0.024)
    assert not (run / "replaced" / "1" / "case.json").exists()


@pytest.mark.parametrize(("values", "says"), [
    ({"fluid__shape__height": -1.0}, "height"), ({"salt": 3}, "salt"), ({"end_time": "long"}, "end_time"),
    ({"output__every": -1.0}, "every"), ({"schema": 99}, "schema"), ({"schema": None}, "schema"),
    ({"run": "another"}, "run"), ({"asked__preset": "gentle"}, "preset"),
    ({"end_time": 1e-3}, "case.json: .*end_time = 0.001 s"),
    ({"end_time": 0.01}, "is of 0.02 s already")])
def test_an_edit_that_is_wrong_is_named(run, values, says):
    edit(run, **values)
    before = contents(run, but="run.log")
    with pytest.raises((CaseError, StoreError), match=says):
        restart_alone(run)
    assert contents(run, but="run.log") == before


def test_the_line_of_the_digest_can_be_removed_as_the_message_says(run):
    path = run / "case.json"
    lines = path.read_text().splitlines(keepends=True)
    kept = [line.replace('"end_time": 0.02', '"end_time": 0.03') for line in lines if '"digest":' not in line]
    assert len(kept) == len(lines) - 1 and kept != [line for line in lines if '"digest":' not in line]
    path.write_text("".join(kept))
    restart_alone(run)
    assert open_run(run).case["end_time"] == 0.03
