"""The forces per unit mass, which add up to the acceleration of a step."""

from parisph.methods.parts import FORCES, Force


class Body(Force):
    """Gravity, and the inertia of a tank that moves."""

    name = "body"

    def add(self, out, flow, time):
        out += flow.body(flow.particles.x_all, time)


FORCES.register(Body())
