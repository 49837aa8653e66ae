"""Write files so that neither a crash nor a full disk can damage a run.

A file is written under a temporary name, forced to the disk and then renamed: readers see either the old content or the
new one, never a part. An error on one rank is raised on all.
"""

import hashlib
import json
import math
import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar, cast

from parisph.base.communicator import Communicator
from parisph.base.errors import StoreError, agree
from parisph.base.json_digest import KEY, with_digest, without_digest
from parisph.base.paths import AnyPath
from parisph.base.reading import check_regular

Result = TypeVar("Result")

def together(comm: Communicator, doing: str, action: Callable[[], Result]) -> Result:
    """Run `action()` on this rank and return its result. Collective.

    Raises StoreError on every rank if the disk or HDF5 failed on any: "cannot <doing>: <cause>". Any other exception is
    also raised on all ranks (errors.agree), so that no rank waits forever.
    """
    result: Result | None = None
    problem: Exception | None = None
    try:
        result = action()
    except (OSError, RuntimeError) as error:  # h5py reports a failed close as a RuntimeError
        problem = StoreError(f"cannot {doing}: {error}")
        problem.__cause__ = error
    except Exception as error:
        problem = error
    agree(comm, problem)
    return cast(Result, result)


def on_first(comm: Communicator, doing: str, action: Callable[[], Result]) -> Result | None:
    """Run `action()` on rank 0 and return its result there, None elsewhere. Collective; raises as `together`."""
    return together(comm, doing, action if comm.rank == 0 else lambda: None)


def temporary(path: Path) -> Path:
    """Return the temporary name for `path`: hidden, in the same folder."""
    return path.with_name(f".{path.name}.tmp")


def create(path: Path) -> int:
    """Make a new, empty file and return its descriptor for writing. One rank. Raises OSError.

    An existing file of this name is removed first; a symbolic link is never followed.
    """
    path.unlink(missing_ok=True)
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666)


def publish(path: Path) -> None:
    """Force the temporary file of `path` to the disk and rename it to `path`. One rank. Raises OSError."""
    _sync(temporary(path))
    os.replace(temporary(path), path)
    _sync(path.parent)  # the new name itself must survive a power cut


@contextmanager
def replacing(path: AnyPath) -> Iterator[Path]:
    """Context with the name of a new file of the same ending, which replaces `path` at the end. One process.

    A symbolic link is replaced, never followed. If the block fails, `path` is unchanged and the new file is removed.
    Raises OSError: a file cannot be made there, or `path` is a folder, a pipe or a device.
    """
    path = Path(path)
    if path.exists() and not path.is_symlink():
        check_regular(os.stat(path))
    new = path.with_name(f".{path.stem[:80]}.{os.urandom(4).hex()}.tmp{path.suffix}")
    try:
        os.close(create(new))
        yield new
        _sync(new)
        os.replace(new, path)
    except BaseException:
        with suppress(OSError):    # the first cause is the one to report
            new.unlink(missing_ok=True)
        raise


def rewrite(path: Path, text: str) -> None:
    """Replace the text of a file of the user atomically, without a change of line ends. One process.

    The file keeps its mode, and its owner if that is allowed. Raises OSError; the file is then unchanged.
    """
    status = os.stat(path)
    with replacing(path) as new:
        with open(new, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        with suppress(OSError):
            os.chown(new, status.st_uid, status.st_gid)
        os.chmod(new, stat.S_IMODE(status.st_mode))


@contextmanager
def failing_as(doing: str) -> Iterator[None]:
    """Raise StoreError "cannot <doing>: <cause>" for an OSError inside. One process."""
    try:
        yield
    except OSError as error:
        raise StoreError(f"cannot {doing}: {error.strerror or error}") from None


def write_text(path: Path, text: str) -> None:
    """Replace the content of `path` by `text` atomically. One rank. Raises OSError, and then leaves no other file."""
    try:
        with open(create(temporary(path)), "w", encoding="utf-8") as file:
            file.write(text)
        publish(path)
    except OSError:
        with suppress(OSError):    # the first cause is the one to report
            temporary(path).unlink(missing_ok=True)
        raise


def write_json(path: Path, content: Any) -> None:
    """Replace the content of `path` by standard JSON with a digest (numpy scalars become numbers, NaN null)."""
    write_text(path, json.dumps(with_digest(plain(content)), indent=2) + "\n")


def read_json(path: Path, needs_digest: bool = False) -> dict[str, Any]:
    """Return the JSON object in a file of a run after a check of its digest. Not collective. Raises StoreError.

    needs_digest : whether a file without a digest is refused, because users may not edit it
    """
    try:
        check_regular(os.stat(path))
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise StoreError(f"there is no {path}") from None
    except OSError as error:
        raise StoreError(f"cannot read {path}: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{path} is damaged: it is not JSON ({str(error)[:80]})") from None
    if not isinstance(content, dict):
        raise StoreError(f"{path} is damaged: it contains a {type(content).__name__}, not an object")
    if needs_digest and content.get(KEY) is None:
        raise StoreError(f"{path} is damaged: it has no digest. Move it away to read the rest of the run")
    content, sound = without_digest(content)
    if not sound:
        raise StoreError(f"{path} is damaged: it does not match its digest" + (
            f', or it was edited: then remove the line "{KEY}"' if Path(path).name == "case.json" else ""))
    return content


def digest(path: Path) -> str:
    """Return the digest of a whole file. Not collective. Raises OSError."""
    found = hashlib.blake2b(digest_size=16)
    with open(path, "rb") as file:
        while piece := file.read(1 << 20):
            found.update(piece)
    return found.hexdigest()


def plain(content: Any) -> Any:
    """Return `content` made of dict, list, str, int, float, bool and None only; NaN and infinity become None."""
    if isinstance(content, dict):
        return {str(key): plain(value) for key, value in content.items()}
    if hasattr(content, "tolist"):  # numpy arrays and scalars
        content = content.tolist()
    if isinstance(content, (list, tuple)):
        return [plain(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
