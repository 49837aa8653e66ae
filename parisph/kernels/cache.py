"""The folders for compiled kernels."""

import hashlib
import os
import stat
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from parisph.base.environment import cache_folder
from parisph.base.paths import AnyPath

# Files besides those of this folder with constants or functions that kernels of other files contain.
ELSEWHERE = "base/fields.py", "base/probe_rows.py", "parallel/hilbert.py", "parallel/partition.py"
# Files of this folder on which compiled code does not depend.
WITHOUT_CODE = "cache.py", "compiling.py", "kept.py"


@dataclass(frozen=True)
class Folders:
    """Where compiled kernels are.

    Attributes
    ----------
    write : folder that new ones are written to; None if none can be written
    read : folders in which they are looked for, in this order; `write` is the first of them
    """

    write: Path | None
    read: tuple[Path, ...]

    def first(self, name: str) -> Path | None:
        """Return the path of a file in the first folder that has it, or None. Not collective."""
        return next((path for path in (folder / name for folder in self.read) if path.exists()), None)


def folders(level: int) -> Folders:
    """Return the folders for kernels compiled at a level of the optimiser. Not collective.

    Their name contains a digest of this level and of the kernels' sources, also of those in ELSEWHERE. numba
    recompiles a cached kernel when its own file changes, but not when a kernel that it has inlined changes in another
    file. The digest makes sure that stale code is never loaded.

    Kernels are written to NUMBA_CACHE_DIR if that is set, else beside the sources, else to the user's cache folder,
    else (on a node without home folders) to a private temporary folder. Of these the first that can be written is
    used, and those before it are read, which may be another user's.
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
    """Return a folder that only this user can write, the same one in every process if possible.

    base : folder to make it in, by default the system's folder for temporary files. Compiled code that is found is
    run, so a folder that others can write is never used. Raises OSError.
    """
    path = Path(base or tempfile.gettempdir()) / f"parisph-kernels-{os.getuid()}"
    path.mkdir(mode=0o700, exist_ok=True)
    found = path.lstat()
    if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022:
        return path
    return Path(tempfile.mkdtemp(prefix="parisph-kernels-", dir=base))
