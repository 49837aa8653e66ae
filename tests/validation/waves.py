"""Waves that do not break, at all resolutions, with their CPU seconds."""

import numpy as np

from parisph.base.table import read_reference
from parisph.study import Function, Required, Study, TruthError, Variant
from tests.launch import ROOT
from tests.solitary_profiles import errors
from tests.validation import record

ERROR = "wave-part error"
AMPLITUDE = "relative error of the amplitude over the last two periods"
SLOSHING = (     # label, spacing, further parameters, largest error of the wave part
    ("200", 0.1, {}, 0.04),
    ("800", 0.05, {}, 0.02),
    ("800 jittered by 0.4", 0.05, {"jitter": 0.4}, 0.03),
    ("3200", 0.025, {}, 0.015),
    ("3200 with time step in proportion", 0.025, {"refine_time": True}, 0.015),
)
STEEP = "a = 0.6 d, 3 s at d/s = 40"
PERIODS = 2.27     # [s] two periods of the standing wave


def rows(bench):
    """Return the errors of the gauges, as required."""
    found = []
    studies = {"small sloshing to t* = 50": sloshing(), "standing wave": standing_wave(),
               "solitary wave": solitary()}
    for what, study in studies.items():
        found += record.rows_of(study, bench.study(study), what)
    return found


def sloshing() -> Study:
    """Return the study of the small sloshing at three spacings, jittered, and with a shorter time step."""
    return Study(
        case="small_sloshing.py",
        variants=[Variant(label=label, spacings=[spacing], parameters=further)
                  for label, spacing, further, _ in SLOSHING],
        errors=[TruthError("left", name=ERROR)],
        required=[Required(ERROR, must=limit, where={"label": label}) for label, _, _, limit in SLOSHING])


def standing_wave() -> Study:
    """Return the study of the standing wave over 9 s."""
    return Study(
        case="standing_wave.py", variants=[Variant(label="9 s at s = 0.025 m", spacings=[0.025])],
        errors=[TruthError("centre", name=ERROR), Function(AMPLITUDE, of=amplitude)],
        required=[Required(ERROR, must=0.08), Required(AMPLITUDE, must=0.05)])


def solitary() -> Study:
    """Return the study of the exact solitary wave: over 5 s at two spacings, and a steep one over 3 s."""
    low = [f"a = 0.2 d, 5 s at d/s = {n}" for n in (15, 30)]
    return Study(
        case="solitary_wave.py",
        variants=[*(Variant(label=label, spacings=[1 / n]) for label, n in zip(low, (15, 30))),
                  Variant(label=STEEP, spacings=[1 / 40],
                          parameters={"height": 0.6, "end_time": 3.0, "start": 8.0, "length": 40.0})],
        errors=[Function(name, of=of) for name, of in SOLITARY.items()],
        required=[*(Required(name, must=must, aim=aim, where={"label": label}) for label in low
                    for name, (must, aim) in zip(SOLITARY, ((0.02, 0.01), (0.004, 0.002), (0.03, 0.02)))),
                  Required("error of the profile", must=0.05, aim=0.03, where={"label": STEEP})])


def profile(run) -> float:
    """Return the error of the profile of a solitary wave, crests aligned."""
    return errors(run)["profile"]


def speed(run) -> float:
    """Return the relative error of its speed."""
    return abs(errors(run)["speed"])


def loss(run) -> float:
    """Return the part of its height that is lost."""
    return abs(errors(run)["height"])


SOLITARY = {"error of the profile": profile, "error of the speed": speed, "loss of height": loss}


def amplitude(run) -> float:
    """Return the relative error of the amplitude of the standing wave over its last two periods."""
    gauge = run.probe("centre")
    late = gauge["time"] > gauge["time"][-1] - PERIODS
    height = 0.5 * np.ptp(gauge["y"][late])
    return abs(height / (0.5 * np.ptp(_exact()[1])) - 1.0)


def _exact():
    """Times and levels of the fully nonlinear solution over the last two periods of its first 9 s."""
    t, level = read_reference(ROOT / "cases" / "exact" / "standing_wave.csv", "t_s", "eta_nonlinear_m")
    chosen = (t <= 9.0) & (t > 9.0 - PERIODS)
    return t[chosen], level[chosen]
