"""The work of a particle in the kernels of a step, by which the ranks get equal shares.

Work is counted, not timed. Measured time includes waiting for other ranks, and differs from run to run,
so that a run on several ranks could not be repeated bit for bit.
"""

import numpy as np

from parisph.base.arrays import Array, Ints
from parisph.base.fields import INNER, SURFACE, WET

# Found by timing the kernels on three ranks, of which one had up to three times the work of another. Each
# measure of work gives the ranks' shares of the processor time with these largest errors:
#                                         dam break   the same, ISPH   still tank   rotating patch
#     particles                               .21            .31           .02            .01
#     neighbours                              .03            .06           .03            .01
#     3 or 10 times (neighbours + 10)         .03            .04           .03            .00
# Calls and work without neighbours cost as much as ten neighbours; particles in no stencil are only
# sorted, listed and tested.
BY_ITSELF = 10
TAKING_PART, LEFT_OUT = 10, 3


def work_of(role: Array, neighbours: Ints) -> Ints:
    """Return the work of particles (n,) int64, in tenths of what one neighbour costs.

    role : (n,) as in the field registry; neighbours : (n,) int, lengths of their lists
    """
    each = np.where(np.isin(role, (INNER, SURFACE, WET)), TAKING_PART, LEFT_OUT)
    work: Ints = each * (np.asarray(neighbours, np.int64) + BY_ITSELF)
    return work
