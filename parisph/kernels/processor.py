"""numba without configuration files of the current folder, and its compiler options."""

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

for _warning in _said:    # numba only warns, with a traceback, of a variable that it cannot read
    _fault = surroundings.unread_number(str(_warning.message))
    if _fault is not None:
        raise _fault
    warnings.warn_explicit(_warning.message, _warning.category, _warning.filename, _warning.lineno)

if _first:    # numba reads the file before each compilation; a program that loaded numba keeps its own settings
    numba.config._config_fname = os.devnull

# Kernels are as fast as with numba's default, 3, and compile in a tenth less time. With 1 they compile in another tenth
# less, and take an eighth longer.
LEVEL = 2


def choose_level() -> None:
    """Set numba's optimisation level to LEVEL in this process, unless NUMBA_OPT is set."""
    if "NUMBA_OPT" not in os.environ:
        numba.config.OPT = type(numba.config.OPT)(LEVEL)


def leave_out_avx512() -> None:
    """Make numba compile without AVX-512 in this process, unless NUMBA_CPU_FEATURES is set.

    The compiler in numba 0.62 to 0.68 (LLVM 20 to 22) stores wrong AVX-512 masks when mask registers run out: a
    conditional store then changes values that do not meet the condition. Kernels mostly gather, and are as fast without
    AVX-512. Code compiled before is not affected.
    """
    if numba.config.CPU_FEATURES is None:
        features = llvm.get_host_cpu_features()
        if any(_wide(name) for name, there in features.items() if there):
            numba.config.CPU_FEATURES = ",".join(
                f"{'+' if there and not _wide(name) else '-'}{name}" for name, there in features.items())


def identity() -> tuple[str, str, str]:
    """Return what compiled kernels depend on besides source: numba's release, the processor, and its features in use.
    """
    features = numba.config.CPU_FEATURES
    return numba.__version__, llvm.get_host_cpu_name(), features or llvm.get_host_cpu_features().flatten()


def _wide(feature):
    return feature.startswith(("avx512", "avx10"))
