"""Snapshots of the flow at the greatest values of probes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base.arrays import Array
from parisph.base.errors import StoreError
from parisph.base.log import logger
from parisph.case.model import Model
from parisph.case.truths import intervals
from parisph.driver.simulation import Simulation
from parisph.io import snapshot
from parisph.io.files import on_first
from parisph.io.layout import BEFORE, PEAKS
from parisph.io.store import Store
from parisph.methods.written import WRITTEN
from parisph.parallel.particles import Particles
from parisph.watch.sampling import Sampler

FALL = 0.1  # of the range of a probe so far: a value as far as this below the greatest has left the peak behind


@dataclass
class Copied:
    """A copy of this rank's particles that can be written as a snapshot. The fields are attributes, as of Particles."""

    dim: int
    n_owned: int
    offset: int
    n_global: int
    arrays: dict[str, Array]

    def __getattr__(self, name: str) -> Array:
        return self.arrays[name]


class Peaks:
    """Keeps the flow at the greatest value of each probe with peak=True, within the window or bands of its truth.

    When a probe has a new maximum, this rank's particles are copied in memory. They are written when
    the value has clearly fallen, at each checkpoint, and at the end of the run. Every step counts, and
    the values are the same on all ranks. Means of pressures, which are known some steps later, do not count here, but
    those over the last steps (watch.means.Means.lately), which may differ from them a little.

    Parameters
    ----------
    simulation : Simulation
    samplers : list of Sampler, of all probes
    fields : names of the fields in snapshots
    state : dict of an earlier part of the run, from its checkpoint (see `state`)
    """

    def __init__(self, simulation: Simulation, samplers: Sequence[Sampler], fields: Sequence[str],
                 state: Mapping[str, Any] | None = None) -> None:
        self.simulation, self.samplers = simulation, [sampler for sampler in samplers if sampler.probe.peak]
        self._fields = ("x", *snapshot.check_fields(fields))
        self._computed = [name for name in fields if name in WRITTEN]
        names = {sampler.name for sampler in self.samplers}
        self._seen = {name: dict(seen) for name, seen in (state or {}).items() if name in names}
        self._held: dict[str, Copied] = {}    # probe -> the flow at its greatest value, not yet written
        self._saved = set(self._seen)   # probes whose file the last checkpoint knows

    def look(self, found: Mapping[str, Sequence[float]]) -> None:
        """Copy the flow if a probe has a new maximum. values : {probe: values} of this step. Collective."""
        s = self.simulation
        # all ranks write together or not at all: one of them says what the sums of all are, to the last bit
        values = [found[sampler.name][0] for sampler in self.samplers]
        if values and s.comm.size > 1:
            values = s.comm.bcast(values)
        computed = not self._computed
        for sampler, value in zip(self.samplers, values):
            counts = _counts(sampler.probe.truth, s.pressure_time if sampler.of_pressure else s.time)
            if not np.isfinite(value) or not (counts or sampler.name in self._seen):
                continue
            seen = self._seen.setdefault(sampler.name, {"least": value, "greatest": -np.inf})
            seen["least"] = min(seen["least"], value)
            if counts and value > seen["greatest"]:
                seen.update(greatest=value, time=s.time, step=s.steps)
                if not computed:
                    s.complete(self._computed)
                    computed = True
                self._held[sampler.name] = _copied(s.particles, self._fields)
            seen["now"] = value

    def write(self, store: Store, all_of_them: bool = False) -> None:
        """Write the copies whose probes have clearly fallen since, or all copies. Collective.

        Raises StoreError on every rank.
        """
        for name in [name for name in self._held if all_of_them or self._passed(name)]:
            seen, keep = self._seen[name], name in self._saved
            store.peak(self._held.pop(name), seen["time"], seen["step"], name, seen["greatest"], keep)
            self._saved.discard(name)

    def state(self) -> dict[str, Any]:
        """Return the data that a checkpoint needs, after all copies have been written. Not collective."""
        self._saved = set(self._seen)
        return {name: dict(seen) for name, seen in self._seen.items()}

    def bring(self, folder: Path) -> None:
        """Read the flows at the peaks so far from another folder of the run, to write them again. Collective.

        The log names missing files; they are not an error, and the greatest values stay known.
        """
        s = self.simulation
        for name, seen in self._seen.items():
            found = on_first(s.comm, f"read the flow at the peak of {name} in {folder}",
                             lambda: self._read(folder, name, seen))
            total = s.comm.bcast(None if found is None else len(found["x"]))
            if total is None:
                logger.warning(f"the flow at the peak of {name} so far, t = {seen['time']:.6g} s, "
                               f"is not in {folder} any more")
                continue
            # the first rank has all of it
            dim = s.particles.dim
            mine = found or {key: s.particles.fields[key].empty(0, dim) for key in self._fields}
            self._held[name] = Copied(dim, n_owned=len(mine["x"]), offset=0 if found else total,
                                      n_global=total, arrays=mine)
        self._saved = set()

    def _read(self, folder: Path, name: str, seen: Mapping[str, Any]) -> dict[str, Array] | None:
        """Return {field: array} of the flow at the known peak, None if it is not in the folder. One rank."""
        for place in (PEAKS, BEFORE):
            path = folder / place / f"{name}.vtkhdf"
            try:
                about = snapshot.read_attributes(path)
                if (about.get("step"), about.get("peak")) == (seen["step"], seen["greatest"]):
                    found = snapshot.read(path)
                    return {key: found[key] for key in self._fields}
            except (StoreError, KeyError):
                continue
        return None

    def _passed(self, name: str) -> bool:
        seen = self._seen[name]
        return bool(seen["now"] < seen["greatest"] - FALL * (seen["greatest"] - seen["least"]))


def _counts(truth: Model | None, time: float) -> bool:
    """Return whether the value of a probe at a time [s] may be its greatest: another event is not that of its truth."""
    where = intervals(truth)
    return not where or any(start <= time <= end for start, end in where)


def _copied(particles: Particles, fields: Sequence[str]) -> Copied:
    arrays = {name: np.array(getattr(particles, name)) for name in fields}
    return Copied(particles.dim, particles.n_owned, particles.offset, particles.n_global, arrays)
