"""Water at rest in 3D over 1,000 steps: a tank, a box on the bed, a slope, and a bed from a file."""

import numpy as np

from parisph import Box, Case, Fluid, Numerics, Obstacle, Profile, StillWater, Surface, Tank
from tests.solid_scenes import DENSITY, G, beach, errors_at_rest
from tests.triangles import sheet, write_stl
from tests.validation.record import Row

STEPS, SPEED, PRESSURE = 1_000, 1e-9, 1e-8
WIDTH, BREADTH, HIGH = 1.4, 1.2, 1.3    # of the tanks [m]; the water is 1 m deep
TANK = Tank(WIDTH, HIGH, breadth=BREADTH)


def _bed(folder):
    bed = sheet(lambda x, y: 0.25 + 0.15 * np.sin(3.0 * x) * np.cos(2.0 * y), (0.0, 0.0), (WIDTH, BREADTH), (28, 24))
    return TANK, Surface(file=str(write_stl(folder / "bed.stl", bed)))


# {name: walls from the folder for the file of the bed}
SCENES = {
    "tank": lambda folder: (TANK,),
    "box on the bed": lambda folder: (
        TANK, Obstacle(Box(width=0.4, height=0.4, breadth=0.4, at=(0.5, 0.4, 0.0)))),
    "slope of 30 degrees": lambda folder: (Profile(beach(30.0)[0].points, breadth=0.6),),
    "bed from a file": _bed,
}


def rows(bench):
    """Return the rows of all scenes for both presets, each from a start on the lattice and from a jittered one."""
    found = []
    for name in SCENES:
        for preset in ("gentle", "violent"):
            for jitter in (0.0, 0.4):
                what = f"{name} in 3D, {preset}, jitter {jitter:g}, {STEPS} steps"
                speed, error = errors_at_rest(still(name, preset, jitter, bench.folder), name, STEPS)
                found += [Row(f"{what}: max u / sqrt(gd)", speed.max(), SPEED),
                          Row(f"{what}: pressure error / rho g d", error.max(), PRESSURE)]
                late = slice(-STEPS // 5, None)
                print(f"  {what}: {speed.max():.1e} {error.max():.1e}, "
                      f"last fifth {speed[late].max():.1e} {error[late].max():.1e}", flush=True)
    return found


def still(name, preset, jitter, folder):
    """Return the Case of water at rest in one of SCENES, with adaptive steps. folder : Path, for the file of the bed"""
    return Case(title=name, fluid=Fluid(StillWater(1.0), density=DENSITY), walls=SCENES[name](folder),
                gravity=(0.0, 0.0, -G), end_time=1000.0,
                numerics=Numerics(spacing=0.1, preset=preset, jitter=jitter, seed=1, rtol=1e-12))
