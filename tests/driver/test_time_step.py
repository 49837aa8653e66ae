"""The limits on an adaptive time step that come from the case."""

from math import pi

import pytest
from mpi4py import MPI

from parisph import Box, Case, Fluid, Numerics, Sway, Tank
from parisph.driver import Simulation, describe

PERIOD = 1.0    # [s]


def swaying(**numerics):
    """A case of a tank without gravity that sways so little that nothing else limits the step."""
    return Case(title="sway", fluid=Fluid(Box(width=1.0, height=0.5), density=1000.0), walls=Tank(width=1.0, height=1.0, lid=True),
                gravity=(0.0, 0.0), frame=Sway(amplitude=1e-3, frequency=2.0 * pi / PERIOD),
                numerics=Numerics(spacing=0.1, **numerics), end_time=5.0)


@pytest.mark.parametrize(("numerics", "longest"), [({}, PERIOD / 50), ({"max_time_step": 0.01}, 0.01), ({"time_step": 0.04}, 0.04)])
def test_adaptive_step_resolves_the_sway(numerics, longest):
    s = Simulation(swaying(**numerics), MPI.COMM_SELF)
    steps = [s.advance() and s.dt for _ in range(4)]
    s.destroy()
    assert steps == pytest.approx([longest] * 4)
    assert f"{longest:g} s" in describe(s.case)
