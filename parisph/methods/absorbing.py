"""Force of zones that absorb or make waves (case.absorb)."""

from typing import TYPE_CHECKING

from parisph.base.arrays import Floats
from parisph.methods.parts import FORCES, ForceTerm

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class Absorption(ForceTerm):
    """(u_t - u)/(tau + dt): alone it takes u to (u + dt/tau u_t)/(1 + dt/tau) in a step, without overshoot for any dt.

    Gravity is not divided by 1 + dt/tau as the velocity is: pressure balances gravity, not the zone, and otherwise
    water at rest in a zone of uneven tau would begin to flow.
    """

    name, only, words, cause = "absorb", "absorbing", "absorb", "absorb"

    def add(self, out: Floats, flow: "Flow", time: float) -> None:
        assert flow.absorb is not None
        rate, pull = flow.absorb(flow.particles.x_all, time)
        own = (pull - rate[:, None] * flow.particles.u_all) / (1.0 + flow.step.dt * rate)[:, None]
        flow.step.absorbed = own[:flow.particles.n_owned]
        out += own

    def given(self, flow: "Flow") -> Floats:
        return flow.step.absorbed


FORCES.register(Absorption())
