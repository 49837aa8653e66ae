"""How a run was made: case file, parameters, date, machine and command."""

import datetime
import os
import platform
import shlex
import sys
from pathlib import Path
from typing import Any

from parisph.base.communicator import Communicator
from parisph.base.text import clipped, named, plain
from parisph.case.schema import Case

LONGEST = 2000    # characters of a command line


def of_run(comm: Communicator, case: Case) -> dict[str, Any]:
    """Return how a new run is made, for `made` in its case.json, the same on every rank. Collective."""
    return {**case.origin, **_here(comm)}


def of_restart(comm: Communicator, case: Case) -> dict[str, Any]:
    """Return the origin of a case with an entry for this restart, the same on every rank. Collective."""
    earlier = case.origin.get("restarts")
    return {**case.origin, "restarts": [*(earlier if isinstance(earlier, list) else ()), _here(comm)]}


def repeated(case: Case) -> list[str]:
    """Return lines for the log about the earlier run of a case, [] without one."""
    first = case.origin.get("repeats")
    if not isinstance(first, dict):
        return []
    by = f", which {first['case_file']} has made" if "case_file" in first else ""    # a script's run has none
    return [f"the case is that of the run {first.get('run')} in {case.origin.get('case_file')}{by}"
            + ", edited by hand since" * bool(case.origin.get("edited"))]


def _here(comm: Communicator) -> dict[str, Any]:
    found: dict[str, Any] = comm.bcast({
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "host": named(platform.node()),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "ranks": comm.size, "command": _command()} if comm.rank == 0 else None)
    return found


def _command() -> str:
    """Return the command line of this process; in a notebook that of its kernel."""
    first, *words = sys.argv or [""]
    own = Path(first).name in ("parisph", "__main__.py", "-m")
    return clipped(plain(shlex.join(["parisph" if own else first, *words])), LONGEST)


def lines(made: Any) -> list[tuple[str, str]]:
    """Return how a run was made as (name, text), for people. made : as in a case.json, which may have been edited"""
    if not isinstance(made, dict):
        return []
    found = []
    if made.get("case_file"):
        found.append(("case file", f"{made['case_file']}, digest {made.get('case_digest')}"))
    if isinstance(made.get("repeats"), dict):
        first = made["repeats"]
        found.append(("  repeats", f"run {first.get('run')}, made by {first.get('case_file', 'an unknown case file')}"
                                     + ", edited by hand since" * bool(made.get("edited"))))
    if isinstance(made.get("parameters"), dict) and made["parameters"]:
        given = made["given"] if isinstance(made.get("given"), list) else []
        found.append(("parameters", ", ".join(f"{name} = {value}{' (given)' * (name in given)}"
                                              for name, value in made["parameters"].items())))
    if made.get("changed"):
        found.append(("  changed then", str(made["changed"])))
    restarts = made.get("restarts")
    later = [("restarted", one) for one in restarts] if isinstance(restarts, list) else []
    for name, one in [("made", made), *later]:
        if isinstance(one, dict) and one.get("date"):
            found.append((name, f"{one['date']} on {one.get('host')}, {one.get('cores')} cores, "
                                f"by {one.get('command')}"))
    return found
