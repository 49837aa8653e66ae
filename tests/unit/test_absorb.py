"""Zones that absorb waves: where they act, how strongly, and what they refuse."""

from types import SimpleNamespace

import numpy as np
import pytest

from parisph import Airy, Box, Case, CaseError, Fluid, Numerics, Relaxation, SolitaryWave, Sponge, Tank
from parisph.case.absorb import Absorber, group_velocity
from parisph.case.stored import from_json, to_json
from parisph.driver.precheck import stages
from parisph.methods.absorbing import Absorption

ENDS, LEVEL, DEPTH, G = (0.0, 10.0), 0.7, 0.5, 9.81
WAVE = Airy(height=0.02, period=1.2, depth=DEPTH)


def tank(absorb, **values):
    return Case(title="tank", fluid=Fluid(Box(10.0, DEPTH), density=1000.0), walls=Tank(10.0, 1.0), gravity=(0.0, -G),
                absorb=absorb, numerics=Numerics(spacing=0.05, preset="gentle", **values), end_time=1.0)


@pytest.mark.parametrize("zone, left", [
    (Sponge(7.0, 2.0), False), (Sponge(1.0, 2.0), True), (Sponge(7.0, 2.0, towards="left"), True),
    (Sponge(1.0, 2.0, towards="right"), False), (Relaxation(7.0, 2.0, wave=WAVE), False),
])
def test_a_zone_grows_with_the_square_towards_the_nearer_end(zone, left):
    absorber = Absorber([zone], ENDS, LEVEL, DEPTH, G)
    x = np.stack([zone.start + zone.length * np.array([-0.01, 0.0, 0.25, 0.5, 1.0, 1.01]), np.zeros(6)], axis=1)
    rate, _ = absorber(x, 0.3)
    most = zone.strength * group_velocity(zone.length, DEPTH, G) / zone.length
    growth = np.array([0.0, 1.0, 0.5625, 0.25, 0.0, 0.0]) if left else np.array([0.0, 0.0, 0.0625, 0.25, 1.0, 0.0])
    np.testing.assert_allclose(rate, most * growth, rtol=1e-12)


def test_a_relaxation_zone_draws_to_the_wave_and_a_sponge_to_rest():
    zones = [Relaxation(0.0, 2.0, wave=WAVE), Sponge(8.0, 2.0)]
    x = np.array([[0.1, 0.3], [1.5, 0.65], [5.0, 0.5], [9.0, 0.5]])
    rate, pull = Absorber(zones, ENDS, LEVEL, DEPTH, G)(x, 0.4)
    wave = np.stack(WAVE.velocity(x[:, 0], x[:, 1] - (LEVEL - DEPTH), 0.4), axis=1)
    np.testing.assert_allclose(pull[:2], rate[:2, None] * wave[:2], rtol=1e-14)
    assert rate[2] == 0.0 < rate[3] and not pull[2:].any()
    _, other = Absorber([Relaxation(0.0, 2.0, wave=WAVE, level=LEVEL + 0.1)], ENDS, LEVEL, DEPTH, G)(x, 0.4)
    lower = np.stack(WAVE.velocity(x[:, 0], x[:, 1] - (LEVEL + 0.1 - DEPTH), 0.4), axis=1)
    np.testing.assert_allclose(other[:2], rate[:2, None] * lower[:2], rtol=1e-14)


@pytest.mark.parametrize("t, share", [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0), (3.0, 1.0)])
def test_a_wave_grows_over_its_ramp(t, share):
    x = np.array([[0.2, 0.4]])
    full, grown = (Absorber([Relaxation(0.0, 2.0, wave=WAVE, ramp=ramp)], ENDS, LEVEL, DEPTH, G)(x, t)[1]
                   for ramp in (0.0, 1.0))
    np.testing.assert_allclose(grown, share * full, atol=1e-15)


@pytest.mark.parametrize("length, depth, speed", [
    (1.0, 100.0, 0.5 * np.sqrt(G / (2.0 * np.pi))), (1000.0, 1.0, np.sqrt(G)),
])
def test_group_velocity_in_deep_and_in_shallow_water(length, depth, speed):
    assert group_velocity(length, depth, G) == pytest.approx(speed, rel=1e-4)


@pytest.mark.parametrize("dt", [1e-4, 0.1, 1e4])
def test_alone_it_is_the_implicit_step_and_pays_what_it_changes(dt):
    rng = np.random.default_rng(3)
    u, rate, target = rng.normal(size=(5, 2)), rng.uniform(0.0, 30.0, 5), rng.normal(size=(5, 2))
    p = SimpleNamespace(x_all=u, u_all=u, n_owned=5, volume=rng.uniform(0.5, 1.0, 5))
    flow = SimpleNamespace(particles=p, step=SimpleNamespace(dt=dt), density=1000.0,
                           absorb=lambda x, t: (rate, rate[:, None] * target))
    out = np.zeros((5, 2))
    Absorption().add(out, flow, 0.0)
    r = (dt * rate)[:, None]
    p.u = u + dt * out
    np.testing.assert_allclose(p.u, (u + r * target) / (1.0 + r), rtol=1e-10, atol=1e-12)
    gain = 500.0 * p.volume @ ((p.u**2).sum(axis=1) - (u**2).sum(axis=1))
    assert Absorption().work(flow, u) == pytest.approx(gain, rel=1e-10)


def test_a_scene_without_zones_has_no_stage_for_them_and_one_with_them_is_driven():
    without, with_one = tank(()), tank(Sponge(8.0, 2.0))
    assert "absorb" not in stages(without) and "absorb" in stages(with_one)
    assert without.absorber is None and not without.driven and with_one.driven
    assert with_one.absorb == (Sponge(8.0, 2.0),) == without.changed(absorb=Sponge(8.0, 2.0)).absorb


def test_zones_are_stored_with_the_case():
    case = tank([Relaxation(0.0, 2.0, wave=SolitaryWave(height=0.1, depth=DEPTH), ramp=1.0), Sponge(8.0, 2.0, 12.0)])
    assert from_json(to_json(case)) == case


@pytest.mark.parametrize("absorb, values, message", [
    (Sponge(8.5, 2.0), {}, r"absorb\[0\]: sponge from x = 8.5 to 10.5: must lie within the walls, from x = 0 to 10"),
    ([Sponge(7.0, 3.0), Relaxation(6.0, 2.0, wave=WAVE)], {}, r"absorb\[1\]: relaxation from x = 6 to 8: lies over the "
     "sponge from x = 7 to 10; move one of them"),
    (Sponge(8.0, 2.0), {"method": "SPH"}, "absorb: weakly compressible SPH has no zones"),
    (Sponge(8.0, 2.0), {"forces": ("body",)}, "absorb: needs the force 'absorb'"),
])
def test_what_cannot_be(absorb, values, message):
    with pytest.raises(CaseError, match=message):
        tank(absorb, **values)


def test_zones_need_a_tank():
    with pytest.raises(CaseError, match="absorb: there is no tank"):
        Case(title="drop", fluid=Fluid(Box(1.0, 1.0), density=1.0), gravity=(0.0, -G), absorb=Sponge(0.0, 0.5),
             numerics=Numerics(spacing=0.1), end_time=1.0)
