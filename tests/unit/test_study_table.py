"""The table of a study, its limits, fitted orders and Pareto front."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from parisph.base.errors import CaseError
from parisph.study import OtherCodes, Required, Study, TruthError, limits, other_codes, report, results
from parisph.study.error_plots import draw
from parisph.study.fits import cost_at, costs_at_equal_error, fitted_order, pareto
from parisph.study.plan import plan_study
from parisph.study.results import Result
from parisph.study.runs import End
from tests.unit.test_study_plan import CASE


@pytest.fixture
def found(tmp_path):
    """The results of two methods, two spacings and two starts; one of them has blown up. As (Plan, results)."""
    (tmp_path / "tank.py").write_text(CASE)
    (tmp_path / "level.csv").write_text("t,y\n0,0.5\n10,0.5\n")
    study = Study(case="tank.py", methods=["ISPH", "ISPH_R"], spacings=[0.1, 0.05], time_steps=[0.01], seeds=[1, 2],
                  title="a study", errors=[TruthError("left")],
                  required=[Required("left", must=0.05, aim=0.02, where={"method": "ISPH_R"})])
    plan, made = plan_study(study, tmp_path / "s.py", out=tmp_path), []
    for k, run in enumerate(plan.runs):
        blown = run.method == "ISPH" and run.spacing == 0.05 and run.seed == 2
        end = End(run.key, 3, 1.0, "diverged", "u is not a number") if blown else End(run.key, 0, 1.0, "completed")
        error = 4.0 * run.spacing**2 * (1.0 + 0.1 * run.seed) * (3.0 if run.method == "ISPH" else 1.0)
        values = {"particles": 100, "steps": 10, "time": 0.03 if blown else 0.1, "cpu_seconds": 2.0 / run.spacing,
                  "wall_seconds": 1.0, "iterations": 7.5, "volume_low": 0.999, "volume_high": 1.001,
                  "energy_end": 0.98, "energy_high": 1.0}
        made.append(Result(run, end, tmp_path / "runs" / str(k), values, {"left": None if blown else error}))
    return plan, made


def test_table_gives_mean_and_range_over_starts(found):
    plan, made = found
    shown = report.table(made, plan.study)
    line = next(line for line in shown.splitlines() if line.split()[1:4] == ["ISPH_R", "|", "0.1"])
    assert "0.046 (0.044 to 0.048)" in line and "yes" in line
    assert "1 of 2" in shown and "u is not a number (reached t = 0.03 s)" in shown
    assert "Fitted order in the spacing, ISPH_R: left 2.00" in shown
    assert len({len(line) for line in shown.splitlines() if line.startswith("|")}) == 1, "the columns are aligned"


def test_csv_and_json_have_one_line_for_each_run(found, tmp_path):
    plan, made = found
    results.save(made, replace(plan, runs=plan.runs + plan.runs[:3]))
    with open(tmp_path / "results.csv", newline="") as file:
        lines = list(csv.DictReader(file))
    content = json.loads((tmp_path / "results.json").read_text())
    assert len(lines) == len(content["runs"]) == 8 and content["missing"] == 3 and content["title"] == "a study"
    assert {"method", "spacing", "time_step", "parameters", "seed", "ranks", "particles", "steps", "left",
            "cpu_seconds", "wall_seconds", "iterations", "volume_low", "volume_high", "energy_end", "energy_high",
            "survived", "reason"} <= set(lines[0])
    assert float(lines[0]["left"]) == content["runs"][0]["left"] == pytest.approx(0.132)
    assert lines[3]["survived"] == "False" and lines[3]["left"] == "" and content["runs"][3]["left"] is None
    assert "reached t = 0.03 s" in lines[3]["reason"]


def test_limits_judge_the_worst_start(found):
    plan, made = found
    verdicts = limits.verdicts(plan.study, plan.runs, made)
    assert [(one.where, one.met, one.reached) for one in verdicts] == [
        ("ISPH_R, spacing 0.1, time step 0.01", True, False), ("ISPH_R, spacing 0.05, time step 0.01", True, True)]
    assert limits.unmet(verdicts) == [] and "yes (aim)" in limits.table(verdicts)


@pytest.mark.parametrize(("required", "met"), [
    (Required("left", must=0.01), [False] * 4), (Required("left", must=0.5, where={"method": "ISPH"}), [True, False]),
    (Required("survived", must=1, least=True, where={"spacing": 0.05}), [False, True]),
    (Required("energy_end", must=0.97, least=True), [True] * 4), (Required("cpu_seconds", aim=30.0), [None] * 4),
])
def test_a_missing_value_meets_nothing(found, required, met):
    plan, made = found
    verdicts = limits.verdicts(plan.study.model_copy(update={"required": (required,)}), plan.runs, made)
    assert [one.met for one in verdicts] == met
    assert len(limits.unmet(verdicts)) == met.count(False)


def test_a_run_without_a_result_meets_nothing(found):
    plan, made = found
    assert [one.met for one in limits.verdicts(plan.study, plan.runs, made[:-1])] == [True, True, False]
    assert "none" in limits.unmet(limits.verdicts(plan.study, plan.runs, []))[0]


def test_picture_is_drawn(found, tmp_path):
    pytest.importorskip("matplotlib")
    _, made = found
    others = [other_codes.OtherPoint("a $code", 0.1, 0.02, 100.0), other_codes.OtherPoint("half", None, 0.02, None)]
    assert draw(made, "left", "error of left", "a $title", tmp_path / "a.png", others)
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert not draw(made, "nothing", "x", "a title", tmp_path / "b.png") and not (tmp_path / "b.png").exists()


def test_fitted_order():
    s = np.array([0.1, 0.05, 0.025])
    assert fitted_order(s, 3.0 * s**1.5) == pytest.approx(1.5)
    assert fitted_order([0.1, 0.05, 0.025, 0.01], [0.01, None, 0.0025, float("nan")]) == pytest.approx(1.0)
    assert fitted_order([0.1, 0.1], [1.0, 2.0]) is None and fitted_order([0.1, 0.05], [1.0, 0.0]) is None
    assert fitted_order([], []) is None


@pytest.mark.parametrize(("costs", "errors", "front"), [
    ([1, 2, 3], [3, 2, 1], [0, 1, 2]), ([1, 2, 3], [1, 2, 3], [0]), ([3, 1, 2], [1, 3, 4], [1, 0]),
    ([1, 1, 2], [2, 1, 1], [1]), ([1, 1], [1, 1], [0, 1]), ([], [], []),
])
def test_pareto_front(costs, errors, front):
    assert pareto(costs, errors) == front


@pytest.mark.parametrize(("level", "cost"), [
    (0.1, (4.0, False)), (0.05, (8.0, False)), (0.2, (2.0, False)), (0.4, (2.0, True)), (0.02, None),
])
def test_cost_of_an_error_lies_between_the_points_of_the_front(level, cost):
    """Costs in inverse proportion to the error, and a point that is beaten."""
    found = cost_at(level, [2.0, 8.0, 9.0], [0.2, 0.05, 0.15])
    assert found is None if cost is None else found == (pytest.approx(cost[0]), cost[1])


def test_methods_are_compared_at_equal_error(found):
    """Errors are 4, CPU times 2 over the spacing: ISPH needs spacings smaller by the root of 3.

    One start of it failed.
    """
    plan, made = found
    levels = plan.study.model_copy(update={"levels": {"left": (0.04, 0.02, 0.001)}})
    swapped = [one for one in made if one.run.method == "ISPH_R"] + [one for one in made if one.run.method == "ISPH"]
    first, second, third = costs_at_equal_error(swapped, levels)
    assert first.startswith("CPU s for left = 0.04: ISPH_R 21.4 (21 to 21.9); ISPH ")
    assert "ISPH does not reach it" in second and third.count("does not reach it") == 2
    with pytest.raises(CaseError, match="levels: there is no measure 'right'; there are left"):
        Study(case="tank.py", errors=[TruthError("left")], levels={"right": [0.1]})


def test_other_codes_are_read(tmp_path):
    (tmp_path / "o.csv").write_text("# a source\ncode,h,error,cpu_seconds\nSPH,0.1,0.2,\nSPH,,0.1,30\n")
    points = other_codes.read(OtherCodes("o.csv", spacing="h"), tmp_path)
    assert points == [other_codes.OtherPoint("SPH", 0.1, 0.2, None), other_codes.OtherPoint("SPH", None, 0.1, 30.0)]
    (tmp_path / "o.csv").write_text("code,error\nSPH,much\n")
    with pytest.raises(CaseError, match="line 2: 'much' in 'error' is not a number"):
        other_codes.read(OtherCodes("o.csv", spacing="", cpu=""), tmp_path)
