"""Water at rest between walls of any shape stays at rest, with hydrostatic pressure."""

import numpy as np
import pytest

from parisph.base.fields import FLUID, SURFACE
from parisph.case.presets import PRESETS
from tests.scenes import simulated
from tests.solid_scenes import errors_at_rest, still

SCENES = ("slope 3", "slope 15", "slope 30", "slope 60", "sill", "box", "plate", "basin")

LONG = {"numerics.time_step": 0.03}    # .3 sqrt(s/g): 300 steps are 9 s
ADAPTIVE = {"numerics.time_step": None}    # 1.3 sqrt(s/g) at rest


@pytest.mark.parametrize(("preset", "jitter", "steps"), [("violent", 0.0, 60), ("violent", 0.4, 200),
                                                         ("gentle", 0.4, 200)])
@pytest.mark.parametrize("name", SCENES)
def test_water_rests(name, preset, jitter, steps):
    """Ten layers of particles. `python -m tests.validation rest_at_walls` takes 10,000 steps.

    On the slope of 3 degrees, the surface is the only layer over more than ten spacings.
    """
    speed, error = errors_at_rest(still(name, preset, jitter=jitter), name, steps)
    assert speed.max() < 1e-10 and error.max() < 1e-10


def kicked(case, steps):
    """Return the greatest speed [m/s] so many steps after random velocities of 1e-9 m/s."""
    s = simulated(case)
    s.advance()
    p = s.particles
    fluid = p.kind == FLUID
    p.u[fluid] += 1e-9 * np.random.default_rng(1).standard_normal((fluid.sum(), 2))
    for _ in range(steps):
        s.advance()
    return np.abs(p.u[p.kind == FLUID]).max()


@pytest.mark.parametrize(("name", "preset", "changes", "steps", "most"), [
    ("slope 15", "violent", {}, 400, 2e-8), ("slope 15", "gentle", {}, 400, 2e-8),
    ("slope 3", "gentle", LONG, 300, 1e-8)])
def test_a_small_motion_does_not_grow_at_the_water_line(name, preset, changes, steps, most):
    """Measured 1e-8 or less; 3e-7 with the last particle of the wedge 0.6 spacings from the slope.

    On a flat beach, 1.4e-9: there waves need no continuity of films.
    """
    assert kicked(still(name, preset, jitter=0.4).changed(**changes), steps) < most


def test_a_small_motion_does_not_grow_on_a_steep_slope_in_long_steps():
    """Measured 5e-10 m/s; 6e-7 without the slopes across walls in the gradient of the last particle."""
    assert kicked(still("slope 60", "violent", jitter=0.4).changed(**ADAPTIVE), 700) < 1e-8


def test_a_small_motion_does_not_grow_on_a_flat_beach():
    """Measured 4e-8, and 3e-3 without the continuity of films: more than ten particles lie in one layer there."""
    others = [name for name in PRESETS["violent"]["regularisers"] if name != "film"]
    with_film, without = (still("slope 3", "violent", jitter=0.4, regularisers=parts).changed(**LONG)
                          for parts in (None, others))
    assert kicked(with_film, 300) < 2e-7 and kicked(without, 300) > 1e-4


@pytest.mark.parametrize(("name", "spacing"), [("slope 30", 0.1), ("slope 30", 0.125), ("slope 45", 0.09)])
def test_the_last_particle_of_a_kept_surface_does_not_creep_off(name, spacing):
    """The harmonic terms of its gradient would drive it: measured 8e-7 at most with their limit, 5e-5 to 6 without."""
    s = simulated(still(name, "gentle", spacing=spacing))
    s.advance()
    p = s.particles
    surface = np.flatnonzero(p.role == SURFACE)
    p.u[surface[np.argmax(p.x[surface, 0])], 0] = -1e-6
    for _ in range(600):
        s.advance()
    assert np.abs(p.u[p.kind == FLUID]).max() < 3e-6
