"""The work of a particle in the kernels of a step, of which ranks get equal shares.

Work is counted, not timed. Measured time includes waiting and varies: runs on several ranks could not be repeated bit
for bit.
"""

import numpy as np

from parisph.base.arrays import Array, Ints
from parisph.base.fields import INNER, SURFACE, WET

# From timings of the kernels on three ranks, with up to three times the work on one of them. Each measure of work gives
# the ranks' shares of CPU time with these largest errors:
#                                         dam break   the same, ISPH   still tank   rotating patch
#     particles                               .21            .31           .02            .01
#     neighbours                              .03            .06           .03            .01
#     3 or 10 times (neighbours + 10)         .03            .04           .03            .00
# Work without neighbours costs as much as ten neighbours. Particles in no stencil are only sorted, listed and tested.
BY_ITSELF = 10
TAKING_PART, LEFT_OUT = 10, 3


def work_of(role: Array, neighbours: Ints) -> Ints:
    """Return the work of particles (n,) int64, in tenths of the cost of one neighbour.

    role : (n,) as in the field registry; neighbours : (n,) int, lengths of their lists
    """
    each = np.where(np.isin(role, (INNER, SURFACE, WET)), TAKING_PART, LEFT_OUT)
    work: Ints = each * (np.asarray(neighbours, np.int64) + BY_ITSELF)
    return work
