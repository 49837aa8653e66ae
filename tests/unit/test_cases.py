"""The scenes that come with parisph: they load, are what the papers describe, and their README lists them."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

from parisph import CaseError, load
from parisph.base import reading
from parisph.base.fields import CONTACT, SURFACE, WET
from parisph.case import measured_data, waves
from parisph.case.load import parameters
from parisph.case.profiles import read_profiles
from parisph.case.schema import Case
from parisph.case.time_scales import stable_time_step
from parisph.case.truths import read_truth
from parisph.driver import describe
from parisph.geometry import build as geometry
from parisph.geometry import scene_checks
from parisph.truth import norms
from tests.scenes import made_motion

CASES = Path(__file__).parents[2] / "cases"
FILES = sorted(CASES.glob("*.py"))
MEASURED = os.environ.get(measured_data.VARIABLE)
OTHER = {"lateral_roll": 0.5, "wet_bed": 0.5}    # times the spacing, where twice the spacing does not fit the water


@pytest.fixture(scope="module", params=FILES, ids=lambda file: file.stem)
def file(request):
    """One after the other through all its tests, as the geometry of the last scenes is kept."""
    return request.param


@pytest.fixture(autouse=True)
def only_made_data(tmp_path, monkeypatch):
    """The measured data of others is not part of a clone."""
    made_motion(tmp_path)
    monkeypatch.setenv(measured_data.VARIABLE, str(tmp_path))


def test_loads_and_is_stored_without_its_script(file):
    case = load(file)
    assert Case.model_validate_json(case.model_dump_json()) == case
    known = parameters(file)
    assert {"spacing", "method", "end_time", "time_step", "jitter", "seed"} <= set(known)
    factor = OTHER.get(file.stem, 2.0)
    other = load(file, {"spacing": factor * known["spacing"][0], "jitter": 0.4})
    n, m = (geometry.counts(scene)["fluid"] ** (2.0 / case.dim) for scene in (case, other))
    assert 3.4 < (n / m if factor > 1.0 else m / n) < 4.7
    assert other.numerics.time_step is None or other.numerics.time_step < 5.0 * stable_time_step(other)[0]


def test_readme_lists_it_with_its_size(file):
    row = re.search(rf"^\| `{file.name}`.*$", (CASES / "README.md").read_text(encoding="utf-8"), re.M).group()
    case = load(file)
    cells = [cell.strip() for cell in row.split("|")]
    assert int(cells[3]) == geometry.counts(case)["fluid"]
    if case.numerics.time_step is not None:
        steps = round(case.end_time / case.numerics.time_step)
        assert int(cells[4]) == steps, "a run ends within half a step of its end time"


def test_is_described(file):
    told = describe(load(file))
    lines = dict(line.split(None, 1) for line in told.splitlines() if not line.startswith(("end time", " ")))
    assert lines["case"] and "fluid" in lines["particles"] and "solve" in lines["stages"] and "MB" in lines["memory"]
    assert "times the step" not in told and "caught in the corner" not in told


def test_geometry_has_no_faults_when_coarse(file):
    case = load(file, {"spacing": OTHER.get(file.stem, 2.0) * parameters(file)["spacing"][0]})
    scene_checks.check(case)
    facts = scene_checks.facts(case)
    if facts is not None:
        # half of the cells at free edges is air, and beside walls half cells are missing
        assert facts.volume == pytest.approx(facts.lattice, rel=0.12 if case.dim == 2 else 0.25)
        assert facts.gap > 2.0 * case.numerics.spacing


def test_dam_break():
    case = load(CASES / "dam_break.py")
    arrays = geometry.build(case)
    assert case.walls.lid and not case.closed
    assert case.end_time * np.sqrt(9.81) == pytest.approx(10.0)
    assert case.numerics.time_step is None and case.numerics.cfl == 1.5
    for across, step in ((20, 0.008), (40, 0.004), (60, 0.004), (160, 0.002)):
        numerics = load(CASES / "dam_break.py", {"spacing": 1 / across, "time_step": 0.004}).numerics
        assert numerics.time_step * np.sqrt(9.81) == pytest.approx(step)
    assert np.count_nonzero(arrays["kind"] == 0) == 3200 and np.count_nonzero(arrays["role"] == CONTACT) == 2
    assert np.count_nonzero(arrays["role"] == SURFACE) == 80 + 40 - 1
    assert {probe.name for probe in case.probes} >= {"P1", "P2", "front", "column", "energy", "volume", "momentum"}
    assert load(CASES / "dam_break.py", ["method=SPH"]).numerics.cfl is None


@pytest.mark.parametrize("spacing, count", [(0.1, 190), (0.05, 780), (0.025, 3160)])
def test_small_sloshing(spacing, count):
    case = load(CASES / "small_sloshing.py", {"spacing": spacing})
    assert geometry.counts(case)["fluid"] == count
    omega = 0.8 * waves.angular_frequency(np.pi, 0.5)
    assert case.frame.law(0.0)[2] == pytest.approx(0.0005 * omega**2)
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


def test_drop_and_sloshing_in_3d_have_exact_truths():
    drop, free = load(CASES / "drop_3d.py", ["stiffness=1"]), load(CASES / "drop_3d.py")
    x = np.array([[0.5, 0.2, -0.1]])
    assert drop.body_force(x, 0.0) == pytest.approx(-x) and drop.dim == 3
    for case, rate in ((drop, 0.4), (free, 0.5)):
        t, u = read_truth(case.probes[0].truth)
        assert u[0] == pytest.approx(0.5 * rate) and t[-1] >= case.end_time
        assert case.fluids[0].start_velocity(np.array([case.probes[0].at]))[0, 0] == pytest.approx(u[0])
    fluid = geometry.build(free)
    energy = 0.5 * 1000.0 * 0.1**3 * np.sum(fluid["u"] ** 2)
    assert read_truth(free.probes[2].truth)[1][0] == pytest.approx(energy, rel=0.02), "of the lattice"
    case = load(CASES / "sloshing_3d.py")
    omega = 0.8 * waves.angular_frequency(np.pi, 0.5)
    for probe in case.probes[:3]:
        t, eta = read_truth(probe.truth)
        own = sum(waves.sway_sloshing_elevation(at, t, 1.0, 0.5, 0.0005 / np.sqrt(2.0), omega)
                  for at in (probe.at, probe.y))
        np.testing.assert_allclose(eta - 0.5, own, atol=1e-6), probe.name
    assert case.frame.acceleration_at(x, 0.0) == pytest.approx(0.0005 * omega**2 * np.array([[1, 1, 0]]) / np.sqrt(2.0))


def test_a_slab_is_compared_with_2d_and_a_column_in_a_corner_is_not():
    slab, flat = load(CASES / "dam_break_3d.py"), load(CASES / "dam_break.py")
    by_name = {probe.name: probe.truth for probe in flat.probes}
    (_, p), (_, plane) = (read_truth(truth) for truth in (slab.probes[1].truth, by_name["P2"]))
    np.testing.assert_allclose(p, plane)
    energy = read_truth(next(probe.truth for probe in slab.probes if probe.name == "energy"))[1]
    np.testing.assert_allclose(energy, 0.6 * read_truth(by_name["energy"])[1])
    corner = load(CASES / "dam_break_3d.py", ["breadth=2", "column=0.5", "spacing=0.1"])
    assert all(probe.truth is None for probe in corner.probes)
    assert geometry.volume(corner) == pytest.approx(0.25) and corner.breadth == (0.0, 2.0)
    pier = load(CASES / "flume_3d.py", ["pier=true", "spacing=0.1"])
    assert not pier.surfaces and load(CASES / "flume_3d.py").surfaces[0].name == "cylinder"


def test_dam_breaks_with_measured_pressures_are_the_same_flow():
    zhou, lobovsky = (load(CASES / f"dam_break_{name}.py") for name in ("zhou", "lobovsky"))
    for case, height in ((zhou, 1.0), (lobovsky, 0.3)):
        assert case.walls.width / height == pytest.approx(161.0 / 30.0)
        assert case.fluid.shape.width == pytest.approx(2.0 * height)
        assert case.fluid.shape.height == pytest.approx(height)
        assert all(probe.truth is None for probe in case.probes), "the data is not there"
    taps = {probe.name: probe for probe in (*zhou.probes, *lobovsky.probes)}
    assert taps["P2"].at[1] / 1.0 == pytest.approx(taps["S4"].at[1] / 0.3)
    assert taps["P2"].diameter == pytest.approx(90.0 / 600.0), "a disc of 90 mm where H = 600 mm"


def test_the_wave_on_a_beach_is_also_compared_with_one_that_was_computed():
    case = load(CASES / "runup_synolakis.py")
    probe = next(probe for probe in case.probes if probe.name == "profile")
    assert probe.truth.name == "Serre-Green-Naghdi" and not probe.truth.others, "the measured one is not there"
    profiles, unit = read_profiles(probe.truth), np.sqrt(0.2 / 9.81)
    assert [time / unit for time, _, _ in profiles] == pytest.approx([8.0, 10.0, 12.0, 14.0, 15.0])
    shore = next(gauge.at for gauge in probe.probes if gauge.name == "at0")
    for time, x, y in profiles:
        crest, way = x[np.argmax(y)], shore - 24.44 * 0.2 + 1.14 * 0.2 * time / unit
        assert way - 0.4 < crest < way, "it becomes slower on the beach"
    low = load(CASES / "runup_synolakis.py", {"height": 0.0185, "spacing": 0.125})
    assert all(probe.truth is None for probe in low.probes if probe.name == "profile")


def test_violent_sloshing_has_the_particles_of_the_paper():
    for spacing, count in (("0.005", 2880), ("0.004", 4500), ("1/300", 6480), ("1/350", 8820)):
        case = load(CASES / "violent_sloshing.py", [f"spacing={spacing}"])
        shape = case.fluid.shape
        assert shape.width * shape.height / case.numerics.spacing**2 == pytest.approx(count)
    assert case.frame.law(0.75)[0] == pytest.approx(0.1), "2 a0 after half a period"


def test_a_motion_that_is_not_there_is_named_with_a_remedy(tmp_path, monkeypatch):
    monkeypatch.setenv(measured_data.VARIABLE, str(tmp_path / "nowhere"))
    with pytest.raises(CaseError, match=r"measured motion of the tank is missing: .*04a_.*--set data=FOLDER"):
        load(CASES / "lateral_roll.py")
    with pytest.raises(CaseError, match="there is no 02k_"):
        load(CASES / "dam_break_zhou.py", {"data": str(tmp_path)})


@pytest.fixture
def shared_data(monkeypatch):
    """The folder of the measured data, which the cases then use."""
    folder = Path(MEASURED or CASES / measured_data.BESIDE).resolve()
    monkeypatch.setenv(measured_data.VARIABLE, str(folder))
    if not folder.is_dir():
        pytest.skip(f"measured data of others is not part of parisph: there is no {folder}")
    return folder


def level_of(file, reference, scale, unit):
    """Return the error of a digitised curve (file, column, sensor) against a reference, as if it were a run."""
    name, column, sensor = file
    names, lines = reading.read_columns(str(name))
    found = sorted({float(cells[names.index("t_sqrt_g_over_H")]): float(cells[names.index(column)])
                    for cells in lines.values() if cells[names.index("sensor")] == sensor}.items())
    time, values = np.transpose(found)
    truth = norms.evenly(*norms.cut(*read_truth(reference), reference.window))
    return norms.judge(time * unit, values * scale, *truth)["relative_l2"]


def test_errors_of_others_are_those_of_their_curves_in_the_window_of_the_run(shared_data):
    zhou, lobovsky = load(CASES / "dam_break_zhou.py"), load(CASES / "dam_break_lobovsky.py")
    for case, file, curves, height in (
        (zhou, "02b_marrone2011_deltaSPH_buchner_numerical.csv",
         {"P2": [(f"p_H{cells}", "P_160mm") for cells in (40, 80, 320)]}, 1.0),
        (lobovsky, "02f_decourcy2024_acsph_lobovsky_numerical.csv",
         {f"S{k}": [("p_over_rho_g_H", f"P{k}")] for k in (1, 2, 3, 4)}, 0.3),
    ):
        truths = {probe.name: probe.truth for probe in case.probes}
        for name, columns in curves.items():
            density = case.fluids[0].density
            found = [level_of((shared_data / file, *column), truths[name], density * 9.81 * height,
                              np.sqrt(height / 9.81)) for column in columns]
            told = [level for who, level in truths[name].published.items() if not who.startswith(("weakly", "EDAC"))]
            assert told == pytest.approx(found, abs=4e-3), name
            assert all("recomputed" in who for who in truths[name].published)


def test_truths_of_measured_data_where_it_lies(shared_data):
    zhou, lobovsky, roll, bed, beach = (load(CASES / f"{name}.py") for name in (
        "dam_break_zhou", "dam_break_lobovsky", "lateral_roll", "wet_bed", "runup_synolakis"))
    truths = {probe.name: probe.truth for case in (zhou, lobovsky, roll) for probe in case.probes if probe.truth}
    assert set(truths) == {"P2", "P2_point", "S1", "S2", "S3", "S4", "H1", "H2", "H3", "H4", "sensor",
                           "wide"}
    photographed, measured = (read_profiles(next(probe.truth for probe in case.probes if probe.name == "profile"))
                              for case in (bed, beach))
    assert [time for time, _, _ in photographed] == list(bed.output.times), "snapshots show what was photographed"
    both = next(probe.truth for probe in beach.probes if probe.name == "profile")
    assert [one.name for one in (both, *both.others)] == ["experiment", "Serre-Green-Naghdi"]
    assert len(measured) == 4 and all(y.max() < 1.6 * 0.2 for _, _, y in measured)
    assert len(truths["P2"].others) == 3 and truths["S1"].published
    band, = truths["S2"].peaks
    assert 1.5 < band.low / (997.0 * 9.81 * 0.3) < 1.871 < band.high / (997.0 * 9.81 * 0.3) < 2.04
    assert [round(band.low) for band in truths["sensor"].peaks[:4]] == [2606, 3096, 2692, 2956], "of 04d, in Pa"
    assert roll.frame.law(8.0)[0] == pytest.approx(np.interp(8.0, roll.frame.angle.times, roll.frame.angle.values))
