"""The jobs of a suite, each in a process of its own, so that nothing that becomes of one ends the others.

    python -m tests.apart JOB OUT.json

computes a pickled job, which writes its outcome to OUT.json unless the process dies.
"""

import pickle
import subprocess
import sys
import tempfile
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Protocol

from parisph.base import environment

environment.prepare()

from tests.hard import table  # noqa: E402
from tests.launch import ROOT, run  # noqa: E402


class Job(Protocol):
    """What a suite computes. name, seed : of its outcome; what : a few words; limit : wall time [s]"""

    name: str
    seed: int
    what: str
    limit: float

    def outcome(self) -> table.Outcome:
        """Compute it."""


def parser_of(prog: str, doc: str, words: str, at_once: int) -> ArgumentParser:
    """Return a parser with the options that all suites have. words : help of the names; at_once : default of --jobs"""
    parser = ArgumentParser(prog=prog, description=doc.partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{words} (default: all)")
    parser.add_argument("--quick", action="store_true", help="the quick selection")
    parser.add_argument("--list", action="store_true", help="show the names and run nothing")
    parser.add_argument("-j", "--jobs", type=int, default=at_once, metavar="N",
                        help=f"processes at the same time (default: {at_once})")
    parser.add_argument("-o", "--out", metavar="DIR", help="folder for results.json (default: nothing is kept)")
    return parser


def chosen(words: Iterable[str], among: Sequence[str]) -> list[str]:
    """Return the names that words are, or are the beginnings of up to a hyphen; all for no words.

    Raises ValueError: a word names none.
    """
    fits = {word: {name for name in among if f"{name}-".startswith(f"{word}-")} for word in words}
    for word in fits:
        if not fits[word]:
            raise ValueError(f"no {word} among {', '.join(among)}")
    return [name for name in among if not fits or any(name in some for some in fits.values())]


def outcomes_of(jobs: Sequence[Job], args: Namespace, order: Sequence[str] = ()) -> list[table.Outcome]:
    """Return the outcomes of all jobs in their order.

    results.json grows with each. What was computed earlier and not now stays in it. order : of names in this file
    """
    done, earlier, kept = [], [], Path(args.out) / "results.json" if args.out else None
    if kept:
        kept.parent.mkdir(parents=True, exist_ok=True)
        now = {(job.name, job.seed) for job in jobs}
        earlier = table.load(kept) if kept.exists() else []
        earlier = [found for found in earlier if (found.scene, found.seed) not in now]
    place = {name: number for number, name in enumerate(order)}
    with ThreadPoolExecutor(max(1, args.jobs)) as pool:
        for job, outcome in zip(jobs, pool.map(apart, jobs)):
            print(f"{job.name}, start {job.seed}: {job.what}: {outcome.ended}, {outcome.steps} steps, "
                  f"{outcome.cpu_seconds:.1f} CPU s{'' if outcome.met else ' - NO'}", flush=True)
            done.append(outcome)
            if kept:    # a name that there is no more comes last
                table.save(sorted(earlier + done, key=lambda one: (place.get(one.scene, len(place)), one.seed)), kept)
    return done


def apart(job: Job) -> table.Outcome:
    """Compute a job in its own process and return its Outcome, whatever becomes of the process."""
    with tempfile.TemporaryDirectory(prefix="parisph-apart-") as folder:
        asked, out = Path(folder) / "job", Path(folder) / "outcome.json"
        asked.write_bytes(pickle.dumps(job))
        try:
            process = run([sys.executable, "-m", "tests.apart", asked, out], timeout=job.limit, cwd=ROOT)
        except subprocess.TimeoutExpired:
            return table.Outcome(job.name, f"failed: not finished after {job.limit:g} s", seed=job.seed)
        died = table.Outcome(job.name, f"failed: exit code {process.returncode}", seed=job.seed)
        outcome = table.load(out)[0] if out.exists() else died
    if not outcome.ended_well and process.stderr.strip():
        print(process.stderr, file=sys.stderr, flush=True)
    return outcome


if __name__ == "__main__":
    table.save([pickle.loads(Path(sys.argv[1]).read_bytes()).outcome()], Path(sys.argv[2]))
