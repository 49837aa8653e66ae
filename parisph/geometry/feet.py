"""Open ends of moving walls that stand on other walls, like the foot of a piston on the bed: corners of the fluid."""

from dataclasses import replace

import numpy as np

from parisph.base.arrays import Floats
from parisph.geometry.distance import unit_normals
from parisph.geometry.mesh import WallMesh

ON = 0.1    # tuned 0.05 to 0.4: spacings between an end and the wall that it stands on; judged
ALIKE = 0.9     # tuned 0.7 to 0.95: cosine of normals above which elements belong to one wall; judged


def on_walls(mesh: WallMesh, spacing: float) -> WallMesh:
    """Return a mesh whose ends of moving walls have the normal of a corner where they stand on another wall.

    It is the normalised sum of the normals of all walls there. With that of the moving wall alone, a node on a bed sees
    no fluid and has no row. Fluid in the corner then has too few neighbours. spacing : [m]
    """
    motion = np.array([body.motion for body in mesh.bodies], dtype=np.int64)
    ends = np.flatnonzero(mesh.ends & (motion[mesh.body] > 0)) if motion.any() else np.empty(0, np.int64)
    if not len(ends):
        return mesh
    x, corners, near = mesh.x0[ends], mesh.corners(), ON * spacing
    low, high = corners.min(axis=1) - near, corners.max(axis=1) + near
    close = ((low <= x.max(axis=0)) & (high >= x.min(axis=0))).all(axis=1)
    corners, low, high, moves = corners[close], low[close], high[close], motion[mesh.element_body[close]]
    unit, normal = unit_normals(corners), mesh.normal0.copy()
    for end, at in zip(ends, x):
        here = (moves < motion[mesh.body[end]]) & ((low <= at) & (high >= at)).all(axis=1)
        here &= np.abs(np.sum((at - corners[:, 0]) * unit, axis=1)) <= near
        normal[end] = _of_corner(normal[end], unit[here])
    return replace(mesh, normal0=normal)


def _of_corner(own: Floats, others: Floats) -> Floats:
    """Return the normalised sum (dim,) of a unit normal (dim,) and of the different ones among others (n, dim)."""
    sides = [own]
    for other in others:
        if max(float(side @ other) for side in sides) < ALIKE:
            sides.append(other)
    total = np.sum(sides, axis=0)
    size = float(np.linalg.norm(total))
    return total / size if size > 1.0 - ALIKE else own
