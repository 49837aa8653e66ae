"""The start-up of Couette and Poiseuille flow: observed orders, with steps in proportion to the square of the spacing."""

import numpy as np
import pytest

from tests import viscous_flows as flows
from tests.manufactured import orders

Y = np.linspace(0.0, 1.0, 21)
CELLS = np.array([10, 20, 40])
forms = pytest.mark.parametrize("form", ["viscous", "viscous_morris"])


def error(exact, prepare=None, **sets):
    """Return the rms error of u at the mid-section over its largest value."""
    s = flows.run(flows.tank(**sets), prepare)
    u = flows.middle(s)
    s.destroy()
    return np.sqrt(np.mean((u - exact) ** 2)) / np.abs(exact).max()


@forms
def test_couette_flow_starts(form):
    """Re = 1, far from the ends of a tank whose lid has no jump of the velocity there."""
    exact = flows.started_by_a_lid(Y, 0.05, 1.0)
    errors = [error(exact, flows.soften_lid, spacing=1.0 / n, viscosity=1.0, end_time=0.05, lid=1.0, length=6.0, forces=("body", form))
              for n in CELLS]
    assert np.all(orders(1.0 / CELLS, errors) > 1.5) and errors[-1] < 5e-4, print(errors)


@forms
def test_poiseuille_flow_starts(form):
    nu, time, push = 0.1, 0.25, 1.0
    exact = push / nu * flows.started_by_a_push(Y, time, nu)
    errors = [error(exact, spacing=1.0 / n, viscosity=nu, end_time=time, gravity=flows.pushed(push), max_time_step=time,
                    forces=("body", form)) for n in CELLS]
    assert np.all(orders(1.0 / CELLS, errors) > 1.5) and errors[-1] < 0.01, print(errors)
