"""Checks of single words of the command line."""

import argparse
import math
from collections.abc import Iterable

from parisph.base import paths
from parisph.base.errors import CaseError
from parisph.base.text import is_plain, shown

LARGEST = 1e30    # as in a case: its square is finite


def check(words: Iterable[str]) -> None:
    """Raise CaseError for a word with line breaks or control characters, or that is not UTF-8."""
    for word in words:
        if not is_plain(word):
            raise CaseError(f"argument {shown(word)}: must be text without line breaks or control characters")


def path(word: str) -> str:
    """Return a word, which can be a path. For argparse, which adds the name of the argument to errors."""
    problem = paths.fault(word)
    if problem:
        raise argparse.ArgumentTypeError(f"{shown(word)}: {problem}")
    return word


def number(word: str) -> float:
    """Return a finite number of limited size. For argparse, as `path`."""
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not abs(value) <= LARGEST:
        raise argparse.ArgumentTypeError(f"{shown(word)}: must be a finite number of at most {LARGEST:g} in size")
    return value


def count(word: str) -> int:
    """Return a whole number of at least 1. For argparse, as `path`."""
    if not word.isdecimal() or not 1 <= int(word[:9]) or len(word) > 6:
        raise argparse.ArgumentTypeError(f"{shown(word)}: must be a whole number of at least 1")
    return int(word)
