"""The sources of the pressure equation."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import sizes
from parisph.base.fields import INNER
from parisph.case.numerics import Numerics
from parisph.methods.parts import SOURCES, Source
from parisph.methods.positions import compression

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

STRAIN_LIMIT = 0.01  # largest change of volume in a step that the strain source answers
EXPANSION = 0.01     # largest relative volume that a particle remembers: what rows cannot remove would grow for ever
GIVEN = 4.0          # steps over which it is given back, at least


class Mixed(Source):
    """Velocity divergence and density error, weighed by zeta and gamma: Eq 17 for gamma 0, Eq 18 for zeta 0.

    To it belong, each with a weight of its own, the strain source, the removal of a residual divergence per strain, and
    the return of the volume that this has made.
    """

    name, source = "mixed", "Z14 Eqs 17-19"

    def words(self, numerics: Numerics) -> str:
        said = ["strain source"] if numerics.strain > 0.0 else []
        if numerics.volume_time > 0.0:
            said.append("volume given back")
        return ", ".join(said)

    def needs(self, numerics: Numerics) -> tuple[str, ...]:
        weights = {"alpha": numerics.gamma, "expansion": numerics.volume_time}
        return tuple(name for name, weight in weights.items() if weight > 0.0)

    def target(self, flow: "Flow", dt: float) -> np.ndarray:
        n, density = flow.numerics, flow.density
        zeta = min(1.0, dt / n.zeta_time) if n.zeta_time else n.zeta
        strain, divergence = 0.0, flow.rows.div
        if n.strain > 0.0 or n.residual_strain > 0.0 or n.volume_time > 0.0:
            square, rate, before = flow.rows.gradient_invariants(flow.particles.u_all, flow.particles.role_all)
            strain = strain_source(square, dt)
            # the step before has aimed at a divergence of n.strain dt times the strain source, which the flow since
            # then has reduced by 2 dt times it; exact also after a step of another length if n.strain is 1
            residual = before + (2.0 - n.strain) * dt * strain
            if n.residual_strain > 0.0:
                divergence = divergence - put_off(flow, dt, residual, rate)
            if n.volume_time > 0.0:
                divergence = divergence + given_back(flow, dt, residual)
        target = density / dt * zeta * divergence
        if n.gamma > 0.0:
            target -= n.gamma * density / dt**2 * compression(flow, flow.particles.alpha,
                                                              np.zeros(flow.particles.n_owned))
        target -= n.strain * density * strain
        return target


class VelocityDivergence(Source):
    """The divergence of the predicted velocity alone."""

    name, source = "divergence", "Z14 Eq 17"

    def target(self, flow: "Flow", dt: float) -> np.ndarray:
        return flow.density / dt * flow.rows.div


class DensityInvariance(Source):
    """The density error of the predicted positions alone, within +-.1."""

    name, source, fields = "density", "Z14 Eq 18", ("alpha",)

    def target(self, flow: "Flow", dt: float) -> np.ndarray:
        return -flow.density / dt**2 * compression(flow, flow.particles.alpha, np.zeros(flow.particles.n_owned))


class ErrorCompensating(Source):
    """The divergence of the predicted velocity, and two terms that compensate the errors of the step before.

    With e = alpha - 1 and d = div u^n, target = rho/dt (div u* + |e| d - |d| e): where both errors have a sign, each
    weighs the other.
    """

    name, source, fields = "compensating", "Khayyer and Gotoh 2011", ("alpha",)

    def target(self, flow: "Flow", dt: float) -> np.ndarray:
        p = flow.particles
        e, before = compression(flow, p.alpha, np.zeros(p.n_owned)), np.empty(p.n_owned)
        flow.rows.divergence(before, p.u_all, p.role_all)
        return flow.density / dt * (flow.rows.div + np.abs(e) * before - np.abs(before) * e)


def strain_source(square: np.ndarray, dt: float) -> np.ndarray:
    """Return tr((grad u)^2)/2 (n,) [1/s^2], the effect of a step of dt [s] in straight lines on volume.

    Particles move from one set of operators to the next by dt u, which changes a volume by the factor
    det(1 + dt grad u) = 1 + dt div u - dt^2/2 tr((grad u)^2) + ... With div u = 0 a straining flow
    shrinks: the dam break loses 4 % of its volume until the impact. div u = dt/2 tr((grad u)^2)
    conserves it. The value is limited to the range in which the expansion is valid.

    square : (n,), tr((grad u)^2) [1/s^2]
    """
    limit = STRAIN_LIMIT / dt**2
    return np.minimum(np.maximum(0.5 * square, -limit), limit)


def put_off(flow: "Flow", dt: float, residual: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return the part of the divergence that is left to later steps (n_owned,) [1/s]. Not collective.

    Rows and gradients do not match exactly: a pressure solve leaves a part of the divergence, near the surface
    most of it, and in some stencils it makes it grow. Regularisation and changes of role add to it. Taken
    out anew in each step, the residual acts per step and not per time: as dt -> 0 its pressure grows as 1/dt,
    and damping in proportion to strain can no longer stop it. So it is removed at a rate in time, in proportion to
    the fluid's velocity gradient or to its free fall; a step of usual length still removes all of it. One that is
    shortened to meet a time removes the same part per time, so that its pressure is that of its neighbours. Forces and
    the strain of the flow itself, thus also impacts, act at once.

    residual, rate : (n_owned,) [1/s], divergence that earlier steps have left, sqrt(2 G:G) of the velocity's gradient
    """
    p, n = flow.particles, flow.numerics
    fall = np.sqrt(sizes(flow.force[:p.n_owned]) / flow.spacing)
    removed = np.minimum(1.0, n.residual_strain * dt * np.maximum(rate, fall))
    if dt < flow.usual:
        removed *= dt / flow.usual
    return (1.0 - removed) * residual


def given_back(flow: "Flow", dt: float, residual: np.ndarray) -> np.ndarray:
    """Return the divergence that gives back the volume made by those of earlier steps (n_owned,) [1/s]. Not collective.

    Every step removes the divergence that the last one has left, and leaves one of its own, as large: in a standing
    wave, in proportion to the length of the step and to the square of the height. Particles have moved by it by then,
    and the mean level under the crests drifts. The integral of what is left, along the path of an inner particle, is
    the relative volume that it has made; it is given back over a time of `numerics.volume_time` sqrt(s/g).

    residual : (n_owned,) divergence that the last step has left [1/s]
    """
    p, n = flow.particles, flow.numerics
    expansion = p.expansion + dt * residual
    p.expansion[:] = np.where(p.role == INNER, np.minimum(np.maximum(expansion, -EXPANSION), EXPANSION), 0.0)
    return p.expansion / max(n.volume_time * flow.wave_time, GIVEN * dt)


for part in (Mixed(), VelocityDivergence(), DensityInvariance(), ErrorCompensating()):
    SOURCES.register(part)
