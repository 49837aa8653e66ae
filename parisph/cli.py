"""Parse a command line and execute its verb."""

import argparse
from collections.abc import Sequence

from parisph import arguments, parser, ranks, verbs
from parisph.base import environment
from parisph.base.errors import CaseError
from parisph.base.text import named


def parse(words: Sequence[str]) -> argparse.Namespace:
    """Return the namespace of a command line; `.verb` is a key of `verbs.WORK`.

    Raises CaseError with the usage. Words after a lone `--` are options for PETSc.
    """
    arguments.check(words)
    cut = words.index("--") if "--" in words else len(words)
    ours, petsc = list(words[:cut]), list(words[cut + 1:])
    args, unknown = parser.build().parse_known_args(ours)
    if getattr(args, "set", None):    # --set a=1 b=2 is --set a=1 --set b=2
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


def _hint(word: str) -> str:
    """Return a hint, as the end of a message, if an unknown word is an option for PETSc; else ""."""
    if word.startswith("-log"):
        return f"; {_early(word)}"
    return "; options for PETSc come after a lone --" if word.startswith(("-pressure_", "-ksp", "-pc")) else ""


def _check_petsc(words: Sequence[str]) -> None:
    """Raise CaseError for words after the lone -- that have no effect there."""
    for word in words:
        if word.startswith("--") or word in ("-o", "-q", "-h"):
            raise CaseError(f"{named(word, 80)} is after the lone --, where only options for PETSc are allowed, "
                            f"such as -pressure_ksp_rtol: write {named(word, 80)} and its value before the --")
        if word.startswith("-log_view"):
            raise CaseError(f"{named(word, 80)} after the lone -- comes too late, because PETSc has started by then: "
                            f"{_early(word)}")


def _early(word: str) -> str:
    return f"set PETSC_OPTIONS={named(word, 80)} before the command"


def execute(words: Sequence[str]) -> int:
    """Execute a command line; return the exit code. Collective for run, restart, doctor --trial.

    Raises ParisphError on every rank.
    """
    args = ranks.everywhere(lambda: parse(words))
    if not getattr(args, "collective", False) and not getattr(args, "trial", False):
        ranks.everywhere(lambda: _alone(args.verb))
    return verbs.WORK[args.verb](args) or 0


def _alone(verb: str) -> None:
    if environment.launched()[1] > 1:
        raise CaseError(f"parisph {verb} runs in one process: start it without mpirun")
