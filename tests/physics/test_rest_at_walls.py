"""Water at rest between walls of any shape stays at rest, with hydrostatic pressure."""

import pytest

from tests.solid_scenes import errors_at_rest, still

SCENES = ("slope 15", "slope 30", "slope 60", "sill", "box", "plate", "basin")


@pytest.mark.parametrize(("preset", "jitter", "steps"), [("violent", 0.0, 60), ("violent", 0.4, 200),
                                                         ("gentle", 0.4, 200)])
@pytest.mark.parametrize("name", SCENES)
def test_water_rests(name, preset, jitter, steps):
    """Ten layers of particles. `python -m tests.validation rest_at_walls` takes 10,000 steps."""
    speed, error = errors_at_rest(still(name, preset, jitter=jitter), name, steps)
    assert speed.max() < 1e-10 and error.max() < 1e-10
