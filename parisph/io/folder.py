"""Changes to the folder of a run. Only incomplete files of parisph are removed, and no link is followed.

All functions are for one rank. They raise OSError, or StoreError with the remedy.
"""

import json
import math
import os
import re
import shutil
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from parisph.base.errors import CaseError, StoreError
from parisph.base.json_digest import KEY
from parisph.base.reading import read_text
from parisph.io.files import digest, read_json, write_json
from parisph.io.layout import BEFORE, FILES, FOLDERS, PEAKS, REPLACED


def content(folder: Path) -> list[str]:
    """Return the names in a folder that a run would overwrite: files, links, and folders that are not empty."""
    return [name for name in (*FILES, *FOLDERS, PEAKS) if _is_used(folder / name)]


def _is_used(path: Path) -> bool:
    return path.is_symlink() or (any(path.iterdir()) if path.is_dir() else path.exists())


def check_free(folder: Path, given: str | os.PathLike[str] | None = None, movable: bool = True) -> None:
    """Raise CaseError if a folder holds a run, or anything else that a new run would overwrite.

    given : the folder as named by the user; movable : whether the command has --overwrite; both for the message
    """
    names = content(folder)
    if not names:
        return
    fault = "holds a run already" if "case.json" in names else \
        f"has no case.json, but it holds {', '.join(names)}, which a run would overwrite"
    raise CaseError(f"{given or folder} {fault}: give another folder with -o"
                    f"{', or move the whole folder aside with --overwrite (in Python: overwrite=True)' * movable}")


def make(folder: Path) -> list[Path]:
    """Make a folder and its parents, all or none; return the new ones, the innermost first."""
    made: list[Path] = []
    for place in reversed([place for place in (folder, *folder.parents) if not place.is_dir()]):
        try:
            place.mkdir()
        except FileExistsError:
            if place.is_dir():    # another process was faster
                continue
            unmake(made)
            raise
        except OSError:
            unmake(made)
            raise
        made.insert(0, place)
    return made


def unmake(made: Sequence[Path]) -> bool:
    """Remove the empty folders of those made by `make`, the innermost first; return whether that one is removed."""
    for number, place in enumerate(made):
        try:
            place.rmdir()
        except OSError:    # it is not empty
            return number > 0
    return bool(made)


def prepare(folder: Path, series: Iterable[str] = ()) -> None:
    """Make the folders of a run, and remove the incomplete files of a killed process.

    series : names of the time series of the run, whose incomplete files are removed
    """
    folder.mkdir(parents=True, exist_ok=True)
    _check_log(folder / "run.log")
    for place in (folder / name for name in FOLDERS):
        make_inside(place)
    for place in (folder / name for name in (PEAKS, BEFORE)):
        _refuse_link(place)
    for name, own in _half_written(series).items():
        place = folder / name
        for path in place.iterdir() if place.is_dir() else ():
            if own.fullmatch(path.name) and not path.is_dir():
                path.unlink()


def _check_log(path: Path) -> None:
    """Raise StoreError if the log cannot be continued: it is a link, or no file."""
    if path.is_symlink() or (path.exists() and not path.is_file()):
        what = "a symbolic link" if path.is_symlink() else "not a regular file"
        raise StoreError(f"{path} is {what}, and parisph writes only to files of its own in the folder of the run: "
                         "move it away")


def _half_written(series: Iterable[str]) -> dict[str, re.Pattern[str]]:
    """Return {folder inside that of a run: pattern of the temporary names that a killed process leaves there}."""
    probes = [name.removeprefix("probes/") for name in series if name.startswith("probes/")]
    own = {
        "": [*(re.escape(name) for name in FILES), r"summary-[0-9]+\.json"],
        "probes": [re.escape(f"{name}.csv") for name in probes],
        "snapshots": [r"[0-9]{6,}\.vtkhdf"],
        "checkpoints": [r"[0-9]{8,}\.h5"],
        PEAKS: [re.escape(f"{name}.vtkhdf") for name in probes],
    }
    found = {place: rf"\.({'|'.join(names)})\.tmp" for place, names in own.items() if names}
    found[""] += r"|\.run\.lock\.[0-9a-f]{16}"
    return {place: re.compile(pattern) for place, pattern in found.items()}


def make_inside(place: Path) -> None:
    """Make a folder inside that of a run, and its parents. Raises StoreError if it is a symbolic link."""
    _refuse_link(place)
    place.mkdir(parents=True, exist_ok=True)


def _refuse_link(place: Path, inside: bool = True) -> None:
    if inside and place.is_symlink():
        raise StoreError(f"{place} is a symbolic link, and parisph writes only inside the folder of the run: "
                         "put a real folder in its place, or choose another folder with -o")


def write_case(folder: Path, case: str, run: str) -> None:
    """Write case.json: the case (JSON text) and the identity of the run."""
    write_json(folder / "case.json", {"run": run, **json.loads(case)})


def is_edited(folder: Path) -> bool:
    """Return whether there is a case.json without a digest: the user has edited it, or an early release wrote it."""
    try:
        return KEY not in json.loads(read_text(folder / "case.json", math.inf))
    except (OSError, ValueError, TypeError):    # other readers raise its faults
        return False


def identity(folder: Path) -> str | None:
    """Return the identity of the run in a folder, "" if it has none, None if there is no run.

    Raises StoreError if case.json is damaged.
    """
    if not (folder / "case.json").exists():
        return None
    return str(read_json(folder / "case.json").get("run", ""))


def digests(folder: Path, names: Iterable[str]) -> dict[str, str]:
    """Return {name: digest} of the existing files of a run, for its summary."""
    return {name: digest(folder / name) for name in names if (folder / name).is_file()}


def summary(folder: Path) -> dict[str, Any] | None:
    """Return the content of summary.json, None if it is missing or damaged: a restart writes another one."""
    try:
        return read_json(folder / "summary.json")
    except StoreError:
        return None


def check_unchanged(path: Path, summary: dict[str, Any] | None, name: str) -> None:
    """Raise StoreError if a file has changed since the summary of its run was written; pass without a summary."""
    due = (summary or {}).get("files", {}).get(name)
    if due is not None and path.is_file() and digest(path) != due:
        raise StoreError(f"{path} is damaged: it has changed since the run ended. Move it away, or repair it")


def move_aside(folder: Path, moved: Iterable[Path], copied: Iterable[Path] = ()) -> Path | None:
    """Move or copy the files of a run that will be replaced to replaced/N; return that folder, None without files."""
    moved, copied = ([path for path in paths if path.exists()] for paths in (moved, copied))
    if not moved and not copied:
        return None
    if (folder / REPLACED).is_symlink():
        raise StoreError(f"{folder / REPLACED} is a symbolic link, and parisph writes only inside the folder of the "
                         "run: remove the link")
    place = _free(folder / REPLACED / "1", lambda number: folder / REPLACED / str(number))
    for path in (*moved, *copied):
        there = place / path.relative_to(folder)
        there.parent.mkdir(parents=True, exist_ok=True)
        if path in copied:
            shutil.copy2(path, there)
        else:
            os.rename(path, there)
    return place


def move_run_aside(folder: Path) -> Path | None:
    """Rename a folder to FOLDER.old, FOLDER.old-2, ...; return the new name, None if a run would overwrite nothing.

    Raises CaseError if the current folder is in it.
    """
    if not content(folder):
        return None
    if Path.cwd().is_relative_to(folder):
        raise CaseError(f"{folder} contains the current folder, and cannot be moved aside: "
                        "give another folder with -o, or repeat the command in another folder")
    old = folder.with_name(f"{folder.name}.old")
    place = _free(old, lambda number: folder.with_name(f"{folder.name}.old-{number}"))
    os.rename(folder, place)
    return place


def _free(first: Path, numbered: Callable[[int], Path]) -> Path:
    number, place = 1, first
    while place.exists() or place.is_symlink():
        number += 1
        place = numbered(number)
    return place
