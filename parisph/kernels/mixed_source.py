"""Mixed source of the pressure equation: divergence, strain source, and residuals of earlier steps."""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.rankine import Invariants
from parisph.kernels.records import Cloud

STRAIN_LIMIT = 0.01  # tuned 0.005 to 0.02: largest change of volume in a step by the strain source; judged
# Otherwise volume that the rows cannot remove would grow without limit.
EXPANSION = 0.01     # tuned 0.005 to 0.02: largest relative volume that a particle remembers; judged


class Weights(NamedTuple):
    """Parameters of the mixed source.

    density [kg/m^3]; dt, usual : the step, and its length if it were not shortened [s]
    zeta, strain : factors of the divergence and of the strain source
    per_strain : rate of the removal of residuals per strain rate, 0 to remove them at once
    time : scale over which volume is given back [s]
    """

    density: float
    dt: float
    usual: float
    zeta: float
    strain: float
    per_strain: float
    time: float


@kernel
def mixed(target: np.ndarray, expansion: np.ndarray, cloud: Cloud, div: np.ndarray, left: np.ndarray,
          before: Invariants, force: np.ndarray, weights: Weights) -> None:
    """Write rho/dt zeta d - strain rho S, with the divergence d, less the deferred and plus the remembered part.

    S is the strain source. The last step aimed at a divergence of strain dt S, and the flow since then has reduced it
    by 2 dt S. The residual is the difference of the divergence from this value. With strain = 1 this is exact also
    after a step of another length.

    The volume made in a step is, to second order, the mean of the divergences of its velocity at its operators and at
    those of the next step. The latter alone would accumulate errors on strained stencils: the mean level under a wave
    would drift in proportion to the step.

    target : (n,) output [Pa/m^2]; expansion : (n,), changed, or (0,) to return no volume
    div : (n,) of the predicted velocity [1/s]; left : (n,) the first of the two divergences [1/s]
    before : of the velocity at the start of the step, with the second divergence; force : (n_all, dim) [m/s^2]
    """
    density, dt, usual, zeta, strain, per_strain, time = weights
    for i in range(len(target)):
        own = strain_source(before.square[i], dt)
        residual = before.div[i] + (2.0 - strain) * dt * own
        divergence = div[i]
        if per_strain > 0.0:
            fall = _fall(force, i, cloud.spacing)
            divergence -= put_off(residual, before.rate[i], fall, per_strain, dt, usual)
        if len(expansion) > 0:
            made = 0.5 * (left[i] + before.div[i])
            expansion[i] = remembered(expansion[i], made, dt) if cloud.role[i] == INNER else 0.0
            divergence += expansion[i] / time
        target[i] = density / dt * zeta * divergence - strain * density * own


@inlined
def strain_source(square: float, dt: float) -> float:
    """Return tr((grad u)^2)/2 [1/s^2], the effect of straight paths on volume in a step of dt [s].

    A move by dt u changes a volume by the factor det(1 + dt grad u) = 1 + dt div u - dt^2/2 tr((grad u)^2) + ... With
    div u = 0 a straining flow shrinks: the dam break loses 4 % of its volume until the impact. div u = dt/2 tr((grad
    u)^2) conserves it. The value is limited to the range of the expansion.

    square : tr((grad u)^2) [1/s^2]
    """
    limit = STRAIN_LIMIT / dt**2
    return min(max(0.5 * square, -limit), limit)


@inlined
def put_off(residual: float, rate: float, fall: float, per_strain: float, dt: float, usual: float) -> float:
    """Return the part of the divergence that is left to later steps [1/s].

    Rows and gradients do not match exactly, so a pressure solve leaves a residual divergence, mostly near the surface,
    and in some stencils increases it. Regularisation and changes of role add to it. Removal of the whole residual in
    each step acts per step, not per time: as dt -> 0 its pressure grows as 1/dt, too fast for damping in proportion to
    strain. The residual is therefore removed at a rate in proportion to the velocity gradient or to free fall; a step
    of usual length may still remove all of it. A step shortened to meet a time removes the same part per time, so that
    its pressure resembles that of its neighbours. Forces and the strain of the flow itself, and so impacts, act at
    once.

    residual, rate : [1/s], residual divergence, and sqrt(2 G:G) of the velocity gradient
    fall : sqrt(g/s) [1/s]; per_strain : [-]; dt, usual : the step, and its length if it were not shortened [s]
    """
    removed = min(per_strain * dt * max(rate, fall), 1.0)
    return (1.0 - removed * min(dt / usual, 1.0)) * residual


@inlined
def remembered(expansion: float, residual: float, dt: float) -> float:
    """Return the relative volume that an inner particle has made after a step of dt [s] with a residual [1/s]."""
    return min(max(expansion + dt * residual, -EXPANSION), EXPANSION)


@inlined
def _fall(force, i, spacing):
    """Return sqrt(g/s) [1/s] of particle i."""
    square = 0.0
    for a in range(force.shape[1]):
        square += force[i, a] ** 2
    return math.sqrt(math.sqrt(square) / spacing)
