"""One process at a time writes into the folder of a run.

The file `run.lock` names it: host, process and start. It is made with O_EXCL, which is atomic on local disks and on NFS
since version 3. Its time is renewed while the run goes on. A killed process leaves its lock behind. On the same host
this is detected, and the lock is taken over. From another host or container it cannot be detected: the user decides.

Processes of one host look at the lock one after the other (`_alone`). Otherwise one could take over a stale lock while
another removes it, and both would have the folder.
"""

import fcntl
import json
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeAlias

from parisph.base.errors import StoreError
from parisph.io.files import create

NAME = "run.lock"
BEAT = 10.0    # [s] between renewals

Found: TypeAlias = dict[str, Any]    # content of a lock


class Lock:
    """The right to write into a folder. One rank only.

    folder : existing folder of the run
    force : whether to take over the lock of a process if it is unknown whether that runs

    Raises StoreError : another process writes into the folder; the message names it, with a remedy
    OSError : the folder cannot be written
    """

    def __init__(self, folder: Path, force: bool = False) -> None:
        self.path = Path(folder) / NAME
        self._mine = {"host": _host(), "processes": _numbering(), "process": os.getpid(), "began": _began(os.getpid()),
                      "since": time.strftime("%Y-%m-%d %H:%M:%S"), "token": os.urandom(8).hex()}
        self._beaten = time.monotonic()
        with _alone(self.path.parent):
            for _ in range(3):    # two processes of different hosts may find the same stale lock at once
                if self._take():
                    return
                self._clear(force)
        raise StoreError(f"another process is starting in {folder} at this moment: wait for it to end")

    def check(self) -> None:
        """Renew the lock every BEAT. Raises StoreError if it has been removed or taken over."""
        if time.monotonic() - self._beaten < BEAT:
            return
        self._beaten = time.monotonic()
        found = _read(self.path)
        if found is None:
            raise StoreError(f"{self.path} is missing: somebody has removed or moved the folder of this run while it "
                             "was running")
        if found.get("token") != self._mine["token"]:
            raise StoreError(f"{self.path} is of {_words(found)} now: it was taken from this process with --force")
        with suppress(OSError):
            os.utime(self.path)

    def release(self) -> None:
        """Remove the lock if this process still has it. Raises nothing."""
        with suppress(OSError, StoreError):
            if (_read(self.path) or {}).get("token") == self._mine["token"]:
                self.path.unlink()

    def _take(self) -> bool:
        try:
            handle = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o644)
        except FileExistsError:
            return False
        try:
            with open(handle, "w", encoding="utf-8") as file:
                json.dump(self._mine, file)
        except OSError:
            with suppress(OSError):    # the first cause is the one to report
                self.path.unlink()
            raise
        return True

    def _clear(self, force: bool) -> None:
        """Remove a lock whose process has ended, with `force` also if that is unknown. Raises StoreError otherwise."""
        found = _read(self.path)
        if found is None:
            return
        alive = _alive(found)
        if alive or (alive is None and not force):
            raise StoreError(self._refusal(found, alive))
        # Move it before reading it again, so that only one of two processes removes it.
        aside = self.path.with_name(f".{NAME}.{self._mine['token']}")
        with suppress(FileNotFoundError):
            os.rename(self.path, aside)
            if (_read(aside) or {}).get("token") != found.get("token"):    # another process was faster
                with suppress(FileExistsError):
                    os.link(aside, self.path)
            aside.unlink()

    def _refusal(self, found: Found, alive: bool | None) -> str:
        folder = self.path.parent
        if alive:
            return f"{folder} is in use by {_words(found)}, which still runs: wait for it to end, or stop it"
        here = socket.gethostname()
        if str(found.get("host")).partition(" ")[0] == here:
            here += ", in another container"
        return (f"{folder} is in use by {_words(found)}. Its last sign of life was {self._silence()} ago, "
                f"and whether it still runs cannot be seen from here ({here}). If it does not, "
                "repeat the command with --force")

    def _silence(self) -> str:
        """Return the time since the lock was renewed as text, by the clock of its file system."""
        probe = self.path.with_name(f".{NAME}.{self._mine['token']}")
        try:
            os.close(create(probe))
            seconds = probe.stat().st_mtime - self.path.stat().st_mtime
            probe.unlink()
        except OSError:
            return "an unknown time"
        return f"{max(seconds, 0.0):.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Wait until no other process of this host is here with the same folder. The system lets go when a process ends."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with suppress(OSError):    # some network file systems cannot lock folders
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _read(path: Path) -> Found | None:
    """Return the content of a lock file, {} if it is not valid, None if there is none."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)    # a pipe would block
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StoreError(f"cannot read {path}: {error.strerror}") from None
    with open(handle, encoding="utf-8", errors="replace") as file:
        text = file.read(10_000)
    try:
        content = json.loads(text)
    except ValueError:
        return {}
    return content if isinstance(content, dict) else {}


def _alive(found: Found) -> bool | None:
    """Return whether the process of a lock runs: True, False, or None if this host cannot tell."""
    name, _, boot = str(found.get("host")).partition(" ")
    here, _, booted = _host().partition(" ")
    if name != here or not isinstance(found.get("process"), int):
        return None
    if boot != booted:
        return False    # the host has been restarted since
    if found.get("processes") != _numbering():
        return None     # in another container the same number means another process
    began = _began(found["process"])
    return began is not None and began == found.get("began")


def _words(found: Found) -> str:
    if not found:
        return "a process that left no name"
    return (f"process {found.get('process')!s:.20} on {str(found.get('host')).partition(' ')[0]:.80}, "
            f"since {found.get('since')!s:.20}")


def _host() -> str:
    """Return the name of this host and the id of its boot, after which no earlier process runs."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        boot = ""
    return f"{socket.gethostname()} {boot}"


def _numbering() -> str:
    """Return the PID namespace of this process, of which each container has its own; "" if unknown."""
    try:
        return os.readlink("/proc/self/ns/pid")
    except OSError:
        return ""


def _began(process: int) -> str | None:
    """Return the start of a process in clock ticks; "" if unknown, None if it has ended.

    Process ids are reused, but not with the same start.
    """
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return None if fields[0] in "ZX" else fields[19]    # Z, X: ended, and its parent has not waited for it yet
    except OSError:
        pass
    if Path("/proc/self/stat").exists():
        return None
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return None
    except OSError:
        pass
    return ""
