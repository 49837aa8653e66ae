"""Force, moment and run-up on bodies of any shape: Archimedes, at corners too."""

from types import SimpleNamespace

import numpy as np
import pytest

from parisph import Box, Case, CaseError, Disc, Fluid, Force, Numerics, Polygon, PressureTap, RunUp, Tank
from parisph.case.bodies import Obstacle, Piston, Profile, StillWater
from parisph.case.motion import Heave, Sway
from parisph.geometry.mesh import CONVEX
from parisph.geometry.movers import MovedNodes
from parisph.methods.rigid_bodies import PressureLoad, node_pressures
from parisph.watch.instruments import build, sample_all
from tests.scenes import at_start, simulated, water
from tests.watched import DENSITY, G, Watch

LEVEL, GRADIENT = 0.8, np.array([20.0, -50.0])
BOX, BLADE = Box(0.3, 0.2, at=(0.4, 0.25)), Polygon([(0.3, 0.2), (0.8, 0.35), (0.45, 0.6)])


def scene(probes, *bodies, tank=True, **numerics):
    walls = (Tank(1.2, 1.0),) * tank + bodies
    return Case(title="bodies", fluid=Fluid(StillWater(LEVEL), density=DENSITY), walls=walls, gravity=(0.0, -G),
                numerics=Numerics(spacing=0.05, **numerics), probes=probes, end_time=1.0)


def linear(arrays):
    """Give walls a linear pressure, but for nodes on convex edges, which have none."""
    arrays["p"][:] = 300.0 + arrays["x"] @ GRADIENT
    arrays["p"][arrays["edge"] == CONVEX] = 1e9


@pytest.mark.parametrize("shape, area, centre", [
    (BOX, 0.06, (0.55, 0.35)), (BLADE, 0.5 * (0.5 * 0.4 - 0.15 * 0.15), (1.55 / 3.0, 1.15 / 3.0)),
])
def test_a_linear_pressure_lifts_a_body_by_its_gradient(shape, area, centre):
    about = (0.1, -0.3)
    probe = Force("load", on="stone", about=about, still=LEVEL)
    watch = Watch(scene([probe], Obstacle(shape, name="stone")), change=linear)
    fx, fy, moment, *dynamic = watch.sample()["load"]
    lift, arm = -GRADIENT * area, np.array(centre) - about
    np.testing.assert_allclose((fx, fy), lift, rtol=1e-9)
    assert moment == pytest.approx(arm[0] * lift[1] - arm[1] * lift[0], rel=1e-9)
    weight = DENSITY * G * area
    still = np.subtract((fx, fy, moment), dynamic)
    np.testing.assert_allclose(still, (0.0, weight, arm[0] * weight), atol=1e-9 * weight)


def test_a_pressure_that_is_missing_is_extrapolated_along_elements_of_any_length():
    """p = 10 + 10 x on 0 < x < 3, whose value at 3 is not known: the integrals of p and p x are 75 and 135."""
    line = PressureLoad(SimpleNamespace(ends=np.zeros(3, bool)), np.array([[0, 1], [1, 2]]))
    x = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]])
    assert line.of(x, np.array([10.0, 20.0, np.nan]), np.zeros(2)) == pytest.approx((0.0, -75.0, -135.0))


def test_the_pressure_at_the_end_of_a_line_is_not_negative():
    """Up to p = 10 and 30 at x = 1 and 2, it would be -10 at the end x = 0: 5 and 20 instead of 0 and 20."""
    line = PressureLoad(SimpleNamespace(ends=np.array([True, False, False])), np.array([[0, 1], [1, 2]]))
    x = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    assert line.of(x, np.array([np.nan, 10.0, 30.0]), np.zeros(2))[1] == pytest.approx(-25.0)


def test_the_dynamic_force_of_water_at_rest_is_zero():
    """On a pier that stands through the surface, a disc below it and the tank; in a tank alone, on the lattice; and in
    a flume, whose bed behind the piston is dry. The foot of the piston has no row, but the force knows its pressure."""
    bodies = Obstacle(Box(0.2, 1.0, at=(0.2, 0.0)), name="pier"), Obstacle(Disc(0.15, at=(0.8, 0.4)), name="disc")
    probes = [Force(name, on=name, still=LEVEL, acted=True) for name in ("pier", "disc", "tank")]
    alone = scene([Force("tank", still=LEVEL), Force("right", side="right", still=LEVEL)], rtol=1e-12).changed(
        fluid=Fluid(Box(1.2, LEVEL), density=DENSITY))
    bed = [Force("bed", side="bed", still=LEVEL), Force("end", side="right", still=LEVEL), Force("board", on="board",
                                                                                               still=LEVEL)]
    flume = scene(bed, Tank(1.5, 1.0, at=(-0.3, 0.0)), Piston(0.0, motion=Sway(amplitude=1e-9, frequency=1.0),
                                                              name="board"), tank=False, rtol=1e-12)
    for case in (scene(probes, *bodies, rtol=1e-12), alone, flume):
        simulation = simulated(case)
        simulation.solve_start()
        samplers = build(case, simulation.comm)
        found = sample_all(samplers, simulation.particles, simulation.domain, 0.0)
        for sampler in samplers:
            values = dict(zip(sampler.columns, found[sampler.name]))
            assert "with the hydrostatic part; dynamic: less that of water at rest up to y = 0.8 m" in sampler.title
            assert sampler.name == "pier" or max(map(abs, values.values())) > 0.05 * DENSITY * G
            assert all(abs(values[name]) < 1e-6 * DENSITY * G for name in values if "dynamic" in name), values
            if sampler.name == "board":
                assert values["fx"] == pytest.approx(-0.5 * DENSITY * G * LEVEL**2, rel=1e-9)


def test_taps_beside_the_foot_of_a_wavemaker_have_the_pressure_there():
    """Nodes at the foot and behind it are dry: at two spacings from it taps showed a tenth too little."""
    heights = (0.02, 0.05, 0.1)
    taps = [*(PressureTap(f"y{y}", at=(0.0, y)) for y in heights), PressureTap("bed", at=(0.1, 0.0))]
    maker = Piston(0.0, motion=Sway(amplitude=1e-9, frequency=1.0))
    found = at_start(scene(taps, Tank(1.5, 1.0, at=(-0.3, 0.0)), maker, tank=False, rtol=1e-12))
    due = [*(DENSITY * G * (LEVEL - y) for y in heights), DENSITY * G * LEVEL]
    assert [value for value, in found.values()] == pytest.approx(due, rel=1e-9)


def test_no_hydrostatic_part_where_gravity_is_not_straight_down():
    with pytest.raises(CaseError, match="probe 'load': still = 0.8: there is no hydrostatic force"):
        scene([Force("load", still=LEVEL)]).changed(gravity=(1.0, -G))


def test_bodies_and_sides_of_the_tank_add_up_to_the_weight_of_the_water():
    """As it is solved, on packed particles around a box that stands on the bed and a disc."""
    bodies = Obstacle(Box(0.3, 0.2, at=(0.1, 0.0)), name="sill"), Obstacle(Disc(0.15, at=(0.8, 0.4)), name="buoy")
    probes = [Force("sill", on="sill"), Force("buoy", on="buoy"), Force("tank"), Force("right", side="right")]
    found = at_start(scene(probes, *bodies, rtol=1e-12))
    weight = DENSITY * G
    assert found["sill"][:2] == (pytest.approx(0.0, abs=1e-6 * weight), pytest.approx(-0.3 * 0.6 * weight, rel=1e-9))
    assert found["buoy"][1] == pytest.approx(np.pi * 0.15**2 * weight, rel=0.02)    # of a polygon of 19 sides
    assert found["tank"][1] == pytest.approx(-0.9 * LEVEL * weight, rel=1e-9)
    assert found["right"][0] == pytest.approx(0.5 * LEVEL**2 * weight, rel=1e-9)


@pytest.mark.parametrize("side, x", [("right", 1.7), ("left", 0.3)])
def test_run_up_on_a_profile_goes_from_its_lowest_point_to_one_of_its_ends(side, x):
    """A basin with two slopes of 45 degrees, a flat bed between them, and a sill on it."""
    basin = Profile([(0.0, 0.6), (0.6, 0.0), (1.4, 0.0), (2.0, 0.6)], name="basin")
    case = water(StillWater(0.3), (basin, Obstacle(Box(0.2, 0.1, at=(0.9, 0.0)))), 0.025,
                 probes=[RunUp("up", on="basin", side=side)])
    assert Watch(case).sample()["up"] == (pytest.approx(0.3, abs=1e-9), pytest.approx(x, abs=1e-9))
    hill = Profile([(0.0, 0.0), (2.0, 0.6)], name="hill")
    with pytest.raises(CaseError, match="side = 'left': hill is lowest at this end"):
        Watch(case.changed(walls=(hill,), probes=[RunUp("up", on="hill", side="left")]))


@pytest.mark.parametrize("probe, message", [
    (Force("load", on="gate"), "'load': on = 'gate': there is no body of this name; there is 'tank', 'stone'"),
    (Force("load", on="stone", side="left"), "'load': side = 'left': only a tank has sides"),
    (RunUp("up", on="stone"), "'up': on = 'stone': give its side"),
])
def test_what_a_body_does_not_have(probe, message):
    with pytest.raises(CaseError, match=message):
        scene([probe], Obstacle(BOX, name="stone"))


class Sinking:
    """A Mover without a law: a body of `mass` [kg/m] that its weight and the pressure at the end of a step move."""

    def __init__(self, simulation, name, mass):
        self.simulation, self.elements, self.mass = simulation, simulation.domain.elements, mass
        mesh = self.elements.mesh
        number = [body.name for body in mesh.bodies].index(name)
        self.force = PressureLoad(mesh, mesh.elements[mesh.element_body == number])
        self.at, self.speed, self.pull = np.zeros((3, 2))

    def way(self, time):
        return time * self.speed + 0.5 * time**2 * self.pull

    def moved(self, mesh, own, at, start, stop):
        still = np.zeros((len(own), 2))
        mean = self.speed + 0.5 * (stop - start) * self.pull
        return MovedNodes(mesh.x0[own] + self.at + self.way(at - start), mesh.normal0[own], mesh.vector_area[own],
                          still + self.speed, still, still + mean, still + self.pull)

    def longest_step(self, x0, time, room):
        return room / max(np.hypot(*self.speed), 1e-9)

    def load(self):
        _, node, pressure = node_pressures(self.simulation.particles, self.elements)
        p = np.empty(len(self.elements.x))
        p[node] = pressure
        return self.force.of(self.elements.x, p, np.zeros(2))

    def advance(self):
        dt = self.simulation.advance().dt
        self.at, self.speed = self.at + self.way(dt), self.speed + dt * self.pull
        fx, fy, _ = self.load()
        self.pull = np.array([fx, fy]) / self.mass - (0.0, G)


def test_a_body_without_a_law_moves_by_the_force_that_the_probe_measures():
    heavy, start = 5.0 * DENSITY * np.pi * 0.15**2, 0.45
    disc = Obstacle(Disc(0.15, at=(0.6, start)), name="disc", motion=Heave(amplitude=0.05, frequency=1.0))
    simulation = simulated(scene([Force("load", on="disc")], disc, max_time_step=0.01))
    mover, p = Sinking(simulation, "disc", heavy), simulation.particles
    with pytest.raises(CaseError, match="no body 'tank' moves .those that do: disc."):
        mover.elements.let_move("tank", mover)
    mover.elements.let_move("disc", mover)
    probes = build(simulation.case, simulation.comm)
    for _ in range(12):
        mover.advance()
        assert sample_all(probes, p, simulation.domain, simulation.time)["load"] == mover.load()
    own = p.body == 1
    assert p.x[own].mean(axis=0) == pytest.approx((0.6, start + mover.at[1]), abs=0.002)
    # (M - m) / (M + A) g, with an added mass A between that in boundless water, m, and twice as much
    assert -4.0 / 6.0 < mover.pull[1] / G < -4.0 / 7.0 and abs(mover.pull[0]) < 0.05 * G
