"""The studies of run_scripts/studies: each can be run, and says what it costs."""

import ast

import pytest

from parisph.study import PatchStudy, study_file
from parisph.study.patch_tasks import tasks
from parisph.study.plan import plan_study
from tests.launch import ROOT

FOLDER = ROOT / "run_scripts" / "studies"
# what studies import, a case of theirs, and what is no study of runs: a table, and a flow by other equations
BESIDE = ("cavity_measures", "column_with_circles", "dam_break_measures", "scaling_measures", "scaling_table",
          "solitary_measures", "solitary_shoaling")
FILES = sorted(path for path in FOLDER.glob("*.py") if path.stem not in BESIDE)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_run_of_a_study_is_valid(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study, file = study_file.read(path)
    assert study.title
    if isinstance(study, PatchStudy):
        assert len(tasks(study)) > 100
        return
    plan = plan_study(study, file)
    assert plan.runs and plan.study.errors and plan.study.histories


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_study_says_what_it_costs_and_is_listed(path):
    text = path.read_text(encoding="utf-8")
    assert "of CPU time" in ast.get_docstring(ast.parse(text)) and "METHODS" in text
    assert f"`{path.name}`" in (FOLDER / "README.md").read_text(encoding="utf-8")
