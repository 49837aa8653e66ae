"""Completion of `parisph` in a shell: verbs, options, case files, folders of runs. Needs shtab."""

import argparse
from collections.abc import Iterator

from parisph.base import libraries

SHELLS = ("bash", "zsh", "fish")


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Return the script that completes the command line of a parser in one of SHELLS. Raises MissingLibrary."""
    libraries.require("shtab")
    import shtab

    described = shtab.glob("*.py", "*.json")
    files = {"case": described, "study": described, "path": shtab.glob("*.h5"), "reference": shtab.glob("*.csv"),
             "DIR": shtab.DIRECTORY, "FILE": shtab.FILE}
    for action in _actions(parser):
        found = files.get(action.dest) or files.get(str(action.metavar))
        if found:
            setattr(action, "complete", found)    # read by shtab
    return shtab.complete(parser, shell=shell)


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield all arguments of a parser and of its verbs."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for verb in action.choices.values():
                yield from _actions(verb)
