"""The folder for compiled kernels."""

import hashlib
import os
import stat
import tempfile
from pathlib import Path

from parisph.base.environment import cache_folder
from parisph.base.paths import AnyPath

# Files besides those of this folder with constants or functions that kernels of other files contain.
ELSEWHERE = "base/fields.py", "parallel/hilbert.py", "parallel/partition.py"


def folder(level: int) -> str:
    """Return the folder for kernels compiled at a level of the optimiser. Its name contains a digest of this level and
    of the kernels' sources, also of those in ELSEWHERE. Not collective.

    numba recompiles a cached kernel when its own file changes, but not when a kernel that it has
    inlined changes in another file. The digest makes sure that stale code is never loaded. The
    folder is in NUMBA_CACHE_DIR if that is set, else beside the sources, else in the user's cache
    folder, else (on a node without home folders) in a private temporary folder.
    """
    here = Path(__file__).resolve().parent
    sources = [*sorted(here.glob("*.py")), *(here.parent / name for name in ELSEWHERE)]
    digest = hashlib.sha256(b"".join([b"%d" % level, *(path.read_bytes() for path in sources)]))
    name = f"kernels-{digest.hexdigest()[:16]}"
    places = [Path(os.environ["NUMBA_CACHE_DIR"])] if os.environ.get("NUMBA_CACHE_DIR") else []
    for place in [*places, here / "__pycache__", cache_folder()]:
        if _can_be_made(place / name):
            return str(place / name)
    return str(private_folder() / name)


def _can_be_made(path):
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return True
    except OSError:
        return False


def private_folder(base: AnyPath | None = None) -> Path:
    """Return a folder that only this user can write, the same one in every process if possible.

    base : folder to make it in, by default the system's folder for temporary files. numba runs the
    code that it finds in its cache, so a folder that others can write is never used.
    """
    path = Path(base or tempfile.gettempdir()) / f"parisph-kernels-{os.getuid()}"
    path.mkdir(mode=0o700, exist_ok=True)
    found = path.lstat()
    if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022:
        return path
    return Path(tempfile.mkdtemp(prefix="parisph-kernels-", dir=base))
