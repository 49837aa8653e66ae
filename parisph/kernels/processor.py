"""Which instructions of the processor kernels may use."""

import llvmlite.binding as llvm
import numba


def leave_out_avx512():
    """Have numba compile without AVX-512 in this process, unless NUMBA_CPU_FEATURES says otherwise.

    The compiler in numba 0.62 to 0.68 (LLVM 20 to 22) saves the masks of AVX-512 with bits of other
    lanes in them when it runs out of mask registers, so that a store under a condition changes
    values for which the condition does not hold. Kernels are no slower without: they gather.
    Without effect on code that was compiled before.
    """
    if numba.config.CPU_FEATURES is None:
        features = llvm.get_host_cpu_features()
        if any(_wide(name) for name, there in features.items() if there):
            numba.config.CPU_FEATURES = ",".join(
                f"{'+' if there and not _wide(name) else '-'}{name}" for name, there in features.items())


def _wide(feature):
    return feature.startswith(("avx512", "avx10"))
