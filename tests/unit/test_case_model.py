"""The case as data: frozen, stored as JSON, presets, and what is derived from it."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

import parisph
from parisph import Box, Case, CaseError, Disc, Energy, Fluid, Numerics, Output, PressureTap, SurfaceGauge, Tank
from parisph.case.methods import METHODS
from parisph.case.motion import Sway, Tabulated
from parisph.case.schema import PRESETS
from parisph.case.time_scales import stable_time_step
from parisph.case.truths import PeakBand, Truth, read_truth
from tests.launch import clean_environment


def scene(**changes):
    values = {
        "title": "test",
        "fluid": Fluid(Box(width=1.0, height=1.0), density=1000.0),
        "walls": Tank(width=2.0, height=2.0),
        "gravity": (0.0, -9.81),
        "numerics": Numerics(spacing=0.1),
        "end_time": 1.0,
    }
    return Case(**{**values, **changes})


def test_json_gives_the_same_case_back():
    case = scene(
        fluid=Fluid(Box(2.0, 1.0), 998.0, ("sin(x)", 0.1), "0.01*cos(pi*x)"),
        gravity=("0.1*sin(t)", -9.81),
        frame=Tabulated((0.0, 1.0, 2.0, 3.0), (0.0, 0.1, 0.0, 0.2)),
        numerics=Numerics(spacing=0.1, zeta_time=0.01, seed=2**62),
        output=Output(every=0.1, times=(0.5,), fields=("u",)),
        probes=[SurfaceGauge("a", 0.5, Truth("f.csv", "t", "v", wave=True)), PressureTap("b", (0.0, 0.3)), Energy("c")],
    )
    again = Case.model_validate_json(case.model_dump_json())
    assert again == case and again.model_dump_json() == case.model_dump_json()
    assert Case.model_validate(case.model_dump()) == case


@pytest.mark.parametrize(("changes", "driven"), [
    ({}, False), ({"gravity": (0.0, "-9.81/2")}, False), ({"gravity": (0.0, 0.0)}, False),
    ({"frame": Sway(0.1, 2.0)}, True), ({"frame": Tabulated((0.0, 1.0, 2.0, 3.0), (0.0, 0.1, 0.0, 0.2))}, True),
    ({"gravity": (0.0, "-9.81*cos(t)")}, True), ({"gravity": ("-x", 0.0)}, True),
])
def test_work_is_done_by_a_moving_frame_and_by_a_force_that_varies(changes, driven):
    assert scene(**changes).driven is driven


def test_frozen():
    with pytest.raises(Exception, match="frozen"):
        scene().end_time = 2.0


def test_positions_and_names_mean_the_same():
    assert Box(1.0, 2.0, (3.0, 4.0)) == Box(width=1.0, height=2.0, at=(3.0, 4.0))
    assert Sway(0.1, 2.0) == Sway(amplitude=0.1, frequency=2.0)
    assert PressureTap("P", (0.0, 1.0)).at == (0.0, 1.0)
    assert (Case.model_validate_json(scene(fluid=Fluid(Disc(0.5, (1.0, 1.0)), 1.0)).model_dump_json()).fluid.shape
            == Disc(0.5, (1.0, 1.0)))


def test_presets_fill_what_is_left_open():
    resolved = Numerics(spacing=0.1, preset="gentle", kappa=0.7).resolved()
    assert resolved.kappa == 0.7
    for name, value in PRESETS["gentle"].items():
        if name != "kappa":
            assert getattr(resolved, name) == value
    assert resolved.resolved() == resolved
    assert all(getattr(resolved, name) is not None for name in PRESETS["violent"])


def test_presets_are_valid_and_complete():
    for name, values in PRESETS.items():
        values = {key: value for key, value in values.items() if key != "zeta" or not PRESETS[name]["zeta_time"]}
        assert Numerics(spacing=0.1, preset=name, **values).preset == name
    assert len({frozenset(values) for values in PRESETS.values()}) == 1
    optional = {name for name, field in Numerics.model_fields.items() if field.default is None}
    for method in METHODS.values():
        assert {*PRESETS["violent"], *method.values} == optional - {"time_step", "max_time_step", "sound_speed"}


def test_body_force_is_gravity_less_the_tanks_acceleration():
    case = scene(gravity=("x*t", -9.81), frame=Sway(0.1, 2.0))
    x = np.array([[1.0, 0.5], [2.0, 0.5]])
    assert case.body_force(x, 0.0) == pytest.approx(np.array([[-0.4, -9.81]] * 2))
    assert case.body_force(x, 3.0)[:, 0] == pytest.approx(3.0 * x[:, 0] - 0.4 * np.cos(6.0))


@pytest.mark.parametrize(("changes", "same"), [
    ({"gravity": ("0.1", "-9.81/2")}, [0.1, -4.905]), ({"frame": Sway(0.1, 2.0)}, None),
    ({"gravity": (0.0, "-9.81*cos(t)")}, None), ({"gravity": ("-x", 0.0)}, None),
])
def test_a_force_is_constant_at_rest_alone(changes, same):
    found = scene(**changes).constant_force
    assert (found is None) == (same is None) and (same is None or np.array_equal(found, same))


def test_travels_between_ranks_after_use():
    case = scene(gravity=("x*t", -9.81), frame=Tabulated((0.0, 1.0, 2.0, 3.0), (0.0, 0.1, 0.0, 0.2)))
    case.body_force(np.zeros((1, 2)), 0.5)
    again = pickle.loads(pickle.dumps(case))
    assert again == case == scene(gravity=case.gravity, frame=case.frame)
    assert np.array_equal(again.body_force(np.ones((3, 2)), 0.5), case.body_force(np.ones((3, 2)), 0.5))


def test_changed_reaches_inside_and_validates():
    case = scene()
    other = case.changed(**{"numerics.kappa": 0.5, "end_time": 2.0, "fluid": Fluid(Box(0.5, 0.5), 900.0)})
    assert other.numerics.kappa == 0.5 and other.end_time == 2.0 and other.fluid.density == 900.0
    assert case.numerics.kappa is None
    for name in ("numerics.kapa", "numericz.kappa", "numerics.spacing.x", "nothing"):
        with pytest.raises(CaseError, match=name.split(".")[0] if name.startswith("numericz") else "no (field|part)"):
            case.changed(**{name: 0.013})


def test_stable_time_step():
    falling = scene(fluid=Fluid(Box(1.0, 1.0), 1.0, velocity=(3.0, 4.0)))
    for case, cfl in ((falling, 0.8), (falling.changed(**{"numerics.time_step": 0.001}), 0.3)):
        violent, reason = stable_time_step(case)
        assert violent == pytest.approx(0.1 * cfl / (5.0 + np.sqrt(2 * 9.81))) and f"by {cfl} spacings" in reason
    gentle, reason = stable_time_step(scene(numerics=Numerics(spacing=0.1, preset="gentle")))
    assert gentle == pytest.approx(np.sqrt(0.1 / 9.81)) and "waves" in reason
    assert np.isinf(stable_time_step(scene(gravity=(0.0, 0.0)))[0])


def test_read_truth_scales_and_shifts(tmp_path):
    file = tmp_path / "truth.csv"
    file.write_text("# made up\nt, h, n\n0, 1, a\n\n2, 3, b\n", encoding="utf-8")
    t, h = read_truth(Truth(str(file), time="t", value="h", offset=0.5, scale=2.0, time_scale=10.0))
    assert np.array_equal(t, [0.0, 20.0]) and np.array_equal(h, [2.5, 6.5])


def test_a_truth_takes_the_rows_of_its_own_series(tmp_path):
    file = tmp_path / "several.csv"
    file.write_text("sensor,t,p\nA,0,1\nA,1,2\nB,0,5\nB,1,6\n")
    of = {name: Truth(str(file), time="t", value="p", rows={"sensor": name}) for name in "ABC"}
    assert np.array_equal(read_truth(of["B"])[1], [5.0, 6.0])
    with pytest.raises(CaseError, match="two lines .* at increasing times, where {'sensor': 'C'}"):
        read_truth(of["C"])
    with pytest.raises(CaseError, match="truth.rows = 'by': .* has no such column; it has sensor, t, p"):
        read_truth(Truth(str(file), time="t", value="p", rows={"by": "A"}))
    with pytest.raises(CaseError, match="at increasing times"):
        read_truth(Truth(str(file), time="t", value="p"))


@pytest.mark.parametrize(("wrong", "message"), [
    (lambda: Truth("a.csv", time="t", value="p", window=(2.0, 1.0)), "must end after its start"),
    (lambda: Truth("a.csv", time="t", value="p", smooth=0.0), "smooth"),
    (lambda: Truth("a.csv", "t", "p", others=(Truth("b.csv", "t", "p"),)), "others have the names \\[''\\]: give each"),
    (lambda: Truth("a.csv", "t", "p", others=[Truth("b.csv", "t", "p", name="b")] * 2), "give each one of its own"),
    (lambda: PeakBand(start=1.0, end=0.5, low=1.0, high=2.0), "start must be before end"),
    (lambda: PeakBand(start=0.0, end=0.5, low=3.0, high=2.0), "low above 0 and below high"),
    (lambda: PeakBand(start=0.0, end=0.5, low=3.0, when=0.2), "give low and high, or `when` alone"),
    (lambda: PeakBand(start=0.0, end=0.5), "give low and high, or `when` alone"),
])
def test_windows_and_bands_are_in_order(wrong, message):
    with pytest.raises(CaseError, match=message):
        wrong()


def test_import_is_light():
    code = (
        "import sys, parisph; assert 'numpy' not in sys.modules and 'pydantic' not in sys.modules;"
        "from parisph import Case, load; bad = {'mpi4py', 'petsc4py', 'numba', 'h5py'} & set(sys.modules); "
        "assert not bad, bad"
    )
    subprocess.run([sys.executable, "-c", code], env=clean_environment(), check=True, timeout=60)


def test_public_names():
    for name in parisph.__all__:
        if name in ("run", "restart", "open_store"):
            continue  # these load MPI
        assert getattr(parisph, name) is not None
    assert {"Case", "load"} <= set(dir(parisph))
    with pytest.raises(AttributeError):
        parisph.nothing
