"""The raised surface of fluid at the start: columns stretched linearly from the bed to the elevation (2D).

This moves the particles of a Box, and the sample places of the volume of any fluid.
"""

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.bodies import StillWater
from parisph.case.fluids import Fluid
from parisph.case.scene import Scene
from parisph.case.shapes import Box
from parisph.geometry.columns import beds
from parisph.geometry.mesh import WallMesh

MOST = 0.5    # of the depth: limit of the elevation where the bed rises, as at a shore
MANY = {2: 10000, 3: 400}    # most places along each axis at which the highest surface is looked for
LEVEL = 1e-9  # of the depth, above the lowest place of the water: a lower bed is level


def raised(fluid: Fluid, mesh: WallMesh | None, bounds: tuple[Floats, Floats], x: Floats) -> tuple[Floats, Floats]:
    """Return where points x (n, 2) [m] below a level surface are moved, and the stretch there, (n,).

    bounds : the corners (2,) [m] of a box around the body of fluid. Points below an overhang stay.
    """
    if not fluid.raised:
        return x, np.ones(len(x))
    columns, which = np.unique(x[:, 0], return_inverse=True)
    top = fluid.top
    bottom = np.full(len(columns), bounds[0][-1])
    if mesh is not None:
        bed = beds(mesh.corners(), columns, top)
        bottom = bed if isinstance(fluid.shape, StillWater) else np.maximum(bottom, bed)
    depth = np.maximum(top - bottom, 1e-300)
    share = fluid.rise(columns) / depth
    share = np.where(bottom > bounds[0][-1] + LEVEL * depth, np.clip(share, -MOST, MOST), share)
    bottom, share = bottom[which.reshape(-1)], share[which.reshape(-1)]
    stretched = x[:, 1] > bottom
    moved = x.copy()
    moved[stretched, 1] = (bottom + (x[:, 1] - bottom) * (1.0 + share))[stretched]
    return moved, np.where(stretched, 1.0 + share, 1.0)


def lowered(fluid: Fluid, x: Floats) -> Floats:
    """Return where points x (n, 2) [m] of a raised Box on a level bed came from; for other fluid, x itself."""
    if not fluid.raised or not isinstance(fluid.shape, Box):
        return x
    bottom, height = fluid.shape.bounds[0][-1], fluid.shape.height
    below = x.copy()
    below[:, 1] = bottom + (x[:, 1] - bottom) / (1.0 + fluid.rise(x[:, 0]) / height)
    return below


def highest(case: Scene, fluid: Fluid) -> float:
    """Return the height [m] of the surface of a body of fluid at the start."""
    lower, upper = case.bounds_of(fluid)
    if not fluid.raised:
        return float(upper[-1])
    many = [min(8 + int(8 * length / case.numerics.spacing), MANY[case.dim]) for length in (upper - lower)[:-1]]
    places = np.meshgrid(*(np.linspace(low, high, n) for low, high, n in zip(lower, upper, many)))
    return float(upper[-1] + fluid.rise(*(place.ravel() for place in places)).max())
