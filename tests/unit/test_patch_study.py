"""Patch studies: their tasks, what they write, parts from outside, and one clear error for each mistake."""

import csv
import json
import os

import pytest

from parisph.base.errors import CaseError, Interrupted, SolverDiverged
from parisph.cli import execute
from parisph.study import AnalyticField, Histogram, PatchStudy, Sweep, patch_tasks, study_file
from parisph.study.patch_report import orders, table
from parisph.study.patch_tasks import apply, tasks

SWEEP = Sweep(spacings=[1 / 10, 1 / 20], jitters=[0.8])
TEXT = '''
from parisph.study import Histogram, PatchStudy, Sweep
study = PatchStudy(title="Short patch", fields=["wave"], laplacians=["gfd", "sph"], seeds=[1, 2],
                   histograms=[Histogram(spacing=0.05, jitter=1.2)],
                   sweeps=[Sweep(spacings=[0.1, 0.05], jitters=[0.8]), Sweep(spacings=[0.05], jitters=[0.0, 0.8])])
'''
BRIEF = '''
from parisph.study import PatchStudy, Sweep
study = PatchStudy(fields=["wave"], laplacians=["gfd", "sph"], gradients=["mixed"], seeds=[1, 2],
                   patches=["interior", "dirichlet"], sweeps=[Sweep(spacings=[0.05], jitters=[0.8])])
'''
OUTSIDE = '''
from parisph.methods import operators, parts

class Wide(type(parts.LAPLACIANS["gfd"])):
    """A quadratic fit, with its lists longer than it needs."""

    name, reach = "wide", 3.0

parts.LAPLACIANS.register(Wide())
'''


def study(**fields):
    return PatchStudy(**{"fields": ["wave"], "laplacians": ["gfd"], "sweeps": [SWEEP], "seeds": [1, 2], **fields})


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short patch.py").write_text(TEXT)
    return tmp_path


def test_tasks_combine_everything_once():
    found = tasks(study(laplacians=["gfd", "sph"], gradients=["mixed"], patches=["interior", "neumann"],
                        wall_rows=["sfdi", "harmonic"],
                        sweeps=[Sweep(spacings=[0.1, 0.05], jitters=[0.0, 0.8]), Sweep(spacings=[0.1], jitters=[0.8])]))
    # 3 operators inside, 4 with walls; one seed of the lattice, two of the disorder
    assert len(found) == (3 + 2 * 2) * (2 + 2 * 2)
    assert len({task.described() for task in found}) == len(found)
    assert {task.operator.word for task in tasks(study(laplacians=["gfd", "sph"]), ["sph"])} == {"sph"}


def test_gradients_that_replace_others_at_the_surface_are_curves_of_their_own():
    found = tasks(study(laplacians=[], gradients=["mixed", "sfdi"], patches=["surface"],
                        surface_gradients=["harmonic"]))
    assert {task.operator.label for task in found} == {"mixed", "sfdi", "harmonic (at the surface)"}


def test_observed_order_and_spread():
    lattice = study(sweeps=[Sweep(spacings=[1 / 20, 1 / 40], jitters=[0.0])], patches=["dirichlet"])
    made = [apply(task, lattice) for task in tasks(lattice)]
    assert orders(made, "L2")["gfd", 0.0] == pytest.approx(2.1, abs=0.2)
    exact = study(fields=["parabola"])
    made = [apply(task, exact) for task in tasks(exact)]
    assert all(one.norms["L2"] < 1e-9 for one in made) and orders(made, "L2") == {}, "rounding has no order"
    assert "gfd" in table(made, exact)


@pytest.mark.parametrize("patch", ["neumann", "closed", "walls", "surface"])
def test_patches_with_walls(patch):
    of = {"gradients": ["mixed"], "laplacians": []} if patch in ("walls", "surface") else {}
    made = apply(tasks(study(fields=["harmonic"], patches=[patch], **of))[-1], study())
    assert made.lost == 0 and 0.0 < made.norms["L2"] < 0.1
    assert made.particles == {"walls": 94, "surface": 19}.get(patch, 361)


def test_a_field_without_a_relative_error_says_so():
    made = apply(tasks(study(fields=["harmonic"]))[0], study())
    assert made.norms == {} and "the exact value is zero" in made.problem
    assert "the exact value is zero" in table([made], study())


def test_a_problem_that_cannot_be_solved_is_a_result(monkeypatch):
    def diverges(*_):
        raise SolverDiverged("no attempt\n  reached the tolerance")

    monkeypatch.setattr(patch_tasks, "solution", diverges)
    whole = study(patches=["dirichlet"])
    made = [apply(task, whole) for task in tasks(whole)]
    assert all(one.norms == {} and one.problem == "no attempt" for one in made)
    assert "seed 2: no attempt" in table(made, whole)


def test_a_field_of_functions_in_three_dimensions():
    field = AnalyticField("square", lambda x: x[:, 2] ** 2, None, lambda x: 2.0 + 0.0 * x[:, 2])
    whole = study(fields=[field], dim=3, sweeps=[Sweep(spacings=[1 / 8], jitters=[0.4])], seeds=[1])
    made = apply(tasks(whole)[0], whole)
    assert made.norms["Linf"] < 1e-9 and made.particles > 50


def test_command_writes_tables_and_pictures(place, capsys):
    assert execute(["study", "short patch.py"]) == 0
    said = capsys.readouterr()
    out = place / "studies" / "short patch"
    names = ["histogram_s0.05_k1.2", "laplacian_interior_wave_k0.8", "laplacian_interior_wave_s0.05"]
    assert sorted(path.stem for path in out.glob("*.png")) == names and not (out / "run.lock").exists()
    assert all((out / f"{name}.png").read_bytes()[:4] == b"\x89PNG" for name in names)
    with open(out / "results.csv", newline="") as file:
        lines = list(csv.DictReader(file))
    content = json.loads((out / "results.json").read_text())
    assert len(lines) == len(content["tests"]) == 14 and content["missing"] == 0
    assert all(float(line["L2"]) > 0.0 for line in lines)
    counted = content["histograms"][0]["counts"]
    assert set(counted) == {"gfd", "sph"} and len(counted["sph"]) == 2
    assert sum(counted["sph"][0]) > sum(counted["gfd"][0])
    text = (out / "results.md").read_text()
    assert "# Short patch" in text and "Fitted orders in the spacing" in text and text.count("\n## ") == 2
    assert "Fitted orders" in said.out and "[14/14]" in said.err


def test_only_and_quiet(place, capsys):
    (place / "s.py").write_text(BRIEF)
    assert execute(["study", "s.py", "--only", "sph", "-q", "-o", "some"]) == 0
    said = capsys.readouterr()
    assert said.err == "" and "| sph" in said.out and "gfd" not in said.out and not list((place / "some").glob("*.png"))


def test_list_makes_nothing(place, capsys):
    assert execute(["study", "short patch.py", "--list"]) == 0
    assert "gfd, sph |" in capsys.readouterr().out and not (place / "studies").exists()


def test_json_file(place):
    (place / "s.json").write_text('{"kind": "patch", "fields": ["wave"], "laplacians": ["gfd"], '
                                  '"sweeps": [{"spacings": [0.1], "jitters": [0]}]}')
    assert isinstance(study_file.read("s.json")[0], PatchStudy)
    (place / "bad.json").write_text('{"kind": "patch", "fields": ["wave"], "laplacians": ["gdf"], '
                                    '"sweeps": [{"spacings": [0.1], "jitters": [0]}]}')
    with pytest.raises(CaseError, match="bad.json: .*unknown laplacian 'gdf'"):
        study_file.read("bad.json")


def test_a_part_from_outside(place, capsys):
    (place / "mine.py").write_text(OUTSIDE)
    (place / "s.py").write_text(BRIEF.replace('"sph"', '"wide"'))
    assert execute(["study", "s.py", "--parts", "mine.py", "-q"]) == 0
    lines = json.loads((place / "studies" / "s" / "results.json").read_text())["tests"]
    found = {name: [line["L2"] for line in lines if line["operator"] == name and line["patch"] == "interior"]
             for name in ("gfd", "wide")}
    assert found["wide"] == pytest.approx(found["gfd"], rel=1e-9)


def test_ctrl_c_leaves_the_tables_of_what_is_done(place, monkeypatch, capsys):
    made = patch_tasks.apply
    count = []

    def stopped(task, whole):
        count.append(task)
        if len(count) == 4:
            os.kill(os.getpid(), 2)
        return made(task, whole)

    monkeypatch.setattr(patch_tasks, "apply", stopped)
    (place / "s.py").write_text(BRIEF)
    with pytest.raises(Interrupted, match="stopped with [67] of 10 tests to do"):
        execute(["study", "s.py", "-q"])
    assert "tests have no result yet" in capsys.readouterr().out
    assert json.loads((place / "studies" / "s" / "results.json").read_text())["missing"] in (6, 7)
    assert not (place / "studies" / "s" / "run.lock").exists()


@pytest.mark.parametrize(("fields", "says"), [
    (dict(laplacians=["gdf"]), "laplacians: unknown laplacian 'gdf'; known are rankine"),
    (dict(gradients=["best"]), "gradients: unknown gradient 'best'"),
    (dict(wall_rows=["none"]), "unknown wall_rows 'none'"),
    (dict(fields=["waves"]), "unknown field 'waves'; known are wave, parabola"),
    (dict(fields=[]), "PatchStudy.fields: must be a list of at least one"),
    (dict(sweeps=[]), "PatchStudy.sweeps: must be a list of at least one"),
    (dict(seeds=[]), "PatchStudy.seeds: must be a list of at least one"),
    (dict(patches=[]), "PatchStudy.patches: must be a list of at least one"),
    (dict(laplacians=[]), "give laplacians=[...] or gradients=[...]"),
    (dict(laplacians="gfd"), "must be a list"),
    (dict(sweeps=SWEEP), "must be a list"),
    (dict(laplacians=["gfd", "gfd"]), "'gfd' is given twice"),
    (dict(fields=["wave", "wave"]), "'wave' is given twice"),
    (dict(patches=["interior", "walls"]), "'walls' needs gradients"),
    (dict(patches=["outer"]), "PatchStudy.patches[0] = 'outer': must be"),
    (dict(gradients=["mixed"], patches=["closed"]), "gradients: none of the patches is for them"),
    (dict(surface_gradients=["harmonic"]), "surface_gradients: need"),
    (dict(patches=["closed"], histograms=[Histogram(spacing=0.1, jitter=0.0)]), "histograms: need"),
    (dict(dim=4), "PatchStudy.dim = 4: must be"),
    (dict(dim=3, sweeps=[Sweep(spacings=[1 / 200], jitters=[0.0])]),
     "spacing 0.005: must be at least 1/100 in 3 dimensions"),
    (dict(spacings=[0.1]), "PatchStudy has no field 'spacings'"),
    (dict(fields=[AnalyticField("mine", lambda x: x[:, 0])]), "field 'mine' has no laplacian="),
])
def test_a_bad_study_is_one_clear_error(fields, says):
    with pytest.raises(CaseError) as error:
        study(**fields)
    assert says in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(("make", "says"), [
    (lambda: Sweep(spacings=[0.03], jitters=[0.0]), "a whole number of spacings must fit into 1; write 1/33"),
    (lambda: Sweep(spacings=[0.5], jitters=[0.0]), r"Sweep.spacings\[0\] = 0.5: must be"),
    (lambda: Sweep(spacings=[0.1], jitters=[-1.0]), r"Sweep.jitters\[0\] = -1.0: must be"),
    (lambda: Sweep(spacings=[0.1], jitters=0.8), "must be a list"),
    (lambda: Histogram(spacing=0.1, jitter=0.8, edges=[0.2, 0.1]), "must increase"),
    (lambda: AnalyticField("f", 3), "must be a function of positions"),
])
def test_a_bad_part_is_one_clear_error(make, says):
    with pytest.raises(CaseError, match=says):
        make()


@pytest.mark.parametrize(("words", "says"), [
    (["--only", "best"], "--only best: the study has no such operator"),
    (["--set", "spacing=0.1"], "--set: a patch study has no runs of a case"),
    (["-j", "2"], "-j: a patch study"),
    (["--limit", "3"], "--limit: a patch study"),
])
def test_a_bad_command_is_one_clear_error(place, words, says):
    with pytest.raises(CaseError) as error:
        execute(["study", "short patch.py", *words])
    assert says in str(error.value) and not (place / "studies").exists()
