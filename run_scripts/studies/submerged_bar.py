"""Regular waves over a submerged bar against the spacing.

    parisph study run_scripts/studies/submerged_bar.py

About 12 minutes of CPU time. There is no data beside parisph: seaward of the bar the wave is compared with
stream-function theory, and heights on the bar and behind it with each other. They are 2 sqrt(2) times the standard
deviation of the surface over three periods, from 13.9 s on.
"""

from functools import partial

import numpy as np

from parisph.study import Function, Study, TruthError

METHODS = ["ISPH_R"]
SPACINGS = [0.4 / 12.0, 0.025, 0.4 / 24.0]    # [m]
GAUGES = ["x4m", "x10.5m", "x12.5m", "x13.5m", "x14.5m", "x15.7m", "x17.3m"]
START, END = 20.0 - 3.0 * 2.02, 20.0          # [s]


def height(run, gauge):
    """Return the height of the waves at a gauge [mm]."""
    probe = run.probe(gauge)
    times = np.linspace(START, END, 1000)
    return 1e3 * 2.0 * np.sqrt(2.0) * float(np.interp(times, probe["time"], probe["y"]).std())


study = Study(
    title="Waves over a submerged bar, H = 20 mm, T = 2.02 s",
    case="../../cases/submerged_bar.py",
    methods=METHODS, spacings=SPACINGS, parameters={"end_time": END},
    errors=[TruthError(probe="x4m", name="wave at 4 m against stream-function theory"),
            *(Function(f"height at {gauge[1:-1]} m [mm]", of=partial(height, gauge=gauge)) for gauge in GAUGES)],
    histories=["x12.5m", "x14.5m", "x17.3m"],
)
