"""The table of a study as Markdown that can be read as plain text: starts that differ by their seed are one line."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from parisph.study import measures
from parisph.study.definition import Study
from parisph.study.fits import fitted_order
from parisph.study.plan import text
from parisph.study.results import Result

# Further columns: head, name of the value, digits.
FURTHER = (("CPU s", "cpu_seconds", 3), ("wall s", "wall_seconds", 3), ("it./step", "iterations", 3))
ENERGIES = (("energy, end", "energy_end", 4), ("energy, most", "energy_high", 5))


def families(results: Iterable[Result]) -> list[list[Result]]:
    """Return results in groups that differ by their seed only, in the order in which they come."""
    found: dict[tuple, list[Result]] = {}
    for one in results:
        point = one.item.point
        sets = {name: value for name, value in point.sets.items() if name != "seed"}
        found.setdefault((point.label, repr(sorted(sets.items(), key=lambda pair: pair[0])), point.ranks), []).append(one)
    return list(found.values())


def curves(results: Iterable[Result]) -> dict[str, list[Result]]:
    """Return {label: results} in the order in which they come."""
    found: dict[str, list[Result]] = {}
    for one in results:
        found.setdefault(one.item.point.label, []).append(one)
    return found


def table(results: Sequence[Result], study: Study) -> str:
    """Return the table, its notes and the fitted orders as text. Several starts: mean (least to largest)."""
    if not results:
        return "no run has a result yet"
    names = [measures.name_of(measure) for measure in study.errors]
    several = any(len(group) > 1 for group in families(results))
    columns: list[tuple[str, Callable]] = [
        ("run", lambda group: group[0].item.point.label), ("spacing", lambda group: f"{group[0].item.spacing:.4g}"),
        ("time step", lambda group: step_of(group[0])),
        *([("starts", lambda group: str(len(group)))] if several else []),
        *([("ranks", lambda group: str(group[0].item.point.ranks))] if any(one.item.point.ranks > 1 for one in results) else []),
        ("particles", lambda group: _count(group[0].values.get("particles"))), ("steps", lambda group: _spread(group, "steps", 6)),
        *((name, lambda group, name=name: _spread(group, name, 3)) for name in names),
        *((head, lambda group, name=name, digits=digits: _spread(group, name, digits)) for head, name, digits in FURTHER),
        ("volume", _volume),
        *((head, lambda group, name=name, digits=digits: _spread(group, name, digits)) for head, name, digits in ENERGIES),
        ("survived", _survived),
    ]
    rows = [[make(group) for _, make in columns] for group in families(results)]
    parts = [markdown([head for head, _ in columns], rows)]
    constant = _constant(results)
    parts += [f"All runs: {constant}."] if constant else []
    parts += _orders(results, names)
    parts += [f"{name_of(one)}: {one.reason}" for one in results if one.reason]
    return "\n\n".join(parts[:1] + ["\n".join(parts[1:])]) if parts[1:] else parts[0]


def name_of(one: Result) -> str:
    """Return what distinguishes a run, for people: curve, spacing, time step and seed if the study sets them."""
    sets, step = one.item.point.sets, step_of(one)
    return ", ".join([one.item.point.label, f"spacing {one.item.spacing:.4g}", *([f"time step {step}"] if "time_step" in sets else []),
                      *([f"seed {one.item.case.numerics.seed}"] if "seed" in sets else [])])


def step_of(one: Result) -> str:
    """Return the time step of a run as text: in the unit of the case if the study gives it, else in seconds."""
    if one.item.time_step is None:
        return "adaptive"
    return f"{one.item.time_step:.4g}{'' if 'time_step' in one.item.point.sets else ' s'}"


def _constant(results):
    """Return the parameters that are the same in all runs, as text."""
    found = [one.item.point.further for one in results]
    return ", ".join(f"{name} = {text(value)}" for name, value in found[0].items()
                     if all(name in other and repr(other[name]) == repr(value) for other in found))


def _orders(results, names):
    """Yield a line with the fitted orders of each curve."""
    for label, group in curves(results).items():
        orders = {name: fitted_order([one.item.spacing for one in group], [one.errors.get(name) for one in group]) for name in names}
        found = ", ".join(f"{name} {order:.2f}" for name, order in orders.items() if order is not None)
        if found:
            yield f"Fitted order in the spacing, {label}: {found}"


def _spread(group, name, digits):
    values = [one.number(name) for one in group]
    values = [value for value in values if value is not None]
    if not values:
        return "-"
    mean, low, high = (f"{value:.{digits}g}" for value in (np.mean(values), min(values), max(values)))
    return mean if low == high else f"{mean} ({low} to {high})"


def _volume(group):
    """Return the least and the largest volume of all starts, over that at their start."""
    low, high = ([one.values[name] for one in group if one.values.get(name) is not None] for name in ("volume_low", "volume_high"))
    return f"{min(low):.4f} to {max(high):.4f}" if low and high else "-"


def _survived(group):
    good = sum(one.survived for one in group)
    return "yes" if good == len(group) else "no" if len(group) == 1 else f"{good} of {len(group)}"


def _count(value):
    return "-" if value is None else str(int(value))


def markdown(head, rows):
    """Return a Markdown table whose columns are aligned."""
    rows = [[cell.replace("|", "/") for cell in row] for row in [head, *rows]]
    widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
    lines = ["| " + " | ".join(cell.ljust(width) if k == 0 else cell.rjust(width)
                               for k, (cell, width) in enumerate(zip(row, widths))) + " |" for row in rows]
    rule = "|" + "|".join("-" * (width + 2) if k == 0 else "-" * (width + 1) + ":" for k, width in enumerate(widths)) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])

