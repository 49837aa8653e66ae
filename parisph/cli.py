"""The command line: verbs and their options. Other modules do the work."""

import argparse
import json
import os
import signal
from collections.abc import Sequence
from pathlib import Path

from parisph import __version__, arguments, completion
from parisph.base import environment, libraries, output
from parisph.base.errors import CaseError, Interrupted, ParisphError, agree
from parisph.base.signals import Signals
from parisph.base.text import clipped, named, plain

FORCE = "Use DIR although run.lock names a process on another host or in another container, which may still write to it"
EXIT_CODES = "Exit codes: 0 done, 2 bad case or usage, 3 diverged, 4 interrupted, 5 file error, 1 other errors."


class _Parser(argparse.ArgumentParser):
    """Raises CaseError where argparse would exit, and prints on rank 0 only."""

    def __init__(self, **options):
        super().__init__(add_help=False, **options)
        self.add_argument("-h", "--help", action="help", help="Show this help and exit")

    def error(self, message):
        raise CaseError(f"{clipped(plain(message), 300)}\n{self.format_usage().strip()}")

    def _print_message(self, message, file=None):
        if environment.launched()[0] == 0:
            super()._print_message(message, file)


def parse(words: Sequence[str]) -> argparse.Namespace:
    """Return the namespace of a command line; `.work` is the function that does it.

    Raises CaseError with the usage. Words after a lone `--` are options for PETSc.
    """
    arguments.check(words)
    cut = words.index("--") if "--" in words else len(words)
    ours, petsc = list(words[:cut]), list(words[cut + 1:])
    args, unknown = _parser().parse_known_args(ours)
    if getattr(args, "set", None):    # --set a=1 b=2 means what --set a=1 --set b=2 does
        more = [word for word in unknown if "=" in word and not word.startswith("-")]
        args.set += more
        unknown = [word for word in unknown if word not in more]
    if unknown:
        raise CaseError(f"unknown argument {named(unknown[0])}{_hint(unknown[0])} (parisph {args.verb} -h lists "
                        "the arguments)")
    if petsc and not hasattr(args, "petsc"):
        raise CaseError(f"parisph {args.verb} takes no options for PETSc")
    _check_petsc(petsc)
    args.petsc = petsc
    return args


def _hint(word):
    """Return a hint if an unknown word is an option for PETSc, as the end of a message; else nothing."""
    if word.startswith("-log"):
        return f"; {_early(word)}"
    return "; options for PETSc come after a lone --" if word.startswith(("-pressure_", "-ksp", "-pc")) else ""


def _check_petsc(words):
    """Raise CaseError for words after the lone -- that would have no effect there."""
    for word in words:
        if word.startswith("--") or word in ("-o", "-q", "-h"):
            raise CaseError(f"{named(word, 80)} is after the lone --, where only options for PETSc are allowed, "
                            f"such as -pressure_ksp_rtol: write {named(word, 80)} and its value before the --")
        if word.startswith("-log_view"):
            raise CaseError(f"{named(word, 80)} after the lone -- comes too late, because PETSc has started by then: "
                            f"{_early(word)}")


def _early(word):
    return f"set PETSC_OPTIONS={named(word, 80)} before the command"


def execute(words: Sequence[str]) -> int:
    """Execute a command line; return the exit code. Collective for run, restart, doctor --trial.

    Raises ParisphError on every rank.
    """
    args = _everywhere(lambda: parse(words))
    if not getattr(args, "collective", False) and not getattr(args, "trial", False):
        _everywhere(lambda: _alone(args.verb))
    return args.work(args) or 0


def _alone(verb):
    if environment.launched()[1] > 1:
        raise CaseError(f"parisph {verb} runs in one process: start it without mpirun")


def _everywhere(action):
    """Return action(), done by each rank separately. An error on one rank is raised on all.

    Without mpirun this needs no MPI.
    """
    if environment.launched()[1] == 1:
        return action()
    result, error = None, None
    try:
        result = action()
    except ParisphError as problem:
        error = problem
    _agree(error)
    return result


def _on_first(action):
    """Call action() on rank 0 only, and return its result on every rank. Errors as in `_everywhere`."""
    if environment.launched()[1] == 1:
        return action()
    comm, result, error = _world(), None, None
    if comm.rank == 0:
        try:
            result = action()
        except ParisphError as problem:
            error = problem
    comm.Barrier()    # a rank that waits here can be stopped by signals; in the sums of `agree` it cannot
    _agree(error)
    return comm.bcast(result)


def _stop_if_asked():
    """Raise Interrupted, on every rank, if any has got a signal to stop: nothing has begun yet."""
    seen = Signals.active().seen
    error = Interrupted(f"stopped by {signal.Signals(seen).name} before the run has begun") if seen else None
    if environment.launched()[1] > 1:
        _agree(error)
    elif error is not None:
        raise error


def _agree(error):
    """Raise on every rank if any has an error; a rank with an error raises its own, without "rank 0:" in front."""
    try:
        agree(_world(), error)
    except ParisphError:
        if error is not None:
            raise error from None
        raise


def _world():
    """Return the communicator of all ranks.

    Raises MissingLibrary where there is no MPI or PETSc, and ParisphError where a launcher has
    started several ranks and MPI sees one: each would run the whole case, all into the same folder.
    """
    libraries.require(*libraries.ENGINE)
    from mpi4py import MPI

    launched = environment.launched()[1]
    if launched != MPI.COMM_WORLD.size == 1:
        raise ParisphError(
            f"{launched} processes were launched, but the MPI library of mpi4py sees one. mpirun and mpi4py "
            "belong to different MPI libraries: see parisph doctor")
    Signals.active().over(MPI.COMM_WORLD)
    return MPI.COMM_WORLD


def _parser():
    parser = _Parser(prog="parisph",
                     description="Compute violent water waves by incompressible SPH, on any number of MPI ranks.",
                     epilog=EXIT_CODES, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"parisph {__version__}",
                        help="Show the version and exit")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    _add_running(verbs)
    _add_looking(verbs)
    verb = _verb(verbs, "doctor", _doctor, "Check whether parisph can run on this machine")
    verb.add_argument("--trial", action="store_true",
                      help="Only solve a small system and write a file, on the ranks of this command (mpirun -n 4 "
                           "parisph doctor --trial)")
    verb = _verb(verbs, "completion", _completion, "Print the script that completes commands in a shell")
    verb.add_argument("shell", choices=completion.SHELLS, metavar="SHELL",
                      help=f"One of {', '.join(completion.SHELLS)}")
    return parser


def _verb(verbs, name, work, text, example=""):
    verb = verbs.add_parser(name, help=text, description=f"{text}{example and ': '}{example or '.'}", epilog=EXIT_CODES)
    verb.set_defaults(work=work)
    verb.add_argument("--debug", action="store_true", help="Show the traceback of an error")
    return verb


def _add_running(verbs):
    verb = _verb(verbs, "run", _run, "Run a case on any number of ranks",
                 "mpirun -n 2 parisph run CASE [options] [-- PETSc options]")
    _add_case(verb)
    verb.add_argument("-o", "--out", type=arguments.path, metavar="DIR",
                      help="Write the run to this folder (default: runs/NAME, named after the case, "
                           "or the first free runs/NAME-2, ...)")
    verb.add_argument("--overwrite", action="store_true",
                      help="If DIR holds a run, move it to DIR.old, DIR.old-2, ... first")
    _add_progress(verb)
    verb = _verb(verbs, "restart", _restart, "Continue a run from a checkpoint, on any number of ranks",
                 "mpirun -n 2 parisph restart DIR [options] [-- PETSc options]")
    verb.add_argument("path", type=arguments.path, metavar="DIR", help="Folder of a run, or a checkpoint file in it")
    _add_parts(verb)
    verb.add_argument("--until", type=arguments.number, metavar="T", help="Set a new end time [s]")
    verb.add_argument("-o", "--out", type=arguments.path, metavar="DIR",
                      help="Write to this folder (default: that of the run, only from its last checkpoint)")
    _add_progress(verb)
    verb = _verb(verbs, "check", _check, "Check a case, and estimate the time and memory of a run")
    _add_case(verb)
    verb.add_argument("--plot", type=arguments.path, metavar="FILE",
                      help="Draw the scene at the start to this file, with the names of walls and probes")
    _add_study(verbs)


def _add_study(verbs):
    verb = _verb(verbs, "study", _study, "Make many runs of a case, and compare their errors and costs",
                 "parisph study FILE [options]. A repeated command makes only the runs that are not done. "
                 "Exit code 1: a run failed, or something that the study requires is not met")
    verb.add_argument("study", type=arguments.path, metavar="FILE",
                      help="Python file with study = Study(...) or PatchStudy(...), or JSON file with its fields")
    _add_parts(verb)
    verb.add_argument("-l", "--list", action="store_true", help="Only list the runs, with their estimated costs")
    verb.add_argument("--only", action="append", default=[], metavar="METHOD",
                      help="Make only the runs of this method or label, or the tests of this operator "
                           "(may be repeated)")
    verb.add_argument("--set", action="append", default=[], metavar="NAME=VALUE",
                      help="Set parameters of all runs, such as --set end_time=2 numerics.gamma=0.01")
    verb.add_argument("-j", "--jobs", type=arguments.count, default=1, metavar="J",
                      help="Make J runs at once (default: 1)")
    verb.add_argument("--limit", type=arguments.number, metavar="S", help="End each run after S seconds on the clock")
    verb.add_argument("-o", "--out", type=arguments.path, metavar="DIR",
                      help="Write the study to this folder (default: studies/NAME, named after FILE)")
    verb.add_argument("-q", "--quiet", action="store_true", help="Do not show progress")
    verb.add_argument("--force", action="store_true", help=FORCE)


def _add_case(verb):
    verb.add_argument("case", type=arguments.path, metavar="CASE",
                      help="Python file with a function case(...), or the case.json of a run")
    verb.add_argument("--set", action="append", default=[], metavar="NAME=VALUE",
                      help="Set parameters of case(...), such as --set spacing=1/40 end_time=2")
    _add_parts(verb)


def _add_parts(verb):
    verb.add_argument("--parts", action="append", default=[], type=arguments.path, metavar="FILE",
                      help="Run a Python file first that registers parts of methods (may be repeated)")


def _add_progress(verb):
    verb.add_argument("-q", "--quiet", action="store_true", help="Do not show progress")
    verb.add_argument("--force", action="store_true", help=FORCE)
    verb.set_defaults(petsc=[], collective=True)


def _add_looking(verbs):
    verb = _verb(verbs, "info", _info,
                 "Show the content, the results and the versions of a run, and check its snapshots")
    _add_run(verb)
    verb.add_argument("--json", action="store_true", help="Print summary.json instead")
    verb = _verb(verbs, "plot", _plot, "Draw the flow, the probes, or the whole run on one page")
    verb.add_argument("runs", type=arguments.path, metavar="DIR", nargs="+",
                      help="Folder of a run; for several runs, their probes are drawn over each other")
    verb.add_argument("--time", type=arguments.number, metavar="T",
                      help="Draw the flow at the snapshot nearest this time [s]")
    verb.add_argument("--peak", metavar="PROBE",
                      help="Draw the flow at the greatest value of a probe: "
                           "the step itself if the probe has peak=True, else the nearest snapshot")
    verb.add_argument("--probe", action="append", metavar="NAME",
                      help="Draw the series of this probe (may be repeated)")
    _add_drawing(verb, "up to the greatest value shown; on a page with several moments, most of the values")
    verb = _verb(verbs, "movie", _movie, "Make an animation of the flow; its title gives the slow-motion factor")
    _add_run(verb)
    verb.add_argument("--fps", type=arguments.number, metavar="N",
                      help="Show N frames per second (default: 20; with --slow, "
                           "the rate that shows each snapshot once)")
    verb.add_argument("--slow", type=arguments.number, metavar="X",
                      help="Play X times slower than in nature (default: the speed that shows each snapshot once)")
    _add_drawing(verb, "one scale for all frames, for most of their values; a short impact may exceed it")
    verb = _verb(verbs, "report", _report, "Write a page that shows a run beside its references",
                 "parisph report DIR. What was run, errors without any shift of time, pictures, cost and drift in one "
                 "HTML file, with the pictures as PNG beside it")
    verb.add_argument("runs", type=arguments.path, metavar="DIR", nargs="+",
                      help="Folder of a run; with --all also a folder that holds runs")
    verb.add_argument("--all", action="store_true",
                      help="Write one gallery of all runs instead, as HTML and as Markdown")
    verb.add_argument("--into", type=arguments.path, metavar="FILE",
                      help="Put the gallery of all runs into this Markdown file, between its two marks, "
                           "with the pictures in the folder pictures beside it")
    verb.add_argument("-o", "--out", type=arguments.path, metavar="DIR",
                      help="Write to this folder (default: that of the run; with --all: gallery)")
    verb = _verb(verbs, "compare", _compare, "Compute the error of a probe against a reference series")
    _add_run(verb)
    verb.add_argument("reference", type=arguments.path, metavar="REFERENCE.csv", help="CSV file with one header line")
    verb.add_argument("--json", action="store_true", help="Print JSON")
    verb.add_argument("--plot", type=arguments.path, metavar="FILE",
                      help="Draw the run, the reference and their difference to a .png, .pdf, ... file")
    for option, text in (("--probe", "Choose a probe, if there are several"), ("--column", "Choose one of its columns"),
                         ("--time", "Choose the reference's column of times (default: the first)"),
                         ("--value", "Choose the reference's column of values (default: "
                                     "the one named like the probe's, else the first after the time)")):
        verb.add_argument(option, metavar="NAME", help=text)
    for option, default, text in (
            ("--offset", 0.0, "Compare with offset + scale * value"), ("--scale", 1.0, "See --offset"),
            ("--time-scale", 1.0, "Set the unit of the reference's time [s]"),
            ("--shift", 0.0, "Add this to the run's time [s]"),
            ("--best-shift", None, "Find the best shift of at most this many seconds in either direction"),
            ("--rest", None, "Set the level at rest: the error is then relative to the wave alone")):
        verb.add_argument(option, type=arguments.number, default=default, metavar="X", help=text)


def _add_run(verb):
    verb.add_argument("run", type=arguments.path, metavar="DIR", help="Folder of a run")


def _add_drawing(verb, scale):
    verb.add_argument("--field", metavar="NAME",
                      help="Colour by pressure (default), speed, velocity_x, velocity_y, density_ratio or role")
    verb.add_argument("--surface", action="store_true", help="Mark the particles of the free surface")
    verb.add_argument("--normalise", action="store_true",
                      help="Divide lengths by H, times by sqrt(H/g), pressures by rho g H (flow or probes, "
                           "not the whole run)")
    verb.add_argument("--limits", type=arguments.number, nargs=2, metavar=("LOW", "HIGH"),
                      help=f"Set the ends of the colour scale, in the unit of the picture (default: {scale})")
    verb.add_argument("--cmap", metavar="NAME", help="Use this colour map of matplotlib, such as magma")
    verb.add_argument("--zoom", type=arguments.number, nargs=4, metavar=("X0", "X1", "Y0", "Y1"),
                      help="Draw only this part of the scene, in the unit of the axes")
    verb.add_argument("-o", "--out", type=arguments.path, metavar="FILE",
                      help="Write to this file (default: in the folder of the run): .png, .pdf, ...; "
                           "a movie: .gif or .mp4")


# ---- the verbs

def _run(args):
    if environment.launched()[1] > 1:
        _world()
        from parisph.driver import run  # noqa: F401  starts PETSc, on all ranks together: the case file may import it on one
    text, out, parts = _on_first(lambda: (_load(args).model_dump_json(), _folder(args), _files_of_parts(args)))
    _stop_if_asked()
    comm = _world()
    from parisph import driver
    from parisph.case.schema import Case

    if comm.rank:
        _register(parts)
    case = Case.model_validate_json(text)    # that of rank 0: a case file may depend on host, clock or rank
    summary = driver.run(case, comm, out, petsc_options=args.petsc, progress=not args.quiet, overwrite=args.overwrite,
                         force=args.force)
    _tell(comm, summary, out)


def _files_of_parts(args):
    """Return the files that have registered parts from outside: those of --parts, and the case file if it has."""
    from parisph.base import vocabulary

    is_stored = str(args.case).endswith(".json")
    return [*args.parts, *([args.case] if vocabulary.outside() and not is_stored else [])]


def _register(files):
    """Run the Python files that register parts of methods. Not collective: each rank does it."""
    from parisph.case.load import register_parts

    for file in files:
        register_parts(file)


def _restart(args):
    comm = _world()
    _everywhere(lambda: _register(args.parts))
    from parisph import driver
    from parisph.io.layout import run_of

    summary = driver.restart(args.path, comm, until=args.until, out=args.out, petsc_options=args.petsc,
                             progress=not args.quiet, force=args.force)
    _tell(comm, summary, args.out or run_of(args.path))


def _check(args):
    case = _load(args)
    from parisph import driver
    from parisph.case.load import arguments

    print(driver.describe(case, arguments(args.case, args.set)))
    if args.plot is not None:
        from parisph.pictures.bodies_view import plot_scene

        plot_scene(case, args.plot)
        print(args.plot)


def _study(args):
    from parisph.study import study_file
    from parisph.study.agenda import listing, of_study
    from parisph.study.carry_out import carry_out
    from parisph.study.definition import Study

    _register(args.parts)
    study, file = study_file.read(args.study)
    if not isinstance(study, Study):
        return _patch_study(args, study, file)
    plan = of_study(study, file, args.set, args.only, args.out, args.limit, args.parts)
    if args.list:
        print(listing(plan))
        return 0
    libraries.require(*libraries.ENGINE)
    return carry_out(plan, args.jobs, not args.quiet, args.force, output.show)


def _patch_study(args, study, file):
    for option, given in (("--set", args.set), ("--limit", args.limit is not None), ("-j", args.jobs > 1)):
        if given:
            raise CaseError(f"{option}: a patch study has no runs of a case, and takes seconds in this process; "
                            "leave it out")
    libraries.require(*libraries.ENGINE)
    from parisph.study import patch_report
    from parisph.study.agenda import folder_for
    from parisph.study.patch_carry_out import carry_out

    folder = folder_for(file, args.out)
    if args.list:
        print(patch_report.listing(study, args.only))
        return 0
    return carry_out(study, file, folder, args.only, not args.quiet, args.force, output.show)


def _doctor(args):
    from parisph import doctor

    if not args.trial:
        findings = doctor.examine()
        print(doctor.report(findings))
        return int(not all(finding.ok for finding in findings))
    comm = _world()
    result = doctor.trial(comm)
    if comm.rank == 0:
        print(json.dumps(result))
    return 0


def _completion(args):
    print(completion.script(_parser(), args.shell))


def _load(args):
    from parisph.case.load import load

    _register(args.parts)
    return load(args.case, args.set)


def _folder(args):
    """Return the folder for a new run, never one that holds a run already (unless asked to overwrite)."""
    if args.out is not None:
        if os.path.exists(Path(args.out) / "case.json") and not args.overwrite:
            raise CaseError(f"{args.out} holds a run already: give another folder with -o, "
                            "or move the whole folder aside with --overwrite")
        return args.out
    case = Path(args.case)
    name = case.resolve().parent.name if case.name == "case.json" else case.stem
    number = 1
    while os.path.exists(folder := Path("runs") / (name if number == 1 else f"{name}-{number}")) and not args.overwrite:
        number += 1
    return str(folder)


def _tell(comm, summary, folder):
    from parisph.io import info

    if comm.rank == 0:
        output.show("\n".join([*info.table(summary), f"{'folder':<16}{folder}"]))


def _info(args):
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


def _compare(args):
    from parisph.io import reader
    from parisph.truth import comparison

    names = ("probe", "column", "time", "value", "offset", "scale", "time_scale", "shift", "best_shift", "rest")
    run = reader.open_run(args.run)
    found = comparison.compare(run, args.reference, **{name: getattr(args, name) for name in names})
    if args.plot is not None:
        from parisph.pictures import orders

        orders.compare(run, found, args.reference, args.plot)
    print(json.dumps(found.result, indent=2) if args.json else comparison.text(found.result))


def _report(args):
    from parisph.report import gallery, page

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


def _plot(args):
    from parisph.io import reader
    from parisph.pictures import orders

    if args.time is not None and args.peak is not None:
        raise CaseError("--time and --peak both select a snapshot: give only one of them")
    runs = [reader.open_run(folder) for folder in args.runs]
    for path in orders.plot(runs, args.time, args.peak, args.probe, args.out, **_look(args)):
        print(path)


def _movie(args):
    from parisph.io import reader
    from parisph.pictures import orders

    print(orders.animate(reader.open_run(args.run), args.out, args.fps, args.slow, **_look(args)))


def _look(args):
    """Return the options of io.view.Look; None for those not given."""
    return {"field": args.field, "surface": args.surface or None, "normalise": args.normalise or None,
            "limits": args.limits, "colours": args.cmap, "zoom": args.zoom}
