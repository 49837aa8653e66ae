"""Snapshots of the flow at the greatest values of probes."""

from collections.abc import Callable, Collection, Mapping, Sequence
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
from parisph.io.checkpoint import Share
from parisph.io.files import on_first
from parisph.io.layout import BEFORE, PEAKS
from parisph.io.store import Store
from parisph.methods.written import WRITTEN
from parisph.parallel.particles import Particles
from parisph.watch.sampling import Sampler

FALL = 0.1  # of the range of a probe so far: a value this far below the greatest ends the peak


@dataclass
class Copied:
    """A copy of this rank's particles that can be written as a snapshot. Its fields are attributes, as of Particles."""

    dim: int
    n_owned: int
    offset: int
    n_global: int
    arrays: dict[str, Array]

    def __getattr__(self, name: str) -> Array:
        return self.arrays[name]


@dataclass
class Waiting:
    """The flow after a step whose pressure means are not yet known.

    pressure : time of its pressure [s]; time : of its end [s]; at_edge : whether a window begins or ends here
    """

    pressure: float
    time: float
    step: int
    flow: Copied
    at_edge: bool


class PeakFlows:
    """Keeps the flow at the greatest value of each probe with peak=True, within the window or bands of its truth.

    At a new maximum of a probe, the particles of this rank are copied in memory. They are written when the value has
    clearly fallen, at each checkpoint, and at the end of the run. Every step counts, and values are equal on all ranks.

    Means of pressures are known only some steps later. Their line is straight between its knots, so its maximum is at a
    knot, or at the first or last step of a window. The flows of these steps, one or two at a time, wait in memory and
    in checkpoints until their means are known. Those at the end of a run are judged there, and again if it continues.

    samplers : list of Sampler, of all probes
    fields : names of the fields in snapshots
    state, waiting : `state()` and `waiting()` of an earlier part of the run, from its checkpoint
    flows : the waiting flows of the same checkpoint
    """

    def __init__(self, simulation: Simulation, samplers: Sequence[Sampler], fields: Sequence[str],
                 state: Mapping[str, Any] | None = None, waiting: Mapping[str, Any] | None = None,
                 flows: Sequence[Share] = ()) -> None:
        self.simulation, self.samplers = simulation, [sampler for sampler in samplers if sampler.probe.peak]
        self._fields = ("x", *snapshot.check_fields(fields))
        self._computed = [name for name in fields if name in WRITTEN]
        names = {sampler.name for sampler in self.samplers}
        self._seen = {name: dict(seen) for name, seen in (state or {}).items() if name in names}
        self._held: dict[str, Copied] = {}    # probe -> the flow at its greatest value, not yet written
        self._saved = set(self._seen)   # probes whose files are in the last checkpoint
        dim = simulation.particles.dim
        self._waiting = [Waiting(pressure, time, step, Copied(dim, len(flow.arrays["x"]), flow.offset, flow.total,
                                                              flow.arrays), at_edge)
                         for (pressure, time, step, at_edge), flow in zip((waiting or {}).get("steps", ()), flows)]
        self._last: dict[str, tuple[dict[str, Any], Copied]] = {}    # probe -> peak in the last steps of the run
        self.replaced = [name for name in (waiting or {}).get("last", ()) if name in self._seen]    # by such a peak
        self._copy: tuple[int, Copied] | None = None    # of a step

    def look(self, found: Mapping[str, Sequence[float]]) -> None:
        """Copy the flow if a probe has a new maximum. found : {probe: values} of this step. Collective."""
        s = self.simulation
        for sampler, value in self._agreed(found):
            at = s.pressure_time if sampler.of_pressure else s.time
            self._judge(sampler, value, _counts(sampler.probe.truth, at), s.time, s.steps, self._flow)

    def look_at_means(self, names: Collection[str], knots: Sequence[float], known: float,
                      means: Callable[[float], Mapping[str, Sequence[float]]]) -> None:
        """Let the flow of this step wait, and judge those whose means are now known. Collective.

        names : of probes with means; knots : times [s] of the knots after `known`
        known : time [s] up to which means are known; means : function of a time [s] up to `known`, {probe: values}
        """
        s, mine = self.simulation, [sampler for sampler in self.samplers if sampler.name in names]
        if not mine:
            return
        before = self._waiting[-1] if self._waiting and self._waiting[-1].step == s.steps - 1 else None
        count, counted = ([_counts(sampler.probe.truth, time) for sampler in mine]
                          for time in (s.pressure_time, before.pressure if before else -np.inf))
        if before is not None:
            before.at_edge |= count != counted
        if any(count):
            self._waiting.append(Waiting(s.pressure_time, s.time, s.steps, self._flow(), count != counted))
        ready = [one for one in self._waiting if one.pressure <= known]
        for one in ready:
            for sampler, value in self._agreed(means(one.pressure)):
                counts = _counts(sampler.probe.truth, one.pressure)
                self._judge(sampler, value, counts, one.time, one.step, lambda: one.flow)
        if not ready:    # a window may have ended
            for sampler, value in self._agreed(means(known)):
                self._judge(sampler, value, False, s.time, s.steps, self._flow)
        self._waiting = [one for one in self._waiting if one.pressure > known
                         and (one.pressure in knots or one.at_edge or one.step == s.steps)]

    def look_at_last(self, means: Callable[[float], Mapping[str, Sequence[float]]]) -> None:
        """Judge the waiting flows by their means if the run ends here. Collective. means : as of `look_at_means`"""
        self._last = {}
        for one in self._waiting:
            for sampler, value in self._agreed(means(one.pressure)):
                seen = (self._last.get(sampler.name) or [self._seen.get(sampler.name, {"greatest": -np.inf})])[0]
                if value > seen["greatest"] and _counts(sampler.probe.truth, one.pressure):
                    peak = {**seen, "greatest": value, "time": one.time, "step": one.step}
                    self._last[sampler.name] = peak, one.flow

    def _agreed(self, found: Mapping[str, Sequence[float]]) -> list[tuple[Sampler, float]]:
        """Return the probes in `found`, with their values. Collective.

        The values are those of rank 0, equal to the last bit, as all ranks must write together or not at all.
        """
        mine = [sampler for sampler in self.samplers if sampler.name in found]
        values = [float(found[sampler.name][0]) for sampler in mine]
        if values and self.simulation.comm.size > 1:
            values = self.simulation.comm.bcast(values)
        return list(zip(mine, values))

    def _judge(self, sampler: Sampler, value: float, counts: bool, time: float, step: int,
               flow: Callable[[], Copied]) -> None:
        """Update the range of a probe, and hold the flow if its value is the greatest so far."""
        if not np.isfinite(value) or not (counts or sampler.name in self._seen):
            return
        seen = self._seen.setdefault(sampler.name, {"least": value, "greatest": -np.inf})
        seen["least"] = min(seen["least"], value)
        if counts and value > seen["greatest"]:
            seen.update(greatest=value, time=time, step=step)
            self._held[sampler.name] = flow()
        seen["now"] = value

    def _flow(self) -> Copied:
        """Return a copy of this rank's particles, shared by all probes of a step. Collective."""
        s = self.simulation
        if self._copy is None or self._copy[0] != s.steps:
            if self._computed:
                s.complete(self._computed)
            self._copy = s.steps, _copied(s.particles, self._fields)
        return self._copy[1]

    def write(self, store: Store, all_of_them: bool = False) -> None:
        """Write the copies whose probes have since clearly fallen, or all copies. Collective.

        Raises StoreError on every rank.
        """
        for name in [name for name in self._held if all_of_them or self._passed(name)]:
            seen, keep = self._seen[name], name in self._saved
            store.peak(self._held.pop(name), seen["time"], seen["step"], name, seen["greatest"], keep)
            self._saved.discard(name)

    def write_last(self, store: Store) -> None:
        """Write the peaks in the last steps of the run, after its checkpoint. Collective. Raises StoreError."""
        for name, (seen, flow) in self._last.items():
            store.peak(flow, seen["time"], seen["step"], name, seen["greatest"], name in self._saved)
        self._last = {}

    def waiting(self) -> tuple[dict[str, Any], list[Copied]]:
        """Return the data of the waiting flows for a checkpoint, and these flows. Not collective."""
        return ({"steps": [(one.pressure, one.time, one.step, one.at_edge) for one in self._waiting],
                 "last": list(self._last)}, [one.flow for one in self._waiting])

    def state(self) -> dict[str, Any]:
        """Return the data that a checkpoint needs, after all copies have been written. Not collective."""
        self._saved = set(self._seen)
        return {name: dict(seen) for name, seen in self._seen.items()}

    def bring(self, folder: Path, names: Collection[str] | None = None) -> None:
        """Read the flows at the peaks so far from a folder of the run, to write them again. Collective.

        The log names missing files. They are not an error, and the greatest values stay known.
        folder : another one, or the same for probes whose file is of a peak in the last steps, which may be outdated
        names : of probes, all if None
        """
        s = self.simulation
        names = list(self._seen) if names is None else names
        for name in names:
            seen = self._seen[name]
            found = on_first(s.comm, f"read the flow at the peak of {name} in {folder}",
                             lambda: self._read(folder, name, seen))
            total = s.comm.bcast(None if found is None else len(found["x"]))
            if total is None:
                logger.warning(f"the flow at the peak of {name} so far, t = {seen['time']:.6g} s, "
                               f"is no longer in {folder}")
                continue
            # rank 0 has the whole flow
            dim = s.particles.dim
            mine = found or {key: s.particles.fields[key].empty(0, dim) for key in self._fields}
            self._held[name] = Copied(dim, n_owned=len(mine["x"]), offset=0 if found else total,
                                      n_global=total, arrays=mine)
        self._saved -= set(names)

    def _read(self, folder: Path, name: str, seen: Mapping[str, Any]) -> dict[str, Array] | None:
        """Return {field: array} of the flow at the peak, None if it is not in the folder. One rank."""
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
    """Return whether the value of a probe at a time [s] counts for its peak: it must be in an interval of its truth."""
    where = intervals(truth)
    return not where or any(start <= time <= end for start, end in where)


def _copied(particles: Particles, fields: Sequence[str]) -> Copied:
    arrays = {name: np.array(getattr(particles, name)) for name in fields}
    return Copied(particles.dim, particles.n_owned, particles.offset, particles.n_global, arrays)
