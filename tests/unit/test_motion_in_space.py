"""Motions of bodies in space: axes, the pose of several motions at once, and what is felt in the moving frame."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from parisph import CaseError, Combined, Heave, Moved, Pitch, Roll, Series, Sway, Tabulated, Turn, Yaw
from parisph.case.motion import AnyMotion, AtRest, leaves_section
from parisph.case.motion.spatial import pose_of

H = 1e-5
TIMES = tuple(np.linspace(0.0, 3.0, 16))
WAVY = Series(times=TIMES, values=tuple(0.1 * np.sin(2.0 * np.array(TIMES)) ** 2))
RATE = Series(times=TIMES, values=WAVY.values, rate=True)
CENTRE = (0.3, -0.2, 0.1)
SIX = Combined([
    Roll(0.3, 3.0, centre=(0.3, 0.1)), Pitch(0.2, 2.0, centre=CENTRE, ramp=0.0), Yaw(WAVY, centre=CENTRE),
    Sway(0.02, 3.0), Moved(RATE, direction=(0.0, 1.0, 0.0)), Heave(0.05, 4.0)])
ALL = [
    Pitch(0.3, 3.0, centre=CENTRE), Yaw(0.3, period=2.0, centre=CENTRE, ramp=0.0), Yaw(WAVY), Pitch(RATE),
    Turn(0.4, 2.0, axis=(1.0, -2.0, 0.5), centre=CENTRE), SIX, Combined([Sway(0.1, 2.0, direction=(1.0, 1.0, 0.0))]),
    Combined([Moved(WAVY), Turn(0.4, 2.0, axis=(0.0, 1.0, 1.0)), Tabulated(TIMES, WAVY.values), Roll(RATE)]),
]
POINTS = np.array([[0.0, 0.0, 0.0], [0.4, 0.3, -0.7], [-1.0, 0.7, 0.2], CENTRE])


def slope(function, t, step=H):
    return (np.asarray(function(t + step)) - np.asarray(function(t - step))) / (2.0 * step)


def kind(motion):
    return motion.kind


@pytest.mark.parametrize("motion", ALL, ids=kind)
def test_rates_are_derivatives_of_the_pose(motion):
    for t in (0.37, 1.234, 2.71):
        there = motion.placed(POINTS, t)
        np.testing.assert_allclose(motion.placed_by(POINTS, motion.law(t)[0]), there, atol=1e-14)
        np.testing.assert_allclose(motion.velocity_at(there, t), slope(lambda t: motion.placed(POINTS, t), t),
                                   atol=1e-8)
        np.testing.assert_allclose(motion.acceleration_at(there, t),
                                   slope(lambda t: motion.velocity_at(motion.placed(POINTS, t), t), t), atol=1e-6)


@pytest.mark.parametrize("motion", ALL, ids=kind)
def test_bodies_stay_rigid_and_motions_are_stored(motion):
    t = 1.234
    there, vectors = motion.placed(POINTS, t), motion.turned(np.eye(3), t)
    np.testing.assert_allclose(vectors @ vectors.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(motion.seen(vectors, t), np.eye(3), atol=1e-14)
    np.testing.assert_allclose(there[1:] - there[0], (POINTS[1:] - POINTS[0]) @ vectors, atol=1e-14)
    assert np.linalg.det(vectors) == pytest.approx(1.0)
    again = TypeAdapter(AnyMotion).validate_json(motion.model_dump_json())
    assert again == motion and (again.placed(POINTS, t) == there).all() and leaves_section(motion)


@pytest.mark.parametrize("motion", ALL, ids=kind)
def test_a_free_particle_moves_on_a_straight_line_in_space(motion):
    """Without gravity, what is felt in the moving frame, with Coriolis' part, moves it as seen from there."""
    start, speed = np.array([[0.2, 0.5, -0.3]]), np.array([[0.7, -0.4, 0.9]])

    def seen_from(t):
        centre = motion.placed(np.zeros((1, 3)), t)
        return motion.seen(start + speed * t - centre, t)

    for t in (0.37, 1.33, 2.71):    # not at times of a series
        x, u = seen_from(t), slope(seen_from, t)
        felt = -motion.acceleration_within(x, t) - 2.0 * np.cross(motion.spin_within(t), u)
        np.testing.assert_allclose((seen_from(t + 1e-4) - 2.0 * x + seen_from(t - 1e-4)) / 1e-8, felt, atol=2e-6)


def test_integrated_in_the_frame_that_yaws_and_pitches_a_free_particle_flies_straight():
    motion = Combined([Yaw(0.5, 3.0, ramp=0.0), Pitch(0.4, 2.0, centre=CENTRE)])
    n, x = 400, np.array([[1.0, 0.2, 0.1]])
    u = motion.seen(np.array([[0.3, 0.1, 0.2]]) - motion.velocity_at(x, 0.0), 0.0)
    dt = 2.0 / n

    def rates(t, x, u):
        return u, -motion.acceleration_within(x, t) - 2.0 * np.cross(motion.spin_within(t), u)

    for k in range(n):    # Runge-Kutta, fourth order
        t = k * dt
        a, b = rates(t, x, u)
        c, d = rates(t + 0.5 * dt, x + 0.5 * dt * a, u + 0.5 * dt * b)
        e, f = rates(t + 0.5 * dt, x + 0.5 * dt * c, u + 0.5 * dt * d)
        g, h = rates(t + dt, x + dt * e, u + dt * f)
        x, u = x + dt / 6.0 * (a + 2 * c + 2 * e + g), u + dt / 6.0 * (b + 2 * d + 2 * f + h)
    np.testing.assert_allclose(motion.placed(x, 2.0), [[1.6, 0.4, 0.5]], atol=1e-9)


def test_axes_and_signs():
    """Angles are positive from x to z of a roll, from y to z of a pitch, from x to y of a yaw."""
    t = 0.5 * np.pi    # a quarter of the period, at the amplitude of a quarter turn
    quarter = dict(amplitude=0.5 * np.pi, frequency=1.0, ramp=0.0)
    x, y, z = np.eye(3)[:, None]
    for motion, before, after in ((Roll(**quarter), x, z), (Pitch(**quarter), y, z), (Yaw(**quarter), x, y),
                                  (Turn(**quarter, axis=(0.0, -3.0, 0.0)), x, z)):
        np.testing.assert_allclose(motion.placed(before, t), after, atol=1e-15)
    rate = 0.5 * np.pi
    for motion, spin in ((Roll(**quarter), (0.0, -rate, 0.0)), (Pitch(**quarter), (rate, 0.0, 0.0)),
                         (Yaw(**quarter), (0.0, 0.0, rate)), (Sway(0.1, 1.0), (0.0, 0.0, 0.0))):
        np.testing.assert_allclose(motion.spin_within(0.0), spin, atol=1e-15)


@pytest.mark.parametrize("motion", [Roll(0.3, 2.0, centre=(0.5, 0.1)), Sway(0.1, 2.0, direction=(1.0, 2.0, 0.0)),
                                    Moved(RATE), Roll(WAVY), AtRest()], ids=kind)
def test_the_pose_of_motions_in_the_section_is_their_own(motion):
    t, pose = 1.1, pose_of(motion, 1.1)
    np.testing.assert_allclose(POINTS @ pose.turn.T + pose.shift, motion.placed(POINTS, t), atol=1e-15)
    np.testing.assert_allclose(pose.speed + np.cross(pose.spin, POINTS), motion.velocity_at(POINTS, t), atol=1e-14)
    own = pose.acceleration + np.cross(pose.second, POINTS) + np.cross(pose.spin, np.cross(pose.spin, POINTS))
    np.testing.assert_allclose(own, motion.acceleration_at(POINTS, t), atol=1e-14)
    np.testing.assert_allclose(pose.turn.T @ pose.spin, motion.spin_within(t), atol=1e-15)


def test_energy_of_a_rigid_rotation():
    """Points of a cube that turns about an axis through its middle have the energy I W^2 / 2, I = m a^2 / 6."""
    points, weight = np.polynomial.legendre.leggauss(3)    # exact for the squares
    x = np.stack(np.meshgrid(points, points, points, indexing="ij"), axis=-1).reshape(-1, 3)
    mass = np.einsum("i,j,k->ijk", weight, weight, weight).ravel() / 8.0
    turn = Turn(0.4, 2.0, axis=(1.0, 2.0, -2.0), ramp=0.0)
    for t in (0.0, 0.3):
        energy = 0.5 * mass @ np.sum(turn.velocity_at(turn.placed(x, t), t)**2, axis=1)
        assert energy == pytest.approx(0.5 * 2.0**2 / 6.0 * turn.law(t)[1]**2, rel=1e-12)
        np.testing.assert_allclose(-turn.acceleration_within(np.array([[2.0, -1.0, 0.0]]), t),    # at a right angle
                                   turn.law(t)[1]**2 * np.array([[2.0, -1.0, 0.0]])
                                   - turn.law(t)[2] * np.cross([1 / 3, 2 / 3, -2 / 3], [2.0, -1.0, 0.0]), atol=1e-14)


@pytest.mark.parametrize("motion", ALL, ids=kind)
def test_limits_for_the_time_step(motion):
    times, lower, upper = np.linspace(0.0, 3.0, 400), np.array([-0.5, 0.0, -0.2]), np.array([1.0, 0.8, 0.6])
    corners = np.array([[x, y, z] for x in (-0.5, 1.0) for y in (0.0, 0.8) for z in (-0.2, 0.6)])
    fastest = max(np.linalg.norm(motion.velocity_at(motion.placed(corners, t), t), axis=1).max() for t in times)
    assert fastest <= 1.15 * motion.top_speed(lower, upper)
    assert motion.top_speed(lower, upper) < 8.0 * fastest
    assert motion.longest_step > 0.0 and motion.instants(3.0)[-1] <= 3.0 and (np.diff(motion.instants(3.0)) >= 0).all()


def test_centres_move_with_translations_that_follow():
    path = Moved(WAVY, direction=(0.0, 1.0, 0.0))
    turn = Yaw(0.5 * np.pi, 0.5 * np.pi, centre=CENTRE, ramp=0.0)
    moved = WAVY.law(1.0)[0]
    np.testing.assert_allclose(Combined([turn, path]).placed(np.array([CENTRE]), 1.0), [[0.3, moved - 0.2, 0.1]])
    np.testing.assert_allclose(Combined([path, turn]).placed(np.array([CENTRE]), 1.0), [[0.3 - moved, -0.2, 0.1]])


@pytest.mark.parametrize("make, words", [
    (lambda: Turn(0.1, 2.0, axis=(0.0, 0.0, 0.0)), "must not be zero; give for example (1, 0, 0)"),
    (lambda: Turn(0.1, 2.0), "Turn.axis is missing"),
    (lambda: Pitch(WAVY, period=2.0), "period = 2: is that of a harmonic pitch; leave it out with a Series"),
    (lambda: Yaw(0.1), "frequency is missing: give the angular frequency [rad/s], or period [s], or a Series"),
    (lambda: Yaw(0.1, 2.0, centre=(0.0, 1.0)), "Yaw.centre"),
    (lambda: Combined([]), "Combined.parts"),
    (lambda: Combined([Combined([Sway(0.1, 1.0)])]), "Combined.parts[0]"),
    (lambda: Roll(0.1, 2.0, axis="x"), "Roll has no field 'axis'; a Roll turns the section, in 3D about y; Pitch t"),
])
def test_messages(make, words):
    with pytest.raises(CaseError) as error:
        make()
    assert words in str(error.value)
