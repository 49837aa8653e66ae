"""The mixed source of the pressure equation: divergence, what strain adds to it, and what earlier steps have left."""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.rankine import Invariants
from parisph.kernels.records import Cloud

STRAIN_LIMIT = 0.01  # tuned 0.005 to 0.02: largest change of volume in a step that the strain source answers; judged
# What rows cannot remove would grow for ever.
EXPANSION = 0.01     # tuned 0.005 to 0.02: largest relative volume that a particle remembers; judged


class Weights(NamedTuple):
    """The numbers of the mixed source.

    density [kg/m^3]; dt, usual : the step, and what it would be if it were not shortened [s]; zeta, strain : of the
    divergence and the strain source; per_strain : strength of the removal of a residual, 0 to remove it at once
    time : over which volume is given back [s]
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
    """Write rho/dt zeta d - strain rho S. d is the divergence, less what is put off, plus what is given back, and S the
    strain source.

    The step before has aimed at a divergence of strain dt times the strain source, which the flow since then has
    reduced by 2 dt times it. What the divergence is beyond that, it has left as a residual; exact also after a step of
    another length if strain is 1.

    The volume that the step has made, to second order in it, is by the mean of the divergences of its velocity where
    its operators were and where those of the next step are. By the second one alone, errors of the divergence on
    strained stencils would add up: the mean level under a wave would drift in proportion to the step.

    target : (n,) output [Pa/m^2]; expansion : (n,), changed, or (0,) to give nothing back
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
    """Return tr((grad u)^2)/2 [1/s^2], the effect of a step of dt [s] in straight lines on volume.

    Particles move from one set of operators to the next by dt u, which changes a volume by the factor
    det(1 + dt grad u) = 1 + dt div u - dt^2/2 tr((grad u)^2) + ... With div u = 0 a straining flow
    shrinks: the dam break loses 4 % of its volume until the impact. div u = dt/2 tr((grad u)^2)
    conserves it. The value is limited to the range in which the expansion is valid.

    square : tr((grad u)^2) [1/s^2]
    """
    limit = STRAIN_LIMIT / dt**2
    return min(max(0.5 * square, -limit), limit)


@inlined
def put_off(residual: float, rate: float, fall: float, per_strain: float, dt: float, usual: float) -> float:
    """Return the part of the divergence that is left to later steps [1/s].

    Rows and gradients do not match exactly: a pressure solve leaves a part of the divergence, near the surface
    most of it, and in some stencils it makes it grow. Regularisation and changes of role add to it. Taken
    out anew in each step, the residual acts per step and not per time: as dt -> 0 its pressure grows as 1/dt,
    and damping in proportion to strain can no longer stop it. So it is removed at a rate in time, in proportion to
    the fluid's velocity gradient or to its free fall; a step of usual length still removes all of it. One that is
    shortened to meet a time removes the same part per time, so that its pressure is that of its neighbours. Forces and
    the strain of the flow itself, thus also impacts, act at once.

    residual, rate : [1/s], divergence that earlier steps have left, sqrt(2 G:G) of the velocity's gradient
    fall : sqrt(g/s) [1/s]; per_strain : without a unit; dt, usual : the step, and that if none were shortened [s]
    """
    removed = min(per_strain * dt * max(rate, fall), 1.0)
    return (1.0 - removed * min(dt / usual, 1.0)) * residual


@inlined
def remembered(expansion: float, residual: float, dt: float) -> float:
    """Return the relative volume that an inner particle has made, after a step of dt [s] with a residual [1/s]."""
    return min(max(expansion + dt * residual, -EXPANSION), EXPANSION)


@inlined
def _fall(force, i, spacing):
    """Return sqrt(g/s) [1/s] of particle i."""
    square = 0.0
    for a in range(force.shape[1]):
        square += force[i, a] ** 2
    return math.sqrt(math.sqrt(square) / spacing)
