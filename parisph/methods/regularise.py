"""What a violent step does beside the projection: to velocities, then to positions."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels import collisions, shifting
from parisph.kernels import surface as surfaces
from parisph.methods import schemes

WORK = 0.1  # largest share of |u|^2 that the work of one displacement may change
SLACK = 1e3  # tolerance of the position solve over that of the pressure: one in a thousand of a small move
CAP = 0.1  # longest move of the position projection and of the shift, in spacings


def velocity(method, dt):
    """Filter, pair collisions and wall guard, each if the scene has it. Collective.

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
    """Position projection, then Fick shift, with the work that they do taken from the speed. Collective.

    force : (n_all, dim), body force per unit mass [m/s^2]

    Returns the SolveRecord of the position projection, None without one. The lists and the matrix are those of the
    pressure: half a step has moved neighbours against each other by far less than a spacing.
    """
    p, d, n = method.particles, method.domain, method.numerics
    h = schemes.DENSITY * method.spacing
    d.update("x")
    walls = (p.x_all, p.kind_all, p.corner_all, p.normal_all)
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
    """Displace the owned fluid, but not into a wall, and no farther along the force than it can pay for."""
    p, d, n = method.particles, method.domain, method.numerics
    shifting.limit_work(move, p.u, force, p.kind, WORK, p.n_owned, method.axes)
    if n.wall_guard > 0.0:
        collisions.keep_off_walls(move, p.x_all, p.kind_all, p.corner_all, p.normal_all,
                                  n.wall_guard * method.spacing, d.indptr, d.indices, method.axes)
    shifting.take_work(p.u, move, force, p.kind, p.n_owned, method.axes)
    fluid = p.kind == FLUID
    p.x[fluid] += move[fluid]
