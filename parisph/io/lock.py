"""One process at a time writes into the folder of a run.

The file `run.lock` names it: host, process and start. It is made with O_EXCL, which is atomic on local
disks and on NFS since version 3, and its time is renewed while the run goes on. A process that is killed
leaves its lock behind. On the same host this can be detected, and the lock is taken over; on another
host, or from another container, it cannot, and the user decides.
"""

import json
import os
import socket
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

from parisph.base.errors import StoreError
from parisph.io.files import create

NAME = "run.lock"
BEAT = 10.0    # [s] between two signs of life

Found: TypeAlias = dict[str, Any]    # what a lock says


class Lock:
    """The right to write into a folder. One rank only.

    folder : the folder of the run, which is there
    force : whether to take over the lock of a process that may or may not run

    Raises:
    StoreError : another process writes into the folder; says which, and what to do. OSError : the folder cannot be
        written.
    """

    def __init__(self, folder: Path, force: bool = False) -> None:
        self.path = Path(folder) / NAME
        self._mine = {"host": _host(), "processes": _numbering(), "process": os.getpid(), "began": _began(os.getpid()),
                      "since": time.strftime("%Y-%m-%d %H:%M:%S"), "token": os.urandom(8).hex()}
        self._beaten = time.monotonic()
        for _ in range(3):    # two processes may find the same stale lock at once
            if self._take():
                return
            self._clear(force)
        raise StoreError(f"another process is starting in {folder} at this moment: wait for it to end")

    def check(self) -> None:
        """Renew the lock from time to time. Raises StoreError if it has been removed or taken over."""
        if time.monotonic() - self._beaten < BEAT:
            return
        self._beaten = time.monotonic()
        found = _read(self.path)
        if found is None:
            raise StoreError(f"{self.path} is gone: somebody has removed or moved the folder of this run while "
                             "it was running")
        if found.get("token") != self._mine["token"]:
            raise StoreError(f"{self.path} is of {_words(found)} now: it was taken from this process with --force")
        with suppress(OSError):
            os.utime(self.path)

    def release(self) -> None:
        """Remove the lock if it is still that of this process. Raises nothing."""
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
        """Remove a lock whose process has ended, or any lock if `force`.

        Raises StoreError if its process still runs.
        """
        found = _read(self.path)
        if found is None:
            return
        alive = _alive(found)
        if alive or (alive is None and not force):
            raise StoreError(self._refusal(found, alive))
        # Move it before looking again, so that of two processes only one removes it.
        aside = self.path.with_name(f".{NAME}.{self._mine['token']}")
        with suppress(FileNotFoundError):
            os.rename(self.path, aside)
            if (_read(aside) or {}).get("token") != found.get("token"):    # another process has been faster
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
        """Return as text how long ago the lock was renewed, by the clock of its file system."""
        probe = self.path.with_name(f".{NAME}.{self._mine['token']}")
        try:
            os.close(create(probe))
            seconds = probe.stat().st_mtime - self.path.stat().st_mtime
            probe.unlink()
        except OSError:
            return "an unknown time"
        return f"{max(seconds, 0.0):.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"


def _read(path: Path) -> Found | None:
    """Return the content of a lock file, {} if it cannot be understood, None if there is none."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)    # a pipe would be waited for
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
        return False    # the host has been started anew since
    if found.get("processes") != _numbering():
        return None     # in another container, where the same number means another process
    began = _began(found["process"])
    return began is not None and began == found.get("began")


def _words(found: Found) -> str:
    if not found:
        return "a process that left no name"
    return (f"process {found.get('process')!s:.20} on {str(found.get('host')).partition(' ')[0]:.80}, "
            f"since {found.get('since')!s:.20}")


def _host() -> str:
    """Return the name of this host and the id of its boot: no process survives a restart of the host."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        boot = ""
    return f"{socket.gethostname()} {boot}"


def _numbering() -> str:
    """Return which numbering of processes this one is in (the PID namespace of Linux); "" if unknown.

    Each container has its own.
    """
    try:
        return os.readlink("/proc/self/ns/pid")
    except OSError:
        return ""


def _began(process: int) -> str | None:
    """Return when a process began, in the system's clock ticks; "" if unknown, None if it has ended.

    Process ids are reused, but not together with the same start.
    """
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return None if fields[0] in "ZX" else fields[19]    # killed, and only its parent has not yet heard of it
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
