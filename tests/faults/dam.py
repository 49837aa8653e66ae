"""The dam break that the campaign disturbs: in 2D, or in a slab of water with --3d."""

import os

from parisph import Case, Energy, Fluid, PressureTap, Volume, WaterFront
from tests.scenes import scene

IN_3D = "PARISPH_FAULTS_IN_3D"    # for the processes of a campaign: set, and not empty, with --3d
CELLS = 6                         # breadth of the slab in spacings


def dam(numerics: dict | None = None, **sets) -> Case:
    """Return the case of tests.scenes.scene("dam_break")."""
    case = scene("dam_break", numerics, **sets)
    return slab(case) if os.environ.get(IN_3D) else case


def slab(case: Case) -> Case:
    """Return a dam break in 2D as one in 3D, some spacings broad; its taps are in the middle, without truths."""
    breadth = CELLS * case.numerics.spacing
    fluid = Fluid(case.fluid.shape.model_copy(update={"breadth": breadth}), case.fluid.density)
    taps = [PressureTap(tap.name, at=(tap.at[0], 0.5 * breadth, tap.at[-1]), radius=tap.radius)
            for tap in case.probes if isinstance(tap, PressureTap)]
    return Case(title=case.title, fluid=fluid, walls=case.walls.model_copy(update={"breadth": breadth}),
                gravity=(0.0, 0.0, case.gravity[-1]), numerics=case.numerics, output=case.output,
                end_time=case.end_time, probes=[*taps, WaterFront("front"), Energy("energy"), Volume("volume")])

