"""The folder of a study: its place, its lock, and the files with its tables."""

import csv
import io
import re
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from parisph.base import markdown, paths
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.text import clipped, named
from parisph.io.files import failing_as, write_json, write_text
from parisph.io.lock import Lock


def choose(file: Path, out: AnyPath | None) -> Path:
    """Return the folder of a study: `out`, or studies/NAME of its file. Raises CaseError for a run or a file."""
    folder = Path("studies") / file.stem if out is None else paths.checked(out, "out")
    if (folder / "case.json").exists():
        raise CaseError(f"{named(folder)} holds a run: give another folder for the study with -o DIR")
    if folder.exists() and not folder.is_dir():
        raise CaseError(f"{named(folder)} is a file: give a folder for the study with -o DIR")
    return folder


def file_name(name: str, otherwise: str, longest: int = 60) -> str:
    """Return a name without characters unfit for file names; `otherwise` if it becomes empty."""
    return clipped(re.sub(r"[^A-Za-z0-9.+-]+", "_", name).strip("_-.") or otherwise, longest)


@contextmanager
def hold(folder: Path, force: bool = False) -> Iterator[Callable[[], None]]:
    """Make a folder and hold its lock. SIGTERM and SIGHUP act as Ctrl-C meanwhile.

    force : whether to use a folder that another host seems to use

    Yields a function to be called repeatedly: it renews the lock, and raises StoreError if that is lost. Raises
    StoreError if the folder cannot be written, or another process writes there.
    """
    with failing_as(f"write to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        lock = Lock(folder, force)
    try:
        with _terminated_as_interrupted():
            yield lock.check
    finally:
        lock.release()


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def save(folder: Path, content: Mapping[str, Any], lines: Sequence[Mapping[str, Any]], name: str) -> None:
    """Write results.json and results.csv atomically. Raises StoreError.

    lines : of the table, {column: value}; name : their entry in results.json; content : its other entries
    """
    table = io.StringIO()
    columns = list(dict.fromkeys(column for line in lines for column in line))    # some lines lack the last ones
    written = csv.DictWriter(table, columns or ["label"], lineterminator="\n")
    written.writeheader()
    written.writerows(lines)
    with failing_as(f"write to {folder}"):
        write_json(folder / "results.json", {**content, name: lines})
        write_text(folder / "results.csv", table.getvalue())


def publish(folder: Path, title: str, parts: Sequence[str], pictures: Sequence[Path],
            show: Callable[[str], None]) -> None:
    """Write results.md, and show its text and the paths of all results. Raises StoreError.

    parts : paragraphs and tables; pictures : paths of drawn pictures; show : function that shows a text
    """
    with failing_as(f"write to {folder}"):
        write_text(folder / "results.md", "\n\n".join([f"# {markdown.line(title)}", *parts]) + "\n")
    show("\n\n".join([title, *parts]))
    for path in [*(folder / f"results.{kind}" for kind in ("md", "csv", "json")), *pictures]:
        show(str(path))
