"""Water that leaves an open tank over its rim is removed and counted, on any number of ranks and over a restart."""


import numpy as np
import pytest

from parisph import Box, Case, Energy, Fluid, Numerics, Obstacle, Output, Piston, Profile, Roll, Sway, Tank
from parisph.base.errors import ParticleLost
from parisph.base.fields import FLUID
from parisph.driver import wall_penetration
from parisph.geometry.rims import rims_of
from parisph.io import reader
from tests.running import last_checkpoint
from tests.scenes import assert_same, at_end, on_ranks, simulated, water


def pouring(end_time=0.2, **output):
    """A square of water, thrown up and to the right: its upper part goes over the rim."""
    return water((0.4, 0.4, (0.5, 0.2)), (1.0, 0.6), dict(spacing=0.05, time_step=0.002, rtol=1e-13),
                 velocity=(3.0, 3.0), output=Output(**output), probes=[Energy("energy")], end_time=end_time)


def test_every_particle_is_in_the_tank_or_counted():
    s = simulated(pouring())
    fluid = np.count_nonzero(s.particles.kind == FLUID)
    volume, walls = s.particles.volume.sum(), s.particles.n_global - fluid
    before = 0
    while not s.finished():
        report = s.advance()
        p = s.particles
        assert report.left == s.left.particles >= before
        assert np.count_nonzero(p.kind == FLUID) + report.left == fluid
        assert np.count_nonzero(p.kind != FLUID) == walls
        assert p.volume.sum() + s.left.volume == pytest.approx(volume, rel=1e-12)
        outside = (p.x[:, 0] > 1.0 + 0.025) | (p.x[:, 0] < -0.025)
        assert not np.any(outside & (p.x[:, 1] > 0.6))
        before = report.left
    assert before > 10 and len(np.unique(s.particles.id)) == s.particles.n_global


def test_energy_leaves_with_the_water():
    s = simulated(pouring())
    s.advance()
    p = s.particles
    which = np.flatnonzero(p.kind == FLUID)[:3]
    p.x[which], p.u[which] = (1.2, 0.9), (2.0, -1.0)
    volume = p.volume[which].sum()
    s._open_tank.let_leave(s.domain)
    assert (s.left.particles, s.left.volume) == (3, pytest.approx(volume))
    assert s.left.energy == pytest.approx(1000.0 * volume * (0.5 * 5.0 + 9.81 * 0.9), rel=1e-12)


@pytest.mark.parametrize(("which", "at", "says"), [
    (slice(3, 4), (1.3, 0.2), "outside the tank, but not over its rim"),
    (slice(None), (1.3, 0.9), "all water has left the tank"),
])
def test_a_loss_through_a_wall_or_of_all_water_is_an_error(which, at, says):
    s = simulated(pouring())
    s.advance()
    p = s.particles
    p.x[np.flatnonzero(p.kind == FLUID)[which]] = at
    with pytest.raises(ParticleLost, match=says):
        s._open_tank.let_leave(s.domain)


def test_water_flows_over_the_rim():
    """Filled to the brim, with gravity that leans to the right: nothing holds the water above the wall."""
    case = water((1.0, 0.5), (1.0, 0.5), 0.05, gravity=(2.0, -9.6), end_time=1.5)
    volume = simulated(case).particles.volume.sum()
    s = at_end(case)
    assert s.left.volume == pytest.approx(0.053, rel=0.3), "as with a quarter of the spacing"
    assert s.particles.volume.sum() + s.left.volume == pytest.approx(volume, rel=1e-12)


# one launch: first two ranks beside one alone, then all three, and one that goes on
RANKS = """
from parisph import driver
from tests.driver.test_overflow import pouring
some = comm.Split(0 if comm.rank < 2 else 1)
driver.run(pouring(), some, f"{some.size}", progress=False)
if some.size == 2:
    driver.run(pouring(0.1), some, "part", progress=False)
comm.Barrier()
driver.run(pouring(), comm, "3", progress=False)
if comm.rank == 0:
    driver.restart("part", MPI.COMM_SELF, until=0.2, progress=False)
"""


def test_ranks_agree_and_a_restart_goes_on_counting(tmp_path):
    on_ranks(3, RANKS, tmp_path)
    whole, due = reader.open_run(tmp_path / "1"), last_checkpoint(tmp_path / "1")[1]
    a = whole.summary
    assert a["left"]["particles"] == whole.steps["left"][-1] > 10
    for name in ("2", "3", "part"):
        found, more = reader.open_run(tmp_path / name), last_checkpoint(tmp_path / name)[1]
        np.testing.assert_array_equal(more["id"], due["id"])
        assert_same(due, more, 1e-8)
        np.testing.assert_array_equal(found.steps["left"], whole.steps["left"])
        b = found.summary
        assert b["left"] == pytest.approx(a["left"], rel=1e-6 if name == "part" else 1e-9)
        assert b["particles"] == a["particles"]
        assert b["energy_drift"] == pytest.approx(a["energy_drift"], abs=1e-6)


OUT = Obstacle(Box(0.4, 0.2, at=(0.9, 0.0)), name="block")    # it sticks out of the side of the tank


def scene(*walls, **more):
    return Case(title="scene", fluid=Fluid(Box(0.5, 0.3, at=(0.2, 0.0)), density=1000.0), walls=walls,
                gravity=(0.0, -9.81), numerics=Numerics(spacing=0.05), end_time=1.0, **more)


@pytest.mark.parametrize("case, time, gone, kept", [
    (scene(Tank(1.0, 0.5), OUT), 0.0, (1.04, 0.55), (0.95, 0.55)),
    (scene(Tank(1.0, 0.5, motion=Sway(0.3, np.pi))), 1.0, (0.56, 0.6), (1.5, 0.6)),
    (scene(Tank(1.0, 0.5, motion=Roll(0.5 * np.pi, 0.5 * np.pi, ramp=0.0))), 1.0, (-0.6, -0.1), (-0.6, 0.1)),
    (scene(Profile([(0.0, 0.0), (1.0, 0.0)])), 0.0, (1.04, 0.01), (0.9, 0.01)),
    (scene(Obstacle(Box(1.0, 0.2))), 0.0, (1.1, -0.5), (0.9, 0.3)),
])
def test_water_leaves_over_the_rim_wherever_that_is(case, time, gone, kept):
    out, lost = rims_of(case, 0.15)[0].out(np.array([gone, kept]), time)
    assert out.tolist() == [True, False] and not lost.any()


def test_water_over_a_wavemaker_has_left():
    _, face = rims_of(scene(Tank(2.0, 1.0), Piston(at=0.2, top=0.5, motion=Sway(0.1, np.pi), side="right")), 0.15)
    x = np.array([(0.36, 0.6), (0.42, 0.6), (0.3, 0.2)])    # at t = 1 s the face is at 0.4 m
    assert face.out(x, 1.0)[0].tolist() == [True, False, False]


def test_fluid_in_a_solid_is_an_error():
    s = simulated(scene(Tank(1.0, 0.5), OUT))
    p = s.particles
    s.domain.refresh()
    wall_penetration.check(s.domain)
    p.x[np.flatnonzero(p.kind == FLUID)[3]] = (0.95, 0.1)
    s.domain.refresh()
    with pytest.raises(ParticleLost, match=r"particle .* at \[0.95, 0.1\] m: in block, or behind it, by up to 1 spac"):
        wall_penetration.check(s.domain)
