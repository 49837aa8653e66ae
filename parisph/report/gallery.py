"""`parisph report --all DIR...`: a page with a picture, the truth, the error and the cost of every run.

It is written twice: as HTML in one file, and as Markdown with its pictures beside it. Needs matplotlib, no MPI.
"""

from collections.abc import Sequence
from pathlib import Path

from parisph.base.errors import StoreError
from parisph.base.paths import AnyPath
from parisph.base.text import named
from parisph.io.files import write_text
from parisph.io.reader import Run
from parisph.pictures import curves, view
from parisph.report import account, markup
from parisph.report.entries import Cell, Table, number
from parisph.report.page import Subject, subject

HEAD = ("run", "particles", "steps", "CPU [s]", "truth", "relative L2 error, shift = 0", "best published")


def found(folders: Sequence[AnyPath]) -> list[Path]:
    """Return the folders of runs: those given, and those inside the given ones. Raises StoreError if there are none."""
    runs: list[Path] = []
    for folder in map(Path, folders):
        inside = [folder] if (folder / "case.json").exists() else [
            path.parent for path in sorted(folder.glob("*/case.json"))]
        if not inside:
            raise StoreError(f"{named(folder)} holds no run: give the folder of a run, which has a case.json, or one "
                             "that holds such folders")
        runs += [path for path in inside if path not in runs]
    return runs


def write(folders: Sequence[AnyPath], out: AnyPath) -> list[Path]:
    """Write gallery.html and gallery.md into a folder, with the pictures; return their paths.

    folders : of runs, or that hold runs

    Raises StoreError for what is no run and for files that cannot be read or written; MissingLibrary.
    """
    subjects, place = [subject(folder) for folder in found(folders)], Path(out)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(f"cannot make {place}: {error.strerror}") from None
    names = [name.replace("/", "_") for name in curves.folder_names([about.run.folder for about in subjects])]
    pages, texts = [], ["# Gallery", "", account.ALIGNMENT.partition(" The last two")[0], ""]
    for name, about in zip(names, subjects):
        content = _table(name, about)
        pages += [markup.heading(about.title), *_pictured(about.run, place / f"{name}.png"), markup.table(content)]
        texts += [f"## {about.title}", "", *([f"![{about.title}]({name}.png)", ""] if len(about.run) else []),
                  _markdown(content), ""]
    try:
        write_text(place / "gallery.html", markup.page("Gallery", [markup.paragraph(texts[2]), *pages]))
        write_text(place / "gallery.md", "\n".join(texts))
    except OSError as error:
        raise StoreError(f"cannot write to {place}: {error.strerror}") from None
    return [place / "gallery.html", place / "gallery.md"]


def _pictured(run: Run, path: Path) -> list[str]:
    if len(run) == 0:
        return []
    number, caption = _moment(run)
    view.plot_field(run, number, path=path)
    return [markup.picture(path, caption)]


def _moment(run: Run) -> tuple[int, str]:
    """Return the snapshot that shows the run best: two thirds of the way, after the impact and before the rest."""
    number = (2 * (len(run) - 1)) // 3
    return number, f"Pressure at t = {run.times[number]:.4g} s"


def _table(name: str, about: Subject) -> Table:
    """Return the table of a run: a line for each probe that has a truth, or one line."""
    own = [Cell(name), *(number(about.summary, account.SUMMARY, [key], form) for key, form in
                         (("particles", "d"), ("steps", "d"), ("cpu_seconds", ".3g")))]
    rows: list[tuple[Cell, ...]] = []
    blank = [Cell("")] * len(own)
    for k, probe in enumerate(about.probes):
        if probe.truth is not None:
            rows.append((*(blank if rows else own), Cell(f"{probe.name}: {account.name_of(probe.truth)}"),
                         account.error_of(about.summary, ["errors", probe.name]),
                         account.best_published(probe.truth, about.case, ["probes", k, "truth"])))
    return Table(HEAD, tuple(rows or [(*own, Cell("none"), Cell("-"), Cell("-"))]))


def _markdown(content: Table) -> str:
    lines = [content.head, tuple("---" for _ in content.head),
             *(tuple(cell.text.replace("|", "/") for cell in row) for row in content.rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
