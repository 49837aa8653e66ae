"""Checks of a whole case: faults are reported before any work.

Each check yields one line per problem, with field, value, limit and remedy.
"""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from parisph.base import vocabulary
from parisph.base.arrays import Floats
from parisph.base.memory import amount
from parisph.base.text import shown
from parisph.case import absorb, breadth_checks, scenery, size, surface_rules, time_checks, wave_sizes
from parisph.case.bodies import Body, StillWater, motion_of
from parisph.case.breadth import lifted
from parisph.case.expressions import uniform_field, vector_field
from parisph.case.fluids import check_components
from parisph.case.lattice import FIT
from parisph.case.methods import METHODS
from parisph.case.motion import AtRest, Translation
from parisph.case.probes import singles
from parisph.case.scene import Scene
from parisph.case.scenery import fluid_names
from parisph.case.shapes import ENDS, Box, Lid, Tank
from parisph.case.surface_body import Surface
from parisph.case.time_scales import SAMPLES, sample
from parisph.case.values import LARGEST
from parisph.case.waves import TankMode

FAR = 1e9       # spacings from the origin up to which float64 resolves places well


def problems(case: Scene) -> list[str]:
    """Return the list of problems of a case, each one line; empty for a case that can run."""
    found = [*_dimensions(case), *breadth_checks.problems(case), *surface_rules.problems(case)]
    if not found:
        found += scenery.problems(case)
    if not found:
        found += [*_inside(case), *_size(case)]
    if not found:
        found += [*_compressible(case), *_forces(case), *_absorbing(case), *_friction(case), *_surface(case),
                  *_wave(case), *_elevation(case), *_finite(case), *_probes(case), *_outputs(case)]
    if not found:
        found += time_checks.problems(case)
    return found


def _dimensions(case: Scene) -> Iterator[str]:
    dim = case.dim
    try:
        check_components("gravity", case.gravity, dim, with_time=True)
    except ValueError as error:
        up = ("; z points up, as in gravity=(0, 0, -9.81)" if dim == 3 else
              "; y points up, as in gravity=(0, -9.81)"
              + (", or give a Tank or a Profile a breadth, which makes the scene 3D" if len(case.gravity) == 3 else ""))
        yield str(error) + ("" if len(case.gravity) == dim else up)
    if isinstance(case.frame, Translation) and len(case.frame.direction) not in (2, dim):
        yield f"frame.direction = {case.frame.direction}: must have 2 components, as the scene is 2D"
    if case.frame.kind != "at_rest" and case.walls is None:
        yield f"frame = {case.frame.kind}: there is no tank to move; give walls=Tank(...) or leave the frame at rest"


def _compressible(case: Scene) -> Iterator[str]:
    """What weakly compressible SPH does not have."""
    if METHODS[case.numerics.method].step != "compressible":
        return
    lacks, choose = "weakly compressible SPH has", "choose a projection method"
    if case.turns:
        yield f"frame = {case.frame.kind}: {lacks} no Coriolis force; {choose}, or a frame that does not turn"
    if case.zones:
        yield f"absorb: {lacks} no zones; {choose}, or leave them out"
    if case.viscosity:
        yield (f"fluid.viscosity = {case.viscosity:g}: {lacks} its artificial viscosity alone; set "
               f"numerics.artificial_viscosity, or {choose}")
    if case.friction is not None:
        yield f"friction: {lacks} none; {choose}, or leave it out"
    for name, body in zip(scenery.body_names(case.bodies), case.bodies):
        if not isinstance(motion_of(body), AtRest):
            yield (f"walls, {name}: {lacks} no walls that move; {choose}, leave the motion out, or give that of a "
                   "whole tank as frame=")
        if (body.sticky or isinstance(body.lid, Lid)) if isinstance(body, Tank) else body.slip == "none":
            yield f"walls, {name}: {lacks} no friction on walls; {choose}, or leave no_slip, slip and Lid out"
    for surface in case.surfaces:
        if surface.slip == "none":
            yield f"walls, {surface.name}: {lacks} no friction on walls; {choose}, or leave slip out"


def _forces(case: Scene) -> Iterator[str]:
    """Physics that the chosen forces leave out."""
    if METHODS[case.numerics.method].step == "compressible":
        return
    forces = case.numerics.resolved().forces
    for there, name, force in ((case.turns, f"frame = {case.frame.kind}", "coriolis"), (case.zones, "absorb", "absorb"),
                               (case.friction, "friction", "friction")):
        if there and force not in forces:
            yield f"{name}: needs the force '{force}'; add it to numerics.forces"


def _absorbing(case: Scene) -> Iterator[str]:
    if case.zones and case.wall_bounds is None:
        yield "absorb: there is no tank; give walls=Tank(...) or leave the zones out"
    elif case.zones:
        yield from absorb.problems(case.zones, case.ends)


def _friction(case: Scene) -> Iterator[str]:
    law, s = case.friction, case.numerics.spacing
    if law is None:
        return
    if all(_sticks(body, case.dim) for body in case.all_bodies):
        yield ("friction: acts on walls along which fluid slips, and this scene has none; leave it out, "
               "or make walls without no_slip")
    if law.roughness > s:
        yield (f"friction.roughness = {law.roughness:g}: must be at most the spacing, here {s:g}, so that water is "
               "above it; use a larger spacing, or make the roughness a part of the walls")


def _sticks(body: Body | Surface, dim: int) -> bool:
    """Return whether all of a body is no-slip."""
    if isinstance(body, Tank):
        sides = {"left", "right", "bottom", *(("top",) if body.closed else ()), *(ENDS if dim == 3 else ())}
        return sides <= set(body.sticky)
    return body.slip == "none"


def _surface(case: Scene) -> Iterator[str]:
    """Only a full tank may lack a free surface, which fixes the level of the pressure in other scenes."""
    if case.closed or case.numerics.resolved().surface_rule != "none":
        return
    if case.numerics.surface_rule == "none":
        rules = ", ".join(rule for rule in vocabulary.known("surface_rule") if rule != "none")
        yield ("numerics.surface_rule = none: only for a tank with a lid that is full; "
               f"choose {rules}, or leave it to the preset")
    else:
        yield (f"numerics.preset = {case.numerics.preset}: looks for no free surface, only for a tank with a lid that "
               "is full; choose violent, gentle or solitary, or give numerics.surface_rule")


def _inside(case: Scene) -> Iterator[str]:
    if case.wall_bounds is None:
        return
    tolerance = FIT * case.numerics.spacing
    for name, fluid in fluid_names(case):
        if isinstance(fluid.shape, StillWater):
            if case.tank is not None and case.tank.closed and fluid.top > case.tank.bounds[1][-1] + tolerance:
                yield (f"{name}.shape.level = {fluid.top:g}: is above the lid of the tank, must be at most "
                       f"{case.tank.bounds[1][-1]:g}")
        else:
            box = case.box_of(fluid.shape)
            level = box[1][-1]
            fills = (f", or give StillWater(level={level:g}), which fills what the walls enclose"
                     if isinstance(fluid.shape, Box) and level <= case.wall_bounds[1][-1] else "")
            yield from _within(case, f"{name}.shape", box, tolerance, fills)


def _within(case: Scene, name: str, box: tuple[Floats, Floats], tolerance: float, remedy: str = "") -> Iterator[str]:
    """Yield where a box reaches beyond the walls, which are open above without a tank. remedy : a further one"""
    (lower, upper), (low, high) = box, case.wall_bounds or box
    for axis in range(case.dim):
        above = upper[axis] > high[axis] + tolerance and (axis < case.dim - 1 or case.tank is not None)
        if lower[axis] < low[axis] - tolerance or above:
            yield (
                f"{name} reaches from {'xyz'[axis]} = {lower[axis]:g} to {upper[axis]:g}: must lie within the walls, "
                f"from {low[axis]:g} to {high[axis]:g}; move or shrink it, or enlarge them{remedy}"
            )


def _size(case: Scene) -> Iterator[str]:
    s, n = case.numerics.spacing, size.counts(case)
    if n["all"] <= size.MOST:
        yield from _far(case)
    else:
        yield (
            f"numerics.spacing = {s:g}: makes about {n['all']:.3g} particles, {n['wall']:.3g} of them on walls, "
            f"which take about {amount(size.memory(n['all'], 1, case.dim))} of memory; "
            f"at most {size.MOST:.2g} can be numbered; "
            "use a larger spacing, or less fluid and a smaller tank"
        )


def _far(case: Scene) -> Iterator[str]:
    s = case.numerics.spacing
    for name, bounds in (("walls", case.wall_bounds), ("fluid.shape", case.fluid_bounds)):
        far = 0.0 if bounds is None else float(np.max(np.abs(bounds)))
        if far > FAR * s:
            yield (
                f"{name}: reaches {far:.3g} m from the origin, at most {FAR:g} spacings, here {FAR * s:.3g} m, "
                "can be told apart there; move the scene to the origin"
            )
            return


def _elevation(case: Scene) -> Iterator[str]:
    for name, fluid in fluid_names(case):
        if not fluid.raised:
            continue
        lower, upper = case.bounds_of(fluid)
        x, y = np.linspace(lower[0], upper[0], 8 * SAMPLES), None
        if case.dim == 3:
            x, y = (axis.ravel() for axis in np.meshgrid(x, np.linspace(lower[1], upper[1], 8 * SAMPLES)))
        eta, height, wave = fluid.rise(x, y), float((upper - lower)[-1]), fluid.wave
        what = f"{name}.elevation = {shown(fluid.elevation)}" if wave is None else f"{name}.wave = {wave.kind}"
        if not np.all(np.isfinite(eta)):
            yield f"{what}: is not a finite number at x = {x[~np.isfinite(eta)][0]:g}"
        elif eta.min() < -0.5 * height or eta.max() > height:
            yield (
                f"{what}: reaches from {eta.min():g} to {eta.max():g}, must stay between "
                f"{-0.5 * height:g} and {height:g}, or the columns are stretched too far"
            )
        elif case.tank is not None and upper[-1] + eta.max() > case.tank.bounds[1][-1]:
            yield (
                f"{what}: raises the surface to {upper[-1] + eta.max():g}, "
                f"above the tank's top at {case.tank.bounds[1][-1]:g}; lower it, or make the tank higher"
            )


def _mode(case: Scene, name: str, wave: object) -> Iterator[str]:
    """A TankMode fits between the walls of its tank."""
    tank = case.lone_tank
    if not isinstance(wave, TankMode) or tank is None or case.dim == 2:
        return
    lower, upper = (np.asarray(corner) for corner in tank.bounds)
    for field, own, due in (("length", wave.length, upper[0] - lower[0]),
                            ("breadth", wave.breadth, upper[1] - lower[1]),
                            ("at", np.array(wave.at), lower[:2])):
        if np.abs(own - due).max() > 1e-6 * (upper - lower).max():
            yield (f"{name}.{field} = {shown(wave.at) if field == 'at' else format(own, 'g')}: the tank has "
                   f"{shown(tuple(due.tolist())) if field == 'at' else format(due, 'g')}; change one of them")


def _wave(case: Scene) -> Iterator[str]:
    """A wave needs the gravity and the depth of the case. geometry.scene_checks checks the depth where they are made.
    """
    gravity = uniform_field(case.gravity)
    for name, wave in wave_sizes.waves(case):
        own = np.array([*[0.0] * (case.dim - 1), -wave.g])
        if gravity is None or np.abs(gravity - own).max() > 1e-6 * wave.g:
            yield (f"{name}.g = {wave.g:g}: the gravity of the case must be ({'0, ' * (case.dim - 1)}{-wave.g:g}); "
                   "change one of them")
    for name, fluid in fluid_names(case):
        yield from _mode(case, f"{name}.wave", fluid.wave)
        lower, upper = case.bounds_of(fluid)
        deepest, own_wave = float((upper - lower)[-1]), fluid.wave
        if own_wave is None or not isinstance(fluid.shape, StillWater):
            continue
        if abs(own_wave.depth - deepest) > 1e-6 * own_wave.depth:
            yield (f"{name}.wave.depth = {own_wave.depth:g}: the still water is {deepest:g} m deep where it is "
                   "deepest; change one of them")


def _finite(case: Scene) -> Iterator[str]:
    """Expressions must give finite numbers where there is fluid."""
    x = sample(case)
    asked = [(f"{name}.velocity", lifted(fluid.velocity, case.dim), False, own)
             for (name, fluid), own in zip(fluid_names(case), x)]
    for name, components, with_time, places in (*asked, ("gravity", case.gravity, True, np.concatenate(x))):
        values = vector_field(components, with_time)(places)
        for axis, component in enumerate(components):
            bad = ~(np.abs(values[:, axis]) <= LARGEST)
            if np.any(bad):
                at, value = ", ".join(f"{value:g}" for value in places[bad][0]), values[bad, axis][0]
                what = (f"is {value:.3g}, more than {LARGEST:g} in size," if np.isfinite(value)
                        else "is not a finite number")
                yield f"{name}[{axis}] = {shown(component)}: {what} at ({at})"


def _probes(case: Scene) -> Iterator[str]:
    for name, count in sorted(Counter(probe.name for probe in case.probes).items()):
        if count > 1:
            yield f"probes: the name {name!r} is given {count} times; give each probe a name of its own"
    for name, probe in singles(case.probes):
        if case.dim not in probe.dims:
            kind = type(probe).__name__
            yield (f"probe {name!r}: a {kind} exists in {probe.dims[0]}D only so far; leave it out of a scene in "
                   f"{case.dim}D")
        else:
            yield from (f"probe {name!r}: {line}" for line in probe.problems(case))


def _outputs(case: Scene) -> Iterator[str]:
    if case.dim != 2 and "vorticity" in case.output.fields:
        yield "output.fields: 'vorticity' exists in 2D only so far; leave it out of a scene in 3D"
