"""Cases as stored: their schema version, and what was asked for beside what it was resolved to."""

import json

import pytest

from parisph import Box, PressureTap, Tank
from parisph.base.errors import CaseError
from parisph.case.presets import PRESETS
from parisph.case.stored import SCHEMA, from_json, to_json
from tests.scenes import scene


def stored(**numerics):
    """Return a case as a run stores it: resolved, through JSON and back."""
    case = scene("small_sloshing", numerics, time_step=0.064)    # which the violent preset allows too
    return from_json(to_json(case.resolved(case.numerics.resolved())))


def test_a_case_comes_back_as_it_was():
    case = stored()
    assert json.loads(to_json(case))["schema"] == SCHEMA
    assert from_json(to_json(case)) == case
    assert from_json(case.model_dump_json()) == case    # from before schemas had versions


@pytest.mark.parametrize("text, says", [
    ("", "not a stored case"), ("[]", "contains a list"), ('{"schema": "x"}', "must be a whole number"),
    ('{"schema": true}', "whole number"),
    (f'{{"schema": {SCHEMA + 1}}}', "written by a newer parisph; this one reads up to schema"),
    ("{}", "Case.title is missing"), ('{"title": "a", "title": "b"}', "'title' is given twice"),
    ('{"fluid": {"density": 1, "density": 2}}', "'density' is given twice"), ("[" * 10**5, "not a stored case"),
    ('{"end_time": ' + "9" * 10**4 + "}", "not a stored case: Exceeds the limit"),
])
def test_what_is_no_case_of_this_release_is_said(text, says):
    with pytest.raises(CaseError, match=says):
        from_json(text)


@pytest.mark.parametrize(("asked", "old", "preset"), [(True, {"preset": "gentle"}, "violent"), (False, {}, "gentle")])
def test_another_preset_replaces_what_the_old_one_gave(asked, old, preset):
    """Also of a case from before asked values were stored."""
    content = json.loads(to_json(stored(kappa=0.4, **old)))
    if not asked:
        del content["schema"], content["asked"]
    found = from_json(json.dumps(content)).changed(**{"numerics.preset": preset}).numerics.resolved()
    due = {**PRESETS[preset], "kappa": 0.4}
    assert {name: getattr(found, name) for name in due} == due


@pytest.mark.parametrize(("schema", "later"), [
    (1, ("kappa_strain", "shift_strain", "filter_strain", "fall", "surface_offset", "residual_strain",
         "pressure_mean", "volume_time")),
    (2, ("residual_strain", "pressure_mean", "volume_time")),
])
def test_an_older_case_keeps_its_strengths(schema, later):
    """What has a name of its own only since then did not exist."""
    content = json.loads(to_json(stored(preset="violent", kappa=0.2)))
    for part in ("numerics", "asked"):
        for name in (*later, "regularisers"):
            del content[part][name]
    found = from_json(json.dumps({**content, "schema": schema})).numerics.resolved()
    assert found.kappa == 0.2 and found.kappa_strain == (0.0 if schema == 1 else 56.0)
    assert "filter" in found.regularisers and "film" not in found.regularisers
    assert {name: getattr(found, name) for name in later} == dict.fromkeys(later, 0.0)


def test_an_older_case_keeps_its_taps():
    """A tap took the wall particles beside it before it had a face."""
    case = stored(preset="violent").changed(probes=[PressureTap("old", (0.0, 0.1)),
                                                    PressureTap("own", (0.0, 0.1), radius=0.2)])
    content = json.loads(to_json(case))
    assert [probe.radius for probe in from_json(json.dumps(content)).probes] == [None, 0.2]
    del content["probes"][0]["radius"]
    assert [probe.radius for probe in from_json(json.dumps(content)).probes] == [case.numerics.spacing, 0.2]


def test_other_changes_keep_what_was_resolved(monkeypatch):
    """A preset of a later release with other numbers does not change what a stored run computes."""
    case = stored(preset="violent")
    before = PRESETS["violent"]["filter"]
    monkeypatch.setitem(PRESETS["violent"], "filter", 0.5)
    for change in ({"end_time": 1.0}, {"numerics.cfl": 0.3}, {"numerics.kappa": 0.1}):
        found = from_json(to_json(case.changed(**change)))
        assert found.numerics.resolved().filter == before
        again = found.resolved(found.numerics.resolved())
        assert again.asked.filter is None
    assert case.changed(**{"numerics.kappa": 0.1}).asked.kappa == 0.1


@pytest.mark.parametrize("name, value, says", [
    ("preset", "gentle", "numerics.preset = 'gentle', but asked.preset = 'violent': change it in \"asked\""),
    ("kappa", 0.1, "numerics.kappa = 0.1, but asked.kappa = 0.4: edit both equally"),
    ("spacing", 0.0125, "numerics.spacing = 0.0125, but asked.spacing = 0.025: edit both equally"),
    ("max_time_step", 0.01, "numerics.max_time_step = 0.01, but asked.max_time_step = None: edit both equally"),
])
def test_an_edit_of_one_of_two_values_is_refused(name, value, says):
    content = json.loads(to_json(stored(preset="violent", kappa=0.4, spacing=0.025, time_step=None)))
    content["numerics"][name] = value
    with pytest.raises(CaseError, match=says):
        from_json(json.dumps(content))
    assert from_json(json.dumps(content), read_only=True)    # the results of the run can still be looked at
    content["asked"][name] = value
    content["numerics"] = content.pop("asked")    # as the message says for a preset
    found = from_json(json.dumps(content)).numerics
    assert getattr(found, name) == value and (name == "kappa" or found.resolved().kappa == 0.4)
    assert found.resolved().collision_distance == PRESETS[found.preset]["collision_distance"]


def test_a_value_of_the_preset_may_be_edited():
    content = json.loads(to_json(stored()))
    content["numerics"]["shift"] = 0.1
    assert from_json(json.dumps(content)).numerics.shift == 0.1


def test_the_weight_of_the_divergence_and_its_time_replace_each_other():
    case = stored()
    assert case.numerics.zeta == 1.0 and case.numerics.zeta_time == 0.0
    relaxed = case.changed(**{"numerics.zeta_time": 0.04}).numerics.resolved()
    assert (relaxed.zeta, relaxed.zeta_time) == (None, 0.04)
    fixed = stored().changed(**{"numerics.zeta": 0.5}).numerics.resolved()
    assert (fixed.zeta, fixed.zeta_time) == (0.5, 0.0)
    # as it is asked for
    with pytest.raises(CaseError, match="zeta = 0.5 and zeta_time = 0.04: give only one") as found:
        stored(zeta_time=0.04).changed(**{"numerics.zeta": 0.5})
    assert str(found.value).count("give only one") == 1


def test_a_full_tank_that_is_no_longer_full_has_a_surface():
    case = scene("hydrostatic").changed(walls=Tank(width=1.0, height=0.5, lid=True), fluid={
        "shape": Box(width=1.0, height=0.5).model_dump(), "density": 1000.0}, probes=())
    assert case.closed
    closed = from_json(to_json(case.resolved(case.numerics.resolved().model_copy(update={"surface_rule": "none"}))))
    opened = closed.changed(walls=Tank(width=1.0, height=1.0))
    assert opened.numerics.resolved().surface_rule == PRESETS[opened.numerics.preset]["surface_rule"]


def test_an_unknown_name_is_said_once():
    with pytest.raises(CaseError) as found:
        stored().changed(**{"numerics.cfi": 1.0})
    assert str(found.value).count("\n") == 0 and "did you mean 'cfl'" in str(found.value)
