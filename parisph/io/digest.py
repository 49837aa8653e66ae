"""Digests: a line at the end of an HDF5 file that shows any change to the file.

HDF5 trusts the bytes that it reads: a few damaged ones may make HDF5 1.10 loop forever, end the process, or be read as
data. So every file is checked against its digest before HDF5 opens it. The digest is a line of text of fixed length,
after the last byte that HDF5 uses; other readers ignore it:

    parisph digest 1 <bytes before the line> <SHA-256>

It is computed from the length and from the digests of all chunks of the file. So the ranks can share the work, and the
digest does not depend on their number.

Runs of 21 November 2026, before 21:57, have no identity, and files without a digest. `early` opens these unchecked.
"""

import hashlib
import os
import re
import stat
from collections.abc import Sequence
from pathlib import Path

from parisph.base.communicator import Communicator
from parisph.base.errors import StoreError
from parisph.io.files import on_first, together

VERSION = 1
CHUNK = 1 << 20   # bytes
PATTERN = re.compile(rb"\nparisph digest (\d) \d{20} [0-9a-f]{64}\n")
LENGTH = len(b"\nparisph digest 1 ") + 20 + 1 + 64 + 1


def append(comm: Communicator, path: Path, doing: str | None = None) -> None:
    """Append the digest to a file, which is closed on every rank. Collective. Raises StoreError on every rank.

    doing : the action to name in an error, by default "write PATH"
    """
    doing = doing or f"write {path}"
    length = comm.bcast(on_first(comm, doing, lambda: Path(path).stat().st_size))
    line = _line_of_all(comm, path, length, doing)

    def write() -> None:
        with open(path, "ab") as file:
            file.write(line)
    on_first(comm, doing, write)


def check(path: Path, early: bool = False) -> None:
    """Raise StoreError unless every byte of a file is as parisph wrote it. Not collective.

    early : whether the run may have files without a digest, which are not checked
    """
    length, line = _ending(path, early)
    if not line:
        return
    try:
        digests = _chunks(path, length)
    except OSError as error:
        raise StoreError(f"cannot read {path}: {error}") from None
    _compare(path, line, _line(length, digests))


def check_together(comm: Communicator, path: Path, early: bool = False) -> None:
    """Do `check` with the work shared by the ranks; raises StoreError on every rank. Collective."""
    length, line = 0, b""
    problem: str | None = None
    if comm.rank == 0:
        try:
            length, line = _ending(path, early)
        except StoreError as error:
            problem = str(error)
    length, line, problem = comm.bcast((length, line, problem))
    if problem:
        raise StoreError(problem)
    if not line:
        return
    _compare(path, line, _line_of_all(comm, path, length, f"read {path}"))


def _line_of_all(comm: Communicator, path: Path, length: int, doing: str) -> bytes:
    """Return the digest line for the first `length` bytes of a file, on every rank. Collective."""
    own = together(comm, doing, lambda: _chunks(path, length, comm.rank, comm.size))
    shares = comm.allgather(own)
    count = sum(len(share) for share in shares)
    return _line(length, [shares[number % comm.size][number // comm.size] for number in range(count)])


def _chunks(path: Path, length: int, rank: int = 0, size: int = 1) -> list[bytes]:
    """Return the digests of chunks rank, rank + size, ... of the first `length` bytes of a file. Raises OSError."""
    numbers = range(rank, -(-length // CHUNK), size)
    if not numbers:
        return []
    # one buffer for all chunks: a new one for each takes 1.5 times as long
    found, buffer = [], memoryview(bytearray(CHUNK))
    with open(path, "rb") as file:
        for number in numbers:
            file.seek(number * CHUNK)
            count = file.readinto(buffer[:min(CHUNK, length - number * CHUNK)])
            found.append(hashlib.sha256(buffer[:count]).digest())
    return found


def _line(length: int, digests: Sequence[bytes]) -> bytes:
    digest = hashlib.sha256(b"%d " % length + b"".join(digests)).hexdigest()
    return b"\nparisph digest %d %020d %s\n" % (VERSION, length, digest.encode())


def _ending(path: Path, early: bool) -> tuple[int, bytes]:
    """Return (number of bytes before the digest line, the line) of a file.

    Raises StoreError if it has no such line; the line is empty then for an early run.
    """
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):    # a pipe would block
            raise StoreError(f"{path} is not a file")
        length = max(0, status.st_size - LENGTH)
        with open(path, "rb") as file:
            file.seek(length)
            line = file.read(LENGTH + 1)
    except FileNotFoundError:
        raise StoreError(f"there is no file {path}") from None
    except OSError as error:
        raise StoreError(f"cannot read {path}: {error}") from None
    found = PATTERN.fullmatch(line)
    if found is None and early:
        return length, b""
    if found is None:
        raise StoreError(f"{path} is not a whole file of parisph: it has no digest at its end. It was cut short or "
                         "changed, or written by an older parisph")
    if int(found[1]) != VERSION:
        raise StoreError(f"{path} has a digest of version {int(found[1])}, this parisph knows {VERSION}: "
                         "it is damaged, or was written by a newer parisph")
    return length, line


def _compare(path: Path, found: bytes, expected: bytes) -> None:
    if found != expected:
        raise StoreError(f"{path} is damaged: its content does not match the digest at its end")
