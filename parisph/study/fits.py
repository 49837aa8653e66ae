"""Orders of convergence, the Pareto front of cost and error, and costs of methods at equal error."""

from collections.abc import Sequence

import numpy as np

from parisph.study.definition import Study
from parisph.study.results import Result, grouped


def fitted_order(spacings: Sequence[float], errors: Sequence[float | None]) -> float | None:
    """Return the slope of log(error) over log(spacing) by least squares; None for fewer than two different spacings.

    spacings, errors : (n,); errors that are None, not finite or not positive are left out
    """
    pairs = [(s, e) for s, e in zip(spacings, errors, strict=True) if e is not None and s > 0.0 and 0.0 < e < np.inf]
    if len({s for s, _ in pairs}) < 2:
        return None
    x, y = np.log(np.array(pairs)).T
    x = x - x.mean()
    return float(np.dot(x, y - y.mean()) / np.dot(x, x))


def pareto(costs: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Return the indices of the points that no other beats in cost and error, by increasing cost.

    costs, errors : (n,) finite numbers; equal points are all returned
    """
    order = sorted(range(len(costs)), key=lambda k: (costs[k], errors[k]))
    front: list[int] = []
    best = float("inf")
    for k in order:
        if errors[k] < best or (front and (costs[k], errors[k]) == (costs[front[-1]], errors[front[-1]])):
            front.append(k)
            best = errors[k]
    return front


def cost_at(level: float, costs: Sequence[float], errors: Sequence[float]) -> tuple[float, bool] | None:
    """Return the least cost of an error of at most `level`, and whether it is an upper bound; None without such errors.

    Between the points of the Pareto front, log(cost) is linear in log(error). The cost is an upper bound if the error
    of the cheapest point is below the level.

    costs, errors : (n,), greater than 0
    """
    front = [(costs[k], errors[k]) for k in pareto(costs, errors)]
    reached = next((k for k, (_, error) in enumerate(front) if error <= level), None)
    if reached is None:
        return None
    cost, error = front[reached]
    if reached == 0:
        return cost, error < level
    cheaper, larger = front[reached - 1]
    part = np.log(larger / level) / np.log(larger / error)
    return float(cheaper * (cost / cheaper) ** part), False


def costs_at_equal_error(results: Sequence[Result], study: Study) -> list[str]:
    """Return a line for each error of study.levels: the CPU time of each method, and its ratio to that of the first.

    The best spacings and time steps of a method count. Several starts give mean (least to largest).
    """
    methods = grouped(results, lambda one: one.run.method)
    return [_line(name, level, methods) for name, levels in study.levels.items() for level in levels]


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
    """Return the cost of the level in each start, and whether it is an upper bound; [] unless all starts reach it."""
    found = []
    for start in grouped(group, lambda one: one.run.seed).values():
        pairs = [(one.values.get("cpu_seconds"), one.errors.get(name)) for one in start]
        good = [(cost, error) for cost, error in pairs if cost and error and np.isfinite(error)]
        cost = cost_at(level, *zip(*good, strict=True)) if good else None
        if cost is None:
            return []
        found.append(cost)
    return found
