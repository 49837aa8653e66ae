"""Motions of the tank: velocity and acceleration are the derivatives of the displacement."""

from time import process_time

import numpy as np
import pytest

from parisph.case.motion import AtRest, Moved, PistonStroke, Roll, Series, Sway, Tabulated, course
from parisph.case.waves import SolitaryWave


def derivative(function, t, h=1e-5):
    return (function(t + h) - function(t - h)) / (2.0 * h)


def pose(motion, t):
    """Return place, velocity and acceleration of the point at the origin of the body at rest, (2,) each."""
    x = np.zeros((1, 2))
    return motion.placed(x, t)[0], motion.velocity_at(x, t)[0], motion.acceleration_at(x, t)[0]


def tabulated(function, times, **more):
    return Tabulated(tuple(times), tuple(function(times)), **more)


@pytest.mark.parametrize("motion", [
    Sway(0.02, 3.0, direction=(3.0, 4.0)),
    tabulated(lambda t: np.sin(2.0 * t), np.sort(np.append(np.linspace(0.0, 3.0, 20), [0.111, 1.9]))),
])
def test_derivatives(motion):
    for t in (0.4, 1.23, 2.7):
        _, u, a = pose(motion, t)
        assert u == pytest.approx(derivative(lambda t: pose(motion, t)[0], t), abs=1e-8)
        assert a == pytest.approx(derivative(lambda t: pose(motion, t)[1], t), abs=1e-6)


def test_sway_starts_at_rest_along_its_direction():
    motion = Sway(0.02, 3.0, direction=(0.0, 2.0))
    x, u, a = pose(motion, 0.0)
    assert not x.any() and not u.any() and a == pytest.approx([0.0, 0.02 * 9.0])


def test_spline_is_exact_for_cubics_and_fourth_order_otherwise():
    cubic = tabulated(lambda t: 1.0 - t + t**2 - 0.3 * t**3, np.array([0.0, 0.3, 1.0, 1.4, 2.0]))
    assert cubic.law(0.77)[0] == pytest.approx(1.0 - 0.77 + 0.77**2 - 0.3 * 0.77**3, abs=1e-13)
    assert cubic.law(1.9)[2] == pytest.approx(2.0 - 1.8 * 1.9, abs=1e-12)
    error = []
    for n in (20, 40):
        motion = tabulated(np.sin, np.linspace(0.0, 6.0, n + 1))
        error.append(max(abs(motion.law(t)[0] - np.sin(t)) for t in np.linspace(0.01, 5.99, 301)))
    assert np.log2(error[0] / error[1]) > 3.5


def test_tabulated_rests_outside_its_times():
    motion = tabulated(np.sin, np.linspace(0.0, 2.0, 9))
    assert motion.law(5.0)[0] == pytest.approx(np.sin(2.0)) and motion.law(5.0)[2] == 0.0
    assert motion.law(-1.0)[:2] == (0.0, 0.0)


def test_a_sway_limits_the_time_step_to_a_share_of_its_period():
    assert Sway(0.02, 2.0 * np.pi * 4.0).longest_step == pytest.approx(0.25 / 50)
    assert Sway(0.0, 3.0).longest_step == AtRest().longest_step == np.inf


def test_a_motion_is_the_integral_of_a_column_of_velocities(tmp_path):
    times = np.linspace(0.0, 2.0, 21)
    rows = [f"{t!r},{v!r}" for t, v in zip(times.tolist(), (3.0 * times**2).tolist())]
    (tmp_path / "paddle.csv").write_text("\n".join(["t,velocity", *rows]))
    series = Series(str(tmp_path / "paddle.csv"), time="t", value="velocity", rate=True)
    for motion in (Moved(series), Tabulated(tuple(times.tolist()), series.values, rate=True)):
        assert motion.law(1.5) == pytest.approx((1.5**3, 3.0 * 1.5**2, 6.0 * 1.5))
        assert motion.law(9.0) == pytest.approx((8.0, 0.0, 0.0))
        assert motion.top_rate == pytest.approx(12.0)


LONG = 300_000    # samples: five minutes at 1 kHz


@pytest.mark.parametrize("make", [
    lambda t, y: Roll(Series(times=t, values=y), centre=(0.45, 0.0)),
    lambda t, y: Moved(Series(times=t, values=y, rate=True)),
    lambda t, y: Tabulated(t, y),
])
def test_a_long_record_is_read_and_followed_quickly(make):
    times = np.arange(LONG) / 1000.0
    samples = tuple(times.tolist()), tuple((0.05 * np.sin(3.85 * times)).tolist())
    start = process_time()
    motion = make(*samples)
    motion.law(0.0)
    made = process_time()
    laws = [motion.law(t) for t in np.linspace(1.0, 250.0, 2000)]
    followed = process_time()
    when, values = course(motion, 200.0)
    seen = process_time()
    assert made - start < 2.0 and followed - made < 1.0 and seen - followed < 1.0    # each evaluation took 7 ms
    assert hash(motion) == hash(make(*samples)) and motion == make(*samples)
    assert course(motion, 200.0)[1] is values
    few = np.linspace(0, len(when) - 1, 50).astype(int)
    assert values[few] == pytest.approx([motion.law(t)[0] for t in when[few]], abs=1e-15)
    expected = 0.05 * np.sin(3.85 * np.linspace(1.0, 250.0, 2000))
    if not isinstance(motion, Moved):
        assert np.array(laws)[:, 0] == pytest.approx(expected, abs=1e-9)
    else:
        assert np.array(laws)[:, 1] == pytest.approx(expected, abs=1e-9)


def test_the_piston_of_a_high_solitary_wave_takes_few_transforms(monkeypatch):
    """It took 60,000 of them and five seconds."""
    taken, transform = [], np.fft.rfft
    monkeypatch.setattr(np.fft, "rfft", lambda *args: taken.append(1) or transform(*args))
    stroke = PistonStroke(SolitaryWave(height=0.749, depth=1.0))
    assert stroke.law(2.0)[1] > 0.0
    assert 10 < len(taken) < 4000
