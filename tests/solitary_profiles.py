"""What a solitary wave has become: its crest, speed, height and profile, beside the exact wave."""

import numpy as np

from parisph.base.fields import SURFACE
from parisph.case.waves import SolitaryWave

REACH = 6.0  # depths on each side of the crest in which profiles are compared
TOP = 0.5  # depths on each side of the highest particle to which a polynomial of fourth degree is fitted


def surface(arrays, depth):
    """Return x [m] and elevation [m] of the surface particles of a snapshot, sorted by x."""
    x = arrays["x"][arrays["role"] == SURFACE]
    x = x[np.argsort(x[:, 0])]
    return x[:, 0], x[:, 1] - depth


def crest(x, eta, depth):
    """Return position and height [m] of the crest: the top of a polynomial fitted to the highest particles."""
    near = np.abs(x - x[np.argmax(eta)]) < TOP * depth
    fit = np.polynomial.Polynomial.fit(x[near], eta[near], 4)
    fine = np.linspace(x[near][0], x[near][-1], 4001)
    top = np.argmax(fit(fine))
    return fine[top], fit(fine)[top]


def profile_error(x, eta, height, depth):
    """Return the relative L2 error of a profile against the exact wave of the given height, crests aligned."""
    place, _ = crest(x, eta, depth)
    near = np.abs(x - place) <= REACH * depth
    exact = SolitaryWave(height, depth).elevation(x[near] - place, 0.0)
    return np.linalg.norm(eta[near] - exact) / np.linalg.norm(exact)


def errors(run, first=0):
    """Return relative errors of a run of cases/solitary_wave.py at its end: of the profile, the speed and the height.

    first : number of the snapshot from which the speed is taken
    """
    case = run.case
    wave = case["fluid"]["wave"]
    height, depth, g = wave["height"], wave["depth"], wave["g"]
    before, after = (surface(run.snapshot(number), depth) for number in (first, -1))
    (x0, _), (x1, top) = crest(*before, depth), crest(*after, depth)
    speed = (x1 - x0) / (run.times[-1] - run.times[first])
    return {
        "profile": profile_error(*after, height, depth),
        "speed": speed / SolitaryWave(height, depth, g=g).celerity - 1.0,
        "height": top / height - 1.0,
    }
