"""Runs of whole scenes, and the table of what was measured against what is asked."""

import shutil
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

from parisph.io.files import write_json
from parisph.io.reader import open_run
from tests.launch import mpirun, parisph

HOURS = 4 * 3600.0     # [s] no run may take longer


@dataclass(frozen=True)
class Row:
    """One line of the table.

    what : the scene and the quantity; measured : number; asked : the limit, None for a report only;
    least : whether the limit is a lower one; cost : CPU seconds of the run, None where it had several
    """

    what: str
    measured: float
    asked: float = None
    least: bool = False
    cost: float = None

    @property
    def met(self):
        """True, False, or None where nothing is asked. A number that is not one meets nothing."""
        if self.asked is None:
            return None
        return bool(self.measured >= self.asked if self.least else self.measured <= self.asked)


def table(rows):
    """Return the rows as a Markdown table."""
    lines = ["| | measured | asked | | CPU s |", "|---|---|---|---|---|"]
    for row in rows:
        asked = "" if row.asked is None else f"{'>=' if row.least else '<='} {row.asked:g}"
        verdict = {None: "", True: "yes", False: "NO"}[row.met]
        cost = "" if row.cost is None else f"{row.cost:.1f}"
        lines.append(f"| {row.what} | {row.measured:.4g} | {asked} | {verdict} | {cost} |")
    return "\n".join(lines)


def save(rows, path):
    """Write the rows as JSON."""
    write_json(Path(path), [{**asdict(row), "met": row.met} for row in rows])


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
