"""Water that starts with a wave, and its vorticity: none where the flow is irrotational."""

import numpy as np
import pytest

from parisph import Airy, Box, Case, CaseError, Disc, Fluid, SolitaryWave, StandingWave, Tank
from parisph.base.fields import SURFACE, WET
from parisph.case.scales import expected
from parisph.case.time_scales import stable_time_step
from parisph.case.waves import standing_wave_start
from parisph.geometry import build as geometry
from tests.scenes import water

WAVE = SolitaryWave(height=0.06, depth=0.3, at=2.0)


def scene(wave=WAVE, shape=None, spacing=0.03, **changes):
    return water(shape or (6.0, 0.3), (6.0, 0.6), spacing, wave=wave, **changes)


def test_particles_start_on_the_wave_with_its_velocity():
    arrays = geometry.build(scene())
    top, fluid = arrays["role"] == SURFACE, arrays["kind"] == 0
    x, u = arrays["x"], arrays["u"]
    assert np.allclose(x[top, 1], 0.3 + WAVE.elevation(x[top, 0], 0.0), atol=1e-12)
    assert x[top, 1].max() == pytest.approx(0.36, abs=1e-4)
    assert np.allclose(u[fluid].T, WAVE.velocity(x[fluid, 0], x[fluid, 1], 0.0), atol=1e-9)
    still = geometry.build(scene(None))
    assert arrays["volume"].sum() - still["volume"].sum() == pytest.approx(
        float(WAVE.shape(-2.0)[2] - WAVE.shape(4.0)[2]), rel=1e-3
    )
    assert np.array_equal(arrays["role"] == WET, still["role"] == WET)


def test_a_box_off_the_origin_has_the_same_water():
    here, moved = (Fluid(Box(6.0, 0.3, at=at), 1000.0, wave=WAVE) for at in ((0.0, 0.0), (0.0, 1.5)))
    x = np.array([[1.7, 0.2], [2.1, 0.25]])
    assert np.allclose(moved.start_velocity(x + [0.0, 1.5]), here.start_velocity(x), rtol=1e-12)


def test_standing_wave_record_starts_as_its_expressions():
    shape = Box(2.0, 1.0)
    by_record = Fluid(shape, 1000.0, wave=StandingWave(0.025, 2.0, 1.0))
    by_text = Fluid(shape, 1000.0, velocity=standing_wave_start(0.025, np.pi, 1.0))
    x = np.random.default_rng(2).random((30, 2))
    assert np.allclose(by_record.start_velocity(x), by_text.start_velocity(x), atol=1e-15)
    assert np.abs(by_record.rise(x[:, 0])).max() == 0.0


def test_slices_json_and_estimates():
    case = scene()
    whole, parts = geometry.build(case), [geometry.build(case, rank, 3) for rank in range(3)]
    for name in ("x", "u", "volume"):
        assert np.array_equal(np.concatenate([part[name] for part in parts]), whole[name])
    assert Case.model_validate_json(case.model_dump_json()) == case
    assert case.changed(**{"fluid.wave": SolitaryWave(0.03, 0.3, at=2.0)}).fluid.wave.height == 0.03
    still = scene(None)
    assert stable_time_step(case)[0] < stable_time_step(still)[0], "it starts faster"
    assert 0.5 * expected(case).wave.height == pytest.approx(0.03, rel=0.5) and expected(still).wave is None


@pytest.mark.parametrize(("make", "words"), [
    (lambda: scene(shape=Disc(0.3)), "only a Box or StillWater has a top to raise; leave it out for a Disc"),
    (lambda: scene(elevation=0.01), "wave = solitary: it gives velocity and elevation; leave these two out"),
    (lambda: scene(velocity=(1.0, 0.0)), "wave = solitary: it gives velocity and elevation; leave these two out"),
    (
        lambda: scene(Airy(0.01, 1.0, 0.4)),
        "wave.depth = 0.4: must be the height of the Box, 0.3; change one of them",
    ),
    (
        lambda: scene(SolitaryWave(0.06, 0.3, g=1.6)),
        r"fluid.wave.g = 1.6: the gravity of the case must be \(0, -1.6\); change one of them",
    ),
    (lambda: scene().changed(walls=Tank(6.0, 0.33)), "fluid.wave = solitary: raises the surface to 0.3[56]"),
    (lambda: scene({"kind": "cnoidal"}), "must be of a known kind"),
])
def test_bad_input(make, words):
    with pytest.raises(CaseError, match=words):
        make()


# -- vorticity ----------------------------------------------------------------------------------------

PLACES = np.random.default_rng(1).random((400, 2)) * (2.0, 1.0)


def vorticity(velocity, spacing):
    return Fluid(Box(width=2.0, height=1.0), density=1000.0, velocity=velocity).start_vorticity(PLACES, spacing)


@pytest.mark.parametrize("spacing", [0.2, 0.05])
@pytest.mark.parametrize("k", [1.0, np.pi, 2.0 * np.pi])
def test_a_wave_has_none(k, spacing):
    """Differences of its velocity leave an error of second order, for which each step would pay."""
    assert not np.any(vorticity(standing_wave_start(0.05, k, 1.0, 9.81), spacing))


def test_rigid_rotation_has_twice_its_rate():
    assert vorticity(("-2*y", "2*x"), 0.1) == pytest.approx(4.0, rel=1e-12)


def test_a_shear_flow_is_right_to_second_order():
    due = -3.0 * np.cos(3.0 * PLACES[:, 1])
    coarse, fine = (np.abs(vorticity(("sin(3*y)", "0"), s) - due).max() for s in (0.1, 0.05))
    assert coarse < 0.02 and fine == pytest.approx(0.25 * coarse, rel=0.05)
