"""Decay of a viscous standing wave on a free surface, against the exact linear wave."""

import numpy as np

from tests import viscous_flows as flows
from tests.manufactured import orders
from tests.scenes import scene


def test_a_viscous_wave_decays():
    """k d = pi, Re = sqrt(g d) d/nu = 780, over three periods; the layer of shear at the surface is 0.04 d thick."""
    cells, nu = np.array([10, 20, 40]), 0.004
    exact = flows.wave_over_a_bed(np.pi, 1.0, nu, False)[0]
    cases = [scene("standing_wave", {}, spacing=1.0 / n, end_time=4.0, amplitude=0.01, refine_time=True,
                   time_step=0.064)
             .changed(**{"fluid.viscosity": nu}) for n in cells]
    errors = [abs(flows.decay(case, 3.4, "centre", (5.0, 6.0))[0] / exact - 1.0) for case in cases]
    assert orders(1.0 / cells, errors)[1] > 0.85 and max(errors[:2]) < 0.05 and errors[2] < 0.03, errors
