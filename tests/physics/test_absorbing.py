"""Zones that make and absorb waves: what comes back, and water at rest in them."""

import numpy as np
import pytest

from parisph import Airy, Output, Relaxation, Sponge, SurfaceGauge
from parisph.truth.reflection import separated
from tests.scenes import after_steps, assert_same, budget, sampled, simulated, water

G, DEPTH, HEIGHT = 9.81, 0.5, 0.02
PERIOD = Airy(height=HEIGHT, period=1.2, depth=DEPTH).period
WAVE = Airy(height=HEIGHT, period=PERIOD, depth=DEPTH)


def tank(sponge, spacing=0.0625, periods=12.0, **values):
    """Return a tank with a zone that makes waves at its left end and one, in wavelengths, that absorbs at its right."""
    length = WAVE.length
    width = spacing * round((2.0 + sponge) * length / spacing)
    gauges = [SurfaceGauge(f"g{k}", at=length * (1.25 + 0.13 * k)) for k in range(5)]
    zones = [Relaxation(0.0, length, wave=WAVE, ramp=2.0 * PERIOD), Sponge(width - sponge * length, sponge * length)]
    return water((width, DEPTH), (width, 2.0 * DEPTH),
                 dict(preset="gentle", spacing=spacing, time_step=PERIOD / 40.0, **values), gravity=(0.0, -G),
                 end_time=periods * PERIOD, probes=gauges, output=Output(budget=True), absorb=zones)


def waves(case):
    """Return the incident and reflected waves over the last three periods."""
    simulation, times, heights = simulated(case), [], []
    for found, _ in sampled(simulation):
        times.append(simulation.time)
        if simulation.time > case.end_time - 3.0 * PERIOD:
            heights.append([found[probe.name][0] for probe in case.probes])
    return separated(times[-len(heights):], np.transpose(heights), [probe.at for probe in case.probes], PERIOD, WAVE.k)


@pytest.mark.parametrize("sponge, limit", [(1.0, 0.03), (2.0, 0.01)])
def test_a_sponge_reflects_little(sponge, limit):
    """Measured: 1.5 % over one wavelength, 0.3 % over two; the zone at the other end makes the wave to 4 %."""
    found = waves(tank(sponge, periods=11.0 + 2.0 * sponge))
    assert found.reflection < limit and found.residual < 0.02
    assert found.incident == pytest.approx(0.5 * HEIGHT, rel=0.05)


def test_water_at_rest_stays_at_rest_in_an_uneven_zone():
    case = water((1.0, 0.5), (1.0, 1.0), dict(preset="gentle", spacing=0.05, time_step=0.01, rtol=1e-12, jitter=0.4),
                 gravity=(0.0, -G), absorb=[Sponge(0.0, 0.4, 100.0), Sponge(0.6, 0.4, 100.0)])
    simulation = simulated(case, 100)
    assert np.abs(simulation.particles.u).max() < 1e-10


def test_the_budget_knows_what_zones_take_and_give():
    works, gains = zip(*budget(tank(1.0, periods=2.0, rtol=1e-12)))
    assert sum(sum(each.values()) for each in works) == pytest.approx(sum(gains), rel=1e-6)
    zones, pressure = (sum(each[name] for each in works) for name in ("work_absorb", "work_pressure"))
    # the waves have their energy from the zone; the rest is of first order in the spacing: 16, 11 and 5 %
    assert zones > 0.0 and abs(pressure) < 0.14 * zones


def test_two_ranks_make_the_same_waves(tmp_path):
    """And give their vorticity, which no step has computed."""
    fields = ("x", "u", "p", "vorticity")
    case = tank(1.0, spacing=0.125, rtol=1e-13).changed(**{"output.fields": fields})
    one, two = after_steps({"waves": case}, 20, fields, tmp_path).values()
    assert np.abs(one["u"]).max() > 1e-4
    assert_same(one, two, fields=fields)
