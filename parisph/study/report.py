"""The table of a study in Markdown, with one line for runs that differ only by their seed, and the list of its runs."""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from parisph.base import markdown
from parisph.driver import estimate
from parisph.study import measures, runs
from parisph.study.definition import Study
from parisph.study.fits import costs_at_equal_error, fitted_order
from parisph.study.plan import Plan
from parisph.study.results import Result, grouped
from parisph.study.set_words import text

Cell = Callable[[Sequence[Result]], str]    # of the runs of a line

# Further columns: head, name of the value, digits.
FURTHER = (("CPU s", "cpu_seconds", 3), ("wall s", "wall_seconds", 3), ("it./step", "iterations", 3))
ENERGIES = (("energy, end", "energy_end", 4), ("energy, most", "energy_high", 5))


def families(results: Iterable[Result]) -> list[list[Result]]:
    """Return results in groups that differ only by their seed, in the given order."""
    def but_seed(one: Result) -> tuple[str, str, int]:
        sets = {name: value for name, value in one.run.sets.items() if name != "seed"}
        return one.run.label, repr(sorted(sets.items(), key=lambda pair: pair[0])), one.run.ranks

    return list(grouped(results, but_seed).values())


def curves(results: Iterable[Result]) -> dict[str, list[Result]]:
    """Return {label: results} in the given order."""
    return grouped(results, lambda one: one.run.label)


def axis_of(results: Sequence[Result]) -> tuple[str | None, str]:
    """Return the axis of a curve, "spacing", "time_step" or None, and its label."""
    if len({one.run.spacing for one in results}) > 1:
        own = all("spacing" in one.run.sets for one in results)
        return "spacing", "spacing (unit of the case)" if own else "spacing [m]"
    if len({one.run.time_step for one in results if one.run.time_step is not None}) > 1:
        return "time_step", "time step (unit of the case)"
    return None, ""


def table(results: Sequence[Result], study: Study) -> str:
    """Return the table, its notes and the fitted orders as text. Several starts: mean (least to largest)."""
    if not results:
        return "no run has a result yet"
    names = [measures.name_of(measure) for measure in study.errors]
    errors = [measures.name_of(measure) for measure in study.errors if measures.is_error(measure)]
    several = any(len(group) > 1 for group in families(results))
    on_several = any(one.run.ranks > 1 for one in results)
    columns: list[tuple[str, Cell]] = [
        ("run", lambda group: group[0].run.label), ("spacing", lambda group: f"{group[0].run.spacing:.4g}"),
        ("time step", lambda group: group[0].run.step_text),
        *([("starts", lambda group: str(len(group)))] if several else []),
        *([("ranks", lambda group: str(group[0].run.ranks))] if on_several else []),
        ("particles", lambda group: str(group[0].values.get("particles") or "-")), _column("steps", "steps", 6),
        *(_column(name, name, 3) for name in names), *(_column(*further) for further in FURTHER),
        ("volume", _volume), *(_column(*energy) for energy in ENERGIES),
        ("survived", _survived),
    ]
    rows = [[make(group) for _, make in columns] for group in families(results)]
    parts = [markdown.table([head for head, _ in columns], rows)]
    constant = _constant(results)
    parts += [f"All runs: {constant}."] if constant else []
    parts += _orders(results, errors)
    parts += costs_at_equal_error(results, study)
    parts += [f"{name_of(one)}: {one.reason}" for one in results if one.reason]
    return "\n\n".join(parts[:1] + ["\n".join(parts[1:])]) if parts[1:] else parts[0]


def listing(plan: Plan) -> str:
    """Return the runs of a study with their estimated costs as text. Runs nothing."""
    ends, rows, left, basis = runs.ends(plan), [], 0.0, ""
    for number, run in enumerate(plan.chosen, 1):
        found, done = run.estimate(), ends.get(run.key)
        left, basis = left + (0.0 if done else found["seconds"]), found["basis"]
        rows.append([run.label, str(number), f"{run.spacing:.4g}", run.step_text, str(run.seed), str(run.ranks),
                     str(found["particles"]), str(found["steps"]), estimate.duration(found["seconds"]),
                     done.status if done else "to do"])
    head = ["run", "n", "spacing", "time step", "seed", "ranks", "particles", "steps", "CPU time", "state"]
    todo = sum(run.key not in ends for run in plan.chosen)
    return "\n\n".join([
        f"{plan.title}, into {plan.folder}", markdown.table(head, rows),
        f"{len(rows)} runs, {todo} to do: about {estimate.duration(left)} of CPU time (estimated from {basis})"])


def name_of(one: Result) -> str:
    """Return the name of a run, for people: curve, spacing, and time step and seed if the study sets them."""
    run = one.run
    parts = [run.label, f"spacing {run.spacing:.4g}",
             f"time step {run.step_text}" if "time_step" in run.sets and "dt = " not in run.label else "",
             f"seed {run.seed}" if "seed" in run.sets else ""]
    return ", ".join(filter(None, parts))


def _constant(results: Sequence[Result]) -> str:
    """Return the common parameters of all runs as text."""
    found = [one.run.further for one in results]
    return ", ".join(f"{name} = {text(value)}" for name, value in found[0].items()
                     if all(name in other and repr(other[name]) == repr(value) for other in found))


def _orders(results: Sequence[Result], names: Sequence[str]) -> Iterator[str]:
    """Yield a line with the fitted orders of each curve, in the spacing or the time step."""
    axis, _ = axis_of(results)
    if axis is None:
        return
    for curve, group in curves(results).items():
        group = [one for one in group if getattr(one.run, axis) is not None]
        x = [getattr(one.run, axis) for one in group]
        orders = {name: fitted_order(x, [one.errors.get(name) for one in group]) for name in names}
        found = ", ".join(f"{name} {order:.2f}" for name, order in orders.items() if order is not None)
        if found:
            yield f"Fitted order in the {axis.replace('_', ' ')}, {curve}: {found}"


def _column(head: str, name: str, digits: int) -> tuple[str, Cell]:
    """Return the head of a column, and the function that returns its cell for the runs of a line."""
    return head, lambda group: spread((one.number(name) for one in group), digits)


def spread(numbers: Iterable[float | None], digits: int = 3) -> str:
    """Return the mean (least to largest) of numbers without None as text, the mean alone if they are equal."""
    values = [value for value in numbers if value is not None]
    if not values:
        return "-"
    mean, low, high = (f"{value:.{digits}g}" for value in (np.mean(values), min(values), max(values)))
    return mean if low == high else f"{mean} ({low} to {high})"


def _volume(group: Sequence[Result]) -> str:
    """Return the least and the largest volume of all starts, relative to that at t = 0, as text."""
    low, high = ([value for value in (one.values.get(name) for one in group) if value is not None]
                 for name in ("volume_low", "volume_high"))
    return f"{min(low):.4f} to {max(high):.4f}" if low and high else "-"


def _survived(group: Sequence[Result]) -> str:
    good = sum(one.survived for one in group)
    return "yes" if good == len(group) else "no" if len(group) == 1 else f"{good} of {len(group)}"
