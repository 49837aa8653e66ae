"""Strain of a step, which scales regularisation."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.kernels import strain
from parisph.methods import lengths
from parisph.methods.last_waves import WAVES

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

# of det/(trace/dim)^dim, below which fluid is one layer
FLOOR = 0.05    # tuned 0.025 to 0.1: floor of the neighbours' moment with a plain weight, for a gradient; judged
DOUBT = 0.02   # tuned 0.01 to 0.04: density error near the surface that is disorder in calm fluid; judged
RAPID = 0.15   # tuned 0.075 to 0.3: rate of strain, over sqrt(a/s), at which flow is half rapid; judged
REST = 0.005   # tuned 0.0025 to 0.01: rate of strain, over sqrt(a/s), of fluid nearly at rest; judged
WHOLE = 0.02   # tuned 0.01 to 0.04: time over sqrt(s/a) that particles resolve, a step of full regularisation; judged

FIELDS = ("grad_u", "strain_rate")


def begin(flow: "Flow", fit: bool = False) -> None:
    """Write the fields grad_u and strain_rate, and add them to flow.stale. Collective.

    They are those of the potential flow at the start of the step, if there is one. With the fit, the rate is the
    smaller of both, as a rotation, which is not a potential flow, has strain there.

    fit : whether StepState.beyond_fit is wanted, which the same pass computes
    """
    p, step = flow.particles, flow.step
    flow.stale.update(FIELDS)
    if step.potential is not None and not fit:
        p.grad_u[:], step.beyond_fit = step.potential.gradient, None
        np.sqrt(2.0 * step.potential.square, out=p.strain_rate)
        return
    flow.fresh("role", "u")
    found = np.empty((p.n_owned if fit else 0, p.dim))
    strain.velocity_gradient(p.grad_u, p.strain_rate, found, flow.cloud, p.u_all, lengths.MLS * flow.spacing, FLOOR)
    if step.potential is not None:
        np.minimum(p.strain_rate, np.sqrt(2.0 * step.potential.square), out=p.strain_rate)
    step.beyond_fit = found if fit else None


def beyond_fit(flow: "Flow") -> Floats:
    """Return the deviation (n_owned, dim) [m/s] of velocities from their moving least squares. Not collective.

    `begin` may have computed it.
    """
    if flow.step.beyond_fit is not None:
        return flow.step.beyond_fit
    p = flow.particles
    found = np.empty_like(p.u)
    strain.velocity_gradient(np.empty((0, p.dim, p.dim)), np.empty(0), found, flow.cloud, p.u_all,
                             lengths.MLS * flow.spacing, FLOOR)
    return found


def finish(flow: "Flow", dt: float) -> None:
    """Write the strain of a step: strained, the local mean of dt sqrt(2 S:S), rapid, doubt and whole. Collective.

    Regularisation in proportion to strain does not act on fluid at rest or in rigid motion, and its effect over a time
    does not depend on the number of steps. A rate far below REST sqrt(a/s), with the acceleration a by pressure alone,
    counts with its square: in still water of disordered particles, moves in proportion to a small velocity would
    amplify it. See kernels.strain.judge.
    """
    p, step = flow.particles, flow.step
    flow.fresh(*FIELDS)
    out = p.strain_rate
    if step.potential is None or step.beyond_fit is not None:    # otherwise the fit is a mean
        out = np.empty(p.n_owned)
        strain.mean_over_fluid(out, flow.cloud, p.strain_rate_all, lengths.MLS * flow.spacing)
    found = np.empty((3, p.n_owned))
    # pressure balances a uniform force on a full closed tank, so a has no meaning
    strain.judge(found, out, step.by_pressure, flow.spacing, dt, 0.0 if flow.closed else REST, RAPID, DOUBT)
    step.strained, step.rapid, step.doubt = found
    step.whole = whole(flow, dt)


def whole(flow: "Flow", dt: float) -> float:
    """Return the part of their maximum strength that regularisers may have in a step of dt [s], 0 to 1.

    Strained fluid soon has the maximum strength. With the same maximum for steps of any length, short steps would
    regularise more per time and lose more energy. It is therefore in proportion to steps shorter than WHOLE sqrt(s/a),
    with the mean acceleration a of the fluid by pressure: particles resolve nothing faster. It is 1 in a full closed
    tank, whose pressure balances any uniform force, and before a is known.
    """
    a = flow.mean_acceleration
    return min(1.0, dt / (WHOLE * np.sqrt(flow.spacing / a))) if a > 0.0 and not flow.closed else 1.0


def remember(flow: "Flow", acceleration: float, dt: float) -> None:
    """Include the mean acceleration [m/s^2] of a step of dt [s] in that of the last steps. Not collective.

    The memory rises at once and falls over WAVES sqrt(s/a), longer than an impact, so that fluid in free fall between
    two impacts does not count as calm.

    acceleration : the squared mean of square roots, which impacts of a few particles hardly change
    """
    if acceleration > 0.0:
        left = 1.0 - min(1.0, dt / (WAVES * np.sqrt(flow.spacing / acceleration)))
        flow.mean_acceleration = max(acceleration, left * flow.mean_acceleration)


def strength(flow: "Flow", most: float, per_strain: float) -> Floats:
    """Return a strength (n,) in proportion to the strain of the step, up to `most` times `whole`.

    It is `most` if per_strain is 0.
    """
    if per_strain:
        return np.minimum(flow.step.whole * most, per_strain * flow.step.strained)
    return np.full(flow.particles.n_owned, most)
