"""Waves in 3D that do not break, at two spacings: modes of tanks with flat and round walls, and a diagonal sway."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import j0, jnp_zeros

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Numerics,
    StandingWave,
    StillWater,
    Surface,
    SurfaceGauge,
    Tank,
    TankMode,
)
from parisph.base.table import read_reference
from parisph.case.waves import angular_frequency
from tests.lasting.harmonics import by_period
from tests.launch import ROOT
from tests.scenes import free, sampled, simulated
from tests.triangles import prism, write_stl
from tests.validation.record import Row, said

G, DENSITY = 9.81, 1000.0
LENGTH, BREADTH, DEPTH, RADIUS = 1.0, 0.8, 0.5, 0.5    # of the tanks and of the round one [m]
HEIGHT, AMPLITUDE = 0.7, 0.0025                        # of the walls, and of the waves [m]
ROUND = 0.002                                          # amplitude of the wave in the round tank in its middle [m]
SLAB = 6                                               # spacings: breadth of a slab
PERIODS, LONG, SWAY = 4.0, 20.0, 10.0                  # length of the runs [periods]; of the sway [s]
GAUGES = 4       # along a side, in the middles of equal parts: their mean is free of the first seven modes
TERMS = 14       # of the series of J0, exact to rounding up to the wall
SIDES = 96       # of the round tank
DEPTHS = (10, 20)    # over the spacing


class Wave(NamedTuple):
    """A decaying oscillation: angular frequency [rad/s] and amplitude at the end of the record [m]."""

    omega: float
    amplitude: float


def rows(bench):
    """Return the errors of frequencies, amplitudes and elevations, and the growth of energy, as required."""
    found = said(_lasting())
    for cells in DEPTHS:
        for part in (_slab, _round, _oblique, _sway):
            found += said(part(bench, cells))
    return found


# -- modes of a tank ------------------------------------------------------------------------

def _slab(bench, cells):
    """Rows of mode (1, 0) in a slab against the same in 2D."""
    plane, slab = (_mode(case, (1, 0)) for case in (plane_case(cells), tank_case((1, 0), cells, SLAB * DEPTH / cells)))
    exact = _exact((1, 0))
    what = f"mode (1, 0) in a slab of {SLAB} s, d/s = {cells}, {PERIODS:g} periods"
    return [Row(f"{what}: frequency over that of 2D - 1", abs(slab.omega / plane.omega - 1.0), 0.001),
            Row(f"{what}: amplitude over that of 2D - 1", abs(slab.amplitude / plane.amplitude - 1.0), 0.01),
            Row(f"{what}: error of the frequency", abs(slab.omega / exact - 1.0)),
            Row(f"{what}: error of the frequency in 2D", abs(plane.omega / exact - 1.0))]


def _oblique(bench, cells):
    """Rows of mode (1, 1) against linear theory."""
    found = []
    for jitter in (0.0, 0.4) if cells == DEPTHS[0] else (0.0,):
        wave = _mode(tank_case((1, 1), cells, BREADTH, jitter), (1, 1))
        what = f"mode (1, 1), jitter {jitter:g}, d/s = {cells}, {PERIODS:g} periods"
        found += [Row(f"{what}: error of the frequency", abs(wave.omega / _exact((1, 1)) - 1.0), 0.003),
                  Row(f"{what}: amplitude at the end / a", wave.amplitude / AMPLITUDE)]
    return found


def _lasting():
    """Rows of mode (1, 1) over twenty periods: the energy in motion of none of them is above that of the first."""
    case = tank_case((1, 1), DEPTHS[0], BREADTH, periods=LONG)
    time, gauges, kinetic = record(case)
    motion = kinetic + 0.5 * DENSITY * G * LENGTH * BREADTH * (gauges**2).mean(axis=1)
    mean = by_period(time, motion, 2.0 * np.pi / _exact((1, 1))).mean
    what = f"mode (1, 1), d/s = {DEPTHS[0]}, {LONG:g} periods: energy in motion"
    return [Row(f"{what}, highest period over the first", mean[1:].max() / mean[0], 1.0),
            Row(f"{what}, highest over the start", motion.max() / motion[0]),
            Row(f"{what}, last period over the first", mean[-1] / mean[0])]


def tank_case(modes, cells, breadth, jitter=0.0, periods=PERIODS):
    """Return the Case of a mode in a 3D tank of a breadth [m], from level water. cells : d/s; periods : its length"""
    wave = TankMode(AMPLITUDE, modes, LENGTH, BREADTH if modes[1] else breadth, DEPTH)
    places = [(x, y) for x in _middles(LENGTH) for y in _middles(breadth)]
    return _case(Fluid(Box(LENGTH, DEPTH), DENSITY, wave=wave), Tank(LENGTH, HEIGHT, breadth=breadth), cells, places,
                 periods * 2.0 * np.pi / _exact(modes), jitter)


def plane_case(cells):
    """Return the Case of mode 1 in a 2D tank."""
    wave = StandingWave(AMPLITUDE, 2.0 * LENGTH, DEPTH)
    return _case(Fluid(Box(LENGTH, DEPTH), DENSITY, wave=wave), Tank(LENGTH, HEIGHT), cells, _middles(LENGTH),
                 PERIODS * 2.0 * np.pi / _exact((1, 0)))


def _case(fluid, walls, cells, places, end_time, jitter=0.0):
    """Return the Case of water with gauges at places, and with the time step of cases/small_sloshing.py."""
    step = min(0.12, 0.76 / np.sqrt(cells)) * np.sqrt(DEPTH / G)
    return Case(title="A mode of a tank", fluid=fluid, walls=walls, gravity=(0.0, -G), end_time=end_time,
                numerics=Numerics(preset="gentle", spacing=DEPTH / cells, jitter=jitter, seed=1, time_step=step),
                probes=[*(SurfaceGauge(f"gauge_{number}", at=at) for number, at in enumerate(places)),
                        Energy("energy")])


def _middles(length):
    return (np.arange(GAUGES) + 0.5) * length / GAUGES


def _exact(modes):
    """Return the angular frequency [rad/s] of a mode of the tank."""
    return float(angular_frequency(np.pi * np.hypot(modes[0] / LENGTH, modes[1] / BREADTH), DEPTH, G))


def _mode(case, modes):
    """Run a case and return the Wave of its mode: the elevations projected on it."""
    time, gauges, _ = record(case)
    shape = np.cos(modes[0] * np.pi / LENGTH * _middles(LENGTH))
    if case.dim == 3:
        shape = np.outer(shape, np.cos(modes[1] * np.pi / BREADTH * _middles(BREADTH))).ravel()
    return fitted(time, gauges @ shape / (shape @ shape), _exact(modes))


def record(case):
    """Run a case; return times (n,) [s], the elevations of its gauges (n, gauges) [m] and kinetic energies (n,) [J]."""
    simulation = simulated(case)
    found = []
    for values, _ in sampled(simulation):
        kinetic, *_ = values.pop("energy")
        found.append((simulation.time, kinetic, *(value[-1] for value in values.values())))
    free()
    time, kinetic, *levels = np.array(found).T
    return time, np.array(levels).T - DEPTH, kinetic


def fitted(time, values, omega):
    """Return the Wave that fits a signal (n,) [m] at times (n,) [s] best, from a first guess of omega [rad/s]."""
    def parts(unknown):
        return np.exp(-unknown[1] * time)[:, None] * np.stack(
            [np.cos(unknown[0] * time), np.sin(unknown[0] * time), np.exp(unknown[1] * time)], axis=1)

    def weights(unknown):
        return np.linalg.lstsq(parts(unknown), values, rcond=None)[0]

    size = np.abs(values).max()
    best = least_squares(lambda unknown: (parts(unknown) @ weights(unknown) - values) / size, (omega, 0.0)).x
    return Wave(float(best[0]), float(np.hypot(*weights(best)[:2]) * np.exp(-best[1] * time[-1])))


# -- the round tank -------------------------------------------------------------------------

def _round(bench, cells):
    """Rows of the first axisymmetric wave in a round tank, from rest, against linear theory."""
    k = float(jnp_zeros(0, 1)[0]) / RADIUS
    omega = float(angular_frequency(k, DEPTH, G))
    time, gauges, _ = record(round_case(cells, k, PERIODS * 2.0 * np.pi / omega, bench.folder))
    r, weight = _radii()
    shape = weight * r * j0(k * r)
    projected = gauges[:, 1:].reshape(len(time), len(r), -1).mean(axis=2) @ shape / (shape @ j0(k * r))
    wave, due, first = fitted(time, projected, omega), ROUND * np.cos(omega * time), time <= 2.0 * np.pi / omega
    what = f"axisymmetric wave in a round tank, d/s = {cells}, {PERIODS:g} periods"
    return [Row(f"{what}: error of the frequency", abs(wave.omega / omega - 1.0), 0.01),
            Row(f"{what}: amplitude at the end / a", wave.amplitude / ROUND),
            *(Row(f"{what}: relative L2 error of the elevation in the middle{part}",
                  np.linalg.norm(gauges[chosen, 0] - due[chosen]) / np.linalg.norm(due[chosen]), aim=0.01)
              for part, chosen in ((", first period", first), ("", first | True)))]


def round_case(cells, k, end_time, folder):
    """Return the Case of the wave a J0(k r), raised and at rest at the start. folder : Path, for the file of the wall

    The gauges are in the middle, and at four places on each of some radii.
    """
    side = 2.4 * RADIUS
    middle = np.full(2, 0.5 * side)
    series = "1"
    for n in range(TERMS, 0, -1):    # J0(k r) = 1 - q (1 - q/4 (1 - q/9 (...))), q = (k r)^2/4
        series = f"(1 - {0.25 * k**2!r}*((x - {middle[0]!r})**2 + (y - {middle[1]!r})**2)/{n**2}*{series})"
    corner = RADIUS * np.sqrt(2.0 * np.pi / SIDES / np.sin(2.0 * np.pi / SIDES))    # the area is that of the circle
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    outline = middle + corner * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    wall = write_stl(folder / "round.stl", prism(outline, -0.2, HEIGHT + 0.2))
    places = [middle, *(middle + r * np.array(way) for r in _radii()[0]
                        for way in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)))]
    return _case(Fluid(StillWater(DEPTH), DENSITY, elevation=f"{ROUND}*{series}"),
                 (Tank(side, HEIGHT, breadth=side), Surface(file=str(wall), side="inside")), cells,
                 [tuple(map(float, place)) for place in places], end_time)


def _radii():
    """Return radii (n,) [m] and weights (n,) [m] of Gauss' rule from the middle to the wall."""
    x, weight = np.polynomial.legendre.leggauss(5)
    return 0.5 * RADIUS * (1.0 + x), 0.5 * RADIUS * weight


# -- the tank that sways along its diagonal --------------------------------------------------

def _sway(bench, cells):
    """Rows of the diagonal sway against linear theory, its errors over that of the same sway in 2D."""
    unit = np.sqrt(DEPTH / G)
    plane, _ = bench.run(f"sway in 2D, d/s = {cells}", "small_sloshing", spacing=1.0 / cells, end_time=SWAY / unit)
    oblique, _ = bench.run(f"diagonal sway, d/s = {cells}", "sloshing_3d", spacing=1.0 / cells, end_time=SWAY)
    known = _error(plane.probe("left"), "small_sloshing.csv", "eta_linear_m")
    what = f"diagonal sway, d/s = {cells}, {SWAY:g} s"
    found = [Row(f"{what}: wave error at the wall in 2D", known)]
    for name in ("corner", "side", "quarter"):
        error = _error(oblique.probe(name), "diagonal_sway.csv", f"{name}_m")
        found += [Row(f"{what}: wave error, {name}", error),
                  Row(f"{what}: wave error, {name}, over that at the wall in 2D", error / known, 1.3)]
    return found


def _error(gauge, file, column):
    """Return the relative L2 error of the elevation of a gauge against a column of a file of cases/exact."""
    time, truth = read_reference(ROOT / "cases" / "exact" / file, "t_s", column)
    due = np.interp(gauge["time"], time, truth)
    return float(np.linalg.norm(gauge[gauge.dtype.names[-1]] - DEPTH - due) / np.linalg.norm(due))
