"""Compiled kernels on disk: a file for each signature of a kernel, with a digest.

numba keeps an index of signatures for each kernel and trusts its files. A damaged file therefore stops every later run,
and two processes that fill one cache may exchange the code of two signatures. Here the name of a file identifies its
content, and files are complete: each is written under a temporary name first.
"""

import glob
import hashlib
import inspect
import os
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

from parisph.base import environment
from parisph.base.log import logger
from parisph.kernels.cache import Folders
from parisph.kernels.processor import numba

ENDING = ".kernel"
_DIGEST = hashlib.sha256().digest_size
_PACKAGE = Path(__file__).resolve().parent.parent


class Kept(numba.core.caching.FunctionCache):
    """numba's cache of one kernel, in these files. It uses numba's `_index_key` and serialisation of compiled code.

    function : the Python function of the kernel
    folders : of its files
    """

    _told: ClassVar[set[str]] = set()    # warnings given once in a process

    def __init__(self, function: Callable[..., Any], folders: Folders) -> None:    # numba's __init__ makes a folder
        self._py_func, self._cache_path = function, str(folders.write)
        file = Path(inspect.getfile(function)).resolve()
        inside = file.is_relative_to(_PACKAGE)
        self.folders = folders
        self._place = "" if inside else f"outside-{hashlib.sha256(os.fsencode(file)).hexdigest()[:16]}"
        name = f"{file.stem}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._name = f"{name[:120]}-{function.__code__.co_firstlineno}"
        self._stamp = hashlib.sha256(file.read_bytes()).hexdigest()[:8] if file.is_file() else None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel for a signature, or None if it must be compiled."""
        # numba also loads parts for the compiler alone, which takes 0.05 s
        numba.core.runtime.rtsys.initialize(target_context)
        try:
            stored = self.load(self._index_key(sig, target_context.codegen()))
            return stored and numba.core.compiler.CompileResult._rebuild(target_context, *stored)
        except Exception:    # the kernel can be compiled again
            self.damaged()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write a compiled kernel unless it contains an address of this process."""
        if not data.library.has_dynamic_globals:
            self.save(self._index_key(sig, data.codegen), data._reduce())

    def load(self, key: Any) -> Any:
        """Return the object saved under a key, or None if it is missing or damaged (with a warning)."""
        name = self._file_of(key)
        if name is None:
            return None
        for folder in self.folders.read:
            with suppress(OSError):
                path = folder / self._place / name
                content = opened(path.name, path.read_bytes())
                if content is not None:
                    with suppress(Exception):    # another release of a library wrote it
                        found = pickle.loads(content)
                        _debug("loaded from", path)
                        return found
                self.damaged(path)
        return None

    def damaged(self, path: Path | None = None) -> None:
        """Warn once, on the first rank, that a file is damaged."""
        where = path or f"{self._name} in {self.folders.write}"
        self._tell("damaged", f"a compiled kernel in the cache is damaged ({where}): it is compiled again")

    def save(self, key: Any, data: Any) -> None:
        """Write an object for load(key), or warn if that is impossible."""
        name = self._file_of(key)
        if name is None:
            return
        if self.folders.write is None:
            self._tell("nowhere", "no folder for compiled kernels is writable, so every run compiles them again: "
                                  "set NUMBA_CACHE_DIR to a folder that you can write")
            return
        path = self.folders.write / self._place / name
        new = path.with_name(f".{os.getpid()}-{os.urandom(4).hex()}.tmp")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            new.write_bytes(sealed(name, numba.core.serialize.dumps(data)))
            os.replace(new, path)
            for old in path.parent.glob(f"{glob.escape(self._name)}.*{ENDING}"):
                if not old.name.startswith(f"{self._name}.{self._stamp}."):    # of an older source
                    old.unlink(missing_ok=True)
        except OSError as error:
            with suppress(OSError):
                new.unlink(missing_ok=True)
            self._tell("full", f"compiled kernels cannot be kept in {self.folders.write} ({error.strerror}), and every "
                               "run compiles them again: free some space there, or set NUMBA_CACHE_DIR to another "
                               "folder")
            return
        _debug("saved to", path)

    def flush(self) -> None:
        """Delete all files of the kernel."""
        for folder in self.folders.read:
            for path in (folder / self._place).glob(f"{glob.escape(self._name)}.*{ENDING}"):
                path.unlink(missing_ok=True)

    def _file_of(self, key):
        """Return the name of the file for a key, or None if another process could not recognise the kernel."""
        text = repr((numba.__version__, sys.version_info[:2], getattr(sys, "abiflags", ""), key))
        if self._stamp is None or " at 0x" in text:
            return None
        return f"{self._name}.{self._stamp}.{hashlib.sha256(text.encode()).hexdigest()[:24]}{ENDING}"

    def _tell(self, what, text):
        if what not in self._told and environment.is_first():
            logger.warning(text)
        self._told.add(what)


def _debug(what, path):
    """Print a line of numba's cache, for NUMBA_DEBUG_CACHE."""
    if numba.config.DEBUG_CACHE:
        print(f"[cache] data {what} {str(path)!r}")


def sealed(name: str, content: bytes) -> bytes:
    """Return the content of a file of this name, preceded by a digest."""
    return hashlib.sha256(name.encode() + b"\0" + content).digest() + content


def opened(name: str, content: bytes) -> bytes | None:
    """Return the content given to `sealed`, or None if the name or the digest does not match."""
    return content[_DIGEST:] if sealed(name, content[_DIGEST:]) == content else None


def state(folders: Folders) -> dict[str, Any]:
    """Return the "kernels" (number of sound ones), their "bytes", the "damaged" files, and the folders to "write" and
    "read".

    Not collective.
    """
    seen: set[str] = set()
    damaged: list[str] = []
    size = 0
    for folder in folders.read:
        for path in sorted(folder.rglob(f"*{ENDING}")):
            name = str(path.relative_to(folder))
            with suppress(OSError):
                if name in seen:
                    continue
                content = path.read_bytes()
                if opened(path.name, content) is None:
                    damaged.append(str(path))
                else:
                    seen.add(name)
                    size += len(content)
    return {"kernels": len(seen), "bytes": size, "damaged": damaged,
            "write": None if folders.write is None else str(folders.write), "read": list(map(str, folders.read))}
