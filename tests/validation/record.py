"""Runs of whole scenes, and the table of what was measured against what is asked."""

import shutil
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from parisph.io.files import write_json
from parisph.io.reader import open_run
from parisph.study import Study, Variant, limits, runs
from parisph.study.definition import OWN
from parisph.study.plan import plan_study
from parisph.study.results import Result, result
from tests.hard.table import Line, spread, verdict
from tests.launch import ROOT

HOURS = 4 * 3600.0     # [s] no run may take longer


@dataclass(frozen=True)
class Row(Line):
    """One line of the table: its `what` names the scene, too.

    cost : CPU seconds of the run, None where it had several; starts : values of all starts, of which `value` is the
    worst
    """

    cost: float | None = None
    starts: tuple[float, ...] = ()

    @classmethod
    def of_starts(cls, what, values, must=None, aim=None, least=False, cost=None):
        """Return the row of runs that differ by their start: the worst of them counts, nan if one is no number."""
        worst = (np.min if least else np.max)(values)
        return cls(what, float(worst), must, aim, least, cost, tuple(float(value) for value in values))


def rows_of(study: Study, results: list[Result], what: str) -> list[Row]:
    """Return a Row for each limit of a study, from its results.

    what : the scene and the quantity, before the name of the curve
    """
    found, cost = [], {one.run.label: one.values.get("cpu_seconds") for one in results}
    for one in limits.verdicts(study, [one.run for one in results], results):
        label = one.where.partition(", spacing ")[0]
        values = [float("nan") if value is None else value for value in one.values]
        found.append(Row.of_starts(f"{what}, {label}: {one.required.of}", values, one.required.must, one.required.aim,
                                   one.required.least, cost.get(label)))
    return found


def table(rows):
    """Return the rows as a Markdown table; of several starts their range is given, and the worst decides."""
    return "\n".join(["| | measured | must | aim | | CPU s |", "|---|---|---|---|---|---|",
                      *(_line(row) for row in rows)])


def _line(row):
    cost = "" if row.cost is None else f"{row.cost:.1f}"
    return (f"| {row.what} | {spread(row.starts or (row.value,))} | {' | '.join(row.limits())} "
            f"| {verdict(row.met, row.reached)} | {cost} |")


def said(rows):
    """Print rows as they are found, and return them: a part takes long, and may be ended before its table."""
    rows = list(rows)
    for row in rows:
        print(f"  {row.what}: {spread(row.starts or (row.value,))} {verdict(row.met, row.reached)}", flush=True)
    return rows


def save(rows, path):
    """Write the rows as JSON."""
    write_json(Path(path), {"rows": [{**asdict(row), "met": row.met, "reached": row.reached} for row in rows]})


class Bench:
    """Runs scenes as runs of studies, in a folder of its own. What is finished there is not run again by the same code.

    folder : where the runs go, kept; None for a temporary folder that is removed by `close`
    """

    def __init__(self, folder=None):
        self._kept = folder is not None
        self.folder = Path(folder or tempfile.mkdtemp(prefix="parisph-validation-"))
        self.folder.mkdir(parents=True, exist_ok=True)

    def run(self, label, scene, numerics=None, ranks=1, **sets):
        """Run a scene of cases/ to its end and return (Run, summary). Raises RuntimeError if it fails.

        numerics : {name: value}, changes of its Numerics; sets : parameters of its case
        """
        inside = {f"numerics.{name}": value for name, value in (numerics or {}).items()}
        own = {name: None if sets[name] == "none" else sets[name] for name in sets if name in OWN}
        sets = {name: value for name, value in sets.items() if name not in OWN}
        study = Study(case=str(ROOT / "cases" / f"{scene}.py"), ranks=[ranks], variants=[Variant(
            label=label, parameters={**sets, **inside}, **{OWN[name]: [value] for name, value in own.items()})])
        found, = self.study(study)
        if not found.survived:
            raise RuntimeError(f"{label} ended with code {found.end.code}:\n{found.reason}")
        run = open_run(found.folder)
        return run, run.summary

    def study(self, study: Study) -> list[Result]:
        """Make the runs of a study that are not done, and return all results. Its paths are relative to cases/."""
        plan, made = plan_study(study, ROOT / "cases" / "validation.py", out=self.folder, limit=HOURS), []
        ends = runs.ends(plan)
        todo = [run for run in plan.runs if run.key not in ends]
        ends |= {run.key: end for run, end in runs.make(todo, plan)}
        for run in plan.runs:
            made.append(result(run, ends[run.key], plan))
            cost = made[-1].values.get("cpu_seconds") or float("nan")
            print(f"  {run.label}: {made[-1].values.get('steps')} steps, {cost:.1f} CPU s"
                  f"{'' if run in todo else ', there already'}", flush=True)
        return made

    def close(self):
        """Remove a temporary folder."""
        if not self._kept:
            shutil.rmtree(self.folder, ignore_errors=True)
