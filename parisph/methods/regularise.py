"""The regularisation of violent flows: first of velocities, then of positions."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels import collisions, shifting, wetness
from parisph.kernels import surface as surfaces
from parisph.methods import schemes

WORK = 0.1  # largest share of the kinetic energy that the work of one displacement may change
SLACK = 1e3  # tolerance of the position solve over that of the pressure: one in a thousand of a small move
CAP = 0.1  # longest move of the position projection and of the shift, in spacings


def velocity(method, dt):
    """Apply the filter, pair collisions and the wall guard, if the case uses them. Collective.

    Returns the number of collisions of owned particles.
    """
    p, d, n = method.particles, method.domain, method.numerics
    hits = 0
    if n.filter > 0.0:
        d.update("u")
        change = np.empty_like(p.u)
        collisions.smooth_velocity(change, p.u_all, p.x_all, p.kind_all, p.role_all, n.filter,
                                   schemes.MLS * method.spacing, d.indptr, d.indices, method.axes)
        p.u[:] += change
    if n.collision_distance > 0.0:
        d.update("u")
        change = np.empty_like(p.u)
        hits = collisions.pair_collisions(change, p.u_all, p.x_all, p.kind_all, p.volume_all,
                                          n.collision_distance * method.spacing, n.restitution,
                                          d.indptr, d.indices, method.axes)
        p.u[:] += change
    if n.wall_guard > 0.0:
        collisions.wall_guard(p.u_all, p.x_all, p.kind_all, p.corner_all, p.normal_all,
                              n.wall_guard * method.spacing, dt, d.indptr, d.indices, method.axes)
    return hits


def positions(method, force):
    """Apply the position projection, then the Fick shift; neither changes the energy. Collective.

    force : (n_all, dim), body force per unit mass [m/s^2]

    Returns the SolveRecord of the position projection, None without one. Uses the lists and the matrix of
    the pressure solve: within half a step, neighbours move relative to each other by far less than a spacing.
    """
    p, d, n = method.particles, method.domain, method.numerics
    h = schemes.DENSITY * method.spacing
    d.update("x")
    walls = (p.x_all, method.seen(wetness.FREE), p.corner_all, p.normal_all)
    solve = _project(method, force, walls, h) if n.kappa > 0.0 else None
    if n.shift > 0.0:
        shifting.concentration_gradient(p.grad_alpha, *walls, h, method.full, d.indptr, d.indices, method.axes)
        d.update("grad_alpha")
        shift = np.empty_like(p.x)
        shifting.fick_shift(shift, p.grad_alpha_all, p.role_all, p.x_all, p.kind_all, n.shift * h * h,
                            CAP * method.spacing, 2.0 * method.spacing, d.indptr, d.indices, method.axes)
        _move(method, shift, force)
    return solve


def compression(method):
    """Return alpha - 1 of owned inner particles, within +-.1 and one-sided by the surface: (n_owned,)."""
    p, d = method.particles, method.domain
    e = np.empty(p.n_owned)
    shifting.compression(e, p.alpha, p.role_all, p.x_all, p.kind_all, 0.1, schemes.WALL * method.spacing,
                         d.indptr, d.indices, method.axes)
    return e


def _project(method, force, walls, h):
    """Solve A phi = kappa e with the pressure matrix, move by -grad phi, return the SolveRecord."""
    p, d, n = method.particles, method.domain, method.numerics
    surfaces.density_ratio(p.alpha, *walls, h, method.full, d.indptr, d.indices, method.axes)
    e = compression(method)
    p.phi[:], solve = method.solver.solve_again(method.rows.right_hand_side(-n.kappa * e), p.phi, slack=SLACK)
    d.update("phi")
    move = -method.pressure_gradient(p.phi_all)
    shifting.limit_lengths(move, p.n_owned, CAP * method.spacing, method.axes)
    _move(method, move, force)
    d.update("x")
    return solve


def _move(method, move, force):
    """Displace the owned fluid, but not into a wall, and keep the total energy of the fluid. Collective."""
    p, d, n = method.particles, method.domain, method.numerics
    if n.wall_guard > 0.0:
        collisions.keep_off_walls(move, p.x_all, p.kind_all, p.corner_all, p.normal_all,
                                  n.wall_guard * method.spacing, d.indptr, d.indices, method.axes)
    share, scale = _paid(p, move, force)
    fluid = p.kind == FLUID
    p.x[fluid] += share * move[fluid]
    p.u[fluid] *= scale


def _paid(p, move, force):
    """Return the fraction of the displacements to apply, and the factor for all velocities. Collective.

    Lifted particles gain potential energy, which a regularisation must not add: without the factor, the
    falling column gains .3 % before the impact, and a shaken tank a quarter of its wave. All
    velocities are scaled equally, by some 1e-5 per step, so that the velocity stays free of divergence.
    If each particle paid for itself, the pressure would be rough, and slow fluid would tear off walls. To
    leave fluid at rest alone, the work is at most the fraction WORK of the kinetic energy.
    """
    own = [np.einsum("i,ia,ia", p.volume, force[:p.n_owned], move), 0.5 * np.einsum("i,ia,ia", p.volume, p.u, p.u)]
    work, kinetic = p.comm.allreduce(np.array(own))
    if work == 0.0 or not np.isfinite(work + kinetic):    # what is wrong is said where particles are looked for
        return 1.0, 1.0
    share = min(1.0, WORK * kinetic / abs(work))
    return share, np.sqrt(1.0 + share * work / kinetic) if kinetic > 0.0 else 1.0
