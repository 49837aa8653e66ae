"""Compilation of kernels, and the compile-time axes that make one source work in 2D and 3D."""

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, TypeVar

from parisph.kernels import cache, compiling, kept, processor
from parisph.kernels.processor import numba

processor.choose_level()
processor.leave_out_avx512()

_F = TypeVar("_F", bound=Callable[..., Any])    # a kernel has the type of the function that it compiles

# Kernels avoid division by zero themselves and need no checks by Python's error model. Without "nnan", NaN stays NaN
# and shows errors. Without wrappers for calls from C, kernels compile faster.
_OPTIONS: dict[str, Any] = dict(
    error_model="numpy", fastmath={"contract", "arcp", "nsz", "reassoc"}, no_cfunc_wrapper=True)


FOLDERS = cache.folders(int(numba.config.OPT))
COMPILATION = compiling.Compilation()
numba.core.event.register("numba:compile", COMPILATION)


def _compiler(cached: bool = False, **options: Any) -> Callable[[_F], _F]:
    """Return a decorator like numba.njit(**options), with the cache in parisph's folders."""
    def decorate(function: _F) -> _F:
        made = numba.njit(**options)(function)
        if cached and not numba.config.DISABLE_JIT:
            made._cache = kept.Kept(function, FOLDERS)
        return made
    return decorate


kernel = _compiler(cached=True, **_OPTIONS)


class Subkernel:
    """A function that kernels call; numba compiles it as a part of each of them.

    It is not cached: its callers are, and loading it would take longer than it saves. A call from Python, as in tests,
    compiles it once more with a wrapper for Python's arrays.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self.py_func, self.options = function, options
        update_wrapper(self, function)

    @cached_property
    def within(self) -> Any:
        """numba's dispatcher for calls from kernels only."""
        return _compiler(no_cpython_wrapper=True, **self.options)(self.py_func)

    @cached_property
    def alone(self) -> Any:
        """numba's dispatcher for calls from Python."""
        return _compiler(**self.options)(self.py_func)

    @property
    def _numba_type_(self) -> Any:    # numba reads the type of a global here
        return self.within._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        return self.alone(*arguments)


def _subkernel_compiler(**options: Any) -> Callable[[Callable[..., Any]], Subkernel]:
    """Return a decorator for functions that only kernels call."""
    return lambda function: Subkernel(function, options)


subkernel = _subkernel_compiler(**_OPTIONS)

# For functions that a kernel calls for every particle. A call, or counting references to its arrays, costs more than a
# short vector loop. Without reference counts ("_nrt") these functions can read and write arrays, but not make or slice
# them.
inlined = _subkernel_compiler(forceinline=True, _nrt=False, **_OPTIONS)

# For scripts: a cache stores the module's name, and a script that others import has two.
uncached = _compiler(**_OPTIONS)

# The length of a tuple is part of its type: loops over range(len(axes)) are unrolled, and `if len(axes) == 3` costs
# nothing in 2D.
_AXES = {2: (0, 1), 3: (0, 1, 2)}


def axes_of(dim: int) -> tuple[int, ...]:
    """Return the compile-time tuple of axes for a dimension, 2 or 3."""
    return _AXES[dim]
