"""Speeds, forces and time steps that follow from a case alone, without particles."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.bodies import StillWater
from parisph.case.ellipsoid import Ellipsoid
from parisph.case.expressions import vector_field
from parisph.case.scene import Scene
from parisph.case.shapes import Box, Disc

SOUND = 10.0     # speed of sound of weakly compressible fluid over the expected largest speed
SAMPLES = 9      # points along each edge at which an expression is evaluated
LOOKS = 33       # times at which the body force is evaluated
STEADY = 0.3     # largest move in a fixed step of violent flow, in spacings
# spacings of thickness above which the flow sets the time scale, not its particles. The dam break at H/s = 80 has
# errors of P2 of .040 and .063 (Basilisk, interFoam; means of three starts) with it and .990 of its energy at
# t* = 2; .046, .054 and .989 without. It takes .73 of the steps
FINE = 20.0


def sample(case: Scene) -> list[Floats]:
    """Return points (n, dim) [m] all over each body of fluid."""
    many = 8 if any(fluid.wave is not None for fluid in case.fluids) else 1    # a wave may be short in a long tank
    return case.points(SAMPLES * many, SAMPLES)


def start(case: Scene) -> tuple[float, float]:
    """Return the largest speed of the fluid [m/s] and body force [m/s2] at the start."""
    x = sample(case)
    u = [np.linalg.norm(fluid.start_velocity(own), axis=1).max(initial=0.0) for fluid, own in zip(case.fluids, x)]
    force = np.linalg.norm(vector_field(case.gravity, True)(np.concatenate(x)), axis=1)
    return float(max(u)), float(force.max(initial=0.0))


def sound_speed(case: Scene) -> float:
    """Return the speed of sound of weakly compressible fluid [m/s]: by default SOUND times `fastest`."""
    return case.numerics.sound_speed or SOUND * fastest(case)


def fastest(case: Scene) -> float:
    """Return the expected largest speed [m/s]: that of the start, plus that of a fall from the fluid's height.

    In waves that do not break, the fall is replaced by the speed of long waves.
    """
    lower, upper = case.fluid_bounds
    fall = 2.0 if case.numerics.preset == "violent" else 1.0
    return start(case)[0] + float(np.sqrt(fall * strongest(case) * (upper - lower)[-1]))


def stable_time_step(case: Scene) -> tuple[float, str]:
    """Estimate the largest sensible time step [s] from the case alone; return also its reason in words.

    For waves, sqrt(s/g), the time scale of the shortest waves on the lattice. For violent flows also
    cfl s/u with u = |u0| + sqrt(2 g H), the speed after a fall from the height of the fluid (Z14 Sec. 3.1.2). The cfl
    of a fixed step is at most STEADY, as nothing shortens the step in an impact.
    """
    s, (speed, g) = case.numerics.spacing, start(case)
    lower, upper = case.fluid_bounds
    cfl = case.numerics.resolved().cfl
    if case.numerics.preset == "violent":
        if case.numerics.time_step is not None:
            cfl = min(cfl, STEADY)
        speed += np.sqrt(2.0 * g * (upper - lower)[-1])
    by_waves = np.sqrt(s / g) if g > 0.0 else np.inf
    by_speed = cfl * s / speed if speed > 0.0 else np.inf
    if by_speed < by_waves:
        return by_speed, f"moves the fastest fluid by {cfl:g} spacings"
    return by_waves, "resolves the shortest waves on the lattice"


def wave_time(case: Scene) -> float:
    """Return sqrt(s/g) [s], the time scale of the shortest waves on the lattice; infinite without a force g."""
    g = strongest(case)
    return float(np.sqrt(case.numerics.spacing / g)) if g > 0.0 else np.inf


def strongest(case: Scene) -> float:
    """Return the largest body force on the fluid [m/s2] at LOOKS times until the end, in the frame of the tank."""
    x = np.concatenate(sample(case))
    if case.same_force_everywhere:
        x = x[:1]
    return float(max(np.linalg.norm(case.body_force(x, t), axis=1).max(initial=0.0)
                     for t in np.linspace(0.0, case.end_time, LOOKS)))


def flow_length(case: Scene) -> float:
    """Return the length l [m] of the time scale sqrt(l/a) of violent flow: the spacing, or if more, the smallest extent
    of any body of fluid at the start over FINE, if all are boxes, discs, ellipsoids or still water without holes."""
    shapes = Box, Disc, Ellipsoid, StillWater
    whole = all(isinstance(fluid.shape, shapes) and not fluid.holes for fluid in case.fluids)
    thickness = min(float(np.min(high - low)) for low, high in map(case.bounds_of, case.fluids))
    return max(case.numerics.spacing, thickness / FINE if whole else 0.0)
