"""How the regularisers of a step act together."""

from collections.abc import Sequence

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

    dt : of the step [s]. Collective.
    """
    p = flow.particles
    changes = [None if isinstance(part, Limiter) else part.change(flow, dt) for part in parts]
    for part, found in zip(parts, changes, strict=True):
        if isinstance(part, Limiter):
            part.apply(flow, dt)
        elif part.moves:
            displace(flow, found)
        else:
            p.u[:] += found
            flow.stale.add("u")
        flow.budget.mark(p, part.cause)
