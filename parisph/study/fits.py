"""Orders of convergence, the Pareto front of cost and error, and the cost of a given error. Pure functions."""

from collections.abc import Sequence

import numpy as np


def fitted_order(spacings: Sequence[float], errors: Sequence[float | None]) -> float | None:
    """Return the slope of log(error) over log(spacing), by least squares; None with fewer than two different spacings.

    spacings, errors : (n,); errors that are None, not finite or not positive are left out
    """
    pairs = [(s, e) for s, e in zip(spacings, errors, strict=True) if e is not None and s > 0.0 and 0.0 < e < np.inf]
    if len({s for s, _ in pairs}) < 2:
        return None
    x, y = np.log(np.array(pairs)).T
    x = x - x.mean()
    return float(np.dot(x, y - y.mean()) / np.dot(x, x))


def pareto(costs: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Return which points no other one beats: none costs as little and errs as little, and less in one of them.

    costs, errors : (n,) finite numbers. The indices are in the order of increasing cost.
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
    """Return the least cost of an error of at most `level`, and whether it is only known not to be above this; or None.

    Between the points of the Pareto front, log(cost) is linear in log(error). If the cheapest point errs less than
    that, the cost may be lower. None if no point errs as little.

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
