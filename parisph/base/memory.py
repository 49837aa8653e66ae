"""The memory of this machine."""

import os
from contextlib import suppress
from pathlib import Path

from parisph.base.paths import AnyPath

_LIMITS = ("memory.max", "memory.limit_in_bytes")    # of control groups, version 2 and 1


def total(root: AnyPath = "/") -> int | None:
    """Return the memory that this process may use [byte], None if unknown.

    It is that of the machine, or of the control group (a container, a batch job) if that is less.

    root : where /proc and /sys are
    """
    found = _limits(Path(root))
    with suppress(ValueError, OSError, AttributeError):
        found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(found, default=None)


def amount(size: float) -> str:
    """Return a number of bytes as text: '160 GB'."""
    for unit in ("B", "kB", "MB", "GB", "TB", "PB", "EB"):
        if size < 999.5:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{1000.0 * size:.3g} EB"


def _limits(root: Path) -> list[int]:
    """Return the limits of the control groups that this process is in, and of those around them."""
    try:
        groups = [line.split(":", 2) for line in (root / "proc/self/cgroup").read_text().splitlines()]
    except OSError:
        return []
    found = []
    for _, controllers, path in (group for group in groups if len(group) == 3):
        top = root / "sys/fs/cgroup" / ("memory" if "memory" in controllers.split(",") else "")
        folder = top / path.lstrip("/")
        # In a container the path may be that of the host, of which only the top exists.
        for place in (folder, *folder.parents):
            if not place.is_relative_to(top):
                break
            for name in _LIMITS:
                with suppress(OSError, ValueError):    # not there, or the word "max"
                    found.append(int((place / name).read_text()))
    return found
