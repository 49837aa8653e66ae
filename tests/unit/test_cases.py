"""The scenes that come with parisph: they load, are what the papers describe, and their README lists them."""

import re
from pathlib import Path

import numpy as np
import pytest

from parisph import load
from parisph.base.fields import CONTACT, SURFACE, WET
from parisph.case import waves
from parisph.case.checks import stable_time_step
from parisph.case.load import parameters
from parisph.case.probes import read_truth
from parisph.case.schema import Case
from parisph.geometry import build as geometry
from parisph.geometry import scene_checks

CASES = Path(__file__).parents[2] / "cases"
FILES = sorted(CASES.glob("*.py"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_loads_and_is_stored_without_its_script(file):
    case = load(file)
    assert Case.model_validate_json(case.model_dump_json()) == case
    known = parameters(file)
    assert {"spacing", "method", "end_time", "time_step", "jitter", "seed"} <= set(known)
    coarse = load(file, {"spacing": 2.0 * known["spacing"][0], "jitter": 0.4})
    n, m = geometry.counts(case)["fluid"], geometry.counts(coarse)["fluid"]
    assert 3.4 < n / m < 4.7
    assert coarse.numerics.time_step is None or coarse.numerics.time_step < 5.0 * stable_time_step(coarse)[0]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_readme_lists_it_with_its_size(file):
    row = re.search(rf"^\| `{file.name}`.*$", (CASES / "README.md").read_text(encoding="utf-8"), re.M).group()
    case = load(file)
    cells = [cell.strip() for cell in row.split("|")]
    assert int(cells[3]) == geometry.counts(case)["fluid"]
    if case.numerics.time_step is not None:
        steps = round(case.end_time / case.numerics.time_step)
        assert int(cells[4]) == steps, "a run ends within half a step of its end time"


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_geometry_has_no_faults_when_coarse(file):
    case = load(file, {"spacing": 2.0 * parameters(file)["spacing"][0]})
    scene_checks.check(case)
    if not case.plain:
        facts, part = scene_checks.facts(case), case.numerics.spacing
        assert facts.volume == pytest.approx(facts.lattice, rel=0.02)
        assert facts.gap > 2.0 * part


def test_dam_break():
    case = load(CASES / "dam_break.py")
    arrays = geometry.build(case)
    assert case.walls.lid and not case.closed
    assert case.end_time * np.sqrt(9.81) == pytest.approx(10.0)
    assert case.numerics.time_step * np.sqrt(9.81) == pytest.approx(0.002)
    assert np.count_nonzero(arrays["kind"] == 0) == 3200 and np.count_nonzero(arrays["role"] == CONTACT) == 2
    assert np.count_nonzero(arrays["role"] == SURFACE) == 80 + 40 - 1
    assert {probe.name for probe in case.probes} >= {"P1", "P2", "front", "column", "energy", "volume", "momentum"}
    assert load(CASES / "dam_break.py", ["time_step=none"]).numerics.time_step is None


@pytest.mark.parametrize("spacing, count", [(0.1, 190), (0.05, 780), (0.025, 3160)])
def test_small_sloshing(spacing, count):
    case = load(CASES / "small_sloshing.py", {"spacing": spacing})
    assert geometry.counts(case)["fluid"] == count
    omega = 0.8 * waves.angular_frequency(np.pi, 0.5)
    assert case.frame.acceleration(0.0) == pytest.approx([0.0005 * omega**2, 0.0])
    t, eta = read_truth(case.probes[0].truth)
    series = waves.sway_sloshing_elevation(0.0, t, 1.0, 0.5, 0.0005, omega)
    assert np.linalg.norm(eta - 0.5 - series) < 0.005 * np.linalg.norm(series)
    assert t[-1] == pytest.approx(case.end_time, rel=1e-3)
    fine = load(CASES / "small_sloshing.py", {"spacing": spacing, "refine_time": True})
    assert fine.numerics.time_step == pytest.approx(case.numerics.time_step * spacing / 0.05)


def test_standing_wave():
    case = load(CASES / "standing_wave.py")
    arrays = geometry.build(case)
    fluid = arrays["kind"] == 0
    u, v = waves.standing_wave_velocity(*arrays["x"][fluid].T, 0.0, 0.025, np.pi, 1.0)
    assert np.allclose(arrays["u"][fluid], np.stack([u, v], axis=1), atol=1e-12)
    t, _ = read_truth(case.probes[0].truth)
    assert t[-1] >= case.end_time
    assert load(CASES / "standing_wave.py", ["amplitude=0.01"]).probes[0].truth is None


def test_hydrostatic_truth_is_the_weight_of_the_water():
    case = load(CASES / "hydrostatic.py")
    assert np.allclose(read_truth(case.probes[0].truth)[1], 9810.0)
    roles = geometry.build(case)["role"]
    assert np.count_nonzero(roles == WET) == 21 + 2 * 19


def test_free_drop_and_patch_turn_as_they_should():
    drop = load(CASES / "free_drop.py", ["stiffness=2"])
    x = np.array([[0.5, 0.0], [0.0, -0.25]])
    assert drop.body_force(x, 0.0) == pytest.approx(-4.0 * x)
    assert drop.walls is None
    arrays = geometry.build(load(CASES / "rotating_patch.py"))
    x, u = arrays["x"], arrays["u"]
    assert np.allclose(x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0], -np.sum(x**2, axis=1))
    assert np.allclose(u.sum(axis=0), 0.0, atol=1e-9)
