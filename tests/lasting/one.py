"""One long run in a process of its own.

    python -m tests.lasting.one PLAN.json OUT.json

Its outcome is in OUT.json unless the process dies.
"""

import json
import sys
from pathlib import Path

from parisph.base import environment

environment.prepare()

from tests.hard import table  # noqa: E402
from tests.hard.flow import Bench  # noqa: E402
from tests.lasting.long import Setting, follow  # noqa: E402
from tests.lasting.parts import PARTS, Plan  # noqa: E402


def outcome(plan: Plan) -> table.Outcome:
    """Compute a run and return its Outcome, also of one that fails."""
    bench = Bench()
    long = PARTS[plan.part].long(plan.values, plan.setting)
    record = follow(bench, long, plan.setting.limit)
    return table.Outcome(plan.name, record.end, lines=long.measure(record), steps=bench.steps,
                         cpu_seconds=bench.cpu_seconds)


def main():
    """Compute the run that is described and write its outcome."""
    part, values, setting = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    table.save([outcome(Plan(part, values, Setting(**setting)))], Path(sys.argv[2]))


if __name__ == "__main__":
    sys.exit(main())
