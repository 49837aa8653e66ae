"""Compilation of kernels, and the compile-time axes that make one source work in 2D and 3D."""

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, TypeVar

from parisph.kernels import cache, compiling, kept, processor
from parisph.kernels.processor import numba

processor.choose_level()
processor.leave_out_avx512()

_F = TypeVar("_F", bound=Callable[..., Any])    # kernels are typed as the functions that they compile

# Kernels avoid division by zero themselves, so the checks of Python's error model are not needed.
# NaN must stay NaN, because that is how errors are found: no "nnan".
# Nothing calls kernels from C: without wrappers for that they compile faster.
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
    """A function that kernels call; numba translates it when a kernel is compiled that does.

    It is not cached: the kernels that it is a part of are, and to load it would take longer than it saves. If Python
    calls it, as tests do, it is compiled once more, with what takes Python's arrays apart.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self.py_func, self.options = function, options
        update_wrapper(self, function)

    @cached_property
    def within(self) -> Any:
        """numba's own object for it, of which nothing but kernels can make use."""
        return _compiler(no_cpython_wrapper=True, **self.options)(self.py_func)

    @cached_property
    def alone(self) -> Any:
        """numba's own object for calls from Python."""
        return _compiler(**self.options)(self.py_func)

    @property
    def _numba_type_(self) -> Any:    # where numba looks for what a global name stands for
        return self.within._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        return self.alone(*arguments)


def _subkernel_compiler(**options: Any) -> Callable[[Callable[..., Any]], Subkernel]:
    """Return a decorator for functions that only kernels call."""
    return lambda function: Subkernel(function, options)


subkernel = _subkernel_compiler(**_OPTIONS)

# For functions that a kernel calls for every particle. A call costs more than a short vector loop,
# and so does counting references to the arrays that are passed. Without reference counts ("_nrt")
# these functions may read and write arrays, but neither make nor slice them.
inlined = _subkernel_compiler(forceinline=True, _nrt=False, **_OPTIONS)

# For scripts: a cache would keep the name of the module, of which a script that others import has two.
uncached = _compiler(**_OPTIONS)

# The length of a tuple is part of its type: a loop over range(len(axes)) is unrolled, and code
# under `if len(axes) == 3` costs nothing in 2D.
_AXES = {2: (0, 1), 3: (0, 1, 2)}


def axes_of(dim: int) -> tuple[int, ...]:
    """Return the compile-time tuple of axes for a dimension, 2 or 3."""
    return _AXES[dim]
