"""What the summary of a run tells of its cost on some ranks: for strong_scaling.py, weak_scaling.py and tables."""

from collections.abc import Callable, Mapping
from typing import Any

from parisph.study import Function

# Phases of a step in their order. The others are not scaled: the start, and what goes to the disk.
PHASES = ("predict", "redistribute", "surface", "assemble", "solve", "correct", "regularise", "record")
Summary = Mapping[str, Any]


def step_ms(summary: Summary) -> float:
    """Return the time on the clock of a step [ms]: the sum of its phases, each on the slowest rank."""
    return sum(phase_ms(summary, phase) for phase in PHASES)


def step_cpu_ms(summary: Summary) -> float:
    """Return the CPU time of a step [ms], of all ranks together."""
    return 1e3 * sum(summary["cpu_phases"].get(phase, 0.0) for phase in PHASES) / summary["steps"]


def phase_ms(summary: Summary, phase: str) -> float:
    """Return the time on the clock of a phase in a step [ms], on the slowest rank."""
    return 1e3 * summary["phases"].get(phase, 0.0) / summary["steps"]


def cost(summary: Summary) -> float:
    """Return the time on the clock of all ranks for a particle and step [us]: its inverse is compared."""
    return 1e3 * step_ms(summary) * summary["ranks"] / summary["particles"]


def shares(*entries: str) -> Callable[[Summary], float]:
    """Return the function that gives an entry of `shares` in a summary."""
    def of(summary):
        found = summary["shares"]
        for entry in entries:
            found = found[entry]
        return float(found)
    return of


def messages(summary: Summary) -> float:
    """Return the messages that a rank sends in a step to update ghosts, on the mean of the ranks."""
    return shares("updates")(summary) * shares("neighbours", "mean")(summary)


# Head of the column -> function of the summary.
COLUMNS: dict[str, Callable[[Summary], float]] = {
    "ms/step": step_ms, "CPU ms/step": step_cpu_ms,
    **{phase: lambda summary, phase=phase: phase_ms(summary, phase) for phase in PHASES},
    "imbalance": shares("imbalance"), "ghosts": shares("ghosts", "mean"), "neighbours": shares("neighbours", "max"),
    "updates": shares("updates"), "messages": messages, "plans": shares("plans"), "lists": shares("lists"),
}


def measure(head: str) -> Function:
    """Return a column as a measure of a study."""
    return Function(name=head, of=lambda run: COLUMNS[head](run.summary), error=False)


MEASURES = [measure(head) for head in COLUMNS]
