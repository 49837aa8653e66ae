"""One table of all finished runs in a folder, that differ by their number of ranks.

    python run_scripts/studies/scaling_table.py runs/strong    # prints it, and writes table.md and table.csv there

Efficiency is the cost of a particle on the fewest ranks over that on more, so that it is the strong one where all runs
have the same particles, and the weak one where each rank has as many. Runs that have not ended are named, and left out.
"""

import argparse
import csv
import io
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from scaling_measures import COLUMNS, cost  # noqa: E402

from parisph.base import markdown  # noqa: E402
from parisph.io.files import write_text  # noqa: E402


def found_in(folder: Path) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the summaries of the completed runs in a folder, by ranks, and the names of the others."""
    done, others = [], []
    for run in sorted(path.parent for path in folder.glob("*/case.json")):
        path = run / "summary.json"
        summary = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        if summary.get("status", "").startswith("completed"):
            done.append(summary)
        else:
            others.append(run.name)
    return sorted(done, key=lambda summary: summary["ranks"]), others


def lines(summaries: Sequence[Mapping[str, Any]]) -> list[dict[str, float]]:
    """Return a line of the table for each summary."""
    first = cost(summaries[0])
    return [{"ranks": summary["ranks"], "particles": summary["particles"], "steps": summary["steps"],
             "efficiency": first / cost(summary), "wall s": summary["wall_seconds"],
             "iterations": (summary.get("iterations") or {}).get("median", float("nan")),
             **{head: of(summary) for head, of in COLUMNS.items()}} for summary in summaries]


def as_csv(table: Sequence[Mapping[str, float]]) -> str:
    """Return the lines as CSV."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return out.getvalue()


def main() -> None:
    """Print the table and write its files."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="folder whose folders are runs")
    folder = parser.parse_args().folder
    summaries, others = found_in(folder)
    if not summaries:
        raise SystemExit(f"scaling_table: there is no completed run in {folder}")
    table = lines(summaries)
    text = markdown.table(list(table[0]), [[f"{value:.4g}" if isinstance(value, float) else str(value)
                                            for value in line.values()] for line in table])
    kind = "Strong" if len({summary["particles"] for summary in summaries}) == 1 else "Weak"
    text = f"{kind} scaling, times of a step in ms on the slowest rank.\n\n{text}\n"
    if others:
        text += f"\nNot completed: {', '.join(others)}\n"
    print(text, end="")
    write_text(folder / "table.md", text)
    write_text(folder / "table.csv", as_csv(table))


if __name__ == "__main__":
    main()
