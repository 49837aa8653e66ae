"""A tank of water at rest over 10,000 steps."""

from tests.scenes import scene
from tests.solid_scenes import errors_at_rest
from tests.validation.record import Row

STEPS = 10_000


def rows(bench):
    """Return the rows for a start on the lattice and for two jittered ones."""
    found = []
    for jitter in (0.0, 0.4, 0.8):
        speed, error = errors_at_rest(scene("hydrostatic", jitter=jitter), "tank", STEPS)
        name = f"hydrostatic, jitter {jitter:g}, {STEPS} steps"
        fifth = STEPS // 5
        found += [
            Row(f"{name}: max u / sqrt(gd)", speed.max(), 1e-6),
            Row(f"{name}: pressure error / rho g d", error.max(), 1e-6),
            Row(f"{name}: last fifth / second fifth of u", speed[-fifth:].max() / speed[fifth:2 * fifth].max(), 1.1),
            Row(f"{name}: last fifth / second fifth of the pressure error",
                error[-fifth:].max() / error[fifth:2 * fifth].max(), 1.1),
        ]
        print(f"  {name}: done", flush=True)
    return found
