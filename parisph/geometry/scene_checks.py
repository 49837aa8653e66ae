"""Checks of a case that need its geometry: faults, warnings, and facts for `parisph check`."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.text import rounded_down
from parisph.case import breadth_checks
from parisph.case.absorb import Relaxation
from parisph.case.bodies import Flap, Piston, Profile, StillWater
from parisph.case.faults import first_lines
from parisph.case.lattice import FIT, misfit
from parisph.case.motion import AtRest, Rotation, course
from parisph.case.scene import Scene
from parisph.case.scenery import body_names, fluid_names
from parisph.case.sections import sections
from parisph.case.shapes import Box, Polygon, Tank
from parisph.geometry import feasible, probe_places, surface_checks
from parisph.geometry.build import counts, domain, fillings, has_surface, scene_mesh, volume
from parisph.geometry.by_sections import said
from parisph.geometry.columns import beds
from parisph.geometry.distance import nearest
from parisph.geometry.encounters import Encounter, encounters
from parisph.geometry.fill import Filling
from parisph.geometry.mesh import chains_of, wall_mesh
from parisph.geometry.quadrature import fluid_area
from parisph.geometry.scene_room import scene_room
from parisph.geometry.solid import Wall, signed_area, solid_of
from parisph.geometry.standing import given, standing
from parisph.geometry.tips import WIDTH, Tip, tips

ROOM = 2.0      # spacings that a tank needs behind the extreme position of a wavemaker
AIR = 2.0       # spacings of air below a lid: with less the force on a tank that sways is more than 1 % too large
LEAST = 4       # fluid particles that a scene needs
STRETCH = 0.1   # of a spacing: a Box whose lattice differs more gets advice
DEEP = 0.01     # of the depth of a wave: largest difference from that of the water
ALONG = 9       # places along a zone at which it is looked at


@dataclass(frozen=True)
class Facts:
    """What `parisph check` reports about the walls and the filling of a scene.

    elements : number of wall elements; gap : the least distance across fluid [m], inf without one; between : its two
    bodies; at : where (3,) [m], beside a Surface, else (); wedge : the sharpest corner of the fluid [degrees], 180
    without one; volume : exact, of all fluid at the start [m^dim]; lattice : the sum of its particles' cells [m^dim]
    """

    elements: int
    gap: float
    between: tuple[str, str]
    wedge: float
    volume: float
    lattice: float
    at: tuple[float, ...] = ()


def check(case: Scene) -> None:
    """Raise CaseError if the geometry of a case cannot be computed, with one line for each fault. Not collective."""
    if found := faults(case):
        raise CaseError(first_lines(found))


def faults(case: Scene) -> list[str]:
    """Return the faults of a scene that cannot be computed, one line each with a remedy.

    In 3D they are those of its sections.
    """
    if case.dim == 3:
        return said(case, _faults) or surface_checks.faults(case) or [*_few(case), *probe_places.faults(case, ())]
    return _faults(case)


def _faults(case: Scene) -> list[str]:
    """Return the faults of a 2D scene, which may be a section without fluid."""
    try:
        walls = standing(case)
    except CaseError as error:
        return [str(error)]
    found = feasible.faults(walls, [fluid.shape for fluid in case.fluids], case.numerics.spacing,
                             [fluid.holes for fluid in case.fluids], [name for name, _ in fluid_names(case)])
    if found or not case.fluids:
        return found or [*_reached(case, walls)]
    return [*_few(case), *_full(case, walls), *_reached(case, walls), *probe_places.faults(case, walls),
            *_depths(case, walls)]


def warnings(case: Scene) -> list[str]:
    """Return what will be computed with larger errors, and advice on the spacing. In 3D it is that of its sections."""
    if case.dim == 2:
        return _warnings(case)
    return [*breadth_checks.warnings(case), *said(case, _warnings), *surface_checks.warnings(case)]


def _warnings(case: Scene) -> list[str]:
    walls, shapes = standing(case), [fluid.shape for fluid in case.fluids]
    own = [*feasible.warnings(walls, shapes, case.numerics.spacing), *_stepped(case, walls)] if walls else []
    return [*own, *_filled(case), *_neared(case, walls), *_advice(case)]


def facts(case: Scene) -> Facts | None:
    """Return the Facts of a scene with walls, None for others. Gaps and wedges of a 3D scene are in its sections."""
    if case.dim == 2 or not case.bodies:
        return _facts(case)
    found = [known for _, _, scene in sections(case) if (known := _facts(scene)) is not None]
    gap, wedge = min(found, key=lambda known: known.gap), min(known.wedge for known in found)
    across, between = breadth_checks.gaps(case)[0]
    if across < gap.gap:
        gap = replace(gap, gap=across, between=between)
    if case.surfaces:
        across, between, at = surface_checks.thinnest_gap(case)
        if across < gap.gap:
            gap = replace(gap, gap=across, between=between, at=tuple(np.round(at, 6).tolist()))
    mesh = scene_mesh(case)
    return replace(gap, elements=0 if mesh is None else len(mesh.elements), wedge=wedge, volume=volume(case),
                   lattice=_lattice(case))


def _lattice(case: Scene) -> float:
    """Return the sum of the cells of all fluid particles on their lattices [m^dim]."""
    return sum(fill.count * float(fill.step.prod()) for fill in fillings(case))


def _facts(case: Scene) -> Facts | None:
    """Return the Facts of a 2D scene, which may be a section without fluid."""
    walls, s = standing(case), case.numerics.spacing
    if not walls:
        return None
    mesh, chains = wall_mesh(walls, s), chains_of(walls, s)
    gap, _, one, other = feasible.thinnest_gap(*feasible.resting(mesh, chains), walls)
    names = [body.name for body in mesh.bodies]
    shores = [angle for angle, _, _ in feasible.shores(mesh, [fluid.top for fluid in case.fluids])]
    wedge = min([float(np.degrees(chain.angle.min())) for chain in chains] + shores)
    return Facts(len(mesh.elements), gap, (names[one], names[other]), min(wedge, 180.0), volume(case),
                 _lattice(case))


def _filled(case: Scene) -> Iterator[str]:
    """Fluid too narrow for particles, which a solid replaces; a line for each pair of bodies."""
    walls, s = given(case), case.numerics.spacing
    wedges: dict[tuple[int, ...], list[Tip]] = {}
    for tip in tips(walls, s):
        pair = tuple(sorted(set(tip.solid.beside)))
        at = f"({tip.at[0]:.3g}, {tip.at[1]:.3g})"
        if tip.gap == 0.0:
            wedges.setdefault(pair, []).append(tip)
        else:
            yield (f"{_names(walls, pair)}: at {at} only {tip.gap:.3g} m are between them, {tip.gap / s:.2g} spacings. "
                   f"The gap is closed over {tip.length:.2g} m: particles have no room in it; to let fluid through, "
                   f"use a spacing of at most {rounded_down(tip.gap / feasible.GAP)}")
    for pair, found in wedges.items():
        places = " and ".join(dict.fromkeys(f"({tip.at[0]:.2g}, {tip.at[1]:.2g})" for tip in found[:2]))
        more = f" and {len(found) - 2} more places" if len(found) > 2 else ""
        yield (f"{_names(walls, pair)}: the fluid ends in a wedge at {places}{more}. Its tip, where it is less than "
               f"{WIDTH:g} spacings wide, is filled over {max(tip.length for tip in found):.2g} m: particles have no "
               "room in it")


def _names(walls: tuple[Wall, ...], pair: tuple[int, ...]) -> str:
    return "walls, " + " and ".join(walls[number].name for number in pair)


def _reached(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Walls that move into others."""
    for met in _met(walls, case):
        if met.distance == 0.0:
            one, other = walls[met.one], walls[met.other]
            moves = type(one.motion).__name__
            unit = "rad" if isinstance(one.motion, Rotation) else "m"
            yield (f"walls, {one.name}: its {moves} brings it to {other.name} at t = {met.time:.3g} s, at "
                   f"({met.at[0]:.3g}, {met.at[1]:.3g}), {abs(met.value):.3g} {unit} from where it starts; must stay "
                   f"clear of it: {_room_behind(case, walls, met)}move less far, move one of them, or give both the "
                   "same motion")


def _room_behind(case: Scene, walls: tuple[Wall, ...], met: Encounter) -> str:
    """Return where a tank or a bed must begin or end to leave room behind a wavemaker that reaches it."""
    face, s = walls[met.one], case.numerics.spacing
    maker, other = (case.bodies[number] if number < len(case.bodies) else None for number in (met.one, met.other))
    if not isinstance(maker, (Piston, Flap)) or not isinstance(other, (Tank, Profile)):
        return ""
    on_left, values = maker.fluid_on_left, course(face.motion, case.end_time)[1]
    x = np.concatenate([face.motion.placed_by(solid_of(face).points, value)[:, 0]
                        for value in (values.min(), values.max())])
    (low, bottom), (high, top) = other.bounds
    if on_left:
        high = s * np.ceil((float(x.max()) + ROOM * s) / s)
    else:
        low = s * np.floor((float(x.min()) - ROOM * s) / s)
    if (met.at[0] < maker.place) if on_left else (met.at[0] > maker.place):    # reached in front
        return ""
    verb, place = ("end", high) if on_left else ("begin", low)
    if isinstance(other, Profile):
        return f"{verb} the bed behind it, at x = {place:g}, "
    return (f"{verb} the tank behind it, as in Tank(width={high - low:g}, height={top - bottom:g}, at=({low:g}, "
            f"{bottom:g})), ")


def _neared(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Walls that move and leave too little room for fluid."""
    s = case.numerics.spacing
    for met in _met(walls, case):
        if 0.0 < met.distance < feasible.GAP * s:
            one, other = walls[met.one], walls[met.other]
            moves = type(one.motion).__name__
            yield (f"walls, {one.name}: its {moves} leaves {met.distance:.3g} m, {met.distance / s:.2g} spacings,"
                   f" between it and {other.name} at t = {met.time:.3g} s, at ({met.at[0]:.3g}, {met.at[1]:.3g}): flow "
                   f"through it needs {feasible.GAP:g}; move less far, or use a spacing of at most "
                   f"{rounded_down(met.distance / feasible.GAP)}")


def _met(walls: tuple[Wall, ...], case: Scene) -> tuple[Encounter, ...]:
    return encounters(walls, case.numerics.spacing, case.end_time, feasible.GAP * case.numerics.spacing)


def _few(case: Scene) -> Iterator[str]:
    count = counts(case)["fluid"]
    if count >= LEAST:
        return
    s, level = case.numerics.spacing, float(case.fluid_bounds[1][-1]) if case.fluids else -np.inf
    bottom = float(scene_room(case).nodes[:, 2].min()) if case.surfaces else -np.inf
    if bottom > level - s:
        yield (f"fluid: reaches up to z = {level:g} m, but the walls leave room from z = {bottom:.4g} m on, above "
               f"{' and '.join(surface.name for surface in case.surfaces)}; raise its level, or move the bed by at=")
    else:
        yield (f"numerics.spacing = {case.numerics.spacing:g}: leaves {count} fluid particles, at least {LEAST} are "
               "needed; use a smaller spacing")


def _full(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Tanks filled up to the lid by other fluid than StillWater: they do not count as closed."""
    tank, s = case.tank, case.numerics.spacing
    if tank is None or case.closed or case.lone_tank is not None or not _at_lid(case):
        return
    if _air(case, walls) < 0.5 * s:
        top = float(tank.bounds[1][1])
        yield (f"fluid: it fills the tank up to its lid at y = {top:g}, and none of it has a surface; give "
               f"StillWater(level={top:g}), which is computed without one, or leave at least a spacing of air, "
               f"{s:g} m")


def _at_lid(case: Scene, within: float = 1.0) -> bool:
    tank = case.tank
    return tank is not None and tank.closed and (
        case.fluid_bounds[1][1] > tank.bounds[1][1] - within * case.numerics.spacing)


def _air(case: Scene, walls: tuple[Wall, ...]) -> float:
    """Return the mean thickness [m] of the air in a tank."""
    assert case.tank is not None
    full = Filling(StillWater(level=float(case.tank.bounds[1][1])), walls, case.numerics.spacing)
    return (fluid_area(full, *domain(case)) - volume(case)) / case.tank.width


def airless(case: Scene) -> Iterator[str]:
    """Yield a warning of fluid without a surface, or with little air, in a scene that does not count as closed."""
    if case.dim == 3:
        yield from [] if case.closed else said(case, lambda scene: _airless(scene) if scene.fluids else ())
    else:
        yield from _airless(case)


def _airless(case: Scene) -> Iterator[str]:
    s = case.numerics.spacing
    if case.closed or not _at_lid(case, AIR):
        return
    if _at_lid(case) and not has_surface(case):
        yield ("no fluid particle is on a free surface, so that p = 0 is set only at the highest one; leave a spacing "
               "of air below the lid, or fill the tank with StillWater")
    elif (air := _air(case, standing(case))) < (1.0 - FIT) * AIR * s:
        yield (f"fluid: the air below the lid is {air:.3g} m thick in the mean, {air / s:.3g} spacings; with less than "
               f"{AIR:g}, water that reaches the lid pushes the tank as if it were half a spacing deeper; use a "
               f"spacing of at most {rounded_down(air / AIR)}")


def _stepped(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Polygons whose surface does not lie on the lattice, so that it starts below where the user puts it."""
    s, corners = case.numerics.spacing, wall_mesh(walls, case.numerics.spacing).corners()
    for (name, fluid), fill in zip(fluid_names(case), fillings(case)):
        if not isinstance(fluid.shape, Polygon) or not isinstance(fill, Filling):
            continue
        points = np.array(fluid.shape.points)
        a, b = (points, np.roll(points, -1, axis=0))[:: 1 if signed_area(points) > 0.0 else -1]
        rows = (np.stack([a, b])[..., 1] - fill.origin[1]) / fill.step[1]
        fits = (abs(a - b)[:, 1] < FIT * s) & (abs(rows - np.round(rows)).max(axis=0) < FIT)
        free = (b[:, 0] < a[:, 0] - s) & (nearest(0.5 * (a + b), corners)[0] > 0.5 * s)
        for k in np.flatnonzero(free & ~fits)[:1]:
            yield (f"{name}: the surface from ({b[k, 0]:g}, {b[k, 1]:g}) to ({a[k, 0]:g}, {a[k, 1]:g}) does not lie on "
                   "the lattice, and starts in steps up to a spacing below it: water at rest has too low a pressure; "
                   "give the elevation of a Box or of StillWater instead, or use a smaller spacing")


def _advice(case: Scene) -> Iterator[str]:
    """Boxes with edges that are not a whole number of spacings long, whose lattice is stretched."""
    s = case.numerics.spacing
    for name, fluid in fluid_names(case):
        if not isinstance(fluid.shape, Box):
            continue
        for field, length in (("width", fluid.shape.width), ("height", fluid.shape.height)):
            step = length / max(round(length / s), 1)
            if misfit(length, s) > FIT and abs(step - s) > STRETCH * s:
                yield (f"{name}.shape.{field} = {length:g} is {length / s:.3g} spacings: its particles start "
                       f"{step:.3g} m apart, not {s:g}; a spacing of {step:.6g} divides it")


def _depths(case: Scene, walls: tuple[Wall, ...]) -> Iterator[str]:
    """Waves that wavemakers and zones make in water of another depth."""
    for name, maker, face in zip(body_names(case.bodies), case.bodies, walls):
        if isinstance(maker, (Piston, Flap)) and isinstance(face, Profile) and maker.wave is not None:
            bed = float(np.min(np.array(face.points)[:, 1]))
            if isinstance(maker, Flap) and maker.bed is not None:
                bed = maker.bed
            yield from _depth(case, f"walls, {name}", maker.wave.depth, np.array([maker.place]), np.array([bed]), None)
    resting = [solid_of(wall) for wall in walls if isinstance(wall.motion, AtRest)]
    for number, zone in enumerate(case.absorb):
        if isinstance(zone, Relaxation) and resting:
            x = np.linspace(zone.start, zone.end, ALONG + 2)[1:-1]
            corners = np.concatenate([outline.elements for outline in resting])
            yield from _depth(case, f"absorb[{number}]", zone.wave.depth, x, beds(corners, x, np.inf), zone.level)


def _depth(case: Scene, where: str, depth: float, x: Floats, bed: Floats, level: float | None) -> Iterator[str]:
    """Compare the depth of a wave with the depths of the water at places x (n,) above beds (n,) [m]."""
    if level is None:
        boxes = [case.bounds_of(fluid) for fluid in case.fluids]
        tops = [top[-1] for low, top in boxes if np.any((x >= low[0] - 1e-9) & (x <= top[0] + 1e-9))]
        if not tops:
            return
        level = max(tops)
    deep = level - bed
    if not deep.min() - DEEP * depth <= depth <= deep.max() + DEEP * depth:
        there = f"{deep.min():g}" if np.ptp(deep) <= DEEP * depth else f"{deep.min():g} to {deep.max():g}"
        yield f"{where}: wave.depth = {depth:g}: the water is {there} m deep there; change one of them"
