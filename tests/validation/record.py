"""Runs of whole scenes, and the table of what was measured against what is asked."""

import shutil
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from parisph.io.files import write_json
from parisph.io.reader import open_run
from tests.launch import mpirun, parisph

HOURS = 4 * 3600.0     # [s] no run may take longer


@dataclass(frozen=True)
class Row:
    """One line of the table.

    what : the scene and the quantity; measured : number; asked : the limit, None for a report only;
    least : whether the limits are lower ones; cost : CPU seconds of the run, None where it had several;
    aim : a limit that is tried for, None without one; starts : values of all starts, of which `measured` is the worst
    """

    what: str
    measured: float
    asked: float = None
    least: bool = False
    cost: float = None
    aim: float = None
    starts: tuple = ()

    @classmethod
    def of_starts(cls, what, values, asked=None, aim=None, least=False, cost=None):
        """Return the row of runs that differ by their start: the worst of them counts, nan if one is no number."""
        worst = (np.min if least else np.max)(values)
        return cls(what, float(worst), asked, least, cost, aim, tuple(float(value) for value in values))

    @property
    def met(self):
        """True, False, or None where nothing is asked. A number that is not one meets nothing."""
        return None if self.asked is None else self._within(self.asked)

    @property
    def reached(self):
        """Whether the aim is reached, None where there is none."""
        return None if self.aim is None else self._within(self.aim)

    def _within(self, limit):
        return bool(self.measured >= limit if self.least else self.measured <= limit)


def table(rows):
    """Return the rows as a Markdown table; of several starts their range is given, and the worst decides."""
    return "\n".join(["| | measured | asked | aim | | CPU s |", "|---|---|---|---|---|---|", *(_line(row) for row in rows)])


def _line(row):
    asked, aim = ("" if limit is None else f"{'>=' if row.least else '<='} {limit:.4g}" for limit in (row.asked, row.aim))
    verdict = {None: "", True: "yes", False: "NO"}[row.met] + {None: "", True: " (aim)", False: ""}[row.reached]
    cost = "" if row.cost is None else f"{row.cost:.1f}"
    return f"| {row.what} | {_range(row.starts or (row.measured,))} | {asked} | {aim} | {verdict.strip()} | {cost} |"


def _range(values):
    if np.isnan(values).any():
        return "nan"
    return " to ".join(dict.fromkeys(f"{value:.4g}" for value in (min(values), max(values))))


def save(rows, path):
    """Write the rows as JSON."""
    write_json(Path(path), {"rows": [{**asdict(row), "met": row.met, "reached": row.reached} for row in rows]})


class Bench:
    """Runs scenes in a folder of its own.

    Parameters
    ----------
    folder : where the runs go, kept; None for a temporary folder that is removed by `close`
    """

    def __init__(self, folder=None):
        self._kept = folder is not None
        self.folder = Path(folder or tempfile.mkdtemp(prefix="parisph-validation-"))
        self.folder.mkdir(parents=True, exist_ok=True)

    def run(self, label, scene, numerics=None, ranks=1, **sets):
        """Run tests.scenes.scene(...) to its end and return (Run, summary). Raises RuntimeError if it fails."""
        case, out = self.folder / f"{label}.py", self.folder / label
        case.write_text("from tests.scenes import scene\n"
                        f"def case():\n    return scene({scene!r}, {numerics or {}!r}, **{sets!r})\n")
        shutil.rmtree(out, ignore_errors=True)
        words = ["run", str(case), "-o", str(out), "-q"]
        done = (parisph(*words, timeout=HOURS) if ranks == 1 else
                mpirun(ranks, ["-m", "parisph", *words], timeout=HOURS))
        if done.returncode != 0:
            raise RuntimeError(f"{label} ended with code {done.returncode}:\n{done.stderr}")
        run = open_run(out)
        print(f"  {label}: {run.summary['steps']} steps, {run.summary['cpu_seconds']:.1f} CPU s", flush=True)
        return run, run.summary

    def close(self):
        """Remove a temporary folder."""
        if not self._kept:
            shutil.rmtree(self.folder, ignore_errors=True)
