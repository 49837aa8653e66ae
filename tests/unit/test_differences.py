"""Labels of runs that are drawn over each other: what differs between their cases."""

import itertools
import json

import pytest

from parisph import Roll, SurfaceGauge, Sway
from parisph.case.differences import labels
from parisph.case.stored import to_json
from tests.scenes import water

RUNS = itertools.count()    # no two runs have the same identity


def stored(title="Basin", height=0.5, frame=None, probes=(), end_time=1.0, parameters=None, **numerics):
    """Return the content of case.json, with the parameters of case(...) where there are any."""
    case = water((1.0, height), (1.0, 2.0), {"spacing": 0.1, **numerics}, title=title, end_time=end_time, probes=probes,
                 **({"frame": frame} if frame else {}))
    found = json.loads(to_json(case)) | {"run": f"{next(RUNS)}"}
    return found | {"made": {"parameters": parameters}} if parameters else found


@pytest.mark.parametrize("cases, expected", [
    ([{"spacing": 0.1}, {"spacing": 0.05}], ["spacing 0.1", "spacing 0.05"]),
    ([{"preset": "gentle"}, {"preset": "violent"}], ["preset gentle", "preset violent"]),    # not what follows from it
    ([{"jitter": 0.2, "seed": 1}, {"jitter": 0.2, "seed": 2}], ["seed 1", "seed 2"]),
    ([{"time_step": None}, {"time_step": 0.01, "spacing": 0.05}],
     ["spacing 0.1, time_step none", "spacing 0.05, time_step 0.01"]),
    ([{"spacing": 0.1}, {"spacing": 0.1 + 1e-7}], ["spacing 0.1", "spacing 0.1000001"]),
    ([{"frame": Sway(0.1, 2.0)}, {"frame": Sway(0.2, 2.0)}], ["frame.amplitude 0.1", "frame.amplitude 0.2"]),
    ([{"frame": Sway(0.1, 2.0)}, {"frame": Roll(0.2, 2.0)}], ["frame.kind sway", "frame.kind roll"]),
    ([{"title": "A"}, {"title": "B", "height": 0.4}], ["shape.height 0.5", "shape.height 0.4"]),
    ([{"end_time": 1.0}, {"end_time": 2.0}], ["end_time 1", "end_time 2"]),
    ([{}, {"probes": [SurfaceGauge("g", at=0.5)]}], ["", ""]),
    ([{}, {}, {"spacing": 0.05}], ["spacing 0.1", "spacing 0.1", "spacing 0.05"]),
    ([{"parameters": {"spacing": 0.1, "waves": 2}}, {"parameters": {"spacing": 0.1, "waves": 3}, "height": 0.4}],
     ["waves 2", "waves 3"]),
    ([{"parameters": {"spacing": 0.1}, "height": 0.4}, {"parameters": {"spacing": 0.1}}],    # another case file
     ["shape.height 0.4", "shape.height 0.5"]),
])
def test_runs_are_named_by_what_differs(cases, expected):
    assert labels([stored(**case) for case in cases]) == expected


def test_scenes_that_have_little_in_common_are_named_by_their_titles():
    other = stored("Tank that rolls", 0.4, Roll(0.2, 2.0), spacing=0.05, seed=3, preset="gentle")
    assert labels([stored("Basin", jitter=0.2), other]) == ["Basin", "Tank that rolls"]
