"""Tanks that turn, in their own frame: gravity turns, and the water feels the spin, its change, and Coriolis' force."""

import numpy as np
import pytest

from parisph import Box, CaseError, Disc, Energy, Fluid, Polygon, StillWater, SurfaceGauge, Tank
from parisph.case.motion import AtRest, Roll, Series, Tabulated
from parisph.case.motion.rigid import rotated
from parisph.case.waves import angular_frequency
from parisph.io import reader
from tests.scenes import after_steps, assert_same, difference, restart_alone, run_alone, simulated, water

G = 9.81
CELL = ("sin(pi*x)*cos(pi*y)", "-cos(pi*x)*sin(pi*y)")
TURNING = dict(times=(0.0, 1.0, 2.0, 3.0), rate=True)


def turning(rate, centre=(0.5, 0.5)):
    """A tank that has always turned with `rate` [rad/s]."""
    return Roll(Series(values=(rate,) * 4, **TURNING), centre=centre)


def scene(fluid, frame, walls=None, gravity=(0.0, -G), end_time=1.0, probes=(), **numerics):
    return water(fluid, walls or (1.0, 1.0), {"spacing": 0.05, "time_step": 0.005, **numerics}, gravity=gravity,
                 frame=frame, probes=probes, end_time=end_time)


def after(case, steps, start=False, *names):
    """Return fields of the fluid after some steps, or with the pressure at the start."""
    simulation = simulated(case)
    if start:
        simulation.solve_start()
    for _ in range(steps):
        simulation.advance()
    found = simulation.gather("kind", "x", "u", "p", "volume")
    return {name: values[found["kind"] == 0] for name, values in found.items()}


def full(rate, velocity=(0.0, 0.0), spacing=0.05, **numerics):
    return scene(
        Fluid(Box(1.0, 1.0), 1000.0, velocity=velocity, viscosity=0.002),
        turning(rate) if rate else AtRest(),
        Tank(1.0, 1.0, lid=True),
        (0.0, 0.0),
        preset="closed",
        spacing=spacing,
        **numerics,
    )


def test_pressure_of_rigid_rotation_is_a_paraboloid():
    found = after(full(2.0), 20)
    exact = 0.5 * 1000.0 * 2.0**2 * ((found["x"] - 0.5) ** 2).sum(axis=1)
    error = (found["p"] - found["p"].mean()) - (exact - exact.mean())
    assert np.abs(error).max() < 0.02 * np.ptp(exact)
    assert np.abs(found["u"]).max() < 0.01 * 2.0 * np.sqrt(0.5), "at rest in the tank"


@pytest.mark.parametrize("level", [1.0, 0.5])
@pytest.mark.parametrize("preset", ["violent", "gentle", "closed"])
@pytest.mark.parametrize("viscosity", [0.0, 1e-6])
def test_water_that_turns_with_its_tank_rests_in_it(preset, level, viscosity):
    """Half full, about a far centre, it has a round surface. Without vorticity in the room it would not turn."""
    if preset == "closed" and level < 1.0:
        return
    centre, shape = ((0.5, 0.5), None) if level == 1.0 else ((0.5, 1.2), "0.7 - sqrt(0.5625 - (x - 0.5)**2)")
    water = Fluid(Box(1.0, level), 1000.0, viscosity=viscosity, elevation=shape)
    found = after(scene(water, turning(2.0, centre), Tank(1.0, 1.0, lid=level == 1.0), (0.0, 0.0), preset=preset,
                        jitter=0.3), 20, start=True)
    exact = 0.5 * 1000.0 * 2.0**2 * ((found["x"] - centre) ** 2).sum(axis=1)
    error = found["p"] - exact
    assert np.ptp(error) < 1e-4 * np.ptp(exact) and np.abs(found["u"]).max() < 1e-4


@pytest.mark.parametrize("preset", ["violent", "gentle"])
def test_water_that_turns_with_walls_in_the_room_goes_on(preset):
    """In a tank that turns in the room, its own velocity says that it has vorticity. Measured 0.0003 to 0.0007."""
    water = Fluid(StillWater(level=1.0), 1000.0, velocity=("-2 * (y - 0.5)", "2 * (x - 0.5)"))
    tank = Tank(1.0, 1.0, lid=True, motion=turning(2.0))
    found = after(scene(water, AtRest(), tank, (0.0, 0.0), preset=preset, spacing=0.1), 40, start=True)
    exact = 0.5 * 1000.0 * 2.0**2 * ((found["x"] - 0.5) ** 2).sum(axis=1)
    error = found["p"] - exact
    assert np.ptp(error) < 0.01 * np.ptp(exact)


def test_coriolis_pressure_is_that_of_the_stream_function():
    """2 Omega x u of a flow without divergence is the gradient of 2 Omega psi, also at the walls.

    Measured 0.0066 and 0.0039, and 0.0021 with half the spacing again.
    """
    errors = []
    for spacing in (0.05, 0.025):
        at_rest, turned = (after(full(rate, CELL, spacing), 0, True) for rate in (0.0, 0.5))
        x = at_rest["x"]
        exact = -2.0 * 1000.0 * 0.5 * np.prod(np.sin(np.pi * x), axis=1) / np.pi + 0.5 * 1000.0 * 0.25 * (
            (x - 0.5) ** 2
        ).sum(axis=1)
        found = turned["p"] - at_rest["p"]
        errors.append(
            np.linalg.norm(found - found.mean() - exact + exact.mean()) / np.linalg.norm(exact - exact.mean())
        )
    assert errors[1] < 0.005 and errors[0] / errors[1] > 1.6, errors


def test_pressure_takes_up_the_coriolis_force_of_a_vortex():
    """In two dimensions it does not change a flow between walls; to turn the velocity itself would take 8 %."""
    at_rest, turned = (after(full(rate, CELL), 100) for rate in (0.0, 2.0))
    energy = [0.5 * (found["volume"] @ found["u"] ** 2).sum() for found in (at_rest, turned)]
    assert energy[1] == pytest.approx(energy[0], rel=0.02)


@pytest.mark.parametrize("wall_rows", ["harmonic", "curved"])
def test_a_drop_that_is_strained_feels_no_frame(wall_rows):
    """Its acceleration at the surface needs the Laplacian of the pressure, to which the forces of the frame add."""
    rate, found = 0.7, []
    for spin in (0.0, rate):
        velocity = f"(x - 0.5) + {spin} * (y - 0.5)", f"-(y - 0.5) - {spin} * (x - 0.5)"
        water = Fluid(Disc(0.3, at=(0.5, 0.5)), 1000.0, velocity=velocity)
        simulation = simulated(scene(water, turning(spin) if spin else AtRest(), gravity=(0.0, 0.0),
                                     surface_gradient="curved", wall_rows=wall_rows))
        simulation.solve_start()
        p, water = simulation.particles, simulation.particles.kind == 0
        found.append((simulation.method.acceleration(0.0)[water], p.u[water], p.x[water] - 0.5))
    (at_rest, _, _), (turned, u, r) = found
    in_the_room = turned + 2.0 * rate * np.stack([-u[:, 1], u[:, 0]], axis=1) - rate**2 * r
    assert np.abs(at_rest).max() > 0.2
    np.testing.assert_allclose(in_the_room, at_rest, atol=1e-9)


def test_free_flight_is_straight_in_the_room():
    """A disc of water is thrown in a tank that turns faster and faster, and falls as if there were no tank."""
    times = np.linspace(0.0, 0.6, 25)
    roll = Roll(Series(times=tuple(times), values=tuple(2.0 * times**2 + times)), centre=(2.0, 2.0))
    thrown = np.array([0.4, 1.0])
    # at rest in the tank it would turn with it
    velocity = (f"{thrown[0]} + (y - 2)", f"{thrown[1]} - (x - 2)")
    case = scene(
        Fluid(Disc(0.2, at=(2.6, 2.3)), 1000.0, velocity=velocity),
        roll,
        Tank(4.0, 4.0, lid=True),
        time_step=0.002,
        preset="violent",
    )
    start = after(case, 0)
    found = after(case, 200)
    t = 0.4
    room = start["x"] + t * thrown + 0.5 * t**2 * np.array([0.0, -G])
    angle, rate, _ = roll.law(t)
    exact = 2.0 + rotated(room - 2.0, -angle)
    speed = rotated(thrown + [0.0, -G * t], -angle) - rate * np.stack(
        [-(exact - 2.0)[:, 1], (exact - 2.0)[:, 0]], axis=1
    )
    assert np.abs(found["x"] - exact).max() < 2e-3
    assert np.abs(found["u"] - speed).max() < 1e-2


def test_a_tank_that_has_turned_is_one_with_turned_gravity():
    angle = 0.1
    tilted = Roll(Series(times=(0.0, 1.0, 2.0, 3.0), values=(angle,) * 4), centre=(0.3, 0.2))
    water = Fluid(Box(1.0, 0.5), 1000.0)
    one = after(scene(water, tilted), 10)
    other = after(scene(water, AtRest(), gravity=(-G * np.sin(angle), -G * np.cos(angle))), 10)
    assert difference(one["u"], other["u"]) < 1e-9 and np.abs(one["u"]).max() > 0.01


def test_a_roll_about_a_far_centre_is_a_sway():
    times = np.linspace(0.0, 0.6, 25)
    moved, far = 0.05 * (1.0 - np.cos(8.0 * times)), 1e6
    water = Fluid(Box(1.0, 0.5), 1000.0)
    sway = after(scene(water, Tabulated(tuple(times), tuple(moved))), 40)
    roll = after(
        scene(water, Roll(Series(times=tuple(times), values=tuple(-moved / far)), centre=(0.5, 0.25 - far))), 40
    )
    assert difference(roll["u"], sway["u"]) < 1e-4 and np.abs(sway["u"]).max() > 0.1


def linear_roll(roll, t, length, depth, modes=81):
    """Return the elevation at x = 0 of linear waves in a tank that rolls about (length/2, y), at times t (n,).

    For the potential of the velocity in the room, with the test functions cos(kx) cosh(ky): the mode
    q = integral of eta cos(kx) obeys q'' + g k T q = (2/k^2 - G) angle'' + 2 g T angle/k, where T = tanh(k depth) and
    G = 2 (depth - y) T/k - 2/k^2 + 4/(k^2 cosh(k depth)).
    """
    fine = np.linspace(0.0, t[-1], 20 * len(t))
    h = fine[1]
    angle, _, second = np.array([roll.law(value) for value in fine]).T
    eta = np.zeros(len(fine))
    for n in range(1, modes, 2):
        k = n * np.pi / length
        T, omega = np.tanh(k * depth), angular_frequency(k, depth)
        G_n = 2.0 * (depth - roll.centre[1]) * T / k - 2.0 / k**2 + 4.0 / (k**2 * np.cosh(k * depth))
        force = second * (2.0 / k**2 - G_n) + 2.0 * G * T / k * angle
        # exact for a force that is linear in each step: the sum of past forces, turned by omega h
        state, found = 0.0 + 0.0j, np.zeros(len(fine))
        for i in range(1, len(fine)):
            state = (state + 0.5 * h * force[i - 1]) * np.exp(1j * omega * h) + 0.5 * h * force[i]
            found[i] = state.imag / omega
        eta += 2.0 / length * found
    return np.interp(t, fine, eta)


def test_small_roll_against_linear_theory(tmp_path):
    roll = Roll(0.002, 0.8 * angular_frequency(np.pi, 0.5), centre=(0.5, 0.1))
    case = scene(
        Fluid(Box(1.0, 0.5), 1000.0),
        roll,
        end_time=4.0,
        preset="gentle",
        time_step=0.01,
        probes=[SurfaceGauge("left", at=0.0), Energy("energy")],
    )
    summary = run_alone(case, tmp_path / "run")
    gauge = reader.open_run(tmp_path / "run").probe("left")
    exact = linear_roll(roll, gauge["time"], 1.0, 0.5)
    error = np.linalg.norm(gauge["y"] - 0.5 - exact) / np.linalg.norm(exact)
    assert np.abs(exact).max() > 0.002 and error < 0.05, error
    assert summary["driven"] and not reader.open_run(tmp_path / "run").probe("energy")["potential"].any()


def test_a_restart_in_the_middle_of_a_roll(tmp_path):
    roll = Roll(0.1, 4.0, centre=(0.5, 0.0), ramp=0.2)
    whole = scene(Fluid(Box(1.0, 0.5), 1000.0), roll, end_time=0.4, rtol=1e-13)
    run_alone(whole, tmp_path / "whole")
    run_alone(whole.changed(end_time=0.2), tmp_path / "part")
    restart_alone(tmp_path / "part", until=0.4)
    one, other = (reader.open_run(tmp_path / name).snapshot() for name in ("whole", "part"))
    assert np.abs(one["u"]).max() > 0.01
    assert_same(one, other)


def test_ranks_agree(tmp_path):
    case = scene(Fluid(Box(1.0, 0.3), 1000.0), Roll(0.3, 4.0, centre=(0.5, 0.0), ramp=0.0), (1.0, 0.5, True),
                 rtol=1e-13, time_step=0.004)
    fields = ("x", "u", "p", "role", "acceleration")
    one, two = after_steps({"roll": case}, 60, fields, tmp_path).values()
    assert np.abs(one["u"]).max() > 0.3
    assert_same(one, two, fields=("x", "u", "p", "acceleration"))


def test_only_tanks_that_turn_pay():
    water = Fluid(Box(1.0, 0.5), 1000.0)
    for frame, there in ((AtRest(), False), (Roll(0.1, 2.0), True)):
        simulation = simulated(scene(water, frame))
        assert ("halfway" in simulation.particles.fields) == ("acceleration" in simulation.particles.fields) == there
        assert ("coriolis" in [part.name for part in simulation.method.parts.forces]) == there


@pytest.mark.parametrize(("changes", "words"), [
    ({"method": "SPH"}, "frame = roll: weakly compressible SPH has no Coriolis force; choose a projection method"),
    ({"forces": ("body",)}, "frame = roll: needs the force 'coriolis'; add it to numerics.forces"),
])
def test_refused(changes, words):
    with pytest.raises(CaseError, match=words):
        scene(Fluid(Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 0.5))), 1000.0), Roll(0.1, 2.0), **changes)
