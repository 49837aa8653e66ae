"""The violent dam break, H/s = 80, to t sqrt(g/H) = 10; front and column against the experiment."""

import re

import numpy as np

from parisph.io import checkpoint
from parisph.io.reference import read_reference
from parisph.study import errors
from tests.launch import ROOT
from tests.validation.record import Row

H, G = 1.0, 9.81
UNIT = np.sqrt(H / G)
WEIGHT = 1000.0 * G * H
MEASURED = ROOT / "cases" / "measured"
JITTER = 0.2
SEEDS = (1, 2, 3)
ALTERNATIVES = {    # what a user might choose instead
    "ISPH rows": dict(method="ISPH"),
    "relaxed divergence": dict(numerics={"zeta": None, "zeta_time": 0.04 * UNIT}),
}


def rows(bench, spacing=0.0125, end=10.0):
    """Return what three jittered starts on 1 and 2 ranks, the lattice, half the spacing and two alternatives give."""
    found = []
    sets = dict(spacing=spacing, end_time=end)
    for ranks in (1, 2):
        for seed in SEEDS:
            found += _judged(bench, f"dam break, seed {seed}, ranks {ranks}", end, ranks=ranks, seed=seed, jitter=JITTER, **sets)
    found += _judged(bench, "dam break, lattice", end, with_experiment=True, ranks=2, **sets)
    found += _judged(bench, "dam break, H/s = 160, to the impact's end", 3.1, ranks=2, seed=1, jitter=JITTER,
                     spacing=0.5 * spacing, end_time=3.1)
    for label, change in ALTERNATIVES.items():    # for comparison: nothing is asked of them
        found += [Row(row.what, row.measured, cost=row.cost) for row in
                  _judged(bench, f"dam break, {label}", end, ranks=2, seed=1, jitter=JITTER, **sets, **change)]
    return found


def _judged(bench, name, end, with_experiment=False, **how):
    """Return the rows of one run; a run that fails is one of them."""
    try:
        run, summary = bench.run(re.sub(r"[^A-Za-z0-9]+", "_", name), "dam_break", **how)
    except RuntimeError as error:
        print(f"  {error}", flush=True)
        return [Row(f"{name}: runs that came to their end", 0, 1, least=True)]
    return (_conserved(name, run, summary) + _pressure(name, run, end) + _equal_masses(name, run)
            + (experiment(run) if with_experiment else []))


def _conserved(name, run, summary):
    cell, energy = run.probe("volume")["cell"], run.probe("energy")["total"]
    lost = summary["particles"] - int(np.unique(_ids(run)).size)
    return [
        Row(f"{name}: particles lost", lost, 0, cost=summary["cpu_seconds"]),
        Row(f"{name}: volume error at the end", abs(cell[-1] - 1.0), 0.01),
        Row(f"{name}: largest volume error", np.nanmax(np.abs(cell - 1.0)), 0.02),
        Row(f"{name}: largest rise of the energy above its start", energy.max() / energy[0] - 1.0, 1e-6),
        Row(f"{name}: iterations, median", summary["iterations"]["median"], 15),
        Row(f"{name}: iterations, p99", summary["iterations"]["p99"], 30),
    ]


def _ids(run):
    import h5py

    with h5py.File(checkpoint.paths(run.folder / "checkpoints")[-1], "r") as file:
        return file["particles/id"][:]


def _pressure(name, run, end):
    tap, energy = run.probe("P2"), run.probe("energy")
    t, p = tap["time"], tap["pressure"]
    hit = t[np.argmax(p > 0.01 * WEIGHT)]
    found = [Row(f"{name}: noise of P2 after the impact", errors.noise(t, p, (hit, t[-1])))]
    if end >= 3.9:
        found.append(Row(f"{name}: noise of P2, 2.5 < t* < 3.9", errors.noise(t, p, (2.5 * UNIT, 3.9 * UNIT)), 0.03))
    if end >= 3.0:
        found += [
            Row(f"{name}: energy lost before the impact, t* = 1.45", 1.0 - np.interp(1.45 * UNIT, energy["time"], energy["total"]) / energy["total"][0]),
            Row(f"{name}: impulse of P2, 1.5 < t* < 2.6", errors.impulse(t, p, (1.5 * UNIT, 2.6 * UNIT)) / (WEIGHT * UNIT), 0.95, least=True),
            Row(f"{name}: E(t* = 3) / E(0)", np.interp(3.0 * UNIT, energy["time"], energy["total"]) / energy["total"][0], 0.93, least=True),
        ]
    return found


def _equal_masses(name, run):
    """The energy of the snapshots as if all particles had one mass, which the particles of a mixed flow do."""
    times, energy = np.array(run.times), []
    for time in times:
        seen = run.snapshot(time)
        fluid = seen["kind"] == 0
        energy.append((0.5 * (seen["u"][fluid] ** 2).sum(axis=1) + G * seen["x"][fluid, 1]).sum())
    energy = np.array(energy) / energy[0]
    return [
        Row(f"{name}: largest rise of the energy of equal masses", energy.max() - 1.0),
        Row(f"{name}: E(t* = 3) / E(0) of equal masses", np.interp(3.0 * UNIT, times, energy)),
    ]


def experiment(run):
    """Return the errors of front and column against Martin & Moyce (1952), raw and with one shift of the time."""
    found, shift = [], None
    for probe, column, time, value, scale, unit in (
            ("front", "x", "T", "front_over_a", 0.5, 0.5),
            ("column", "y", "tau", "height_over_H", 1.0, 0.5**0.5)):
        t, truth = read_reference(MEASURED / f"martin_moyce_{probe}.csv", time, value, scale=scale, time_scale=unit * UNIT)
        before = (t < 1.55 * UNIT) if probe == "front" else (t < run.probe(probe)["time"][-1])
        t, truth, got = t[before], truth[before], run.probe(probe)
        found.append(Row(f"{probe} against Martin & Moyce, raw", errors.judge(got["time"], got[column], t, truth)["relative_l2"]))
        if shift is None:   # of the front: the gate opens in a finite time
            shift = errors.best_shift(got["time"], got[column], t, truth, 0.2 * UNIT)
        found.append(Row(f"{probe} against Martin & Moyce, shifted by {shift / UNIT:.3f} in t*",
                         errors.judge(got["time"] + shift, got[column], t, truth)["relative_l2"]))
    return found
