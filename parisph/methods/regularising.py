"""How the regularisers of a step act together."""

from collections.abc import Sequence

import numpy as np

from parisph.methods.flow import Flow
from parisph.methods.parts import Limiter, Regulariser
from parisph.methods.positions import CAP, displace


def prepare(flow: Flow, parts: Sequence[Regulariser], dt: float) -> None:
    """Prepare all parts, and send what they need of neighbours in one message. Collective.

    dt : of the step [s]
    """
    for part in parts:
        part.prepare(flow, dt)
    flow.fresh()


def change(flow: Flow, parts: Sequence[Regulariser], dt: float) -> None:
    """Compute the changes of all parts from one state, then add them in their order; limiters act in their turn.

    Collective.

    dt : of the step [s]
    """
    p = flow.particles
    changes = {part.name: part.change(flow, dt) for part in parts if not isinstance(part, Limiter)}
    share = share_of_moves([changes[part.name] for part in parts if part.moves and part.name in changes], flow.spacing)
    for part in parts:
        if isinstance(part, Limiter):
            part.apply(flow, dt)
        elif part.moves:
            displace(flow, share * changes[part.name])
        else:
            p.u[:] += changes[part.name]
            flow.stale.add("u")
        flow.budget.mark(p, part.cause)


def share_of_moves(moves: Sequence[np.ndarray], spacing: float) -> np.ndarray | float:
    """Return the part of several moves (n, dim) [m] that is made: (n, 1), or 1 for fewer than two.

    Together they lead no farther than CAP spacings, or than the longest of them: several parts that mend the same close
    pair would otherwise throw it apart.
    """
    if len(moves) < 2:
        return 1.0
    most = np.maximum(CAP * spacing, np.max([np.linalg.norm(move, axis=1) for move in moves], axis=0))
    whole = np.linalg.norm(np.sum(moves, axis=0), axis=1)
    return np.minimum(1.0, most / np.maximum(whole, np.finfo(float).tiny))[:, None]
