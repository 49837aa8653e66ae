"""What the studies of the solitary wave by a piston measure: its profile, height and place beside the exact wave."""

import numpy as np

from parisph import PistonStroke
from parisph.case.waves import SolitaryWave
from parisph.study import Function
from parisph.truth import crests

DEPTH, HEIGHT = 0.25, 0.05    # [m]
EXACT = SolitaryWave(height=HEIGHT, depth=DEPTH)
MADE = PistonStroke(EXACT).made
NEAR = 8.0 * DEPTH            # [m], of where the crest is due: some methods lose particles near the piston
PRINTED = SolitaryWave(height=HEIGHT, depth=DEPTH, theory="boussinesq")    # Z17 Eq 34
GAUGES = ["x6d", "x13d", "x20d"]


def profile_at(run, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x [m] and elevation [m] of the surface near the wave, in the snapshot next to a time [s]."""
    number = int(np.argmin(np.abs(np.asarray(run.times) - time)))
    x, eta = crests.surface_profile(run.snapshot(number), DEPTH)
    near = np.abs(x - MADE.at - MADE.celerity * run.times[number]) < NEAR
    return x[near], eta[near]


def profile(time: float) -> Function:
    """Return the error of the profile at a time [s] within 6 d of its crest, crests aligned, relative L2."""
    return Function(f"profile at {time:g} s", of=lambda run: crests.profile_error(*profile_at(run, time), EXACT))


def printed(time: float) -> Function:
    """Return the Err of Z17 Eq 35 at a time [s] over surface particles near the wave, crests aligned with Eq 34."""
    return Function(f"Err of Z17 at {time:g} s",
                    of=lambda run: crests.printed_error(*profile_at(run, time), PRINTED))


def height(time: float) -> Function:
    """Return how far the height of the crest is from what was asked at a time [s], over it."""
    return Function(f"height at {time:g} s",
                    of=lambda run: abs(crests.crest(*profile_at(run, time), DEPTH)[1] / HEIGHT - 1.0))
