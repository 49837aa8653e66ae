"""numba, without configuration files of the current folder, and how it may translate kernels."""

import os
import sys
import warnings

with warnings.catch_warnings(record=True) as _said:
    warnings.simplefilter("always")
    import llvmlite.binding as llvm

    from parisph.base import libraries, surroundings

    _first = "numba" not in sys.modules

    with libraries.unconfigured("numba"):
        import numba as numba  # for the other modules

for _warning in _said:    # numba shows a traceback and goes on where it cannot read a variable
    _fault = surroundings.unread_number(str(_warning.message))
    if _fault is not None:
        raise _fault
    warnings.warn_explicit(_warning.message, _warning.category, _warning.filename, _warning.lineno)

if _first:    # it looks again before each compilation; a program that has loaded numba itself keeps what it has
    numba.config._config_fname = os.devnull

# Kernels are as fast as at numba's own level, 3, and compiled in a tenth less time. At 1 they are compiled in another
# tenth less, and take an eighth longer.
LEVEL = 2


def choose_level() -> None:
    """Make numba's optimiser work at LEVEL in this process, unless NUMBA_OPT is set."""
    if "NUMBA_OPT" not in os.environ:
        numba.config.OPT = type(numba.config.OPT)(LEVEL)


def leave_out_avx512() -> None:
    """Make numba compile without AVX-512 in this process, unless NUMBA_CPU_FEATURES is set.

    The compiler in numba 0.62 to 0.68 (LLVM 20 to 22) stores wrong AVX-512 masks when it runs out of
    mask registers: a conditional store then changes values for which the condition does not hold.
    Kernels are as fast without AVX-512, because they mostly gather. Code that was compiled before
    is not affected.
    """
    if numba.config.CPU_FEATURES is None:
        features = llvm.get_host_cpu_features()
        if any(_wide(name) for name, there in features.items() if there):
            numba.config.CPU_FEATURES = ",".join(
                f"{'+' if there and not _wide(name) else '-'}{name}" for name, there in features.items())


def identity() -> tuple[str, str, str]:
    """Return what else compiled kernels depend on: the release of numba, the processor, and its features in use."""
    features = numba.config.CPU_FEATURES
    return numba.__version__, llvm.get_host_cpu_name(), features or llvm.get_host_cpu_features().flatten()


def _wide(feature):
    return feature.startswith(("avx512", "avx10"))
