"""A tank of water at rest over 10,000 steps by every method that keeps it still, from a jittered start."""

from tests.scenes import scene
from tests.solid_scenes import errors_at_rest
from tests.validation.record import Row
from tests.validation.rest import STEPS

ASKED, JITTER = 1e-6, 0.4
METHODS = ("ISPH_R", "ISPH", "CISPH1", "CISPH2", "GFD", "ISPH_R2", "FM")


def rows(bench):
    """Return the largest speed with each method, with the preset for waves that do not break."""
    found = []
    for method in METHODS:
        speed = errors_at_rest(scene("hydrostatic", jitter=JITTER, method=method), "tank", STEPS)[0].max()
        found.append(Row(f"hydrostatic, {method}, jitter {JITTER:g}, {STEPS} steps: max u / sqrt(gd)", speed, ASKED))
        print(f"  {method}: {speed:.1e}", flush=True)
    return found
