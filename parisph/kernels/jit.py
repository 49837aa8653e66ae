"""How kernels are compiled, and the compile-time axes that make them dimension-generic."""

import numba

# Division by zero is guarded by the kernels themselves, so the check that Python's error
# model adds is paid for nothing. NaN must stay NaN (it is how trouble is seen): no "nnan".
kernel = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "arcp", "nsz", "reassoc"})

# The length of a tuple is part of its type: a loop over range(len(axes)) is unrolled.
_AXES = {2: (0, 1), 3: (0, 1, 2)}


def axes_of(dim):
    """Return the compile-time axes tuple of a dimension, 2 or 3."""
    return _AXES[dim]
