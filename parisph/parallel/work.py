"""How much work a particle makes in the kernels of a step: the measure by which ranks get equal shares.

Work is counted, not timed. A clock also runs while a rank waits for the others, and ranks that are
spread by it are spread another way each time, so that no run on several ranks could be repeated
bit for bit.
"""

import numpy as np

from parisph.base.fields import INNER, SURFACE, WET

# Found by timing the kernels of three ranks, of which the busiest had up to three times the work
# of the idlest. Processor time was shared out as follows, with the largest error of a rank's share:
#                                         dam break   the same, ISPH   still tank   rotating patch
#     particles                               .21            .31           .02            .01
#     neighbours                              .03            .06           .03            .01
#     3 or 10 times (neighbours + 10)         .03            .04           .03            .00
# The overhead of a call and what has no neighbours cost as much as ten of them; particles in no
# stencil are sorted, listed and tested, and no more.
BY_ITSELF = 10
TAKING_PART, LEFT_OUT = 10, 3


def work_of(role, neighbours):
    """Return the work of particles (n,) int64, in tenths of what one neighbour costs.

    role : (n,) as in the field registry; neighbours : (n,) int, lengths of their lists
    """
    each = np.where(np.isin(role, (INNER, SURFACE, WET)), TAKING_PART, LEFT_OUT)
    return each * (np.asarray(neighbours, np.int64) + BY_ITSELF)
