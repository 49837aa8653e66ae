"""Water at rest stays at rest under every method, on disordered particles."""

import numpy as np
import pytest

from parisph.case.methods import METHODS
from tests.scenes import scene, simulated

# Methods with a warning say what moves.
STILL = [name for name, method in METHODS.items() if method.step == "projection"
         and (not method.warning or name == "ISPH_R_printed")]


def fastest(method, steps):
    """Return the speed of the fastest particle after some steps of a hydrostatic tank, over sqrt(g d)."""
    s = simulated(scene("hydrostatic", spacing=0.1, method=method, jitter=0.4, seed=1, end_time=1e3), steps)
    found = np.linalg.norm(s.particles.u, axis=1).max() / np.sqrt(9.81)
    return found


@pytest.mark.parametrize("method", STILL)
def test_a_jittered_tank_rests(method):
    assert fastest(method, 200) < 1e-8


def test_weakly_compressible_water_stays_nearly_at_rest():
    """Sums over pairs do not balance on disordered particles: they find new places first."""
    assert fastest("SPH", 400) < 0.03


def test_rows_of_constants_alone_need_the_balance(monkeypatch):
    """Without it, a Laplacian that is not exact for linear pressure stirs the water."""
    from parisph.methods.operators import Sph
    monkeypatch.setattr(Sph, "linear", True)
    assert fastest("ISPH", 100) > 1e-3
