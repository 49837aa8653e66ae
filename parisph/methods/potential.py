"""The potential flow closest to the fluid's velocity, and the regulariser that removes the deviation."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import movement
from parisph.kernels.harmonic import Slopes
from parisph.kernels.potential_fit import Potential, fit_potential
from parisph.methods import lengths, straining
from parisph.methods.parts import REGULARISERS, Regulariser
from parisph.methods.spins import add_cross, gradient_of

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

# In viscous fluid the filter removes roughness, and a higher rate would add to the viscosity.
VISCOUS = 0.5   # tuned 0.25 to 1: part of the rate in viscous fluid; judged


def find(flow: "Flow") -> Potential:
    """Fit the potential flow around owned particles to the current velocity. Not collective.

    It needs the velocity of walls, ghosts included, as data across them. In a rotating tank, the velocity in the room
    is that of a potential, plus a rotation if the fluid rotated at the start.
    """
    p = flow.particles
    u = p.u_all
    spin = turning_rate(flow)
    if np.any(spin):
        turning = np.zeros_like(u)
        add_cross(turning, spin, p.x_all, 1.0)
        u = u + turning
    found = Potential(np.empty_like(p.u), np.empty((p.n_owned, p.dim, p.dim)), np.empty(p.n_owned))
    across = Slopes(movement.along(p.normal_all, u), flow.walls.known_slopes(flow))
    fit_potential(found, flow.cloud, u, across, lengths.WALL * flow.spacing)
    if np.any(spin):
        np.subtract(found.gradient, gradient_of(spin, p.dim), out=found.gradient)
    return found


def turning_rate(flow: "Flow") -> Floats:
    """Return the angular velocity, () or (3,) [rad/s], of the tank relative to the fluid's by `Flow.vorticity`."""
    return flow.turn(flow.step.time) - 0.5 * flow.vorticity


class Irrotational(Regulariser):
    """Removes the deviation of velocities from a potential flow, at the rate filter sqrt(a/s); less in rapid flow.

    a is the acceleration by pressure. Without the filter, small errors of the operators grow at .02 to .05 sqrt(g/s). A
    standing wave with a = .05 d and d/s = 20 gains .7 % of its energy in 60 periods with a filter of .5, and 2.5 % with
    .33.

    Viscous fluid keeps its vorticity: only the deviation from a linear fit is removed, unless a filter in proportion to
    the strain (`filter_strain`) does that.
    """

    name, cause, words, reach = "irrotational", "filter", "irrotational filter", lengths.WALL
    fields, reads = straining.FIELDS, ("filter",)
    needs_potential = True

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.filter > 0.0

    def change(self, flow: "Flow", dt: float) -> Floats:
        step, fit = flow.step, flow.step.potential
        if fit is None and flow.numerics.filter_strain:
            return np.zeros_like(flow.particles.u)
        beyond = straining.beyond_fit(flow) if fit is None else fit.beyond
        part = np.minimum(1.0, flow.numerics.filter * dt * np.sqrt(step.by_pressure / flow.spacing))
        if fit is None:
            part *= VISCOUS
        part *= step.rapid - 1.0
        out = np.empty_like(beyond)
        for axis in range(out.shape[1]):    # numpy is slow along a short last axis
            np.multiply(part, beyond[:, axis], out=out[:, axis])
        return out


REGULARISERS.register(Irrotational())
