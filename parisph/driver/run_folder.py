"""Preparation of a run: its folder and lock, and for a restart the checkpoint and the case."""

import json
import math
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from mpi4py import MPI

from parisph.base.errors import CaseError, StoreError
from parisph.base.paths import AnyPath
from parisph.base.reading import read_text
from parisph.case.schema import Case
from parisph.case.stored import from_json
from parisph.driver import case_edits
from parisph.io import checkpoint
from parisph.io.checkpoint import Checkpoint
from parisph.io.files import create, on_first, read_json
from parisph.io.folder import check_free, content, identity, make, move_run_aside, unmake
from parisph.io.lock import Lock


@contextmanager
def left_only_if_used(made: Sequence[Path] | None, old: Path | None = None) -> Iterator[None]:
    """Remove the folders made for a run if it fails before anything is written to them. Not collective.

    made : folders, the innermost first, on the rank that made them, else None
    old : folder to which an earlier run was moved, to move it back, or None
    """
    try:
        yield
    except BaseException:
        if made and unmake(made) and old is not None:
            with suppress(OSError):
                os.rename(old, made[0])
        raise


@contextmanager
def locked(comm: MPI.Comm, folder: Path, force: bool) -> Iterator[Lock | None]:
    """Hold the lock of a folder (on rank 0; None on the others) and release it at the end. Collective.

    Raises StoreError on every rank if another process writes into the folder.
    """
    lock = on_first(comm, f"use the folder {folder}", lambda: Lock(folder, force))
    try:
        yield lock
    finally:
        if lock is not None:
            lock.release()


def new_folder(folder: Path, overwrite: bool | None = None, force: bool = False) -> tuple[list[Path], Path | None]:
    """Make the folder for a new run, before any work.

    overwrite : whether to move an earlier run aside; None if the command has no such option

    Returns the folders that were made, the innermost first, and the folder to which an earlier run was moved, or None.
    Raises CaseError, StoreError, OSError.
    """
    given, folder = folder, folder.resolve()
    old: Path | None = None
    if not overwrite:
        check_free(folder, given, movable=overwrite is not None)
    elif content(folder):
        Lock(folder, force).release()    # it must not be in use
        moved = move_run_aside(folder)
        old = None if moved is None else _as_given(moved, given)
    with left_only_if_used(made := make(folder), old):
        _check_writable(folder)
    return made, old


def _as_given(path: Path, given: Path) -> Path:
    """Return a path beside a folder that the user named `given`, relative if `given` is."""
    near = given.parent / path.name
    return near if near.resolve() == path else path


def _check_writable(folder: Path) -> None:
    """Check that a file can be made in a folder. Raises OSError."""
    probe = folder / f".{os.getpid()}.tmp"
    os.close(create(probe))
    probe.unlink()


def check_run(folder: Path, path: AnyPath) -> None:
    """Check that there is a run to continue, and that its folder is writable. Raises StoreError, OSError."""
    if not Path(path).exists():
        raise StoreError(f"{path}: no such folder or file")
    if not (folder / "case.json").exists() and not checkpoint.paths(folder / "checkpoints"):
        if Path(path).is_file():
            checkpoint.read(MPI.COMM_SELF, path)    # raises if it is damaged
            raise StoreError(f"{path} is not in the folder of a run: give a folder to continue in with -o DIR")
        raise StoreError(f"{path} holds no run to continue: it has neither case.json nor a checkpoint; "
                         "start one with parisph run")
    identity(folder)    # raises if case.json is damaged
    _check_writable(folder)


def find(path: Path, folder: Path, comm: MPI.Comm) -> Path | None:
    """Return the checkpoint file to continue from, or None, the same on every rank. Collective."""
    def newest() -> Path | None:
        if path.is_file():
            return path
        return next(reversed(checkpoint.paths(folder / "checkpoints")), None)
    found: Path | None = comm.bcast(on_first(comm, f"find the checkpoints of {folder}", newest))
    return found


def case_of(saved: Checkpoint | None, found: Path | None, folder: Path, until: float | None
            ) -> tuple[Case, str, list[str]]:
    """Return the case of the restart, the identity of its run, and what to log of edits (driver.case_edits)."""
    text = saved.case if saved else read_text(folder / "case.json", math.inf)
    try:
        case = from_json(text)
    except CaseError as error:
        raise CaseError(f"{found or folder / 'case.json'}: {error}") from None
    origin, taken = case.origin, case_edits.edits(folder, text) if saved else {}
    if until is not None:
        taken.pop("end_time", None)
    try:
        case = case.changed(**taken) if taken else case
    except CaseError as error:
        raise CaseError(f"{folder / 'case.json'}: {error}") from None
    case = case if until is None else case.changed(end_time=float(until))
    return case.of(origin), json.loads(text).get("run", ""), case_edits.told(taken, folder)


def check_useful(saved: Checkpoint | None, case: Case, found: Path | None, folder: Path, elsewhere: bool, done: bool,
                 until: float | None) -> None:
    """Raise CaseError if nothing is left to do, or if the restart would remove later results from the run."""
    last = checkpoint.paths(folder / "checkpoints")[-1:]
    if saved and not elsewhere and last and int(last[0].stem) > saved.step:
        raise CaseError(f"{found} is not the last checkpoint of {folder}, which is {last[0]}: "
                        f"results after step {saved.step} would be lost; give another folder with -o DIR, "
                        "or continue from the last one")
    if saved and done and (elsewhere or until is not None or _is_complete(folder)):
        raise CaseError(f"end_time = {case.end_time:g} s: the checkpoint {found} is of {saved.time:g} s already; "
                        "ask for more with --until")


def _is_complete(folder: Path) -> bool:
    """Return whether a run is completed, by its summary."""
    try:
        return str(read_json(folder / "summary.json").get("status")).startswith("completed")
    except StoreError:
        return False
