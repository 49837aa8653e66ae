"""How kernels are compiled, and the compile-time axes that make them dimension-generic."""

import numba

from parisph.kernels import cache, processor

processor.leave_out_avx512()

# Division by zero is guarded by the kernels themselves, so the check that Python's error
# model adds is paid for nothing. NaN must stay NaN (it is how trouble is seen): no "nnan".
_OPTIONS = dict(cache=True, error_model="numpy", fastmath={"contract", "arcp", "nsz", "reassoc"})


_FOLDER = cache.folder()


def _compiler(**options):
    """Return a decorator like numba.njit(**options) whose cache is in the folder above."""
    def decorate(function):
        # numba reads the setting when it decorates; others in this process keep their own
        before, numba.config.CACHE_DIR = numba.config.CACHE_DIR, _FOLDER
        try:
            return numba.njit(**options)(function)
        finally:
            numba.config.CACHE_DIR = before
    return decorate


kernel = _compiler(**_OPTIONS)

# For what a kernel calls for every particle. A call costs more than a short vector loop, and so
# does counting the references to the arrays that are passed ("_nrt"): without that, functions of
# this kind may read and write arrays, but neither make nor slice them.
inlined = _compiler(forceinline=True, _nrt=False, **_OPTIONS)

# The length of a tuple is part of its type: a loop over range(len(axes)) is unrolled, and
# what stands under `if len(axes) == 3` costs nothing in 2D.
_AXES = {2: (0, 1), 3: (0, 1, 2)}


def axes_of(dim):
    """Return the compile-time axes tuple of a dimension, 2 or 3."""
    return _AXES[dim]
