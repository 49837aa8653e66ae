"""Water at rest over 10,000 steps beside walls of any shape: slopes, a sill, a box, a plate, a basin."""

from tests.solid_scenes import WALLS, errors_at_rest, still
from tests.validation.record import Row

STEPS, ASKED = 10_000, 1e-9


def rows(bench):
    """Return the rows for both presets, each from a start on the lattice and from a jittered one."""
    found = []
    for name in WALLS:
        if name == "slope 3":    # rests for hundreds of steps: see the limits
            continue
        for preset in ("violent", "gentle"):
            for jitter in (0.0, 0.4):
                what = f"{name}, {preset}, jitter {jitter:g}, {STEPS} steps"
                speed, error = errors_at_rest(still(name, preset, jitter=jitter), name, STEPS)
                late = slice(-STEPS // 5, None)
                found += [Row(f"{what}: max u / sqrt(gd)", speed.max(), ASKED),
                          Row(f"{what}: pressure error / rho g d", error.max(), ASKED)]
                print(f"  {what}: {speed.max():.1e} {error.max():.1e}, "
                      f"last fifth {speed[late].max():.1e} {error[late].max():.1e}", flush=True)
    return found
