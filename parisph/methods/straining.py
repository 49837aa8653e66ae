"""The strain of a step, to which regularisation is in proportion."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.kernels import strain
from parisph.methods import lengths

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

# det/(trace/dim)^dim of the neighbours' moment below which there is no velocity gradient, and fluid is one layer
SPAN = 0.05    # tuned 0.025 to 0.1: floor of the neighbours' moment for a velocity gradient; judged
DOUBT = 0.02   # tuned 0.01 to 0.04: density error near the surface that is disorder in calm fluid; judged
RAPID = 0.15   # tuned 0.075 to 0.3: rate of strain, over sqrt(a/s), at which flow is half rapid; judged
REST = 0.005   # tuned 0.0025 to 0.01: rate of strain, over sqrt(a/s), below which fluid is as good as at rest; judged
MEMORY = 20.0  # tuned 10 to 40: time that forgets the mean acceleration, over sqrt(s/a), more than an impact; judged
WHOLE = 0.02   # tuned 0.01 to 0.04: step over sqrt(s/a) that may regularise with full strength; judged

FIELDS = ("grad_u", "strain_rate")


def begin(flow: "Flow", fit: bool = False) -> None:
    """Write the fields grad_u and strain_rate, and name them in flow.stale. Collective.

    Of a potential flow they are known, that of the start of the step. Where the fit is wanted too, the rate is the
    smaller one of both: a rotation is no potential flow, and has strain there.

    fit : whether StepState.beyond_fit is wanted, which the same pass finds
    """
    p, step = flow.particles, flow.step
    flow.stale.update(FIELDS)
    if step.potential is not None and not fit:
        p.grad_u[:], step.beyond_fit = step.potential.gradient, None
        np.sqrt(2.0 * step.potential.square, out=p.strain_rate)
        return
    flow.fresh("role", "u")
    found = np.empty((p.n_owned if fit else 0, p.dim))
    strain.velocity_gradient(p.grad_u, p.strain_rate, found, flow.cloud, p.u_all, lengths.MLS * flow.spacing, SPAN)
    if step.potential is not None:
        np.minimum(p.strain_rate, np.sqrt(2.0 * step.potential.square), out=p.strain_rate)
    step.beyond_fit = found if fit else None


def beyond_fit(flow: "Flow") -> Floats:
    """Return what velocities (n_owned, dim) [m/s] have beyond the moving least squares of their neighbours.

    It is that of `begin` if this has found it. Not collective.
    """
    if flow.step.beyond_fit is not None:
        return flow.step.beyond_fit
    p = flow.particles
    found = np.empty_like(p.u)
    strain.velocity_gradient(np.empty((0, p.dim, p.dim)), np.empty(0), found, flow.cloud, p.u_all,
                             lengths.MLS * flow.spacing, SPAN)
    return found


def finish(flow: "Flow", dt: float) -> None:
    """Write the strain of a step: strained, dt sqrt(2 S:S) as the mean around each particle, rapid, doubt and whole.

    Collective.

    Regularisation is in proportion to strain: fluid at rest or in rigid motion is left alone, and the effect over
    a time does not depend on the number of steps in it. A rate far below REST sqrt(a/s), with the
    acceleration a by pressure alone, counts for less, with its square: in still water of disordered particles,
    moves in proportion to a small velocity would make it grow. See kernels.strain.judge.
    """
    p, step = flow.particles, flow.step
    flow.fresh(*FIELDS)
    out = p.strain_rate
    if step.potential is None or step.beyond_fit is not None:    # else its fit is a mean itself
        out = np.empty(p.n_owned)
        strain.mean_over_fluid(out, flow.cloud, p.strain_rate_all, lengths.MLS * flow.spacing)
    found = np.empty((3, p.n_owned))
    # a full closed tank does not notice a uniform force, which only its pressure balances
    strain.judge(found, out, step.by_pressure, flow.spacing, dt, 0.0 if flow.closed else REST, RAPID, DOUBT)
    step.strained, step.rapid, step.doubt = found
    step.whole = whole(flow, dt)


def whole(flow: "Flow", dt: float) -> float:
    """Return the part of their greatest strengths that regularisers may have in a step of dt [s], 0 to 1.

    Strained fluid soon has the greatest strength. If that were one for steps of any length, short steps would do more
    of it in a time, and lose more energy. It is in proportion to steps shorter than WHOLE sqrt(s/a), with the mean
    acceleration a of the fluid by pressure: particles resolve nothing faster. In a full closed tank, whose pressure
    balances any uniform force, and before a is known, it is whole.
    """
    a = flow.mean_acceleration
    return min(1.0, dt / (WHOLE * np.sqrt(flow.spacing / a))) if a > 0.0 and not flow.closed else 1.0


def remember(flow: "Flow", acceleration: float, dt: float) -> None:
    """Take the mean acceleration [m/s^2] of a step of dt [s] into that of the last steps. Not collective.

    It rises at once and falls slowly, so that fluid in free fall between two impacts is not taken for calm.

    acceleration : the square of the mean of its root, which impacts of a few particles hardly change
    """
    if acceleration > 0.0:
        left = 1.0 - min(1.0, dt / (MEMORY * np.sqrt(flow.spacing / acceleration)))
        flow.mean_acceleration = max(acceleration, left * flow.mean_acceleration)


def strength(flow: "Flow", most: float, per_strain: float) -> Floats:
    """Return a strength (n,) in proportion to the strain of the step, at most `most` in a whole one (`whole`).

    It is `most` if per_strain is 0.
    """
    if per_strain:
        return np.minimum(flow.step.whole * most, per_strain * flow.step.strained)
    return np.full(flow.particles.n_owned, most)
