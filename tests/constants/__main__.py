"""The tuned numbers of parisph: what they are, and what they do. Not part of the tests.

    python -m tests.constants list                    what the sources say
    nice python -m tests.constants study --part 1/2   halve and double the first half of them, beside a second process
    python -m tests.constants study shifting          those whose file or name contains a word
    python -m tests.constants page                    write parisph/methods/CONSTANTS.md

From the top folder of the clone. A study that was ended goes on: it appends to tests/constants/results.jsonl. Remove
this file first if the code computes something else than it did, since its base line is of the code of then.
"""

import argparse
import sys
from pathlib import Path

from parisph.base import environment

environment.prepare()

from tests.constants import page, sources, study  # noqa: E402


def main():
    """Do what is asked, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.constants", description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("list", "study", "page"))
    parser.add_argument("names", nargs="*", metavar="WORD", help="of the files or names of the numbers (default: all)")
    parser.add_argument("--part", default="1/1", metavar="K/N", help="the K-th of N parts (default: 1/1)")
    parser.add_argument("-o", "--out", type=Path, default=Path("runs/constants"), metavar="DIR",
                        help="folder for compiled kernels (default: runs/constants)")
    args = parser.parse_args()
    if args.what == "list":
        print("\n".join(f"{one.key:50} {one.value:<8g} {one.low:g} to {one.high:g}" for one in sources.listed()))
    elif args.what == "page":
        page.PAGE.write_text(page.text(), encoding="utf-8")
    else:
        study.study(*map(int, args.part.split("/")), args.names, args.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
