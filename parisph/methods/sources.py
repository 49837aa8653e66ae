"""Sources of the pressure equation."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import mixed_source
from parisph.methods.parts import SOURCES, Source
from parisph.methods.positions import compression

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

# Volume is given back a step after it was made, as in x' = x - k x_before: critically damped with k = 1/4.
CRITICAL = 4.0


class MixedSource(Source):
    """Velocity divergence and density error, weighted by zeta and gamma: Eq 17 for gamma 0, Eq 18 for zeta 0.

    It includes, with their own weights, the strain source, the removal of a residual divergence per strain, and the
    return of the volume that the residual has made. Every step removes the divergence that the last one left, and
    leaves one as large: in a standing wave, in proportion to the length of the step and to the square of the height.
    Particles have moved by it by then, and the mean level under the crests drifts. The integral of the residual along
    the path of an inner particle is the relative volume made; it is returned over a time of `numerics.volume_time`
    sqrt(s/g). See kernels.mixed_source.
    """

    name, source = "mixed", "Z14 Eqs 17-19"

    def words(self, numerics: ResolvedNumerics) -> str:
        said = ["strain source"] if numerics.strain > 0.0 else []
        if numerics.volume_time > 0.0:
            said.append("volume given back")
        return ", ".join(said)

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        weights = {"alpha": numerics.gamma, "expansion": numerics.volume_time, "left": numerics.volume_time}
        return tuple(name for name, weight in weights.items() if weight > 0.0)

    def target(self, flow: "Flow", dt: float) -> Floats:
        n, density = flow.numerics, flow.density
        zeta = min(1.0, dt / n.zeta_time) if n.zeta_time else n.zeta
        assert zeta is not None
        target = self._of_velocity(flow, dt, zeta)
        if n.gamma > 0.0:
            target -= n.gamma * density / dt**2 * compression(flow)
        return target

    def _of_velocity(self, flow: "Flow", dt: float, zeta: float) -> Floats:
        """Return the velocity's part of the target (n_owned,) [Pa/m^2]."""
        p, n, density = flow.particles, flow.numerics, flow.density
        if not (n.strain > 0.0 or n.residual_strain > 0.0 or n.volume_time > 0.0):
            return density / dt * zeta * flow.rows.div
        target, none = np.empty(p.n_owned), np.empty(0)
        expansion, left = (p.expansion, p.left) if n.volume_time > 0.0 else (none, none)
        weights = mixed_source.Weights(density, dt, flow.step.usual, zeta, n.strain, n.residual_strain,
                                       max(n.volume_time * flow.wave_time, CRITICAL * dt))
        mixed_source.mixed(target, expansion, flow.cloud, flow.rows.div, left, flow.rows.gradient_invariants(p.u_all),
                           flow.step.force, weights)
        return target


class VelocityDivergence(Source):
    """The divergence of the predicted velocity alone."""

    name, source = "divergence", "Z14 Eq 17"

    def target(self, flow: "Flow", dt: float) -> Floats:
        return flow.density / dt * flow.rows.div


class DensityInvariance(Source):
    """The density error of the predicted positions alone, within +-.1."""

    name, source, fields = "density", "Z14 Eq 18", ("alpha",)

    def target(self, flow: "Flow", dt: float) -> Floats:
        return -flow.density / dt**2 * compression(flow)


class ErrorCompensating(Source):
    """The divergence of the predicted velocity, and two terms that compensate errors of the previous step.

    With e = alpha - 1 and d = div u^n, target = rho/dt (div u* + |e| d - |d| e): each error is weighted by the size of
    the other.
    """

    name, source, fields = "compensating", "Khayyer and Gotoh 2011", ("alpha",)

    def target(self, flow: "Flow", dt: float) -> Floats:
        p = flow.particles
        e, before = compression(flow), np.empty(p.n_owned)
        flow.rows.divergence(before, p.u_all)
        found: Floats = flow.density / dt * (flow.rows.div + np.abs(e) * before - np.abs(before) * e)
        return found


for part in (MixedSource(), VelocityDivergence(), DensityInvariance(), ErrorCompensating()):
    SOURCES.register(part)
