"""Tanks that move as frames and by their walls, the wave of a piston, and run-up, with their CPU seconds."""

from functools import partial

from parisph.study import Function, Required, Study, Variant
from tests import moving_tanks
from tests.solitary_profiles import against_a_wall, run_up_error, run_ups
from tests.validation import record
from tests.validation.record import Row

DEPTH = 0.25                        # of the scenes with a solitary wave [m]
ASKED = {"x6d": 0.01, "x20d": 0.02}     # of the height of the wave of a piston, after so many depths
SPACINGS = (0.025, 1 / 60, 0.0125)    # [m], on the slope
SHORT = {"length": 3.0, "end_time": 2.9}    # a flume of 3 m instead of 10 m, in which the wave runs up at 2.5 s


def rows(bench):
    """Return the differences of frames and walls, and the errors of waves, as required."""
    found = [row for kind in ("sway", "roll") for row in _moved(kind)]
    for what, study in {"piston wave, a = 0.2 d": piston(), "run-up at a wall, d/s = 40": wall()}.items():
        found += record.rows_of(study, bench.study(study), what)
    return found + _slope(bench)


def _moved(kind):
    """Return the rows of one motion: gently over three periods, and violently until the first impact.

    Gauges at the walls are only reported in violent flow: such a gauge reads one particle. The mean level over four
    spacings is compared instead.
    """
    gauges_too, others = dict.fromkeys(moving_tanks.SERIES, 0.01), dict.fromkeys(moving_tanks.SERIES[2:], 0.05)
    for name, scene, spacing, asked in (("gentle", moving_tanks.gentle, 0.025, gauges_too),
                                        ("violent", moving_tanks.violent, 0.01, others)):
        walls, frame = (moving_tanks.histories(scene(kind, moving, spacing)) for moving in (True, False))
        yield from (Row(f"{name} {kind} by walls and by the frame, s = {spacing:g} m: {what}", apart, asked.get(what))
                    for what, apart in moving_tanks.differences(walls, frame).items())
        print(f"  {name} {kind}: done", flush=True)


def piston() -> Study:
    """Return the study of the wave of a piston after 6 and 20 depths."""
    return Study(
        case="solitary_piston.py", parameters={"length": 9.0, "end_time": 4.8},
        variants=[Variant(label=f"d/s = {n}", spacings=[1 / n]) for n in (16, 30)],
        errors=[Function(f"height at {gauge}", of=partial(height, gauge=gauge)) for gauge in ASKED],
        required=[Required(f"height at {gauge}", must=limit) for gauge, limit in ASKED.items()])


def height(run, gauge) -> float:
    """Return the relative error of the crest's height at a gauge."""
    return abs((run.probe(gauge)["y"].max() - DEPTH) / (0.2 * DEPTH) - 1.0)


def wall() -> Study:
    """Return the study of the run-up at a vertical wall, from the exact start, d/s = 40."""
    return Study(
        case="solitary_wave.py", errors=[Function("run-up", of=run_up_error)],
        required=[Required("run-up", must=0.01)],
        variants=[Variant(label=f"a = {height:g} d", spacings=[1 / 40], parameters=against_a_wall(height, 40))
                  for height in run_ups()])


def _slope(bench):
    """Return the rows of the run-up on a slope of 60 degrees: its height, and its change between spacings."""
    runs = [bench.run(f"slope, s = {spacing:.4g} m", "solitary_slope", spacing=spacing, **SHORT)[0]
            for spacing in SPACINGS]
    high = [run.probe("run_up")["y"].max() / DEPTH - 1.0 for run in runs]
    return [*(Row(f"run-up on a slope, s = {spacing:.4g} m: height / d", one) for spacing, one in zip(SPACINGS, high)),
            Row("run-up on a slope: change between the two finest", abs(high[-2] / high[-1] - 1.0), 0.03)]
