"""Waves that do not break, at all resolutions, with their CPU seconds."""

import numpy as np

from tests.validation.record import Row

SLOSHING = (     # label, parameters, largest error of the wave part
    ("200", dict(spacing=0.1), 0.04),
    ("800", dict(spacing=0.05), 0.02),
    ("800 jittered by 0.4", dict(spacing=0.05, jitter=0.4), 0.03),
    ("3200", dict(spacing=0.025), 0.015),
    ("3200, time step in proportion", dict(spacing=0.025, refine_time=True), 0.015),
)


def rows(bench):
    """Return the errors of the gauges."""
    found = []
    for label, sets, asked in SLOSHING:
        _, summary = bench.run(f"sloshing_{label.replace(' ', '_').replace(',', '')}", "small_sloshing", **sets)
        found.append(Row(f"small sloshing to t* = 50, {label}: wave-part error", summary["errors"]["left"]["relative_l2"],
                         asked, cost=summary["cpu_seconds"]))
    run, summary = bench.run("standing_wave", "standing_wave", spacing=0.025)
    found.append(Row("standing wave, 9 s at s = 0.025 m: wave-part error", summary["errors"]["centre"]["relative_l2"], 0.08,
                     cost=summary["cpu_seconds"]))
    gauge = run.probe("centre")
    late = gauge["time"] > gauge["time"][-1] - 2.27     # two periods
    height = 0.5 * np.ptp(gauge["y"][late])
    exact = 0.5 * np.ptp(_exact()[1])
    found.append(Row("standing wave: relative error of the amplitude over the last two periods", abs(height / exact - 1.0), 0.05))
    return found


def _exact():
    """Times and levels of the fully nonlinear solution over the last two of its first 9 s."""
    from parisph.base.table import read_reference
    from tests.launch import ROOT

    t, level = read_reference(ROOT / "cases" / "exact" / "standing_wave.csv", "t_s", "eta_nonlinear_m")
    chosen = (t <= 9.0) & (t > 9.0 - 2.27)
    return t[chosen], level[chosen]
