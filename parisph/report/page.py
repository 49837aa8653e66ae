"""`parisph report RUN`: a page with a run beside its references. Needs matplotlib, no MPI. Not collective.

The page is one file. Its pictures are also written as PNG files into the folder `report` beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from parisph.base.errors import CaseError, ParisphError, StoreError
from parisph.base.paths import AnyPath
from parisph.base.text import clipped, named, plain
from parisph.case.probes import Probe, ProbeArray
from parisph.case.truths import intervals
from parisph.io.files import failing_as, write_text
from parisph.io.folder import make_inside
from parisph.io.reader import Run, open_run
from parisph.pictures import beside, curves, overview, rendering, view
from parisph.report import account, conditions, energies, events, markup

PAGE, FOLDER = "report.html", "report"
LAST = 0.005    # share of an interval at its end, in which a greatest value may still rise


@dataclass(frozen=True)
class Subject:
    """The run of a report. case, summary : as of case.json and summary.json ({} if missing); probes : of the case"""

    run: Run
    title: str
    case: dict[str, Any]
    probes: Sequence[Probe]
    summary: dict[str, Any]


def subject(folder: AnyPath) -> Subject:
    """Return the Subject of the run in a folder. Raises StoreError if there is none, with a remedy."""
    path = Path(folder)
    if not (path / "case.json").exists():
        inner = [item.parent.name for item in sorted(path.glob("*/case.json"))] if path.is_dir() else []
        hint = (f"it holds runs ({clipped(', '.join(map(named, inner)), 80)}): give one of them, or all with --all"
                if inner else "give the folder that `parisph run` has printed at its end")
        raise StoreError(f"{named(folder)} is not the folder of a run: it has no case.json; {hint}")
    run = open_run(path)
    return Subject(run, clipped(plain(run.scene.title), 200), run.case, run.scene.probes, run.summary or {})


def write(folder: AnyPath, out: AnyPath | None = None) -> Path:
    """Write the page of a run, and its pictures; return the path of the page.

    folder : of the run; out : the folder to write to, by default that of the run
    Raises StoreError for a folder without a run and for files that cannot be read or written; MissingLibrary.
    """
    about, place = subject(folder), Path(out if out is not None else folder)
    pictures = place / FOLDER
    with failing_as(f"make {pictures}"):
        make_inside(pictures)
    try:
        parts = [*_run(about), *_errors(about), *_series(about, pictures), *_flow(about, pictures),
                 *_conserved(about), *_cost(about, pictures), *_made(about)]
    except (TypeError, KeyError, AttributeError, OverflowError) as error:
        raise StoreError(f"{about.run.folder / 'summary.json'} is damaged: its entries are not those of a summary "
                         f"({type(error).__name__})") from None
    with failing_as(f"write {place / PAGE}"):
        write_text(place / PAGE, markup.page(about.title, parts))
    return place / PAGE


def _run(about: Subject) -> list[str]:
    parts = [markup.paragraph(f"Run in {named(about.run.folder.resolve().name)}. Every number of the tables is an "
                              "entry of summary.json or case.json of this run, named by its tooltip.", "small")]
    if not about.summary:
        parts.append(markup.paragraph("There is no summary.json: the run goes on, or was killed.", "warning"))
    parts += [markup.paragraph(f"Warning: {text}", "warning") for text in about.summary.get("warnings") or ()]
    return [*parts, markup.heading("What was run"), markup.table(conditions.conditions(about.case, about.summary))]


def _errors(about: Subject) -> list[str]:
    parts, judged = [markup.heading("Errors")], account.errors(about.probes, about.case, about.summary)
    if judged.rows:
        parts += [markup.paragraph(account.ALIGNMENT), markup.table(judged)]
        parts.append(markup.paragraph("In pictures, times that are not compared are grey.", "small"))
    without = [probe.name for probe in about.probes if probe.truth is None]
    if without:
        parts.append(markup.paragraph(f"Without a reference: {', '.join(without)}.", "small"))
    for name, text in account.published(about.probes):
        parts.append(markup.paragraph(f"Errors of others at {name}, {text}.", "small"))
    parts += [markup.paragraph(f"{name}: {note}", "small") for name, note in account.notes(about.probes)]
    for title, content, words in (("Profiles", account.profiles(about.probes, about.summary), ""),
                                  ("Peaks", events.peaks(about.probes, about.summary), events.PEAKS),
                                  ("Greatest pressures", events.impacts(about.summary), events.IMPACTS),
                                  ("Arrivals", events.arrivals(about.case, about.summary), events.PASSED),
                                  ("Water that passed lines", events.passed(about.summary), events.LINES)):
        if content.rows:
            parts += [markup.heading(title), markup.table(content)]
            parts += [markup.paragraph(words, "small")] if words else []
    waves = list(events.reflection(about.summary))
    parts += [markup.heading("Incident and reflected waves")] if waves else []
    for content, words in waves:
        parts += [markup.table(content), *([markup.paragraph(words, "small")] if words else [])]
    return parts


def _series(about: Subject, folder: Path) -> list[str]:
    parts, rest = [markup.heading("Probes")], []
    parts += [markup.paragraph(f"{name}: {words}", "small")
              for name, words in (about.summary.get("touched") or {}).items()]
    for probe in about.probes:
        if probe.name not in about.run.probe_names:
            continue
        if probe.truth is None:
            rest.append(probe.name)
            continue
        path = folder / f"{probe.name}.png"
        try:
            if isinstance(probe, ProbeArray):
                beside.plot_profiles(about.run, probe, path)
            else:
                beside.plot_beside(about.run, probe, path)
        except CaseError as error:    # the file of the truth is missing
            parts.append(markup.paragraph(f"{probe.name} is shown without its reference: {error}", "warning"))
            rest.append(probe.name)
            continue
        parts.append(markup.picture(path, f"{probe.name} beside its references, not shifted"))
    if rest:
        path = folder / "probes.png"
        curves.plot_probe(about.run, rest, path)
        parts.append(markup.picture(path, f"Probes: {', '.join(rest)}"))
    return parts


def _flow(about: Subject, folder: Path) -> list[str]:
    run = about.run
    if len(run) == 0:
        return []
    overview.plot_moments(run, folder / "flow.png")
    where = "Pressure at moments of the run" + (", in a slice" if run.scene.dim == 3 else "")
    parts = [markup.heading("The flow"), markup.picture(folder / "flow.png", where)]
    if run.scene.dim == 3 and rendering.available():
        moment = (2 * (len(run) - 1)) // 3    # often after an impact
        view.plot_field(run, moment, "speed", folder / "rendered.png", view="3d")
        parts.append(markup.picture(folder / "rendered.png", f"Speed, and pressure on bodies, at t = "
                                                             f"{run.times[moment]:.4g} s"))
    for name in run.probe_names:
        peak = run.peak(name)
        if peak is not None:
            path = folder / f"peak_{name}.png"
            view.plot_field(run, peak, path=path)
            parts.append(markup.picture(path, _of_peak(about, name, peak["peak"], peak["time"])))
    return parts


def _of_peak(about: Subject, name: str, value: float, time: float) -> str:
    """Return the caption of the flow at the greatest value of a probe, in older runs also outside compared times."""
    unit = next((unit for column, unit in about.run.units(name).items() if column not in ("time", "step")), "")
    compared = next((intervals(probe.truth) for probe in about.probes if probe.name == name), ())
    inside = any(start <= time <= end for start, end in compared)
    where = (" within the compared time" if inside else ", outside the compared time") if compared else ""
    if any(end - LAST * (end - start) <= time <= end for start, end in compared):
        where += ", at its end and so perhaps no peak"
    known = (about.summary.get("peaks") or {}).get(name) or {}
    if known.get("short"):
        where += (f", a short peak that is not resolved (mean over {1e3 * known['mean_over']:g} ms: "
                  f"{known['mean']:.4g} {unit})")
    return f"Pressure at the greatest value of {name}{where}: {value:.4g} {unit} at t = {time:.4g} s"


def _conserved(about: Subject) -> list[str]:
    if not about.summary:
        return []
    scene = about.run.scene
    tables = (energies.drift(scene, about.summary), energies.motion(about.summary))
    return [markup.heading("Volume and energy"), *(markup.table(content) for content in tables if content.rows),
            *(markup.paragraph(text, "small")
              for text in (*energies.lost(about.summary), *energies.drift_notes(scene, about.summary)))]


def _cost(about: Subject, folder: Path) -> list[str]:
    parts = [markup.heading("Cost")]
    if about.summary:
        parts.append(markup.table(account.cost(about.summary)))
    try:
        overview.plot_solver(about.run, folder / "solver.png")
    except (ParisphError, ValueError):    # no step was made
        return parts
    return [*parts, markup.picture(folder / "solver.png", "Iterations of the pressure solve, and time steps")]


def _made(about: Subject) -> list[str]:
    """Return the parameters, files and versions of the run, partly folded."""
    values = conditions.parameters(about.case)
    return [markup.heading("How it was made"), *([markup.table(values)] if values.rows else []),
            markup.folded("Case file, machine, options and versions",
                          markup.table(conditions.making(about.case, about.summary)))]
