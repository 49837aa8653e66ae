"""Joint action of the regularisers of a step."""

from collections.abc import Mapping, Sequence

import numpy as np

from parisph.base.arrays import Floats
from parisph.kernels import movement, shifting
from parisph.methods.flow import Flow
from parisph.methods.parts import Limiter, Regulariser
from parisph.methods.positions import CAP, displace
from parisph.methods.step_state import Preparation


def prepare(flow: Flow, parts: Sequence[Regulariser], dt: float) -> None:
    """Prepare all parts, and send the fields they need of neighbours in one message. Collective.

    dt : of the step [s]
    """
    flow.preparation = Preparation()
    for part in parts:
        part.prepare(flow, dt)
    flow.fresh()


def change(flow: Flow, parts: Sequence[Regulariser], dt: float) -> None:
    """Compute the changes of all parts from one state, then add them in order, with limiters in their turn. Collective.

    dt : of the step [s]
    """
    p = flow.particles
    changes = {part.name: np.ascontiguousarray(part.change(flow, dt), float)
               for part in parts if not isinstance(part, Limiter)}
    cap_together({part.name: changes[part.name] for part in parts if part.moves and part.name in changes},
                 [part.name for part in parts if part.free], CAP * flow.spacing)
    for part in parts:
        if isinstance(part, Limiter):
            part.apply(flow, dt)
        elif part.moves:
            displace(flow, changes[part.name])    # shortens moves into walls
            if part.carries:
                movement.carry(p.u, p.grad_u, changes[part.name])
                flow.stale.add("u")
        else:
            p.u[:] += changes[part.name]
            flow.stale.add("u")
        flow.budget.mark(p, part.cause)


def cap_together(moves: Mapping[str, Floats], free: Sequence[str], cap: float) -> None:
    """Shorten moves (n, dim) [m] whose sum exceeds both the cap [m] and the longest `free` move. Not collective.

    Several parts that mend the same close pair would otherwise throw it apart.
    """
    if len(moves) > 1:
        shifting.cap_together(tuple(moves.values()), np.array([name in free for name in moves]), cap)
