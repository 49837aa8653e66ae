"""What the roles mean to a stencil."""

from parisph.base.fields import CONTACT, DRY
from parisph.kernels.jit import kernel


@kernel
def outside(role):
    """Return whether a particle with this role is in no stencil.

    Dry walls have no pressure. Nor has the wall node at the contact line: it stays where it is
    while the surface beside it moves, so p = 0 there is wrong by as much as the wave itself
    (small sloshing: error .84 of the wave with it, .04 without).
    """
    return role == DRY or role == CONTACT
