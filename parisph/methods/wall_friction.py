"""Friction of walls (case.friction)."""

from typing import TYPE_CHECKING

from parisph.base.arrays import Floats
from parisph.methods import lengths
from parisph.methods.parts import FORCES, ForceTerm

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class WallFriction(ForceTerm):
    """Stress of turbulent flow on free-slip walls, on the layer of particles beside them."""

    name, source, only = "friction", "Werner & Wengle 1993", "friction"
    words, cause, reach = "friction", "friction", lengths.WALL
    fields = ("no_slip", "wall_u", "friction")

    def add(self, out: Floats, flow: "Flow", time: float) -> None:
        p = flow.particles
        assert flow.friction is not None
        p.friction[:] = 0.0
        flow.walls.rub(p.friction, flow, flow.friction)
        flow.domain.update("friction")
        out += p.friction_all

    def given(self, flow: "Flow") -> Floats:
        return flow.particles.friction


FORCES.register(WallFriction())
