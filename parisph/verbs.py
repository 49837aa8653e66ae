"""The work of the verbs of the command line."""

import argparse
import json
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parisph import completion, parser, ranks
from parisph.base import environment, libraries, output
from parisph.base.communicator import Communicator
from parisph.base.errors import CaseError

if TYPE_CHECKING:    # loaded by the verbs that need them
    from parisph.case.schema import Case
    from parisph.study.patch_study import PatchStudy


def _run(args: argparse.Namespace) -> None:
    if environment.launched()[1] > 1:
        ranks.world()
        from parisph.driver import run  # noqa: F401  starts PETSc on all ranks, before a case file may import it on one

    def prepared() -> tuple[str, dict[str, Any], str, list[str]]:
        case = _load(args)
        return case.model_dump_json(), dict(case.origin), _folder(args), _files_of_parts(args)

    text, origin, out, parts = ranks.on_first(prepared)
    ranks.stop_if_asked()
    comm = ranks.world()
    from parisph import driver
    from parisph.case.schema import Case

    if comm.rank:
        _register(parts)
    case = Case.model_validate_json(text).of(origin)    # of rank 0: a case file may depend on host, clock or rank
    summary = driver.run(case, comm, out, petsc_options=args.petsc, progress=not args.quiet, overwrite=args.overwrite,
                         force=args.force)
    _tell(comm, summary, out)


def _restart(args: argparse.Namespace) -> None:
    comm = ranks.world()
    ranks.everywhere(lambda: _register(args.parts))
    from parisph import driver
    from parisph.io.layout import run_of

    summary = driver.restart(args.path, comm, until=args.until, out=args.out, petsc_options=args.petsc,
                             progress=not args.quiet, force=args.force)
    _tell(comm, summary, args.out or run_of(args.path))


def _check(args: argparse.Namespace) -> None:
    case = _load(args)
    from parisph import driver
    from parisph.case.load import arguments

    print(driver.describe(case, arguments(args.case, args.set)))
    if args.plot is not None:
        from parisph.pictures.bodies_view import plot_scene

        plot_scene(case, args.plot)
        print(args.plot)


def _load(args: argparse.Namespace) -> "Case":
    from parisph.case.load import load

    _register(args.parts)
    return load(args.case, args.set)


def _folder(args: argparse.Namespace) -> str:
    """Return the folder for a new run. Raises CaseError if it holds a run, without --overwrite."""
    if args.out is not None:
        if os.path.exists(Path(args.out) / "case.json") and not args.overwrite:
            raise CaseError(f"{args.out} holds a run already: give another folder with -o, "
                            "or move the whole folder aside with --overwrite")
        return str(args.out)
    case = Path(args.case)
    name = case.resolve().parent.name if case.name == "case.json" else case.stem
    number = 1
    while os.path.exists(folder := Path("runs") / (name if number == 1 else f"{name}-{number}")) and not args.overwrite:
        number += 1
    return str(folder)


def _files_of_parts(args: argparse.Namespace) -> list[str]:
    """Return the files that have registered parts: those of --parts, and the case file if it has."""
    from parisph.base import vocabulary

    is_stored = str(args.case).endswith(".json")
    return [*args.parts, *([args.case] if vocabulary.outside() and not is_stored else [])]


def _register(files: Iterable[str]) -> None:
    """Run the Python files that register parts of methods. Not collective: each rank does it."""
    from parisph.case.load import register_parts

    for file in files:
        register_parts(file)


def _tell(comm: Communicator, summary: Mapping[str, Any], folder: str | Path) -> None:
    from parisph.io import info

    if comm.rank == 0:
        output.show("\n".join([*info.table(summary), f"{'folder':<16}{folder}", *info.last_words(summary)]))


def _study(args: argparse.Namespace) -> int:
    from parisph.study import report, study_file
    from parisph.study.definition import Study
    from parisph.study.plan import plan_study
    from parisph.study.run_study import run_study

    _register(args.parts)
    study, file = study_file.read(args.study)
    if not isinstance(study, Study):
        return _patch_study(args, study, file)
    plan = plan_study(study, file, args.set, args.only, args.out, args.limit, args.parts)
    if args.list:
        print(report.listing(plan))
        return 0
    libraries.require(*libraries.ENGINE)
    return run_study(plan, args.jobs, not args.quiet, args.force, output.show)


def _patch_study(args: argparse.Namespace, study: "PatchStudy", file: Path) -> int:
    for option, given in (("--set", args.set), ("--limit", args.limit is not None), ("-j", args.jobs > 1)):
        if given:
            raise CaseError(f"{option}: a patch study has no runs of a case, and takes seconds in this process; "
                            "leave it out")
    libraries.require(*libraries.ENGINE)
    from parisph.study import patch_report, study_folder
    from parisph.study.run_patch_study import run_patch_study

    folder = study_folder.choose(file, args.out)
    if args.list:
        print(patch_report.listing(study, args.only))
        return 0
    return run_patch_study(study, file, folder, args.only, not args.quiet, args.force, output.show)


def _info(args: argparse.Namespace) -> None:
    from parisph.io import info, reader

    run = reader.Run(args.run)
    if args.json:
        print(json.dumps(run.summary, indent=2))
        return
    print(info.describe(run))
    try:    # last, because the snapshots may be damaged
        if len(run):
            print(f"\n{info.provenance(run)}")
    finally:
        run.check()


def _plot(args: argparse.Namespace) -> None:
    from parisph.io import reader
    from parisph.pictures import orders

    if args.time is not None and args.peak is not None:
        raise CaseError("--time and --peak both select a snapshot: give only one of them")
    runs = [reader.open_run(folder) for folder in args.runs]
    for path in orders.plot(runs, args.time, args.peak, args.probe, args.out, **_look(args)):
        print(path)


def _movie(args: argparse.Namespace) -> None:
    from parisph.io import reader
    from parisph.pictures import orders

    print(orders.animate(reader.open_run(args.run), args.out, args.fps, args.slow, progress=True, **_look(args)))


def _look(args: argparse.Namespace) -> dict[str, Any]:
    """Return the options of pictures.view.Look, None for those not given."""
    return {"field": args.field, "surface": args.surface or None, "normalise": args.normalise or None,
            "limits": args.limits, "colours": args.cmap, "zoom": args.zoom, "frame": args.frame,
            "slice": args.slice, "view": args.view, "camera": args.camera}


def _report(args: argparse.Namespace) -> None:
    from parisph.report import gallery, page

    if args.into is not None and args.out is not None:
        raise CaseError("-o: with --into the pictures go beside the file; leave out one of the two")
    if args.into is not None:
        written = gallery.put_into(args.runs, args.into)
    elif args.all:
        written = gallery.write(args.runs, args.out or "gallery")
    elif args.out is not None and len(args.runs) > 1:
        raise CaseError("-o: several runs cannot have their pages in one folder; leave it out, or use --all")
    else:
        written = [page.write(folder, args.out) for folder in args.runs]
    for path in written:
        print(path)


def _compare(args: argparse.Namespace) -> None:
    from parisph.io import reader
    from parisph.truth import comparison

    names = ("probe", "column", "time", "value", "offset", "scale", "time_scale", "shift", "best_shift", "rest")
    run = reader.open_run(args.run)
    found = comparison.compare(run, args.reference, **{name: getattr(args, name) for name in names})
    if args.plot is not None:
        from parisph.pictures import orders

        orders.compare(run, found, args.reference, args.plot)
    print(json.dumps(found.result, indent=2) if args.json else comparison.text(found.result))


def _reflection(args: argparse.Namespace) -> None:
    from parisph.io import reader
    from parisph.truth import reflected

    run = reader.open_run(args.run)
    found = reflected.analysed(run.scene, run, args.probes, args.period, args.depth, args.start, args.end)
    print(json.dumps(found, indent=2) if args.json else reflected.text(found))


def _doctor(args: argparse.Namespace) -> int:
    from parisph import doctor

    if not args.trial:
        findings = doctor.examine()
        print(doctor.report(findings))
        return int(not all(finding.ok for finding in findings))
    comm = ranks.world()
    result = doctor.trial(comm)
    if comm.rank == 0:
        print(json.dumps(result))
    return 0


def _completion(args: argparse.Namespace) -> None:
    print(completion.script(parser.build(), args.shell))


# {verb: function of the arguments that returns the exit code, None for 0}
WORK: dict[str, Callable[[argparse.Namespace], int | None]] = {
    "run": _run, "restart": _restart, "check": _check, "study": _study, "info": _info, "plot": _plot, "movie": _movie,
    "report": _report, "compare": _compare, "reflection": _reflection, "doctor": _doctor, "completion": _completion}
