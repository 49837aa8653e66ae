"""The violent dam break against grid codes, at three spacings and several time steps, and against the experiment.

Times t* are in sqrt(H/g), pressures in rho g H. The reference is cases/computed/dam_break_vof.csv: its impulse of P2 is
1.13 between its two codes, and it keeps the energy until t* = 2.
"""

import re
from dataclasses import dataclass, field

import numpy as np

from parisph.base.table import read_reference
from parisph.case.load import load
from parisph.io import checkpoint
from parisph.io.reader import Run
from parisph.truth import norms
from run_scripts.studies import dam_break_measures
from run_scripts.studies.dam_break_measures import CODES, COMPARED, QUIET, UNIT, WEIGHT
from tests.launch import ROOT
from tests.validation.record import Bench, Row

MEASURED = ROOT / "cases" / "measured"
COMPUTED = ROOT / "cases" / "computed" / "dam_break_vof.csv"
EXTRAPOLATED = "Basilisk, extrapolated"    # from 128 and 256 cells, as of first order

JITTER = 0.2
SEEDS = (1, 2, 3)
COARSE, FINE, FINEST = 1 / 40, 1 / 80, 1 / 160    # spacings over H
STEP = 0.004               # dt* of fixed steps at H/s = 40 and 80
END, LATE = 4.0, 10.0      # t* of most runs, and of those that watch the volume
BESIDE = 1.13              # impulse of P2 in the reference
BEFORE = {"front": 1.55, "column": 4.0}    # t* at which the far wall is met, and water comes back to the near one
ALTERNATIVES = {    # what a user might choose instead
    "ISPH rows": dict(method="ISPH"),
    "relaxed divergence": dict(numerics={"zeta": None, "zeta_time": 0.04 * UNIT}),
}


@dataclass(frozen=True)
class Limits:
    """What is required and what is aimed at, as pairs; the impulse by its distance from that of the reference."""

    pressure: tuple
    early: tuple
    later: tuple
    impulse: tuple
    quiet: tuple
    volume: tuple
    rise: tuple


LIMITS = {
    COARSE: Limits(pressure=(0.15, 0.08), early=(0.985, 0.99), later=(0.93, 0.96), impulse=(0.09, 0.05),
                   quiet=(0.012, 0.008), volume=(0.01, 0.005), rise=(1e-3, 3e-4)),
    FINE: Limits(pressure=(0.08, 0.05), early=(0.993, 0.996), later=(0.96, 0.98), impulse=(0.05, 0.03),
                 quiet=(0.010, 0.006), volume=(0.005, 0.003), rise=(5e-4, 1e-4)),
}


@dataclass
class Measures:
    """What one run gives; a measure is missing if the run ends before its time.

    cpu [s], lost: particles, iterations: median and p99 of a solve, found: {measure: value}
    """

    cpu: float
    lost: int
    iterations: tuple
    found: dict = field(default_factory=dict)

    def __getitem__(self, name):
        return self.found[name]


def rows(bench: Bench) -> list[Row]:
    """Return what three jittered starts give at two spacings, then finer ones, other time steps and alternatives."""
    for ranks in (1, 2):    # compiles the kernels, which must not count as CPU time of a row
        bench.run("dam_break_short", "dam_break", spacing=0.1, end_time=0.1, ranks=ranks)
    coarse, fine = (_starts(bench, spacing) for spacing in (COARSE, FINE))
    found = _against_limits("H/s = 40", coarse, LIMITS[COARSE]) + _against_limits("H/s = 80", fine, LIMITS[FINE])
    for part in (lambda: _other_steps(bench, COARSE, coarse), lambda: _fixed(bench, COARSE, coarse),
                 lambda: _volume(bench), lambda: _other_steps(bench, FINE, fine), lambda: _fixed(bench, FINE, fine),
                 lambda: _lattice(bench), lambda: _alternatives(bench), lambda: _orders(bench, coarse, fine)):
        try:
            found += part()
        except RuntimeError as error:    # a run that fails is a row
            print(f"  {error}", flush=True)
            found.append(Row(f"dam break: {str(error).splitlines()[0]}", 0, 1, least=True))
    return found


def _starts(bench, spacing, label="", **how):
    return [_measured(bench, f"{1 / spacing:.0f} {label} seed {seed}", spacing=spacing, seed=seed, **how)
            for seed in SEEDS]


def _measured(bench, label, end=END, seed=1, **how):
    name = re.sub(r"[^A-Za-z0-9]+", "_", f"dam_break {label}")
    run, summary = bench.run(name, "dam_break", seed=seed, jitter=JITTER, end_time=end, volume_every=1, **how)
    solve = summary["iterations"]
    return Measures(cpu=summary["cpu_seconds"], lost=summary["particles"] - int(np.unique(_ids(run)).size),
                    iterations=(solve["median"], solve["p99"]), found=measures(run))


def _ids(run):
    import h5py

    with h5py.File(checkpoint.paths(run.folder / "checkpoints")[-1], "r") as file:
        return file["particles/id"][:]


def measures(run: Run) -> dict:
    """Return {measure: value} of a run of the dam break.

    P2 against each code, one of them also extrapolated (relative L2, unshifted, at its times), arrival (t* of
    P2 > 0.1), onset (of P2 > 1, between the samples), E(1.45) and E(2) over the start, impulse, quiet (noise), volume
    (largest error), volume in 99 % of the samples, rise (highest energy over its start, less 1). Raises ValueError if
    the run ends before t* = 3.4.
    """
    tap, energy, volume = run.probe("P2"), run.probe("energy"), np.abs(run.probe("volume")["cell"] - 1.0)
    t, p = tap["time"] / UNIT, tap["pressure"] / WEIGHT
    if t[-1] < COMPARED[1]:
        raise ValueError(f"the run ends at t* = {t[-1]:g}, before the last time that is compared")
    total = energy["total"] / energy["total"][0]
    found = {f"P2 against {code}": _distance(t, p, *read_reference(COMPUTED, "t_star", column))
             for code, column in CODES.items()}
    times, fine = read_reference(COMPUTED, "t_star", CODES["Basilisk"])
    coarse = read_reference(COMPUTED, "t_star", "P2_basilisk_128")[1]
    found[f"P2 against {EXTRAPOLATED}"] = _distance(t, p, times, 2.0 * fine - coarse)
    found |= {"arrival": float(t[np.argmax(p > 0.1)]), "onset": _crossing(t, p, 1.0),
              "impulse": dam_break_measures.impulse(run)}
    found |= {f"E({time})": float(np.interp(time, energy["time"] / UNIT, total)) for time in (1.45, 2)}
    if t[-1] >= QUIET[1]:
        found["quiet"] = dam_break_measures.noise(run)
    found |= {"volume": float(np.nanmax(volume)), "volume in 99 %": float(np.nanquantile(volume, 0.99)),
              "rise": float(total.max()) - 1.0}
    return found


def _crossing(t, p, value):
    """Return the time at which a trace first exceeds a value, between two samples."""
    k = int(np.argmax(p > value))
    return float(np.interp(value, p[k - 1:k + 1], t[k - 1:k + 1]))


def _distance(t, p, times, truth):
    """Return the relative L2 difference of a trace from a reference, at the times of the latter."""
    inside = (times > COMPARED[0]) & (times < COMPARED[1])
    return norms.relative_l2(np.interp(times[inside], t, p), truth[inside])


def _against_limits(name, starts, limits):
    """Return the rows of runs that differ by their start; limits: Limits, or None for a report."""
    def of(measure):
        return [start[measure] for start in starts]

    def row(what, values, limit, **how):
        must, aim = (None, None) if limits is None else getattr(limits, limit)
        return Row.of_starts(f"dam break, {name}: {what}", values, must, aim, **how)

    impulse = of("impulse")
    found = [
        row("P2 against Basilisk, 1.4 < t* < 3.4, relative L2", of("P2 against Basilisk"), "pressure",
            cost=max(start.cpu for start in starts)),
        *(Row.of_starts(f"dam break, {name}: P2 against {truth}", of(f"P2 against {truth}"))
          for truth in (EXTRAPOLATED, "interFoam")),
        Row.of_starts(f"dam break, {name}: arrival of P2 > 0.1 (Basilisk 1.487, interFoam 1.483)", of("arrival")),
        Row.of_starts(f"dam break, {name}: onset, P2 > 1 (Basilisk 1.504, interFoam 1.499)", of("onset")),
        row("E(1.45) / E(0)", of("E(1.45)"), "early", least=True),
        row("E(2) / E(0)", of("E(2)"), "later", least=True),
        row(f"impulse of P2, 1.5 < t* < 2.6, from {BESIDE}", [abs(value - BESIDE) for value in impulse], "impulse"),
        Row.of_starts(f"dam break, {name}: impulse itself", impulse),
    ]
    if all("quiet" in start.found for start in starts):
        found.append(row("noise of P2, 2.5 < t* < 3.9", of("quiet"), "quiet"))
    return found + [
        row("largest volume error", of("volume"), "volume"),
        row("largest rise of the energy above its start", of("rise"), "rise"),
        Row.of_starts(f"dam break, {name}: particles lost", [start.lost for start in starts], 0),
        Row.of_starts(f"dam break, {name}: iterations, median", [start.iterations[0] for start in starts], 15),
        Row.of_starts(f"dam break, {name}: iterations, p99", [start.iterations[1] for start in starts], 30),
    ]


def _orders(bench, coarse, fine):
    """Return the rows of one run at H/s = 160, and observed orders; those of several starts are of their mean."""
    finest = [_measured(bench, "160", spacing=FINEST, end=COMPARED[1], ranks=2)]
    found = _against_limits("H/s = 160, to t* = 3.4", finest, None)
    for what, error in (("P2 against Basilisk", lambda start: start["P2 against Basilisk"]),
                        ("1 - E(2)", lambda start: 1.0 - start["E(2)"])):
        at = [float(np.mean([error(start) for start in starts])) for starts in (coarse, fine, finest)]
        for first, label in ((0, "40 to 80"), (1, "80 to 160")):
            order = float(np.log2(at[first] / at[first + 1])) if min(at[first:first + 2]) > 0.0 else np.nan
            found.append(Row(f"dam break: observed order of {what}, H/s = {label}", order, aim=1.2, least=True))
    return found


def _other_steps(bench, spacing, full):
    """Return the rows of half and a quarter of the limits on the time step, beside the starts at the default ones.

    Of two sets of starts, which chance has spread, means are compared. Steps of different length differ by less than
    what the codes themselves leave open (with 256 cells, Basilisk's onset still moves), so these stand beside it. The
    pressure is solved more closely, as the errors of more steps add up: to 1e-4, one start of three with a quarter of
    the step at H/s = 80 errs by 0.136 in P2, to 1e-5 by less than 0.05.
    """
    found, usual = [], load(ROOT / "cases" / "dam_break.py").numerics.resolved()
    for label, parts in (("half", 2), ("a quarter", 4)):
        limits = {"cfl": usual.cfl / parts, "fall": usual.fall / parts, "rtol": usual.rtol / parts**2}
        starts = _starts(bench, spacing, f"{label} of the step", numerics=limits)
        found += _beside(f"dam break, H/s = {1 / spacing:.0f}, {label} of the step", starts, full, no_worse=True)
    return found


def _beside(name, starts, full, no_worse=False):
    """Return the rows of starts with another step than the default one, beside these. no_worse : whether P2 must be."""
    pairs = list(zip(starts, full))
    ours, due = (float(np.mean([start["P2 against Basilisk"] for start in some])) for some in (starts, full))
    return [
        Row(f"{name}: P2 against Basilisk, mean of the starts, and that at the full step", ours,
            due if no_worse else None, cost=max(start.cpu for start in starts)),
        *(Row.of_starts(f"{name}: {what}", [start[what] for start in starts]) for what in
          (*(f"P2 against {truth}" for truth in ("Basilisk", EXTRAPOLATED, "interFoam")), "onset", "quiet", "E(2)")),
        Row.of_starts(f"{name}: change of E(2), of each start",
                      [abs(start["E(2)"] - one["E(2)"]) for start, one in pairs], 0.01, 0.005),
        Row.of_starts(f"{name}: change of the impulse, of each start",
                      [abs(start["impulse"] / one["impulse"] - 1.0) for start, one in pairs], 0.03, 0.01),
    ]


def _fixed(bench, spacing, adaptive):
    """Return the rows of a fixed time step, beside the starts with the adaptive one."""
    name = f"dam break, H/s = {1 / spacing:.0f}, fixed step"
    fixed = _starts(bench, spacing, "fixed", time_step=STEP)
    ours, due = (float(np.mean([start.cpu for start in starts])) for starts in (adaptive, fixed))
    return [*_beside(name, fixed, adaptive),
            Row(f"{name}: CPU s of the adaptive steps, mean of the starts, and that of the fixed one", ours, due)]


def _volume(bench):
    late = _starts(bench, COARSE, "late", end=LATE)
    name = f"dam break, H/s = 40, to t* = {LATE:g}"
    return [
        Row.of_starts(f"{name}: largest volume error", [run["volume"] for run in late], 0.013, 0.01,
                      cost=max(run.cpu for run in late)),
        Row.of_starts(f"{name}: volume error in 99 % of the steps", [run["volume in 99 %"] for run in late], 0.01),
        Row.of_starts(f"{name}: largest rise of the energy above its start", [run["rise"] for run in late]),
        Row.of_starts(f"{name}: particles lost", [run.lost for run in late], 0),
    ]


def _alternatives(bench):
    """Return the rows of what a user might choose instead: nothing is asked of them."""
    return [row for label, change in ALTERNATIVES.items()
            for row in _against_limits(f"H/s = 80, {label}", [_measured(bench, label, spacing=FINE, **change)], None)]


def _lattice(bench):
    return experiment(bench.run("dam_break_lattice", "dam_break", spacing=FINE, end_time=6.0)[0])


def experiment(run: Run) -> list[Row]:
    """Return the errors of front and column against Martin & Moyce (1952), raw and with one shift of the time."""
    found, shift = [], None
    for probe, column, time, value, scale, unit in (
            ("front", "x", "T", "front_over_a", 0.5, 0.5),
            ("column", "y", "tau", "height_over_H", 1.0, 0.5**0.5)):
        t, truth = read_reference(MEASURED / f"martin_moyce_{probe}.csv", time, value, scale=scale,
                                  time_scale=unit * UNIT)
        before = t < BEFORE[probe] * UNIT
        t, truth, got = t[before], truth[before], run.probe(probe)
        found.append(Row(f"{probe} against Martin & Moyce, raw",
                         norms.judge(got["time"], got[column], t, truth)["relative_l2"]))
        if shift is None:   # of the front: the gate opens in a finite time
            shift = norms.best_shift(got["time"], got[column], t, truth, 0.2 * UNIT)
        found.append(Row(f"{probe} against Martin & Moyce, shifted by {shift / UNIT:.3f} in t*",
                         norms.judge(got["time"] + shift, got[column], t, truth)["relative_l2"]))
    return found
