"""The table of a study as Markdown that can be read as plain text: starts that differ by their seed are one line."""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from parisph.study import equal_error, measures
from parisph.study.definition import Study
from parisph.study.fits import fitted_order
from parisph.study.plan import text
from parisph.study.results import Result

Cell = Callable[[Sequence[Result]], str]    # of the runs of a line

# Further columns: head, name of the value, digits.
FURTHER = (("CPU s", "cpu_seconds", 3), ("wall s", "wall_seconds", 3), ("it./step", "iterations", 3))
ENERGIES = (("energy, end", "energy_end", 4), ("energy, most", "energy_high", 5))


def families(results: Iterable[Result]) -> list[list[Result]]:
    """Return results in groups that differ by their seed only, in the order in which they come."""
    found: dict[tuple[str, str, int], list[Result]] = {}
    for one in results:
        point = one.item.point
        sets = {name: value for name, value in point.sets.items() if name != "seed"}
        like = (point.label, repr(sorted(sets.items(), key=lambda pair: pair[0])), point.ranks)
        found.setdefault(like, []).append(one)
    return list(found.values())


def curves(results: Iterable[Result]) -> dict[str, list[Result]]:
    """Return {label: results} in the order in which they come."""
    found: dict[str, list[Result]] = {}
    for one in results:
        found.setdefault(one.item.point.label, []).append(one)
    return found


def axis_of(results: Sequence[Result]) -> tuple[str | None, str]:
    """Return what the runs of a curve differ by, spacing or time_step or None, and its name for people."""
    if len({one.item.spacing for one in results}) > 1:
        own = all("spacing" in one.item.point.sets for one in results)
        return "spacing", "spacing (unit of the case)" if own else "spacing [m]"
    if len({one.item.time_step for one in results if one.item.time_step is not None}) > 1:
        return "time_step", "time step (unit of the case)"
    return None, ""


def table(results: Sequence[Result], study: Study) -> str:
    """Return the table, its notes and the fitted orders as text. Several starts: mean (least to largest)."""
    if not results:
        return "no run has a result yet"
    names = [measures.name_of(measure) for measure in study.errors]
    errors = [measures.name_of(measure) for measure in study.errors if measures.is_error(measure)]
    several = any(len(group) > 1 for group in families(results))
    on_several = any(one.item.point.ranks > 1 for one in results)
    columns: list[tuple[str, Cell]] = [
        ("run", lambda group: group[0].item.point.label), ("spacing", lambda group: f"{group[0].item.spacing:.4g}"),
        ("time step", lambda group: group[0].item.step_text),
        *([("starts", lambda group: str(len(group)))] if several else []),
        *([("ranks", lambda group: str(group[0].item.point.ranks))] if on_several else []),
        ("particles", lambda group: _count(group[0].values.get("particles"))), _column("steps", "steps", 6),
        *(_column(name, name, 3) for name in names), *(_column(*further) for further in FURTHER),
        ("volume", _volume), *(_column(*energy) for energy in ENERGIES),
        ("survived", _survived),
    ]
    rows = [[make(group) for _, make in columns] for group in families(results)]
    parts = [markdown([head for head, _ in columns], rows)]
    constant = _constant(results)
    parts += [f"All runs: {constant}."] if constant else []
    parts += _orders(results, errors)
    parts += equal_error.lines(results, study)
    parts += [f"{name_of(one)}: {one.reason}" for one in results if one.reason]
    return "\n\n".join(parts[:1] + ["\n".join(parts[1:])]) if parts[1:] else parts[0]


def name_of(one: Result) -> str:
    """Return what distinguishes a run, for people: curve, spacing, time step and seed if the study sets them."""
    sets = one.item.point.sets
    parts = [one.item.point.label, f"spacing {one.item.spacing:.4g}",
             f"time step {one.item.step_text}" if "time_step" in sets and "dt = " not in one.item.point.label else "",
             f"seed {one.item.case.numerics.seed}" if "seed" in sets else ""]
    return ", ".join(filter(None, parts))


def _constant(results: Sequence[Result]) -> str:
    """Return the parameters that are the same in all runs, as text."""
    found = [one.item.point.further for one in results]
    return ", ".join(f"{name} = {text(value)}" for name, value in found[0].items()
                     if all(name in other and repr(other[name]) == repr(value) for other in found))


def _orders(results: Sequence[Result], names: Sequence[str]) -> Iterator[str]:
    """Yield a line with the fitted orders of each curve, in the spacing or the time step."""
    axis, _ = axis_of(results)
    if axis is None:
        return
    for curve, group in curves(results).items():
        group = [one for one in group if getattr(one.item, axis) is not None]
        x = [getattr(one.item, axis) for one in group]
        orders = {name: fitted_order(x, [one.errors.get(name) for one in group]) for name in names}
        found = ", ".join(f"{name} {order:.2f}" for name, order in orders.items() if order is not None)
        if found:
            yield f"Fitted order in the {axis.replace('_', ' ')}, {curve}: {found}"


def _column(head: str, name: str, digits: int) -> tuple[str, Cell]:
    """Return the head of a column, and the function of the runs of a line that gives its cell."""
    return head, lambda group: _spread(group, name, digits)


def _spread(group: Sequence[Result], name: str, digits: int) -> str:
    values = [value for value in (one.number(name) for one in group) if value is not None]
    if not values:
        return "-"
    mean, low, high = (f"{value:.{digits}g}" for value in (np.mean(values), min(values), max(values)))
    return mean if low == high else f"{mean} ({low} to {high})"


def _volume(group: Sequence[Result]) -> str:
    """Return the least and the largest volume of all starts, over that at their start."""
    low, high = ([value for value in (one.values.get(name) for one in group) if value is not None]
                 for name in ("volume_low", "volume_high"))
    return f"{min(low):.4f} to {max(high):.4f}" if low and high else "-"


def _survived(group: Sequence[Result]) -> str:
    good = sum(one.survived for one in group)
    return "yes" if good == len(group) else "no" if len(group) == 1 else f"{good} of {len(group)}"


def _count(value: float | None) -> str:
    return "-" if value is None else str(int(value))


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table whose columns are aligned."""
    rows = [[cell.replace("|", "/") for cell in row] for row in [head, *rows]]
    widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
    lines = ["| " + " | ".join(cell.ljust(width) if k == 0 else cell.rjust(width)
                               for k, (cell, width) in enumerate(zip(row, widths))) + " |" for row in rows]
    rule = "|" + "|".join("-" * (width + 1) + "-:"[k > 0] for k, width in enumerate(widths)) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])

