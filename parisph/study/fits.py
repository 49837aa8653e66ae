"""Orders of convergence and the Pareto front of cost and error. Pure functions."""

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
