"""What the studies of the solitary wave by a piston measure: its profile, height and place beside the exact wave.

Profiles are compared with aligned crests: their error does not contain that of the speed.
"""

from collections.abc import Mapping

import numpy as np

from parisph import PistonStroke
from parisph.base.fields import SURFACE
from parisph.case.waves import SolitaryWave
from parisph.study import Function
from parisph.truth import norms

DEPTH, HEIGHT = 0.25, 0.05    # [m]
EXACT = SolitaryWave(height=HEIGHT, depth=DEPTH)
MADE = PistonStroke(EXACT).made
NEAR = 8.0 * DEPTH            # [m], of where the crest is due: some methods lose particles near the piston
PRINTED = SolitaryWave(height=HEIGHT, depth=DEPTH, theory="boussinesq")    # Z17 Eq 34
GAUGES = ["x6d", "x13d", "x20d"]
REACH = 6.0    # depths on each side of the crest in which profiles are compared
TOP = 0.5      # depths on each side of the highest particle to which a polynomial of fourth degree is fitted


def surface_profile(arrays: Mapping[str, np.ndarray], depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x [m] and elevation [m] of the surface particles of a snapshot, (n,) each, sorted by x.

    arrays : with x (n, 2) [m] and role (n,); depth : of still water above y = 0 [m]
    """
    x = arrays["x"][arrays["role"] == SURFACE]
    x = x[np.argsort(x[:, 0])]
    return x[:, 0], x[:, 1] - depth


def crest(x: np.ndarray, eta: np.ndarray, depth: float) -> tuple[float, float]:
    """Return place and height [m] of the crest: the top of a polynomial fitted to the highest particles."""
    near = np.abs(x - x[np.argmax(eta)]) < TOP * depth
    fit = np.polynomial.Polynomial.fit(x[near], eta[near], 4)
    fine = np.linspace(x[near][0], x[near][-1], 4001)
    top = np.argmax(fit(fine))
    return float(fine[top]), float(fit(fine)[top])


def profile_error(x: np.ndarray, eta: np.ndarray, wave: SolitaryWave) -> float:
    """Return the relative L2 error of a profile within REACH of its crest against a wave, crests aligned."""
    place, _ = crest(x, eta, wave.depth)
    near = np.abs(x - place) <= REACH * wave.depth
    return norms.relative_l2(eta[near], _centred(wave).elevation(x[near] - place, 0.0))


def printed_error(x: np.ndarray, eta: np.ndarray, wave: SolitaryWave) -> float:
    """Return Z17's Err (Eq 35) of all surface particles against a wave, crests aligned."""
    place, _ = crest(x, eta, wave.depth)
    return norms.z17_elevation(eta, _centred(wave).elevation(x - place, 0.0))


def _centred(wave: SolitaryWave) -> SolitaryWave:
    return wave.model_copy(update={"at": 0.0})


def profile_at(run, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x [m] and elevation [m] of the surface near the wave, in the snapshot next to a time [s]."""
    number = int(np.argmin(np.abs(np.asarray(run.times) - time)))
    x, eta = surface_profile(run.snapshot(number), DEPTH)
    near = np.abs(x - MADE.at - MADE.celerity * run.times[number]) < NEAR
    return x[near], eta[near]


def profile(time: float) -> Function:
    """Return the error of the profile at a time [s] within 6 d of its crest, crests aligned, relative L2."""
    return Function(f"profile at {time:g} s", of=lambda run: profile_error(*profile_at(run, time), EXACT))


def printed(time: float) -> Function:
    """Return the Err of Z17 Eq 35 at a time [s] over surface particles near the wave, crests aligned with Eq 34."""
    return Function(f"Err of Z17 at {time:g} s",
                    of=lambda run: printed_error(*profile_at(run, time), PRINTED))


def height(time: float) -> Function:
    """Return how far the height of the crest is from what was asked at a time [s], over it."""
    return Function(f"height at {time:g} s",
                    of=lambda run: abs(crest(*profile_at(run, time), DEPTH)[1] / HEIGHT - 1.0))
