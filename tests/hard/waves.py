"""Waves with the violent preset: standing, sloshing, shaken from below; and gentle ones run backwards."""

import re
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from parisph.base.fields import FLUID, SURFACE
from parisph.case.load import load
from parisph.case.schema import Box, Case, Fluid, Numerics, Sway, Tank
from parisph.case.waves import angular_frequency, standing_wave_start
from parisph.driver.conservation import Conservation
from tests.hard.flow import Bench, History
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.launch import ROOT
from tests.scenes import scene

G, DEPTH = 9.81, 1.0
K = np.pi / DEPTH                               # of the standing wave in a tank of two depths
OMEGA = float(angular_frequency(K, DEPTH, G))
PERIOD = 2.0 * np.pi / OMEGA
SHAKES = 6                                      # periods of the Faraday wave
STRENGTH = 0.2                                  # acceleration of the tank over g


def mode(s, k: float = K, length: float = 2.0 * DEPTH) -> float:
    """Return the first cosine mode of the surface over its length, 2/L int eta cos(kx) dx [m].

    The surface joins the surface particles by straight lines; it is level from the outermost ones to the walls.
    """
    p = s.particles
    x = p.x[(p.kind == FLUID) & (p.role == SURFACE)]
    x = x[np.argsort(x[:, 0])]
    at = (np.arange(400) + 0.5) * length / 400
    return float(2.0 * np.mean(np.interp(at, x[:, 0], x[:, 1] - DEPTH) * np.cos(k * at)))


def modal_energy(t, a) -> np.ndarray:
    """Return a^2 + (da/dt / omega)^2 of a mode a (n,) [m] at times t (n,) [s]."""
    return a**2 + (np.gradient(a, t) / OMEGA) ** 2


def standing(bench: Bench, amplitude: float, time_step: float | None) -> list[Line]:
    """The standing wave of cases/ for 9 s, nearly 8 periods. amplitude : a/d; time_step : dt sqrt(g/d) or None"""
    case = scene("standing_wave", {} if time_step else {"time_step": None}, spacing=0.05, preset="violent",
                 amplitude=amplitude, time_step=time_step or 0.064)
    t, a = bench.follow(case, lambda s: (s.time, mode(s))).T
    energy = modal_energy(t, a)
    start, last = (amplitude * DEPTH) ** 2, energy[t > t[-1] - PERIOD].mean()
    periods = [energy[(t >= k * PERIOD) & (t < (k + 1) * PERIOD)].mean() / start for k in range(int(t[-1] / PERIOD))]
    return [Line("modal energy of the last period over that of the start", last / start),
            Line("its change", abs(last / start - 1.0), 0.15, 0.05 if amplitude > 0.02 else None),
            Line("least of any period", min(periods)), Line("greatest of any period", max(periods))]


def sloshing(spacing: float, end: float) -> Case:
    """Return the first case of the README."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    text, = (block for block in re.findall(r"^```python\n(.*?)^```", readme, flags=re.M | re.S) if "def case(" in block)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sloshing.py"
        path.write_text(text, encoding="utf-8")
        return load(path, {"spacing": spacing, "end_time": end})


def sloshing_energy(bench: Bench) -> list[Line]:
    """Energy of the waves after 3 s; linear theory has 146 J/m."""
    watch = None
    for s in bench.flow(sloshing(0.02, 3.0)):
        watch = watch or Conservation(s)
        watch.step(s)
    return [Line("energy in motion after 3 s [J/m]", watch.motion.now, 132.0, 138.0, least=True)]


def resonance(bench: Bench) -> list[Line]:
    """The README's tank with a lid 0.2 m above the water, shaken at resonance for 20 s: it is hit again and again."""
    case = sloshing(0.02, 20.0).changed(**{"walls.height": 0.6})
    found = History.of(bench, case)
    return [*found.volume_lines(), Line("largest energy over that at rest", found.total.max() / found.total[0])]


def faraday(bench: Bench) -> list[Line]:
    """A tank shaken vertically at twice a wave's frequency: the wave grows as the Mathieu equation says.

    Of a wave that starts with a flat surface, half grows and half decays at the rate e omega/4, e = a Omega^2/g:
    its energy is that of the start times cosh(e omega t/2).
    """
    end, start = SHAKES * PERIOD, 0.0125 * DEPTH
    box = Box(width=2.0 * DEPTH, height=DEPTH)
    fluid = Fluid(box, density=1000.0, velocity=standing_wave_start(start, K, DEPTH, G))
    case = Case(title="Faraday wave", fluid=fluid, walls=Tank(width=2.0 * DEPTH, height=2.0 * DEPTH), gravity=(0.0, -G),
                frame=Sway(amplitude=STRENGTH * G / (2.0 * OMEGA) ** 2, frequency=2.0 * OMEGA, direction=(0.0, 1.0)),
                numerics=Numerics(spacing=0.05), end_time=end)
    t, a = bench.follow(case, lambda s: (s.time, mode(s))).T
    energy = modal_energy(t, a)
    last = t > t[-1] - PERIOD
    theory = start**2 * np.mean(np.cosh(0.5 * STRENGTH * OMEGA * t[last]))
    return [Line("amplitude in the last of 6 periods / Mathieu", np.sqrt(energy[last].mean() / theory)),
            Line("amplitude in the last period / start", np.sqrt(energy[last].mean()) / start, 2.0, least=True)]


def backwards(bench: Bench, amplitude: float = 0.0125) -> list[Line]:
    """A gentle standing wave for one period, then with reversed velocities for one more: it should come back."""
    case = scene("standing_wave", spacing=0.05, amplitude=amplitude)
    steps, way = round(PERIOD / case.numerics.time_step), 0.0
    for s in bench.flow(case, most=2 * steps):
        p = s.particles
        if s.steps == 0:
            start = p.x.copy(), p.u.copy(), p.id.copy()
        way = max(way, np.linalg.norm(_sorted(p.x, p.id) - _sorted(start[0], start[2]), axis=1).max())
        if s.steps == steps:
            p.u *= -1.0
    back = _sorted(p.x, p.id) - _sorted(start[0], start[2]), _sorted(p.u, p.id) + _sorted(start[1], start[2])
    rms = np.sqrt((back[1] ** 2).sum() / (start[1] ** 2).sum())
    return [Line("largest return error of the positions / longest way", np.linalg.norm(back[0], axis=1).max() / way),
            Line("rms return error of the velocities / those of the start", rms)]


def _sorted(values, number):
    return values[np.argsort(number)]


STANDING = ((0.05, 0.064), (0.05, 0.032), (0.05, None), (0.0125, 0.064))    # a/d, dt sqrt(g/d)
SCENES = {
    **{f"wave-{amplitude:g}-{step or 'adaptive'}": Scene(
        f"standing wave, violent preset, a/d = {amplitude:g}, s/d = 0.05, dt* {step or 'adaptive'}, 9 s",
        partial(standing, amplitude=amplitude, time_step=step)) for amplitude, step in STANDING},
    "sloshing": Scene("the README's sloshing, s = 0.02 m, 3 s", sloshing_energy),
    "sloshing-lid": Scene("resonance sloshing with lid impacts, s = 0.02 m, 20 s", resonance, may_stop=True),
    "faraday": Scene("Faraday wave: a tank shaken vertically", faraday),
    "backwards": Scene("a gentle wave run backwards", backwards),
}
