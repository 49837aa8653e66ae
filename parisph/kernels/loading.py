"""Kernels from the cache, without what numba does at that for those who compile.

Otherwise a run that finds all its kernels compiled spends a third of its start on them. This relies on internals of
numba: `jit` imports it for the releases of `processor.INTERNALS` only.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding as llvm

from parisph.kernels.kept import Kept
from parisph.kernels.processor import numba


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
    """What numba stores of a kernel. Where is decided by Kept."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._lineno = function.__code__.co_firstlineno
        self._locator = self
        self._py_file = function.__code__.co_filename

    def ensure_cache_path(self) -> None:
        """Do nothing: Kept makes its folder."""

    def rebuild(self, target_context: Any, payload: tuple[Any, ...]) -> Any:
        """Return a kernel from what is stored of it, with a _Library."""
        (_, kind, _), described = payload[:2]
        if kind != "object":
            return super().rebuild(target_context, payload)
        with _reading(target_context.codegen(), {described.llvm_func_name, described.llvm_cpython_wrapper_name}):
            return super().rebuild(target_context, payload)


@contextmanager
def _reading(codegen: Any, symbols: set[str]) -> Iterator[None]:
    """Make codegen read stored libraries as a _Library, whose machine code defines these symbols.

    When it does, numba has prepared what a kernel may need besides, such as threads.
    """
    def read(stored: tuple[str, str, tuple[bytes, bytes]]) -> _Library:
        name, _, (machine_code, bitcode) = stored
        library = _Library(codegen, name, machine_code, bitcode)
        codegen._engine._defined_symbols |= symbols
        return library
    codegen.unserialize_library = read
    try:
        yield
    finally:
        del codegen.unserialize_library


class KernelCache(numba.core.caching.FunctionCache):
    """numba's cache of a kernel.

    Before it loads the first, numba makes all types and functions known that kernels may be written with, which takes
    0.2 s. Only those who compile need them, and the compiler does the same. Compiled code needs numba's runtime, which
    counts references to arrays.
    """

    def __init__(self, function: Callable[..., Any], files: Kept) -> None:
        self._name, self._py_func, self._impl, self._cache_file = repr(function), function, _Results(function), files
        self._cache_path = str(files.folders.write)
        self.enable()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel for a signature, or None if it is not in the cache."""
        numba.core.runtime.rtsys.initialize(target_context)
        try:
            return self._load_overload(sig, target_context)
        except Exception:    # whatever is wrong with what was stored, the kernel can be compiled again
            self._cache_file.damaged()
            return None
