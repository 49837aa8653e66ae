"""How the regularisers of a step act together."""

from collections.abc import Mapping, Sequence

import numpy as np

from parisph.methods.flow import Flow
from parisph.methods.parts import Limiter, Regulariser
from parisph.methods.positions import displace


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
    keep_alone(changes, [part.name for part in parts if part.alone])
    for part in parts:
        if isinstance(part, Limiter):
            part.apply(flow, dt)
        elif part.moves:
            displace(flow, changes[part.name])
        else:
            p.u[:] += changes[part.name]
            flow.stale.add("u")
        flow.budget.mark(p, part.cause)


def keep_alone(changes: Mapping[str, np.ndarray], alone: Sequence[str]) -> None:
    """Remove all other changes (n, dim) of particles that one of the parts `alone` changes. Not collective.

    Several parts that mend the same close pair would otherwise throw it apart.
    """
    for name in alone:
        taken = np.any(changes[name] != 0.0, axis=1)
        for other, change in changes.items():
            if other != name:
                change[taken] = 0.0
