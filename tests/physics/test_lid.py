"""Waves below a lid: the lid has no effect until they touch it."""

import numpy as np
import pytest

from parisph import PressureTap, SurfaceGauge, Sway, Volume
from parisph.base.fields import FLUID
from parisph.watch import instruments
from tests.scenes import simulated, water

S, DEPTH = 0.05, 0.5


def swayed(gap, amplitude, steps, **numerics):
    """Return (probes' columns, most isolated particles) of a tank whose lid is `gap` spacings above the water."""
    top = DEPTH + gap * S
    case = water((1.0, DEPTH), (1.0, top, True), dict(spacing=S, **numerics), title="lid",
                 frame=Sway(amplitude=amplitude, frequency=5.0), end_time=100.0,
                 probes=[SurfaceGauge("left", at=0.0), Volume("volume"), PressureTap("lid", at=(0.0, top))])
    s = simulated(case)
    isolated = s.solve_start()
    samplers, found = instruments.build(case, s.comm), []
    for _ in range(steps):
        isolated = max(isolated, s.advance().isolated)
        found.append([value[0] for value in instruments.sample_all(samplers, s.particles, s.domain, s.time).values()])
    inside = s.particles.x[s.particles.kind == FLUID, 1].max() < top
    assert inside
    return np.array(found).T, isolated


@pytest.mark.parametrize(("preset", "difference"), [("gentle", 4e-4 * S), ("violent", 0.02 * S)])
def test_wave_that_stays_below_the_lid(preset, difference):
    """A fifth of a spacing high, where the lid is one spacing above the water.

    The side walls end at the lid: above the water, gentle flow takes the slope of pressure from them, measured 2e-4
    spacings, and the regularisation of violent flow counts them.
    """
    (far, _, _), _ = swayed(8, 0.004, 120, preset=preset, time_step=0.01)
    (near, _, lid), isolated = swayed(1, 0.004, 120, preset=preset, time_step=0.01)
    assert 0.15 * S < np.abs(far - DEPTH).max() < 0.25 * S
    np.testing.assert_allclose(near, far, atol=difference)
    assert isolated == 0 and not lid.any()


@pytest.mark.parametrize("gap", [1, 3])
def test_crest_that_hits_the_lid(gap):
    """One spacing of air is so little that the water closes it here and there: it must not collapse then.

    With this air it lets go of the lid slowly: swayed by 0.04, 0.05 and 0.06 m, it comes down by 0.40, 0.29 and 0.16
    spacings. With three spacings of air it falls below its level.
    """
    (left, volume, lid), isolated = swayed(gap, 0.05, 900)
    assert lid.max() > 500.0 and np.abs(lid).max() < 2e4
    crest = np.argmax(left)
    assert left[crest:].min() < left[crest] - 0.25 * S, "it comes down again"
    assert gap == 1 or left.min() < DEPTH - 0.25 * S
    assert np.abs(volume - 1.0).max() < 0.05
    assert gap == 1 or isolated == 0
