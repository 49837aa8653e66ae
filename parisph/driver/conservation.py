"""Conservation of volume and energy in a run: their initial, current and extreme values."""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Optional

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.fields import FLUID, SURFACE
from parisph.case.motion import AtRest
from parisph.case.schema import Box, Case
from parisph.driver.simulation import Simulation
from parisph.watch import instruments
from parisph.watch.probes.energy_probe import Energy
from parisph.watch.probes.volume import Volume
from parisph.watch.sampling import ProbeScene, View

EVERY = 10             # steps between two measurements of the volume, which take a twelfth of a step
VOLUME_LIMIT = 0.02    # change of the volume that is worth a warning
ENERGY_LIMIT = 2e-3    # rise of the energy above its start, of a flow without work on it
BREAKING = 'preset="violent" for steep or breaking waves'    # a further remedy for "gentle"
ROUNDING = 1e-12       # of the total energy: a smaller energy in motion counts as zero
TORN = 1.5             # times the particles of a level surface: with more, its elevation has no meaning
RANGES = ("energy", "motion", "kinetic", "volume")
# why they may not be a number
REASONS = {"energy": "a velocity or position is out of range", "volume": "nothing was 2.1 spacings inside the fluid"}


@dataclass
class Range:
    """A quantity over a run: its initial, current and extreme values, with their times [s].

    missing, missing_since : number of values that were not a number, and the time of the first
    """

    start: Optional[float] = None
    now: Optional[float] = None
    low: Optional[float] = None
    low_time: Optional[float] = None
    high: Optional[float] = None
    high_time: Optional[float] = None
    missing: int = 0
    missing_since: Optional[float] = None

    def add(self, time: float, value: float | None) -> None:
        """Add a value at `time` [s]; None or NaN counts as missing."""
        value = math.nan if value is None else float(value)
        self.now = value if math.isfinite(value) else None
        if self.now is None:
            self.missing += 1
            self.missing_since = time if self.missing_since is None else self.missing_since
            return
        self.start = value if self.start is None and not self.missing else self.start
        if self.low is None or value < self.low:
            self.low, self.low_time = value, time
        if self.high is None or value > self.high:
            self.high, self.high_time = value, time

    def relative(self, value: float | None) -> float | None:
        """Return a value relative to the start, minus one; None if undefined."""
        return value / self.start - 1.0 if self.start and value is not None else None

    def extremes(self) -> dict[str, float] | None:
        """Return {"low", "low_time", "high", "high_time"} relative to the start, minus one; None without a start."""
        low, high = self.relative(self.low), self.relative(self.high)
        if low is None or high is None or self.low_time is None or self.high_time is None:
            return None
        return {"low": low, "low_time": self.low_time, "high": high, "high_time": self.high_time}


class Conservation:
    """Follows volume and energy through a run, and over restarts.

    The energy is computed in each step, the volume (mean Voronoi cell inside the fluid) every EVERY steps. Fluid that
    has left the tank counts with its energy at that time. The potential energy is relative to the lowest corner of the
    tank, in the direction of gravity. So it is positive, and its relative change has the right sign.

    The energy in motion is the kinetic energy plus the potential energy above that of the fluid at rest: the energy of
    waves, which is small compared with the total potential energy. If a tank is the only wall and the water as wide as
    it, the elevation of the surface gives the potential energy: regularisation changes that of all particles by more
    than the energy of waves. It is unknown while the surface is torn. If that happens, the energy itself is not judged.

    state : `state()` of an earlier part of the run, or empty
    start : {"energy", "volume"} at the start of the run, or None; for a `state` without them
    """

    def __init__(self, simulation: Simulation, state: Mapping[str, Any] | None = None,
                 start: Mapping[str, float | None] | None = None) -> None:
        case = simulation.case
        self._scene = ProbeScene.of(case)
        self._energy = Energy(name="energy")
        volume = Volume(name="volume")
        self._volume = instruments.build(case.model_copy(update={"probes": (volume,)}), simulation.comm)
        self.driven, self._at_rest, self._lowest = case.driven, _rest(case, self._scene), _lowest(self._scene)
        self.by_surface = has_level(case, self._scene)
        self._or_violent = f", or {BREAKING}" if simulation.numerics.preset in ("gentle", "solitary") else ""
        state, start = state or {}, start or {}
        self.energy, self.motion, self.kinetic, self.volume = (
            Range(**state[name]) if name in state else Range(start=start.get(name)) for name in RANGES)

    def step(self, simulation: Simulation) -> None:
        """Measure the energy after a step, and from time to time the volume. Collective."""
        self._look_at_energy(simulation)
        if simulation.steps % EVERY == 0:
            self._look_at_volume(simulation)

    def measure(self, simulation: Simulation) -> None:
        """Measure both. Collective."""
        self._look_at_energy(simulation, whole=True)
        self._look_at_volume(simulation)

    def state(self) -> dict[str, Any]:
        """Return the data that a checkpoint needs for a restart. Not collective."""
        return {name: asdict(getattr(self, name)) for name in RANGES}

    def content(self) -> dict[str, Any]:
        """Return the entries of summary.json. Not collective."""
        energy, volume, motion = self.energy, self.volume, self.motion
        nothing = ROUNDING * abs(energy.start or 0.0)    # rounding of the total energy
        start, end, high = (0.0 if value is not None and abs(value) <= nothing else value
                            for value in (motion.start, motion.now, motion.high))
        change = None
        first, last = energy.start, energy.now
        if not self.driven and start is not None and start > 0.0 and first is not None and last is not None:
            change = (last - first) / start
            if self.by_surface and motion.now is not None:
                change = motion.now / start - 1.0
        return {
            "volume_drift": volume.relative(volume.now), "volume_range": volume.extremes(),
            "volume_unknown": REASONS["volume"] if volume.missing and volume.low is None else None,
            "energy_drift": energy.relative(energy.now), "energy_range": energy.extremes(),
            "energy_in_motion": None if motion.low is None else {
                "start": start, "end": end, "high": high, "high_time": motion.high_time, "drift": change,
                "unit": self._energy.columns_in(self._scene)["total"]},
            "driven": self.driven,
        }

    def passed(self) -> dict[str, str]:
        """Return {exceeded limit: message}. Not collective."""
        found = {}
        volume, energy = self.volume.extremes(), self.energy.extremes()
        for name in ("low", "high"):
            if volume and abs(volume[name]) > VOLUME_LIMIT:
                found[f"volume {name}"] = (
                    f"the volume was {volume[name]:+.1%} off its start at t = {volume[name + '_time']:.4g} s, more "
                    f"than {VOLUME_LIMIT:.0%}: use a smaller spacing or time step{self._or_violent}")
        judged = self.by_surface and not self.motion.missing    # by driver.diagnostics, from the energy in motion
        if energy and not self.driven and not judged and energy["high"] > ENERGY_LIMIT:
            found["energy"] = (
                f"the energy was {energy['high']:+.2%} above its start at t = {energy['high_time']:.4g} s, though "
                f"nothing does work on the fluid: use a smaller spacing or time step{self._or_violent}")
        for name, reason in REASONS.items():
            gaps = getattr(self, name)
            if gaps.missing and gaps.low is not None:
                found[f"{name} missing"] = (
                    f"the {name} was not a number {gaps.missing} time{'s' * (gaps.missing > 1)}, first at "
                    f"t = {gaps.missing_since:.4g} s: {reason}")
        return found

    def _look_at_energy(self, simulation: Simulation, whole: bool = False) -> None:
        s, p = simulation, simulation.particles
        view = View(p, s.domain, self._scene, s.time)
        sums = self._energy.sums(view)
        s.comm.Allreduce(MPI.IN_PLACE, sums, op=MPI.SUM)
        kinetic, potential, total = self._energy.values(sums, np.empty(0), view)
        self.energy.add(s.time, total + s.left.energy - self._lowest * (sums[2] + s.left.volume))
        self.kinetic.add(s.time, kinetic)
        if self.by_surface:
            if whole or s.steps % EVERY == 0:
                elevated = self._elevation(s)
                self.motion.add(s.time, None if elevated is None else kinetic + elevated)
        elif self._at_rest is not None:
            self.motion.add(s.time, kinetic + potential - self._at_rest(sums[2]))

    def _elevation(self, simulation: Simulation) -> float | None:
        """Return the potential energy of the elevation about its mean [J/m, in 3D J], None if torn. Collective."""
        s, p, scene = simulation, simulation.particles, self._scene
        top = np.concatenate(s.comm.allgather(p.x[(p.kind == FLUID) & (p.role == SURFACE)]))
        lower, upper = scene.lower[:-1], scene.upper[:-1]
        if not len(top) or len(top) > TORN * np.prod((upper - lower) / scene.step[:-1] + 1.0):
            return None
        part, z = _shares(top[:, :-1], lower, upper, float(min(scene.step))), top[:, -1]
        off = z - part @ z / part.sum()
        return float(0.5 * scene.density * abs(scene.gravity[-1]) * (part @ off**2))

    def _look_at_volume(self, simulation: Simulation) -> None:
        s = simulation
        found = instruments.sample_all(self._volume, s.particles, s.domain, s.time)
        self.volume.add(s.time, found["volume"][0])


def _shares(x: Floats, lower: Floats, upper: Floats, spacing: float) -> Floats:
    """Return the part of the width [m] or of the plan [m^2] of a tank that is nearest to each particle x (n, dim - 1).

    In 3D, places half a spacing apart are counted.
    """
    if x.shape[1] == 1:
        order = np.argsort(x[:, 0])
        at = x[order, 0]
        middle = np.r_[lower, 0.5 * (at[1:] + at[:-1]), upper]
        found = np.empty(len(x))
        found[order] = np.diff(middle)
        return found
    from scipy.spatial import cKDTree  # as methods.surface_load, only in 3D

    number = np.maximum(1, np.ceil(2.0 * (upper - lower) / spacing)).astype(int)
    axes = [low + (np.arange(n) + 0.5) * (high - low) / n for low, high, n in zip(lower, upper, number)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    nearest = cKDTree(x).query(places)[1]
    counts: Floats = np.bincount(nearest, minlength=len(x)) * (np.prod(upper - lower) / len(places))
    return counts


def has_level(case: Case, scene: ProbeScene) -> bool:
    """Return whether the water is as wide as a tank at rest without other walls, with gravity downwards.

    Then its surface has a level: its volume over the width or the plan of the tank.
    """
    tank, gravity = case.tank, scene.gravity
    if tank is None or len(case.all_bodies) > 1 or not isinstance(tank.motion, AtRest) or case.closed:
        return False
    if len(case.fluids) > 1 or case.fluids[0].holes or gravity[:-1].any() or not gravity[-1] < 0.0:
        return False
    lower, upper = (np.asarray(corner) for corner in case.fluid_bounds)
    on_bed = lower[-1] <= scene.lower[-1] + case.numerics.spacing    # water in the air has no level
    return bool(on_bed and np.allclose((lower[:-1], upper[:-1]), (scene.lower[:-1], scene.upper[:-1])))


def _lowest(scene: ProbeScene) -> float:
    """Return the least potential energy of a volume of fluid in the scene's box [J/m^3].

    The datum is that of the probe Energy.
    """
    return scene.density * float(np.minimum(0.0, scene.gravity * (scene.lower - scene.upper)).sum())


def _rest(case: Case, scene: ProbeScene) -> Callable[[float], float] | None:
    """Return the potential energy at rest as a function of the volume, or None if it is not defined.

    It is defined for a tank with vertical walls, with gravity downwards. Particles represent the volumes around them,
    as at the start (Filling.cells): particles at the bed 3/2 cells, those on the surface 1/2. So at rest on the lattice
    their potential energy is proportional to d^2/2 + s^2/2, that of water of depth d to d^2/2. This applies if the
    water is as wide as the tank; other water comes to rest off the lattice. Without a force it is 0.
    """
    g, density = scene.gravity, case.density
    if not case.driven and not g.any():
        return lambda volume: 0.0
    if case.lone_tank is None or np.abs(g[:-1]).max(initial=0.0) > 1e-12 * abs(g[-1]) or not g[-1] < 0.0:
        return None
    width = float(np.prod((scene.upper - scene.lower)[:-1]))
    lower, upper = case.bounds_of(case.fluids[0])
    spans = (isinstance(case.fluids[0].shape, Box) and len(case.fluids) == 1 and not case.closed
             and np.allclose((upper - lower)[:-1], (scene.upper - scene.lower)[:-1]))
    extra = width * scene.step[-1] ** 2 if spans else 0.0
    return lambda volume: 0.5 * density * abs(g[-1]) * (volume**2 / width + extra)
