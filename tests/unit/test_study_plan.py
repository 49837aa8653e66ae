"""Study files, and the runs that they stand for: products, variants, names, and one clear error for each mistake."""

import json

import pytest

from parisph.base.errors import CaseError
from parisph.study import FinestError, Function, OtherCodes, Quantity, Required, SeriesError, Study, TruthError, Variant
from parisph.study.combinations import combine
from parisph.study.plan import code_version, plan_study
from parisph.study.report import listing
from parisph.study.study_file import read

CASE = '''
from math import sqrt
from parisph import Box, Case, Energy, Fluid, Numerics, SurfaceGauge, Tank, Truth
def case(spacing: float = 0.1, method: str = "ISPH_R", time_step: float | None = 0.02, depth: float = 0.5,
         seed: int = 0, end_time: float = 0.1) -> Case:
    return Case(title="tank", fluid=Fluid(Box(width=1.0, height=depth), density=1000.0), gravity=(0.0, -9.81),
                walls=Tank(width=1.0, height=1.0), end_time=end_time, probes=[
                    SurfaceGauge("left", at=0.0, truth=Truth("level.csv", time="t", value="y")), Energy("energy")],
                numerics=Numerics(spacing=spacing, method=method, preset="gentle", time_step=time_step, seed=seed))
'''


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a case, its truth, and a path with a space in it, which is the current one."""
    place = tmp_path / "my studies"
    place.mkdir()
    (place / "tank.py").write_text(CASE)
    (place / "level.csv").write_text("t,y\n0,0.5\n10,0.5\n")
    monkeypatch.chdir(place)
    return place


def study(**fields):
    return Study(**{"case": "tank.py", **fields})


def test_a_product_combines_everything():
    found = combine(study(methods=["ISPH", "ISPH_R"], spacings=[0.1, 0.05], time_steps=[0.01], seeds=[1, 2],
                         parameters={"depth": 0.3}))
    assert len(found) == 8
    assert found[0].sets == {"method": "ISPH", "spacing": 0.1, "time_step": 0.01, "depth": 0.3, "seed": 1}
    assert found[0].ranks == 1
    assert [one.label for one in found] == ["ISPH"] * 4 + ["ISPH_R"] * 4
    assert len({one.name for one in found}) == 8 and found[0].name == "ISPH-s0.1-dt0.01-seed1"


def test_a_list_of_values_is_combined_and_a_tuple_is_one_value():
    found = combine(study(parameters={"numerics.gamma": [0.01, 0.05], "sides": (1.0, 2.0)}))
    assert [one.label for one in found] == ["gamma = 0.01", "gamma = 0.05"]
    assert all(one.sets["sides"] == (1.0, 2.0) for one in found)


def test_variants_replace_choices_and_add_parameters():
    found = combine(study(spacings=[0.1, 0.05], parameters={"depth": 0.5}, variants=[
        Variant(methods=["ISPH"], time_steps=[0.002]),
        Variant(methods=["ISPH_R"], spacings=[0.1], time_steps=[0.008], parameters={"end_time": 2.0}, label="long")]))
    assert [(one.label, one.sets["spacing"], one.sets["time_step"]) for one in found] == [
        ("ISPH", 0.1, 0.002), ("ISPH", 0.05, 0.002), ("long", 0.1, 0.008)]
    assert found[2].sets["depth"] == 0.5 and found[2].sets["end_time"] == 2.0


def test_the_time_step_is_in_the_label_only_where_a_curve_has_several():
    variants = [Variant(spacings=[0.1], time_steps=[0.02]), Variant(spacings=[0.05], time_steps=[0.01])]
    per_spacing = combine(study(methods=["ISPH"], variants=variants))
    assert {one.label for one in per_spacing} == {"ISPH"}
    both = combine(study(methods=["ISPH"], spacings=[0.1, 0.05], time_steps=[0.02, None]))
    assert {one.label for one in both} == {"ISPH, dt = 0.02", "ISPH, adaptive"}
    steps_alone = combine(study(methods=["ISPH"], spacings=[0.1], time_steps=[0.02, 0.01]))
    assert {one.label for one in steps_alone} == {"ISPH"}, "they are the axis"


def test_ranks_are_part_of_the_label():
    assert [one.label for one in combine(study(methods=["ISPH"], ranks=[1, 2]))] == ["ISPH, 1 rank", "ISPH, 2 ranks"]


@pytest.mark.parametrize(("fields", "says"), [
    (dict(spacing=[0.1]), "did you mean 'spacings'"),
    (dict(spacings=[-0.1]), "Study.spacings[0] = -0.1: must be greater than 0"),
    (dict(spacings=0.1), "must be a list; write [0.1]"),
    (dict(methods="ISPH"), "must be a list; write ['ISPH']"),
    (dict(seeds=[1, 1]), "1 is given twice"),
    (dict(ranks=[0]), "Study.ranks[0] = 0"),
    (dict(parameters={"spacing": 0.1}), "give it as spacings=[...]"),
    (dict(parameters={"depth": []}), "a list of at least one"),
    (dict(parameters={"depth": {}}), "depth = {}"),
    (dict(errors=[TruthError("left"), TruthError("left")]), "two measures are named 'left'"),
    (dict(errors=[Quantity("steps", name="iterations")]), "as a column of the table"),
    (dict(required=[Required("left", must=1.0)]), "there is no measure 'left'"),
    (dict(errors=TruthError("left")), "must be a list"),
    (dict(time_limit=0.0), "must be greater than 0"),
    (dict(variants=[dict(spacings=[])], label="x"), "no field 'label'"),
])
def test_a_bad_study_is_one_clear_error(fields, says):
    with pytest.raises(CaseError) as error:
        study(**fields)
    assert says in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(("make", "says"), [
    (lambda: Required("left"), "give must= or aim="),
    (lambda: Function("f", of=3), "must be a function"),
    (lambda: TruthError("left", norm="mine"), "TruthError.norm = 'mine'"),
])
def test_a_bad_part_is_one_clear_error(make, says):
    with pytest.raises(CaseError, match=says):
        make()


def test_parts_of_the_command_line_go_to_the_runs(folder):
    (folder / "mine.py").write_text("")
    plan = plan_study(study(methods=["ISPH"]), folder / "s.py", parts=["mine.py"])
    assert plan.runs[0].parts[0] == str(folder / "mine.py")


def test_two_equal_runs_are_an_error(folder):
    with pytest.raises(CaseError, match="two runs of the study are the same"):
        combine(study(variants=[Variant(methods=["ISPH"]), Variant(methods=["ISPH"])]))
    with pytest.raises(CaseError, match="are the same case"):
        plan_study(study(variants=[Variant(spacings=[0.1]), Variant(methods=["ISPH_R"])]), folder / "s.py")


@pytest.mark.parametrize(("fields", "says"), [
    (dict(methods=["MPS"]), "unknown method 'MPS'"),
    (dict(parameters={"depht": 1.0}), "did you mean 'depth'"),
    (dict(parameters={"numerics.gama": 1.0}), "did you mean 'gamma'"),
    (dict(parameters={"numerics.gamma": 3.0}), "gamma = 3"),
    (dict(spacings=[1e-5]), "spacing"),
    (dict(case="tanks.py"), "there is no such case file"),
    (dict(errors=[TruthError("right")]), "no probe 'right'"),
    (dict(errors=[TruthError("energy")]), "the probe energy has no truth"),
    (dict(errors=[SeriesError("left", file="nowhere.csv")]), "nowhere.csv"),
    (dict(errors=[SeriesError("left", file="level.csv", value="z")]), "no column 'z'"),
    (dict(histories=["right"]), "no probe 'right'"),
    (dict(errors=[TruthError("left")], others=[OtherCodes("nowhere.csv")]), "nowhere.csv"),
    (dict(errors=[TruthError("left")], others=[OtherCodes("level.csv")]), "no column 'code'"),
    (dict(errors=[TruthError("left")], required=[Required("left", must=1.0, where={"method": "ISPH"})]),
     "no run of the study has"),
])
def test_every_run_is_checked_before_the_first(folder, fields, says):
    with pytest.raises(CaseError) as error:
        plan_study(study(**fields), folder / "s.py")
    assert says in str(error.value), error.value
    assert not (folder / "studies").exists()


def test_what_the_case_has_no_parameter_for_is_set_in_its_numerics(folder):
    (folder / "tank.py").write_text(CASE.replace('method: str = "ISPH_R", ', "").replace("method=method, ", ""))
    one, = plan_study(study(methods=["ISPH"], parameters={"numerics.rtol": 1e-5}), folder / "s.py",
                      ["numerics.gamma=1/100", "depth=0.3"]).runs
    assert one.case.numerics.method == "ISPH" and one.case.numerics.rtol == 1e-5 and one.case.numerics.gamma == 0.01
    assert one.case.fluid.shape.height == 0.3


def test_set_cannot_change_what_varies(folder):
    with pytest.raises(CaseError, match="the study varies it"):
        plan_study(study(spacings=[0.1, 0.05]), folder / "s.py", ["spacing=0.1"])
    one, = plan_study(study(spacings=[0.1]), folder / "s.py", ["spacing=0.05"]).runs
    assert one.case.numerics.spacing == 0.05


@pytest.mark.parametrize(("word", "step", "text"), [("none", None, "adaptive"), ("1/200", 0.005, "0.005")])
def test_a_time_step_for_all_runs_is_a_text(folder, word, step, text):
    one, = plan_study(study(spacings=[0.1]), folder / "s.py", [f"time_step={word}"]).runs
    assert (one.time_step, one.case.numerics.time_step, one.step_text) == (step, step, text)


def test_keys_follow_case_ranks_and_code(folder, monkeypatch):
    def keys(**fields):
        return [run.key for run in plan_study(study(**fields), folder / "s.py").runs]

    assert keys(spacings=[0.1]) == keys(spacings=[0.1], methods=["ISPH_R"], errors=[FinestError("left")])
    assert len({*keys(spacings=[0.1, 0.05]), *keys(spacings=[0.1], ranks=[2])}) == 3
    before = keys()
    monkeypatch.setattr("parisph.study.plan.code_version", lambda: "another")
    assert keys() != before and code_version() == code_version()


def test_a_study_file_in_json(folder):
    (folder / "s.json").write_text(json.dumps({
        "case": "tank.py", "methods": ["ISPH"], "time_steps": [0.01, None], "parameters": {"depth": [0.5, 0.4]},
        "errors": [{"kind": "truth", "probe": "left"}, {"kind": "quantity", "entry": "energy_drift"}]}))
    found, file = read("s.json")
    assert file == folder / "s.json" and found.errors == (TruthError("left"), Quantity("energy_drift"))
    assert len(combine(found)) == 4


@pytest.mark.parametrize(("text", "says"), [
    ("x = 1", "has no `study`; write: study = Study"),
    ("study = 3", "`study` is a int"),
    ("from parisph.study import Study\nstudy = Study(case='a.py',\n    spacings=[0])", "line 2: Study.spacings[0] = 0"),
    ("study = (", "line 1: syntax error"),
    ("1/0", "line 1: ZeroDivisionError"),
])
def test_a_bad_study_file_names_the_line(folder, text, says):
    (folder / "s.py").write_text(text)
    with pytest.raises(CaseError) as error:
        read("s.py")
    assert says in str(error.value) and str(error.value).startswith("s.py")


def test_a_study_may_be_a_function(folder):
    (folder / "s.py").write_text("from parisph.study import Study\ndef study():\n    return Study(case='tank.py')\n")
    assert read("s.py")[0].case == "tank.py"
    with pytest.raises(CaseError, match="there is no such study file"):
        read("t.py")


def test_listing_estimates_and_only_selects(folder):
    def plan(**options):
        return plan_study(study(methods=["ISPH", "ISPH_R"], spacings=[0.1, 0.05]), folder / "s.py", **options)

    shown = listing(plan())
    assert "4 runs, 4 to do: about" in shown and shown.count("to do") == 5 and "studies/s" in shown
    assert "2 runs, 2 to do" in listing(plan(only=["ISPH"]))
    (folder / "case.json").write_text("{}")
    for options, says in ((dict(only=["SPH"]), r"--only SPH: the study has no such method \(it has: ISPH; ISPH_R\)"),
                          (dict(limit=-1.0), "must be greater than 0"), (dict(out="."), "holds a run")):
        with pytest.raises(CaseError, match=says):
            plan(**options)
