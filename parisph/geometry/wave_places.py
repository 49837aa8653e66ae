"""Whether the water at wavemakers and relaxation zones has the depth of their waves (2D)."""

from collections.abc import Iterator, Sequence

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.absorb import Relaxation
from parisph.case.bodies import Flap, Piston, Profile
from parisph.case.motion import AtRest
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.geometry.columns import beds
from parisph.geometry.solid import Wall, solid_of

CLOSE = 0.01    # of the depth of a wave: tolerance of the depth of the water
PLACES = 9      # along a zone


def faults(case: Scene, walls: Sequence[Wall]) -> Iterator[str]:
    """Yield one line for each wave made in water of another depth.

    walls : geometry.standing.standing of the case
    """
    for name, maker, face in zip(body_names(case.bodies), case.bodies, walls):
        if isinstance(maker, (Piston, Flap)) and isinstance(face, Profile) and maker.wave is not None:
            bed = float(np.min(np.array(face.points)[:, 1]))
            if isinstance(maker, Flap) and maker.bed is not None:
                bed = maker.bed
            yield from _depth(case, f"walls, {name}", maker.wave.depth, np.array([maker.place]), np.array([bed]), None)
    resting = [solid_of(wall) for wall in walls if isinstance(wall.motion, AtRest)]
    for number, zone in enumerate(case.absorb):
        if isinstance(zone, Relaxation) and resting:
            x = np.linspace(zone.start, zone.end, PLACES + 2)[1:-1]
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
    if not deep.min() - CLOSE * depth <= depth <= deep.max() + CLOSE * depth:
        there = f"{deep.min():g}" if np.ptp(deep) <= CLOSE * depth else f"{deep.min():g} to {deep.max():g}"
        yield f"{where}: wave.depth = {depth:g}: the water is {there} m deep there; change one of them"
