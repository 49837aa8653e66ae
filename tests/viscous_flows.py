"""Exact solutions of viscous flow in closed rectangular tanks, and the cases that have them.

There are no periodic boundaries. In the middle of a long closed tank with free-slip ends, the flow between bottom and
lid is parallel, u(y, t), and its flux is zero: the pressure gradient along x is whatever keeps it so. The ends matter
over about a fourth of the height.
"""

from itertools import takewhile

import numpy as np

from parisph import Box, Case, Fluid, Lid, Numerics, Tank, VelocityProfile
from parisph.base.fields import WALL
from tests.scenes import sampled, simulated

LONG = 3.0      # length of a tank over its height


def tank(spacing, viscosity, end_time, lid=0.0, no_slip=("bottom", "top"), gravity=(0.0, 0.0),
         velocity=(0.0, 0.0), length=LONG, **numerics):
    """Return the Case of a full closed tank of height 1 m, its profile at the mid-section as a probe.

    spacing : [m]; viscosity : [m^2/s]; lid : its speed [m/s]; gravity : body force [m/s^2], velocity : at the start
        [m/s],
    numbers or expressions
    """
    return Case(
        title="tank", fluid=Fluid(Box(width=length, height=1.0), density=1.0, viscosity=viscosity, velocity=velocity),
        walls=Tank(width=length, height=1.0, lid=Lid(lid), no_slip=no_slip), gravity=gravity, end_time=end_time,
        numerics=Numerics(preset="closed", spacing=spacing, **{"max_time_step": 0.25 * spacing, **numerics}),
        probes=[VelocityProfile("middle", start=(0.5 * length, 0.0), end=(0.5 * length, 1.0), points=21)],
    )


def run(case, prepare=None):
    """Return the Simulation at the end of the case. prepare : changes it before the first step."""
    s = simulated(case)
    if prepare:
        prepare(s)
    while not s.finished():
        s.advance()
    return s


def middle(s):
    """Return u (21,) [m/s] at the mid-section, y = 0, .05, ..., 1."""
    return np.reshape(next(sampled(s))[0]["middle"], (-1, 3))[:, 0]


def soften_lid(s):
    """Let the velocity of the lid rise smoothly from 0 at the ends of the tank, over one and a half of its heights.

    Where a lid of one speed meets an end, the velocity jumps, whatever the spacing. Rows there leave a flux through the
    tank of 0.055 U s that is not in the fluid: the error of every profile is then of first order.
    """
    p, length = s.particles, s.case.walls.width
    lid = (p.kind == WALL) & (p.x[:, 1] > 1.0 - 1e-6)
    part = np.clip(np.minimum(p.x[lid, 0], length - p.x[lid, 0]) / 1.5, 0.0, 1.0)
    p.wall_u[lid, 0] = s.case.walls.lid.velocity * part**2 * (3.0 - 2.0 * part)


def started_by_a_lid(y, time, viscosity, terms=30):
    """Return u/U at heights y (n,) of 1, after a lid has moved with U for a time [s], the flux being zero.

    u/U = 3 y^2 - 2 y - sum of a_n f_n(y) exp(-nu k_n^2 t). The f_n are zero at both walls and have no flux:
    sin(2 pi n z) with z = y - 1/2, and cos(k z) - cos(k/2) with tan(k/2) = k/2.
    """
    z, fine = y - 0.5, np.linspace(-0.5, 0.5, 4001)
    steady = 3.0 * y**2 - 2.0 * y
    start = 3.0 * fine**2 - 0.25
    weight = np.where(np.abs(fine) == 0.5, 0.5, 1.0)    # of the trapezoidal rule
    for n in range(1, terms + 1):
        steady -= ((-1.0) ** (n + 1) / (np.pi * n) * np.sin(2.0 * np.pi * n * z)
                   * np.exp(-viscosity * (2.0 * np.pi * n) ** 2 * time))
        k = 2.0 * _tangent_root(n)
        form = np.cos(k * fine) - np.cos(0.5 * k)
        share = np.sum(weight * start * form) / np.sum(weight * form * form)
        steady -= share * (np.cos(k * z) - np.cos(0.5 * k)) * np.exp(-viscosity * k**2 * time)
    return steady


def _tangent_root(n):
    """Return the n-th positive root of tan q = q."""
    low, high = n * np.pi, (n + 0.5) * np.pi
    for _ in range(60):
        q = 0.5 * (low + high)
        low, high = (low, q) if (-1) ** n * (np.sin(q) - q * np.cos(q)) > 0.0 else (q, high)
    return 0.5 * (low + high)


def forced(amplitude, viscosity):
    """Return the body force (x, y) that drives u = amplitude sin(2 pi y) (1 - exp(-nu 4 pi^2 t)) between walls that
    fluid sticks to."""
    return (f"{4.0 * np.pi**2 * viscosity * amplitude!r}*sin(2*pi*y)", 0.0)


def pushed(acceleration):
    """Return the body force (x, y) [m/s^2] that pushes the lower half of the fluid right and the upper half left."""
    return (f"{-acceleration!r}*tanh(1e9*(y - 0.5))", 0.0)


def started_by_a_push(y, time, viscosity, terms=50):
    """Return u nu/a at heights y (n,) of 1, after `pushed(a)` has acted for a time [s].

    By symmetry, u = 0 in the middle, and each half is a channel of the height h = 1/2, in which Poiseuille flow starts:
    u = a (h - y) y/(2 nu) - sum over odd m of 4 a h^2/(nu (pi m)^3) sin(pi m y/h) exp(-nu (pi m/h)^2 t).
    """
    h = 0.5
    z = np.where(y < h, y, 1.0 - y)
    found = 0.5 * z * (h - z)
    for m in range(1, 2 * terms, 2):
        decay = np.exp(-viscosity * (np.pi * m / h) ** 2 * time)
        found -= 4.0 * h**2 / (np.pi * m) ** 3 * np.sin(np.pi * m * z / h) * decay
    return np.where(y < h, found, -found)


# in a square with free-slip walls decays as exp(-2 nu pi^2 t)
VORTEX = ("sin(pi*x)*cos(pi*y)", "-cos(pi*x)*sin(pi*y)")


def vortex(x):
    """Return the velocity of VORTEX at x (n, 2): (n, 2) [m/s]."""
    a, b = np.pi * x.T
    return np.stack([np.sin(a) * np.cos(b), -np.cos(a) * np.sin(b)], axis=1)


def wave_over_a_bed(k, depth, viscosity, sticky, g=9.81):
    """Return the rate of damping [1/s] and the frequency [rad/s] of a small standing wave, exactly.

    Linear waves of viscous water (as Lamb 1932, Art. 349, for deep water) are u = i k f + s', v = f' - i k s times
    exp(i k x + c t), with f = A cosh(k y) + B sinh(k y) and s made of exp(-m y) and exp(m (y - d)), m^2 = k^2 + c/nu:
    no velocity at a sticky bed, else no flow through it and no shear; at the surface no shear, and
    c^2 f + 2 nu c v' + g v = 0.
    """
    def determinant(c):
        m = np.sqrt(k**2 + c / viscosity)
        thin = np.exp(-m * depth)
        # A, B, and s and s'/m at the surface, of two waves that meet the conditions at the bed
        if sticky:
            waves = ((-1j * m / k, 1j, thin, -thin), (1j * m / k * thin, 1j * thin, 1.0, 1.0))
        else:
            waves = ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0 - thin**2, 1.0 + thin**2))
        conditions = []
        for a, b, s, turn in waves:
            f = a * np.cosh(k * depth) + b * np.sinh(k * depth)
            slope = k * (a * np.sinh(k * depth) + b * np.cosh(k * depth))
            v, stretch = slope - 1j * k * s, k**2 * f - 1j * k * m * turn
            conditions.append((2j * k * slope + (m**2 + k**2) * s, c**2 * f + 2.0 * viscosity * c * stretch + g * v))
        return conditions[0][0] * conditions[1][1] - conditions[0][1] * conditions[1][0]

    omega = np.sqrt(g * k * np.tanh(k * depth))
    last, c = 0.9j * omega, 1j * omega - 2.0 * viscosity * k**2
    before = determinant(last)
    for _ in range(30):    # the secant method
        now = determinant(c)
        if now == before:
            break
        last, before, c = c, now, c - now * (c - last) / (now - before)
    return -c.real, c.imag


def decay(case, until, probe, frequencies, after=0.0, prepare=None):
    """Return the rate [1/s] and frequency [rad/s] of a wave at the first gauge of a case.

    until, after : times [s] to which it runs, and from which on the wave is fitted; probe : name of the gauge
    frequencies : first and last value between which it is looked for; prepare : changes the Simulation before it runs
    """
    s = simulated(case)
    if prepare:
        prepare(s)
    seen = takewhile(lambda _: s.time < until, sampled(s, case.probes[0]))
    t, y = np.transpose([(s.time, found[probe][0]) for found, _ in seen])
    return damped_wave(t[t > after], y[t > after], (0.0, 0.5), frequencies)


def damped_wave(t, y, rates, frequencies):
    """Return the rate [1/s] and frequency [rad/s] of exp(-rate t) cos(frequency t + phase) + level fitted to y (n,) at
    t (n,).

    rates, frequencies : first and last value between which they are looked for
    """
    for _ in range(5):
        ranges = [np.linspace(*limits, 11) for limits in (rates, frequencies)]
        _, rate, frequency = min((_residual(t, y, g, w), g, w) for g in ranges[0] for w in ranges[1])
        (rates, frequencies) = ((c - 1.5 * (r[1] - r[0]), c + 1.5 * (r[1] - r[0]))
                                for c, r in zip((rate, frequency), ranges))
    return rate, frequency


def _residual(t, y, rate, frequency):
    decay = np.exp(-rate * t)
    basis = np.stack([decay * np.cos(frequency * t), decay * np.sin(frequency * t), np.ones(len(t))], axis=1)
    return float(np.sum((y - basis @ np.linalg.lstsq(basis, y, rcond=None)[0]) ** 2))
