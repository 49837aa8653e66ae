"""`parisph report --all DIR...`: a page with picture, truth, error and cost of every run. Needs matplotlib, no MPI.

The page is one HTML file, and Markdown with pictures beside it, in its own file or between two marks of another.
"""

from collections.abc import Sequence
from pathlib import Path

from parisph.base.errors import StoreError
from parisph.base.markdown import escaped, line, target
from parisph.base.paths import AnyPath
from parisph.base.text import named, plain
from parisph.io.files import failing_as, write_text
from parisph.io.reader import Run
from parisph.pictures import curves, overview, rendering
from parisph.report import account, events, markup
from parisph.report.between import Between
from parisph.report.entries import Cell, CellTable, number
from parisph.report.page import Subject, subject

START, END = "<!-- gallery -->", "<!-- end of the gallery -->"
WORDS = account.ALIGNMENT.partition(" The last two")[0]
PICTURES = "pictures"    # folder beside a file that a gallery is put into
HEAD = ("probe", "truth", "error, greatest value or time", "least error of others", "error against further references")


def found(folders: Sequence[AnyPath]) -> list[Path]:
    """Return the folders that hold a run, and the runs inside the others. Raises StoreError for one without runs."""
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
    Raises StoreError for a folder without runs and for files that cannot be read or written; MissingLibrary.
    """
    place = Path(out)
    pages, texts = [], ["# Gallery", ""]
    for name, about in _subjects(folders):
        path = _picture(about.run, place / f"{name}.png")
        caption = f"{_shown(about.run).capitalize()} at t = {about.run.times[_moment(about.run)]:.4g} s" if path else ""
        pages += [markup.heading(about.title), *([markup.picture(path, caption)] if path else []),
                  markup.table(_facts(about)),
                  markup.table(truths) if (truths := _table(about)).rows else markup.paragraph("No truth.")]
        texts += [f"## {line(about.title)}", "", *_text(name, about, f"{name}.png" if path else "")]
    with failing_as(f"write to {place}"):
        write_text(place / "gallery.html", markup.page("Gallery", [markup.paragraph(WORDS), *pages]))
        write_text(place / "gallery.md", "\n".join([*texts[:2], WORDS, "", *texts[2:]]))
    return [place / "gallery.html", place / "gallery.md"]


def put_into(folders: Sequence[AnyPath], file: AnyPath) -> list[Path]:
    """Put the gallery between the lines START and END of a Markdown file; return its path.

    Sections are named as the folders of the runs. The pictures go to the folder `pictures` beside the file, or beside
    the target of a link. Raises CaseError for a file without the marks, or not in UTF-8; otherwise as `write`.
    """
    place, texts = Between(file, START, END, "the gallery"), ["", WORDS, ""]
    pictures = place.path.parent / PICTURES
    for name, about in _subjects(folders):
        picture = _picture(about.run, pictures / f"{name}.png")
        texts += [f"### {line(name)}", "", *_text(about.title, about, f"{PICTURES}/{name}.png" if picture else "")]
    place.put(texts)
    return [Path(file)]


def _subjects(folders: Sequence[AnyPath]) -> list[tuple[str, Subject]]:
    subjects = [subject(folder) for folder in found(folders)]
    names = [name.replace("/", "_") for name in curves.folder_names([about.run.folder for about in subjects])]
    return [(name if names.count(name) == 1 else f"{name}-{number}", about)
            for number, (name, about) in enumerate(zip(names, subjects), 1)]


def _picture(run: Run, path: Path) -> Path | None:
    """Draw a run, and return the path; None for a run without snapshots."""
    with failing_as(f"make {path.parent}"):
        path.parent.mkdir(parents=True, exist_ok=True)
    if len(run) == 0:
        return None
    overview.plot_small(run, _moment(run), path, _field(run))
    return path


def _moment(run: Run) -> int:
    """Return the snapshot at two thirds of the run: often after the impact and before the flow comes to rest."""
    return (2 * (len(run) - 1)) // 3


def _field(run: Run) -> str:
    """Return the quantity in the picture: the pressure, or the speed of a viscous flow."""
    return "speed" if run.scene.viscosity else "pressure"


def _shown(run: Run) -> str:
    """Return the quantity in the picture, of a rendered one the speed."""
    return "speed" if run.scene.dim == 3 and rendering.available() else _field(run)


def _facts(about: Subject) -> CellTable:
    """Return size, cost and drift of a run."""
    def of(path: list[str | int], form: str = ".4g", unit: str = "") -> Cell:
        return number(about.summary, account.SUMMARY, path, form, unit)

    both = "fluid_particles" in about.summary and "wall_particles" in about.summary
    wanted = [*([("fluid particles", of(["fluid_particles"], "d")), ("wall particles", of(["wall_particles"], "d"))]
                if both else [("particles", of(["particles"], "d"))]), ("spacing", of(["spacing"], ".4g", "m")),
              ("steps", of(["steps"], "d")), ("to t", of(["time"], ".4g", "s")),
              ("CPU time", of(["cpu_seconds"], ".3g", "s")),
              ("volume from", of(["volume_range", "low"], "+.2%")), ("to", of(["volume_range", "high"], "+.2%"))]
    if not about.summary.get("driven") and about.summary.get("energy_range"):
        wanted.append(("energy at most", of(["energy_range", "high"], "+.2%")))
    if (about.summary.get("energy_in_motion") or {}).get("drift") is not None:
        wanted.append(("energy in motion", of(["energy_in_motion", "drift"], "+.2%")))
    return CellTable(tuple(name for name, _ in wanted), (tuple(cell for _, cell in wanted),))


def _table(about: Subject) -> CellTable:
    """Return errors, greatest values beside those of others, and arrivals of a run, a line for each."""
    judged: dict[str, list[tuple[Cell, ...]]] = {}
    for row in account.errors(about.probes, about.case, about.summary).rows:
        judged.setdefault(row[0].text, []).append(row)
    rows = [(first[0], first[1], first[2], first[7],
             _joined("; ".join(f"{row[1].text}: {row[2].text}" for row in others) or "-", *(row[2] for row in others)))
            for first, *others in judged.values()]
    for row in events.peaks(about.probes, about.summary).rows:
        if row[4].text == "-":    # the run ends before the interval
            continue
        smoothed = "" if row[3].text == "-" else f", smoothed over {row[3].text} s"
        rows.append((Cell(row[0].text + smoothed), _joined(_reported(row), *row[6:9], row[10]),
                     _joined(f"{row[4].text} at {_time(row[5])}{_beyond(row[9])}", *row[4:6], row[9]),
                     Cell("-"), Cell("-")))
    for row in events.arrivals(about.case, about.summary).rows:
        rows.append((row[0], _joined(f"when it passes {row[1].text}", row[1]), row[2], Cell("-"), Cell("-")))
    wide = any(row[4].text != "-" for row in rows)
    return CellTable(HEAD if wide else HEAD[:4], tuple(row if wide else row[:4] for row in rows))


def _reported(row: tuple[Cell, ...]) -> str:
    low, high, level, when, whose = (row[k].text for k in (6, 7, 8, 10, 11))
    band = "" if low == "-" else f"greatest value {low} to {high}"
    band += f", shares of the height above {level}" if band and level not in ("-", "0") else ""
    return band + (f"{', ' if band else ''}{whose}: at {when} s" if when != "-" else "")


def _time(cell: Cell) -> str:
    time, _, remark = cell.text.partition(" ")
    return f"{time} s" + (", the last sample" if remark else "")


def _beyond(cell: Cell) -> str:
    return "" if cell.text == "-" else ", inside" if cell.text in ("+0%", "-0%") else f", {cell.text} beyond"


def _joined(text: str, *cells: Cell) -> Cell:
    """Return a Cell with a text and the sources of other cells."""
    return Cell(text, ", ".join(cell.source for cell in cells if cell.source))


def _text(alternative: str, about: Subject, picture: str) -> list[str]:
    """Return the lines of a run: its picture, its size and cost, its truths."""
    origin = f"{plain(about.case['source'])}. " if about.case.get("source") else ""
    told = (f"{about.title}. " if alternative == about.title else "") + origin + _in_words(_facts(about))
    content = _table(about)
    return [*([f"![{escaped(alternative)}]({target(picture)})", ""] if picture else []), line(f"{told}."), "",
            *([_markdown(content)] if content.rows else ["No truth."]), ""]


def _in_words(facts: CellTable) -> str:
    """Return size, cost and drift of a run as part of a sentence."""
    of = {name: cell.text for name, cell in zip(facts.head, facts.rows[0])}
    particles = of.get("particles") or f"{of['fluid particles']} fluid and {of['wall particles']} wall"
    energy = [f", energy at most {of['energy at most']}"] if "energy at most" in of else []
    energy += [f", change of the energy in motion {of['energy in motion']}"] if "energy in motion" in of else []
    return (f"{particles} particles, spacing {of['spacing']}; {of['steps']} steps to t = {of['to t']}, "
            f"{of['CPU time']} of CPU time; volume {of['volume from']} to {of['to']}" + "".join(energy))


def _markdown(content: CellTable) -> str:
    rows = [content.head, tuple("---" for _ in content.head),
            *(tuple(escaped(cell.text) for cell in row) for row in content.rows)]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
