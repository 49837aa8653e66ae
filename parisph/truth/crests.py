"""The crest of a solitary wave in a snapshot: its place, its height, and the error of its profile. Not collective.

Profiles are compared with aligned crests: their error does not contain that of the speed.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import SURFACE
from parisph.case.waves import SolitaryWave
from parisph.truth import norms

REACH = 6.0    # depths on each side of the crest in which profiles are compared
TOP = 0.5      # depths on each side of the highest particle to which a polynomial of fourth degree is fitted


def surface_profile(arrays: Mapping[str, Any], depth: float) -> tuple[Floats, Floats]:
    """Return x [m] and elevation [m] of the surface particles of a snapshot, (n,) each, sorted by x.

    arrays : of a snapshot, with x (n, 2) [m] and role (n,); depth : of still water above y = 0 [m]
    """
    x = arrays["x"][arrays["role"] == SURFACE]
    x = x[np.argsort(x[:, 0])]
    return x[:, 0], x[:, 1] - depth


def crest(x: Floats, eta: Floats, depth: float) -> tuple[float, float]:
    """Return place and height [m] of the crest: the top of a polynomial fitted to the highest particles."""
    near = np.abs(x - x[np.argmax(eta)]) < TOP * depth
    fit = np.polynomial.Polynomial.fit(x[near], eta[near], 4)
    fine = np.linspace(x[near][0], x[near][-1], 4001)
    top = np.argmax(fit(fine))
    return float(fine[top]), float(fit(fine)[top])


def profile_error(x: Floats, eta: Floats, wave: SolitaryWave) -> float:
    """Return the relative L2 error of a profile within REACH of its crest against a wave, crests aligned."""
    place, _ = crest(x, eta, wave.depth)
    near = np.abs(x - place) <= REACH * wave.depth
    return norms.relative_l2(eta[near], _centred(wave).elevation(x[near] - place, 0.0))


def printed_error(x: Floats, eta: Floats, wave: SolitaryWave) -> float:
    """Return Z17's Err (Eq 35) of all surface particles against a wave, crests aligned."""
    place, _ = crest(x, eta, wave.depth)
    return norms.z17_elevation(eta, _centred(wave).elevation(x - place, 0.0))


def _centred(wave: SolitaryWave) -> SolitaryWave:
    return wave.model_copy(update={"at": 0.0})
