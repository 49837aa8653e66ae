"""Folders for compiled kernels."""

import hashlib
import os
import stat
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from parisph.base.environment import cache_folder
from parisph.base.paths import AnyPath

# Files outside this folder whose constants or functions are compiled into kernels.
ELSEWHERE = "base/fields.py", "base/probe_rows.py", "parallel/hilbert.py", "parallel/partition.py"
# Files of this folder that do not affect compiled code.
WITHOUT_CODE = "cache.py", "compiling.py", "kept.py"


@dataclass(frozen=True)
class Folders:
    """Where compiled kernels are.

    Attributes
    ----------
    write : folder for new kernels, or None if none is writable
    read : folders to search, in this order; `write` comes first
    """

    write: Path | None
    read: tuple[Path, ...]

    def first(self, name: str) -> Path | None:
        """Return the path of a file in the first folder that has it, or None. Not collective."""
        return next((path for path in (folder / name for folder in self.read) if path.exists()), None)


def folders(level: int) -> Folders:
    """Return the folders for kernels compiled at an optimisation level. Not collective.

    Folder names contain a digest of this level and of all kernel sources, including ELSEWHERE: numba recompiles a
    cached kernel if its own file changes, but not if a kernel inlined from another file does.

    Candidates are NUMBA_CACHE_DIR if set, the folder beside the sources, the user's cache folder, and a private
    temporary folder (for nodes without home folders). Kernels are written to the first one that is writable. Readable
    ones before it, perhaps another user's, are searched too.
    """
    here = Path(__file__).resolve().parent
    own = (path for path in sorted(here.glob("*.py")) if path.name not in WITHOUT_CODE)
    sources = [*own, *(here.parent / name for name in ELSEWHERE)]
    digest = hashlib.sha256(b"".join([b"%d" % level, *(path.read_bytes() for path in sources)]))
    name = f"kernels-{digest.hexdigest()[:16]}"
    places = [Path(os.environ["NUMBA_CACHE_DIR"])] if os.environ.get("NUMBA_CACHE_DIR") else []
    places.append(here / "__pycache__")
    with suppress(OSError):    # there is no home folder
        places.append(cache_folder())
    others: list[Path] = []
    for folder in (place / name for place in places):
        if _can_be_made(folder):
            return Folders(folder, (folder, *others))
        if os.access(folder, os.R_OK | os.X_OK):
            others.append(folder)
    with suppress(OSError):    # there is no folder for temporary files either
        folder = private_folder() / name
        if _can_be_made(folder):
            return Folders(folder, (folder, *others))
    return Folders(None, tuple(others))


def _can_be_made(path):
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return True
    except OSError:
        return False


def private_folder(base: AnyPath | None = None) -> Path:
    """Return a folder that only this user can write, if possible the same one in every process. Raises OSError.

    Stored code is executed, so a folder that others can write is never used.
    base : parent folder, by default the system's folder for temporary files
    """
    path = Path(base or tempfile.gettempdir()) / f"parisph-kernels-{os.getuid()}"
    path.mkdir(mode=0o700, exist_ok=True)
    found = path.lstat()
    if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022:
        return path
    return Path(tempfile.mkdtemp(prefix="parisph-kernels-", dir=base))
