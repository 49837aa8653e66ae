"""Which roles are used in stencils."""

from parisph.base.fields import CONTACT, DRY
from parisph.kernels.jit import subkernel


@subkernel
def outside(role: int) -> bool:
    """Return whether a particle with this role is left out of all stencils.

    Dry walls have no pressure. The wall particle at the contact line is left out too: it does not
    move with the surface, so p = 0 there is wrong by the height of the wave (small sloshing: error
    .84 of the wave with it, .04 without).
    """
    return role == DRY or role == CONTACT
