"""The verbs of the command line, their options and their help texts."""

import argparse
import re
from typing import Any, NoReturn, TypeAlias

from parisph import __version__, arguments, completion
from parisph.base import environment
from parisph.base.errors import CaseError
from parisph.base.text import clipped, plain

FORCE = "Use DIR although run.lock names a process on another host or in another container, which may still write to it"
QUIET = "Show no progress, also of the compilation of kernels; warnings are still shown"
EXIT_CODES = "Exit codes: 0 done, 2 bad case or usage, 3 diverged, 4 interrupted, 5 file error, 1 other errors."


Verbs: TypeAlias = "argparse._SubParsersAction[_Parser]"


class _Parser(argparse.ArgumentParser):
    """Raises CaseError where argparse would exit, and prints on rank 0 only."""

    def __init__(self, **options: Any) -> None:
        super().__init__(add_help=False, **options)
        self._negative_number_matcher = re.compile(r"-\.?\d")    # argparse's has no exponent, nor -1/40
        self.add_argument("-h", "--help", action="help", help="Show this help and exit")

    def error(self, message: str) -> NoReturn:
        raise CaseError(f"{clipped(plain(message), 300)}\n{self.format_usage().strip()}")

    def _print_message(self, message: str, file: Any = None) -> None:
        if environment.is_first():
            super()._print_message(message, file)


def build() -> argparse.ArgumentParser:
    """Return the parser of the command line. It stores the verb as `verb`, and raises CaseError with the usage."""
    parser = _Parser(prog="parisph",
                     description="Compute violent water waves by incompressible SPH, on any number of MPI ranks.",
                     epilog=EXIT_CODES, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"parisph {__version__}",
                        help="Show the version and exit")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    for define in (_run, _restart, _check, _study, _info, _plot, _movie, _report, _compare, _reflection, _doctor,
                   _completion):
        define(verbs)    # in the order of the help
    return parser


def _verb(verbs: Verbs, name: str, text: str, example: str = "") -> argparse.ArgumentParser:
    verb = verbs.add_parser(name, help=text, description=f"{text}{example and ': '}{example or '.'}", epilog=EXIT_CODES)
    verb.add_argument("--debug", action="store_true", help="Show the traceback of an error")
    return verb


def _run(verbs: Verbs) -> None:
    verb = _verb(verbs, "run", "Run a case on any number of ranks",
                 "mpirun -n 2 parisph run CASE [options] [-- PETSc options]")
    _add_case(verb)
    verb.add_argument("-o", "--out", type=arguments.path, metavar="DIR",
                      help="Write the run to this folder (default: runs/NAME, named after the case, "
                           "or the first free runs/NAME-2, ...)")
    verb.add_argument("--overwrite", action="store_true",
                      help="If DIR holds a run, move it to DIR.old, DIR.old-2, ... first")
    _add_progress(verb, petsc=[], collective=True)


def _restart(verbs: Verbs) -> None:
    verb = _verb(verbs, "restart", "Continue a run from a checkpoint, on any number of ranks",
                 "mpirun -n 2 parisph restart DIR [options] [-- PETSc options]")
    verb.add_argument("path", type=arguments.path, metavar="DIR", help="Folder of a run, or a checkpoint file in it")
    _add_parts(verb)
    verb.add_argument("--until", type=arguments.number, metavar="T", help="Set a new end time [s]")
    verb.add_argument("-o", "--out", type=arguments.path, metavar="DIR",
                      help="Write to this folder (default: that of the run, only from its last checkpoint)")
    _add_progress(verb, petsc=[], collective=True)


def _check(verbs: Verbs) -> None:
    verb = _verb(verbs, "check", "Check a case, and estimate the time and memory of a run")
    _add_case(verb)
    verb.add_argument("--plot", type=arguments.path, metavar="FILE",
                      help="Draw the scene at the start to this file, with the names of walls and probes")


def _study(verbs: Verbs) -> None:
    verb = _verb(verbs, "study", "Make many runs of a case, and compare their errors and costs",
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
    verb.add_argument("--limit", type=arguments.number, metavar="S", help="End each run after S seconds of wall time")
    verb.add_argument("-o", "--out", type=arguments.path, metavar="DIR",
                      help="Write the study to this folder (default: studies/NAME, named after FILE)")
    _add_progress(verb)


def _info(verbs: Verbs) -> None:
    verb = _verb(verbs, "info", "Show the content, the results and the versions of a run, and check its snapshots")
    _add_run(verb)
    verb.add_argument("--json", action="store_true", help="Print summary.json instead")


def _plot(verbs: Verbs) -> None:
    verb = _verb(verbs, "plot", "Draw the flow, the probes, or the whole run on one page")
    verb.add_argument("runs", type=arguments.path, metavar="DIR", nargs="+",
                      help="Folder of a run; for several runs, their probes are drawn over each other, "
                           "named by what differs between their cases")
    verb.add_argument("--time", type=arguments.number, metavar="T",
                      help="Draw the flow at the snapshot nearest this time [s]")
    verb.add_argument("--peak", metavar="PROBE",
                      help="Draw the flow at the greatest value of a probe: "
                           "the step itself if the probe has peak=True, else the nearest snapshot")
    verb.add_argument("--probe", action="append", metavar="NAME",
                      help="Draw the series of this probe (may be repeated)")
    _add_drawing(verb, "up to the greatest value shown; on a page with several moments, most of the values")


def _movie(verbs: Verbs) -> None:
    verb = _verb(verbs, "movie", "Make an animation of the flow; its title gives the slow-motion factor")
    _add_run(verb)
    verb.add_argument("--fps", type=arguments.number, metavar="N",
                      help="Show N frames per second (default: 20; with --slow, "
                           "the rate that shows each snapshot once)")
    verb.add_argument("--slow", type=arguments.number, metavar="X",
                      help="Play X times slower than in nature (default: the speed that shows each snapshot once)")
    _add_drawing(verb, "one scale for all frames, for most of their values; a short impact may exceed it")


def _report(verbs: Verbs) -> None:
    verb = _verb(verbs, "report", "Write a page that shows a run beside its references",
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


def _compare(verbs: Verbs) -> None:
    verb = _verb(verbs, "compare", "Compute the error of a probe against a reference series")
    _add_run(verb)
    verb.add_argument("reference", type=arguments.path, metavar="REFERENCE.csv",
                      help="Text file with one header line; commas, semicolons, tabs or blanks between columns")
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


def _reflection(verbs: Verbs) -> None:
    verb = _verb(verbs, "reflection", "Tell incident and reflected waves apart by two gauges or more",
                 "parisph reflection DIR --probes g1 g2 g3. Heights, reflection coefficient and residual by least "
                 "squares, for irregular waves by frequency")
    _add_run(verb)
    verb.add_argument("--probes", nargs="+", metavar="NAME",
                      help="SurfaceGauges in line over a level bed, GAUGES.NAME in an array (default: the two or three "
                           "within 0.75 wave lengths that tell the waves apart best)")
    for option, name, text in (
            ("--period", "period", "Set the period of regular waves [s] (default: that of the wavemaker)"),
            ("--depth", "depth", "Set the depth of the water at the gauges [m] (default: that of the wavemaker)"),
            ("--from", "start", "Look at times from this one on [s] (default: the last ten whole periods; all "
                                "irregular waves after their arrival)"),
            ("--to", "end", "Look at times up to this one [s]")):
        verb.add_argument(option, dest=name, type=arguments.number, metavar="X", help=text)
    verb.add_argument("--json", action="store_true", help="Print JSON")


def _doctor(verbs: Verbs) -> None:
    verb = _verb(verbs, "doctor", "Check whether parisph can run on this machine")
    verb.add_argument("--trial", action="store_true",
                      help="Only solve a small system and write a file, on the ranks of this command (mpirun -n 4 "
                           "parisph doctor --trial)")


def _completion(verbs: Verbs) -> None:
    verb = _verb(verbs, "completion", "Print the script that completes commands in a shell")
    verb.add_argument("shell", choices=completion.SHELLS, metavar="SHELL",
                      help=f"One of {', '.join(completion.SHELLS)}")


def _add_case(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("case", type=arguments.path, metavar="CASE",
                      help="Python file with a function case(...), or the case.json of a run")
    verb.add_argument("--set", action="append", default=[], metavar="NAME=VALUE",
                      help="Set parameters of case(...), such as --set spacing=1/40 end_time=2")
    _add_parts(verb)


def _add_parts(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("--parts", action="append", default=[], type=arguments.path, metavar="FILE",
                      help="Run a Python file first that registers parts of methods (may be repeated)")


def _add_progress(verb: argparse.ArgumentParser, **defaults: Any) -> None:
    verb.add_argument("-q", "--quiet", action="store_true", help=QUIET)
    verb.add_argument("--force", action="store_true", help=FORCE)
    verb.set_defaults(**defaults)


def _add_run(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("run", type=arguments.path, metavar="DIR", help="Folder of a run")


def _add_drawing(verb: argparse.ArgumentParser, scale: str) -> None:
    verb.add_argument("--field", metavar="NAME",
                      help="Colour by pressure (default), speed, velocity_x, velocity_y, velocity_z (3D), "
                           "density_ratio or role")
    verb.add_argument("--frame", choices=("tank", "world"),
                      help="Show a tank that moves from itself (tank, the default), or from the room, with gravity "
                           "downwards (world)")
    verb.add_argument("--slice", metavar="AXIS=PLACE",
                      help="Of a 3D flow, show the particles within half a spacing of this plane, such as y=0.47 [m] "
                           "(default: the middle of the breadth)")
    verb.add_argument("--view", choices=("slice", "3d"),
                      help="Show a slice of a 3D flow (slice, the default), or render the water, the walls and the "
                           "pressure on bodies from outside (3d)")
    verb.add_argument("--camera", type=arguments.number, nargs=2, metavar=("AZIMUTH", "ELEVATION"),
                      help="With --view 3d, look from these angles [degrees]; 0 0 is from the front, along y")
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
