"""Fluid whose particles do not start on a square lattice keeps the cells that they stand for at the start."""

import numpy as np
import pytest

from parisph import Box, Case, Energy, Fluid, Numerics, SolitaryWave, StandingWave, StillWater, SurfaceGauge, Tank
from parisph.base.fields import FLUID, INNER, SURFACE
from parisph.case.waves import angular_frequency
from parisph.io import reader
from tests.scenes import run_alone, sampled, simulated, water

G, D, LENGTH = 9.81, 1.0, 14.0
RUN_UP = 0.42411823    # in depths, of a wave of .2 depths on a vertical wall: exact, by a spectral method of high order


def wave(shape, height=0.2, spacing=0.125):
    fluid = Fluid(shape, density=1000.0, wave=SolitaryWave(height=height * D, depth=D, at=8.0))
    return Case(title="solitary wave", fluid=fluid, walls=Tank(width=LENGTH, height=2.0), gravity=(0.0, -G),
                numerics=Numerics(spacing=spacing), end_time=2.6)


@pytest.mark.parametrize("shape", [Box(width=LENGTH, height=D), StillWater(level=D)], ids=["stretched", "moved up"])
def test_no_density_is_missing_at_the_start(shape):
    """Cells under the crest are a fifth higher than those of the lattice, or layers do not divide the depth."""
    s = simulated(wave(shape))
    s.solve_start()
    s.advance()
    p, h = s.particles, s.numerics.spacing
    surface = p.x[(p.kind == FLUID) & (p.role != INNER)]
    inner = (p.kind == FLUID) & (p.role == INNER) & (p.x[:, 1] > 1.5 * h)
    below = np.interp(p.x[:, 0], *surface[np.argsort(surface[:, 0])].T) - p.x[:, 1]
    deep = inner & (below > 3.0 * h)
    assert deep.sum() > 400
    error = np.sqrt(np.mean((p.alpha[deep] - 1.0)**2))
    halves = s.method.flow.cells[:p.n_owned][(p.kind == FLUID) & (p.role == SURFACE) & (np.abs(p.x[:, 0] - 7.0) < 6.0)]
    assert error < 0.01    # with equal weights .088, and .015 where particles are moved up
    if isinstance(shape, Box):
        np.testing.assert_allclose(halves, 0.5)    # whatever the stretch


def test_a_stretched_wave_runs_up_a_wall():
    """With cells of one size as the aim, it keeps half of its height: .24 depths."""
    s = simulated(wave(Box(width=LENGTH, height=D)))
    s.solve_start()
    highest = max(found["wall"][0] for found, _ in sampled(s, SurfaceGauge("wall", at=LENGTH)))
    assert highest - D == pytest.approx(RUN_UP * D, rel=0.05)


def test_a_standing_wave_at_its_highest_gains_nothing(tmp_path):
    """Cells of its start differ by a tenth. Distances become even, volumes do not, and voids that this leaves are none:
    filled, they give the wave 5 % in five periods."""
    depth, k = 1.0, np.pi
    period = 2.0 * np.pi / float(angular_frequency(k, depth, 9.81))
    wave = StandingWave(amplitude=0.05, length=2.0, depth=depth, phase=0.5 * np.pi)
    case = water((1.0, depth), (1.0, 2.0 * depth), dict(spacing=0.05, preset="gentle"), wave=wave,
                 probes=[Energy("energy")], end_time=6.0 * period)
    found = run_alone(case, tmp_path / "run")
    energy = reader.open_run(tmp_path / "run").probe("energy")
    first, last = (energy["kinetic"][(energy["time"] >= i * period) & (energy["time"] < (i + 1) * period)].max()
                   for i in (0, 5))
    assert 0.97 < last / first < 1.003
    assert abs(found["volume_drift"]) < 1e-3
