"""What a solitary wave has become: its profile, speed and height beside the exact wave, and its run-up at a wall."""

import numpy as np

from parisph.base.table import read_reference
from parisph.case.waves import SolitaryWave
from run_scripts.studies import solitary_measures as crests
from tests.launch import ROOT

RUN_UPS = ROOT / "cases" / "exact" / "solitary_wall_runup.csv"
TAIL = 6.0    # exp(-TAIL): of the height, what is at the wall when a wave starts
AFTER = 1.0   # [sqrt(d/g)], of a run after the crest would pass the wall: it is highest up to 0.3 later


def errors(run, first=0):
    """Return relative errors of a run of cases/solitary_wave.py at its end: of the profile, the speed and the height.

    first : number of the snapshot from which the speed is taken
    """
    given = run.case["fluid"]["wave"]
    wave = SolitaryWave(given["height"], given["depth"], g=given["g"])
    before, after = (crests.surface_profile(run.snapshot(number), wave.depth) for number in (first, -1))
    (x0, _), (x1, top) = (crests.crest(*profile, wave.depth) for profile in (before, after))
    speed = (x1 - x0) / (run.times[-1] - run.times[first])
    return {
        "profile": crests.profile_error(*after, wave),
        "speed": speed / wave.celerity - 1.0,
        "height": top / wave.height - 1.0,
    }


def run_ups():
    """Return {height: greatest run-up} of exact waves at a vertical wall, over the depth."""
    return dict(zip(*(column.tolist() for column in read_reference(RUN_UPS, "a_over_d", "R_over_d"))))


def against_a_wall(height, n):
    """Return parameters of cases/solitary_wave.py with which a wave runs up the right wall, in as short a tank as its
    tail allows. height : over the depth; n : d/s"""
    wave = SolitaryWave(height, 1.0, g=1.0)
    far = round(n * TAIL / wave.rate) / n
    end = (far / wave.celerity + AFTER) * np.sqrt(0.25 / 9.81)
    return {"height": height, "length": 2.0 * far, "start": far, "end_time": float(end)}


def run_up_error(run):
    """Return the relative error of the greatest run-up at the right wall."""
    wave = run.case["fluid"]["wave"]
    due, = (high for height, high in run_ups().items() if np.isclose(height, wave["height"] / wave["depth"]))
    return abs((run.probe("wall")["y"].max() / wave["depth"] - 1.0) / due - 1.0)
