"""Kernels from the cache, without what numba does at that for those who compile.

Otherwise a run that finds all its kernels compiled spends a third of its start on them. This relies on internals of
numba, which are known for some releases; others load kernels in numba's own way.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding as llvm

from parisph.kernels.processor import numba

KNOWN = ((0, 61), (0, 68))    # first and last release
_known = KNOWN[0] <= numba.version_info[:2] <= KNOWN[1]


class _Library(numba.core.codegen.JITCodeLibrary):
    """Machine code of a kernel. Its intermediate code is read if another kernel is compiled that calls it."""

    def __init__(self, codegen: Any, name: str, machine_code: bytes, bitcode: bytes) -> None:
        self._bitcode, self._read = bitcode, None
        super().__init__(codegen, name)
        self.enable_object_caching()
        self._set_compiled_object(machine_code)
        self._finalize_final_module()

    @property
    def _shared_module(self):
        if self._read is None and self._bitcode:
            self._read, self._bitcode = llvm.parse_bitcode(self._bitcode), b""
            self._codegen._engine._load_defined_symbols(self._read)
        return self._read

    @_shared_module.setter
    def _shared_module(self, module):    # numba sets it to None at first
        self._read = module


class _Results(numba.core.caching.CompileResultCacheImpl):
    """What numba stores of a kernel."""

    def rebuild(self, target_context: Any, payload: tuple[Any, ...]) -> Any:
        """Return a kernel from what is stored of it, with a _Library."""
        (name, kind, code), described = payload[:2]
        if kind != "object" or not _known:
            return super().rebuild(target_context, payload)
        codegen = target_context.codegen()
        library = _Library(codegen, name, *code)
        codegen._engine._defined_symbols |= {described.llvm_func_name, described.llvm_cpython_wrapper_name}
        with _reading(codegen, library):
            return super().rebuild(target_context, payload)


@contextmanager
def _reading(codegen: Any, library: _Library) -> Iterator[None]:
    """Make codegen return this library, whatever it is asked to read."""
    codegen.unserialize_library = lambda stored: library
    try:
        yield
    finally:
        del codegen.unserialize_library


class KernelCache(numba.core.caching.FunctionCache):
    """numba's cache of a kernel.

    Before it loads the first, numba makes all types and functions known that kernels may be written with, which takes
    0.2 s. Only those who compile need them, and the compiler does the same. Machine code needs what counts references.
    """

    _impl_class = _Results

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel for a signature, or None if it is not in the cache."""
        if not _known:
            return super().load_overload(sig, target_context)
        numba.core.runtime.rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)
