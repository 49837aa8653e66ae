"""What each method of a study costs for the same error."""

from collections.abc import Iterable, Sequence

import numpy as np

from parisph.study.definition import Study
from parisph.study.fits import cost_at
from parisph.study.results import Result


def lines(results: Sequence[Result], study: Study) -> list[str]:
    """Return a line for each error of study.levels: the CPU time of each method, over that of the first one.

    All spacings and time steps of a method count: its best ones are compared. Several starts: mean (least to largest).
    """
    return [_line(name, level, _methods(results)) for name, levels in study.levels.items() for level in levels]


def _methods(results: Iterable[Result]) -> dict[str, list[Result]]:
    found: dict[str, list[Result]] = {}
    for one in results:
        found.setdefault(str(one.item.case.numerics.method), []).append(one)
    return found


def _line(name: str, level: float, methods: dict[str, list[Result]]) -> str:
    costs = {method: _costs(name, level, group) for method, group in methods.items()}
    first = next(iter(methods))
    unit = np.mean([cost for cost, _ in costs[first]]) if costs[first] else None
    parts = []
    for method, found in costs.items():
        if not found:
            parts.append(f"{method} does not reach it")
            continue
        values = [cost for cost, _ in found]
        less = "at most " if any(bound for _, bound in found) else ""
        spread = f" ({min(values):.3g} to {max(values):.3g})" if len(values) > 1 else ""
        times = f", {np.mean(values) / unit:.2g} times" if unit and method != first else ""
        parts.append(f"{method} {less}{np.mean(values):.3g}{spread}{times}")
    return f"CPU s for {name} = {level:g}: " + "; ".join(parts)


def _costs(name: str, level: float, group: list[Result]) -> list[tuple[float, bool]]:
    """Return the cost of the level in each start that reaches it; none unless all of them do."""
    seeds = dict.fromkeys(one.item.case.numerics.seed for one in group)
    found = []
    for seed in seeds:
        pairs = [(one.values.get("cpu_seconds"), one.errors.get(name))
                 for one in group if one.item.case.numerics.seed == seed]
        good = [(cost, error) for cost, error in pairs if cost and error and np.isfinite(error)]
        cost = cost_at(level, *zip(*good, strict=True)) if good else None
        if cost is None:
            return []
        found.append(cost)
    return found
