"""Limits of the time step, which do not depend on the end of the run."""

import math
from collections.abc import Callable

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats, sizes
from parisph.base.errors import SolverDiverged
from parisph.base.fields import FLUID
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import record
from parisph.methods.flow import Flow
from parisph.methods.step_numbers import BRISK, IMPACT, STRAIN, WAVE_LEAST, WAVE_STRAIN
from parisph.methods.straining import WHOLE
from parisph.parallel.particles import Particles

GROWTH = 1.1    # tuned 1.05 to 1.2: largest ratio of successive steps; judged
# Shorter steps feed jets close above a solid, and disintegrating columns one or two particles wide.
LEAST_MOVE = 0.1    # tuned 0.05 to 0.2: least limit on the move of the fastest particle, in spacings; measured
WAVE_MOVE = 0.02    # tuned 0.01 to 0.04: the same in waves without a force; judged
GENTLE = 0.1    # tuned 0.05 to 0.2: part of the longest move by acceleration in the first step; judged
REST = 9.81     # [m/s^2], gravity on earth, which sets the first step of fluid at rest without forces
TOLD_MOVE = 0.3       # tuned 0.15 to 0.6: move in spacings in the shortest time that particles resolve; judged


def next_step(flow: Flow, gravity: float, previous: float | None = None, shortest: float = 0.0,
              accelerations: tuple[float, float] = (0.0, 0.0), strain_rate: float = 0.0,
              length: float | None = None) -> float:
    """Return the time step [s]: fixed, or limited by velocity, acceleration and body force. Collective.

    The limits are:

    - No particle moves by more than `numerics.cfl` spacings, neither by its velocity (|u| dt) nor from rest (g dt^2/2).
    - `fall` sqrt(l/a), with the length l of the flow's time scale. In waves and starting flow, a is 1.5 times the
      largest acceleration, at most the body force: a longer step costs accuracy long before it moves a particle far. In
      an impact a is 1.25 times the root of the mean square, which then is larger: in a dam break, half the step during
      the impact is worth as much as half the step all the time.
    - If `fall` is not 0, a mean strain of STRAIN.
    - In waves, `wave_step` sqrt(s/g), and a strain of WAVE_STRAIN, but at least WAVE_LEAST of the longest step. Steps
      that change within a period would feed or damp the wave.
    - In violent flow, impact and strain still let the fastest particle move LEAST_MOVE spacings.
    - Growth by a tenth, so that a single calm step during an impact does not undo the reduction.

    gravity : the largest body force on this rank's fluid [m/s^2], 0 if there is none
    previous : the last step [s], or None
    shortest : a step [s] below which the run has diverged
    accelerations : of fluid in the last step, on all ranks [m/s^2]: the largest, and the root of their mean square
    strain_rate : mean sqrt(2 S:S) of fluid in the last step, on all ranks [1/s]; with `wave_step` that of the last
        waves
    length : l [m], see case.time_scales.flow_length; None for the spacing
    Returns infinity without a limit.

    Raises SolverDiverged on every rank if a velocity is NaN, or so large that the step is below `shortest`.
    """
    numerics, particles = flow.numerics, flow.particles
    if numerics.time_step is not None:
        return numerics.time_step
    fastest, gravity, lost = _largest_of_all(particles.comm, _fastest(particles), gravity)
    if lost:
        raise SolverDiverged("the velocity of a particle is no longer a number")
    move = longest_move(numerics)
    dt = np.inf if fastest == 0.0 else move / fastest
    if dt < shortest:
        raise SolverDiverged(f"a particle has reached {fastest:.3g} m/s, for which the time step would have to "
                             f"be {dt:.3g} s: the flow is far too fast for this scene; use the preset violent,"
                             " or a smaller spacing")
    largest, mean = accelerations
    violent = _accurate(numerics, IMPACT * mean, length)
    if numerics.fall and strain_rate > 0.0:
        violent = min(violent, STRAIN / strain_rate)
    if fastest > 0.0:
        violent = max(violent, LEAST_MOVE * numerics.spacing / fastest)
    dt = min(dt, _fall(move, gravity), _accurate(numerics, min(BRISK * largest, gravity), length), violent,
             _of_waves(numerics, gravity, strain_rate, fastest, flow.wave_time))
    if numerics.max_time_step is not None:
        dt = min(dt, numerics.max_time_step)
    if previous is not None:
        dt = min(dt, GROWTH * previous)
    return float(dt)


def first_step(comm: MPI.Comm, particles: Particles, numerics: ResolvedNumerics, acceleration: Floats, dt: float,
               force_at: Callable[[float], float], length: float | None = None) -> float:
    """Return the first step of an adaptive run: `dt` [s], shortened. Collective.

    Released fluid has no velocity, so the acceleration, including that by the initial pressure, limits the step: |u| dt
    + 10 |a| dt^2 is at most `numerics.cfl` spacings. From rest, steps then grow by a tenth each until velocity limits
    them, instead of falling to a tenth of the first. The body force half way and at the end of the step must also allow
    it, because it may be zero at the start. Fluid at rest without forces has no time scale: its step is that of a fall
    from rest on earth.

    Parameters
    ----------
    acceleration : (n_owned, dim) at the start [m/s^2]
    force_at : function of a time after the start [s], the largest body force on this rank's fluid [m/s^2]
    length : as of `next_step`
    """
    move, fluid = longest_move(numerics), particles.kind == FLUID
    u, a = (sizes(v[fluid]) for v in (particles.u, acceleration))
    inverse = ((u + np.sqrt(u * u + 4.0 * move / GENTLE * a)) / (2.0 * move)).max(initial=0.0)
    mine = np.array([inverse, a.max(initial=0.0), force_at(0.0)])
    comm.Allreduce(MPI.IN_PLACE, mine, op=MPI.MAX)
    inverse, strongest, force = mine
    dt = min(dt, _accurate(numerics, min(BRISK * strongest, force), length), _of_waves(numerics, force))
    if inverse > 0.0:
        dt = min(dt, 1.0 / float(inverse))
    if dt == np.inf:
        dt = _fall(move, REST)
    while True:
        allowed = _fall(move, comm.allreduce(max(force_at(dt), force_at(0.5 * dt)), op=MPI.MAX))
        if not dt > allowed:    # also for a NaN force, on which the step itself raises
            return float(dt)
        dt = min(allowed, 0.5 * dt)


def resolved_time(comm: MPI.Comm, particles: Particles, spacing: float, force: Floats, acceleration: float = 0.0,
                  walls: Floats | None = None) -> float:
    """Return the shortest time [s] over which the pressure of particles has a meaning. Collective.

    It is the time in which the fastest particle moves TOLD_MOVE spacings, at most WHOLE sqrt(s/a), where a is the
    largest of the body force, of the acceleration by pressure and of that of walls; 0 if nothing moves or pulls. Over
    shorter times, pressure consists of the pulses of single particles that come to a wall or to the surface.

    force : (n_owned, dim), body force per unit mass [m/s^2]; that on walls does not count
    acceleration : mean of fluid by pressure, on all ranks [m/s^2]; it counts in a swaying tank without gravity, whose
        velocity passes through zero
    walls : (n_owned, dim), acceleration of wall particles [m/s^2], None if all walls rest; it counts beside a small
        swaying body in much water at rest, where the mean of the fluid is almost zero
    """
    strongest = record.fluid_sizes(force, particles.kind)[0]
    if walls is not None:
        strongest = max(strongest, float(sizes(walls).max(initial=0.0)))
    fastest, strongest, _ = _largest_of_all(comm, _fastest(particles), strongest)
    strongest = max(strongest, acceleration)
    rate = max(fastest / (TOLD_MOVE * spacing), np.sqrt(strongest / spacing) / WHOLE)
    return 1.0 / rate if 0.0 < rate < np.inf else 0.0


def rest_step(numerics: ResolvedNumerics) -> float:
    """Return the time [s] of a fall from rest on earth over the longest move of an adaptive step."""
    return float(_fall(longest_move(numerics), REST))


def longest_move(numerics: ResolvedNumerics) -> float:
    """Return the longest move [m] of a particle in an adaptive step."""
    return numerics.cfl * numerics.spacing


def _fall(move: float, gravity: float) -> float:
    """Return the time [s] of a fall from rest over `move` [m]; infinite without a force."""
    return np.sqrt(2.0 * move / gravity) if gravity > 0.0 else np.inf


def _accurate(numerics: ResolvedNumerics, acceleration: float, length: float | None) -> float:
    """Return the longest step [s] with a small error of the scheme in time; infinite without acceleration."""
    if not (numerics.fall and acceleration > 0.0):
        return np.inf
    found: float = numerics.fall * np.sqrt((length or numerics.spacing) / acceleration)
    return found


def _of_waves(numerics: ResolvedNumerics, gravity: float, strain_rate: float = 0.0, fastest: float = 0.0,
              wave_time: float = np.inf) -> float:
    """Return the longest step [s] of waves; infinite without `wave_step`."""
    if not numerics.wave_step:
        return np.inf
    by_gravity = numerics.wave_step * np.sqrt(numerics.spacing / gravity) if gravity > 0.0 else np.inf
    if strain_rate == 0.0:
        return by_gravity
    if wave_time < np.inf:
        least = WAVE_LEAST * numerics.wave_step * wave_time
    else:
        least = WAVE_MOVE * numerics.spacing / fastest if fastest > 0.0 else 0.0
    return min(by_gravity, max(WAVE_STRAIN / strain_rate, least))


def _fastest(particles: Particles) -> float:
    return record.fluid_sizes(particles.u, particles.kind)[0]


def _largest_of_all(comm: MPI.Comm, speed: float, force: float) -> Floats:
    """Return the largest speed and force on all ranks, and whether any speed is NaN. Collective."""
    worst = np.array([speed, force, math.isnan(speed)], float)
    worst[np.isnan(worst)] = 0.0
    if comm.size > 1:
        comm.Allreduce(MPI.IN_PLACE, worst, op=MPI.MAX)
    return worst
