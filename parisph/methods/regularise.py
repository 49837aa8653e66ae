"""The regularisation of violent flows: first of velocities, then of positions."""

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels import collisions, halves, pairs, shifting, strain, wetness
from parisph.kernels import surface as surfaces
from parisph.methods import schemes
from parisph.pressure.solver import SolveRecord

SLACK = 1e3  # tolerance of the position solve over that of the pressure: one in a thousand of a small move
CAP = 0.1    # longest move of the position projection and of the shift, in spacings
SPAN = 0.05  # det/(trace/dim)^dim of the neighbours' moment below which there is no velocity gradient
DOUBT = 0.02  # density error near the surface that is no more than disorder in calm fluid
RAPID = 0.15  # rate of strain, over sqrt(a/s), at which the doubt is half of that, and flow half rapid
REST = 0.005  # rate of strain, over sqrt(a/s), below which fluid is as good as at rest

# Close pairs; lengths in spacings.
TURN_WITHIN, TURN = 0.7, 0.05   # pairs of inner particles that turn, and by how much at the full strength of the shift
TURNS = 2.5     # times that, at most: a lattice collapses within a few long steps, in which the shift has its full strength
PART_WITHIN, PART = 0.6, 0.5    # pairs without pressure that part, and the fraction of what is missing
APART, SWEEPS, SWEEP = 0.45, 8, 0.15    # distance that all pairs are brought to, sweeps at most, and longest move in one


def strain_of_step(method, dt) -> np.ndarray | None:
    """Return the strain of the fluid in a step, dt sqrt(2 S:S), as the mean around each particle: (n_owned,). Collective.

    Regularisation is in proportion to it: fluid at rest or in rigid motion is left alone, and the effect over
    a time does not depend on the number of steps in it. A rate far below REST sqrt(a/s), with the
    acceleration a by pressure alone, counts for less, with its square: in still water of disordered particles,
    moves in proportion to a small velocity would make it grow. Also computes the velocity gradient, for pair
    collisions, and the doubt in the density error. None if nothing in the case needs it.
    """
    p, d, n = method.particles, method.domain, method.numerics
    if not (n.filter_strain or n.collision_distance or n.kappa or n.shift):
        return None
    d.update("u")
    radius = schemes.MLS * method.spacing
    strain.velocity_gradient(p.grad_u, p.strain_rate, p.u_all, p.x_all, p.kind_all, p.role_all, radius, SPAN,
                             d.indptr, d.indices, method.axes)
    d.update("grad_u", "strain_rate")
    out = np.empty(p.n_owned)
    strain.mean_over_fluid(out, p.strain_rate_all, p.x_all, p.kind_all, radius, d.indptr, d.indices, method.axes)
    # a full closed tank does not notice a uniform force, which only its pressure balances
    small = 0.0 if method.closed else REST * np.sqrt(method.by_pressure / method.spacing)
    method.rapid = _rapid(out, method.by_pressure / method.spacing)
    method.doubt = DOUBT * (1.0 - method.rapid)
    return dt * out * out / np.maximum(out + small, np.finfo(float).tiny)


def _rapid(rate, square):
    """Return how rapid a strain is, D^2/(D^2 + RAPID^2 a/s), from 0 in calm fluid to 1: (n,).

    Rapid strain packs particles faster than disorder does, and all of that is compression: the density error near
    the surface that may be disorder is DOUBT times what is left to 1.

    rate : (n,), D [1/s]; square : (n,), a/s of the acceleration a by pressure alone [1/s^2]
    """
    calm = RAPID**2 * square
    return 1.0 - calm / np.maximum(calm + rate**2, np.finfo(float).tiny)


def velocity(method, dt, strained) -> int:
    """Apply the filter, pair collisions and the wall guard, if the case uses them. Collective.

    strained : (n_owned,) or None, of `strain_of_step`

    Returns the number of collisions of owned particles.
    """
    p, d, n = method.particles, method.domain, method.numerics
    hits = 0
    if n.filter > 0.0:
        d.update("u")
        change = np.empty_like(p.u)
        collisions.smooth_velocity(change, p.u_all, p.x_all, p.kind_all, p.role_all, _strength(n.filter, n.filter_strain, strained, p.n_owned),
                                   schemes.MLS * method.spacing, d.indptr, d.indices, method.axes)
        p.u[:] += change
        method.budget.mark(p, "filter")
    if n.collision_distance > 0.0:
        hits = _collide(method)
        method.budget.mark(p, "collisions")
    if n.wall_guard > 0.0:
        collisions.wall_guard(p.u_all, p.x_all, p.kind_all, p.corner_all, p.normal_all,
                              n.wall_guard * method.spacing, dt, d.indptr, d.indices, method.axes)
        method.budget.mark(p, "guard")
    return hits


def keep_in_tank(method, u, dt) -> np.ndarray:
    """Limit a velocity (n_owned, dim) of the fluid, by which it will be moved, with the wall guard. Not collective.

    Particles move by the mean of two velocities. The guard of the new one alone would let a particle that is
    stopped in this step pass the wall, and stop one that is only slowed down.
    """
    p, d, n = method.particles, method.domain, method.numerics
    if not n.wall_guard:
        return u
    both = p.u_all.copy()    # walls keep theirs
    fluid = p.kind == FLUID
    both[:p.n_owned][fluid] = u[fluid]
    collisions.wall_guard(both, p.x_all, p.kind_all, p.corner_all, p.normal_all, n.wall_guard * method.spacing, dt,
                          d.indptr, d.indices, method.axes)
    return both[:p.n_owned]


def _strength(most, per_strain, strained, n):
    """Return a strength in proportion to the strain of the step, at most `most`; `most` itself if per_strain is 0: (n,)."""
    return np.minimum(most, per_strain * strained) if per_strain else np.full(n, most)


def _collide(method):
    """Let close pairs collide; return the number of collisions of owned particles. Collective."""
    p, d, n = method.particles, method.domain, method.numerics
    distance = n.collision_distance * method.spacing
    d.update("u")
    collisions.count_collisions(p.pairs, p.u_all, p.x_all, p.grad_u_all, p.kind_all, distance, d.indptr, d.indices, method.axes)
    d.update("pairs")
    change = np.empty_like(p.u)
    hits = collisions.pair_collisions(change, p.pairs_all, p.u_all, p.x_all, p.grad_u_all, p.kind_all, p.volume_all,
                                      distance, n.restitution, d.indptr, d.indices, method.axes)
    p.u[:] += change
    return hits


def positions(method, strained) -> SolveRecord | None:
    """Apply the position projection, part close pairs, then apply the Fick shift. Collective.

    strained : (n_owned,), of `strain_of_step`

    Returns the SolveRecord of the position projection, None without one. Uses the lists and the matrix of
    the pressure solve: within half a step, neighbours move relative to each other by far less than a spacing.
    """
    p, d, n = method.particles, method.domain, method.numerics
    h = schemes.DENSITY * method.spacing
    d.update("x")
    walls = (p.x_all, method.seen(wetness.FREE), p.corner_all, p.normal_all)
    _share(method)
    solve = _project(method, _strength(n.kappa, n.kappa_strain, strained, p.n_owned), walls, h) if n.kappa > 0.0 else None
    method.budget.mark(p, "projection")
    if n.shift > 0.0:
        _part(method)
        method.budget.mark(p, "parting")
        _shift(method, strained, walls, h)
        method.budget.mark(p, "shift")
        _keep_apart(method)
        method.budget.mark(p, "parting")
    return solve


def _share(method):
    """Find the part of the half cells at walls for which fluid stands. Collective.

    Fluid that fills a closed tank started at all of its walls.
    """
    p, d = method.particles, method.domain
    if not method.closed:
        halves.wall_share(p.share, p.x_all, p.kind_all, p.volume_all, p.normal_all, method.spacing, d.indptr, d.indices,
                          method.axes)
        d.update("share")


def _surplus(method, walls, h):
    """Return what half cells at walls for which no fluid stands add to alpha (n_owned,), and to its gradient (n_owned, dim)."""
    p, d = method.particles, method.domain
    ratio, gradient = np.zeros(p.n_owned), np.zeros((p.n_owned, p.dim))
    if not method.closed:
        x, kind, corner, normal = walls
        halves.surplus(ratio, gradient, x, kind, p.share_all, corner, normal, h, method.full, d.indptr, d.indices, method.axes)
    return ratio, gradient


def _less_pushed(push, less, rapid):
    """Return a push with the part of it that is due to a surplus left out in rapid flow, but without a pull: (n,).

    push : (n,), with the surplus; less : (n,), without it; rapid : (n,), 0 to 1
    """
    return push + rapid * (np.minimum(push, np.maximum(less, 0.0)) - push)


def _keep_apart(method):
    """Bring all pairs of fluid to a least distance, as far as a few sweeps can. Collective.

    Columns and jets one or two particles wide have no pressure. When they fall on something, their particles would end
    in one place.
    """
    p, d = method.particles, method.domain
    move, near = np.empty_like(p.x), np.ones(p.n_owned, bool)
    for _ in range(SWEEPS):
        d.update("x")
        crowded = pairs.keep_apart(move, near, p.x_all, p.kind_all, p.id_all, APART * method.spacing, SWEEP * method.spacing,
                                   d.indptr, d.indices, method.axes)
        if not p.comm.allreduce(crowded):
            break
        _move(method, move)


def _part(method):
    """Part close pairs that have no pressure. Collective."""
    p, d = method.particles, method.domain
    distance = PART_WITHIN * method.spacing
    pairs.count_close(p.pairs, p.x_all, p.kind_all, p.role_all, distance, d.indptr, d.indices, method.axes)
    d.update("pairs")
    move = np.empty_like(p.x)
    pairs.part_pairs(move, p.pairs_all, p.x_all, p.kind_all, p.role_all, p.id_all, distance, PART, d.indptr, d.indices, method.axes)
    _move(method, move)
    d.update("x")


def _shift(method, strained, walls, h):
    """Shift by C_i h^2 along -grad alpha, and turn close pairs. Collective.

    strained : (n_owned,) or None, of `strain_of_step`
    """
    p, d, n = method.particles, method.domain, method.numerics
    shifting.concentration_gradient(p.grad_alpha, *walls, h, method.full, d.indptr, d.indices, method.axes)
    _push_off_less(method, _surplus(method, walls, h)[1])
    d.update("grad_alpha")
    move = np.empty_like(p.x)
    strength = _strength(n.shift, n.shift_strain, strained, p.n_owned)
    shifting.fick_shift(move, p.grad_alpha_all, p.role_all, p.x_all, p.kind_all, strength * h * h,
                        CAP * method.spacing, 2.0 * method.spacing, d.indptr, d.indices, method.axes)
    turns = TURNS if n.shift_strain and not method.closed else 1.0
    p.turn[:] = TURN * method.spacing * _strength(turns, n.shift_strain / n.shift, strained, p.n_owned)
    d.update("turn")
    pairs.turn_pairs(move, p.x_all, p.kind_all, p.role_all, p.id_all, TURN_WITHIN * method.spacing, p.turn_all,
                     d.indptr, d.indices, method.axes)
    _move(method, move)


def _push_off_less(method, surplus):
    """Leave out of grad alpha what pushes fluid off a wall by half cells for which no fluid stands, in rapid flow.

    surplus : (n_owned, dim), the part of grad alpha by those
    """
    p = method.particles
    size = np.linalg.norm(surplus, axis=1)
    some = size > 0.0
    towards = surplus[some] / size[some, None]
    push = np.einsum("ia,ia->i", p.grad_alpha[some], towards)
    p.grad_alpha[some] += (_less_pushed(push, push - size[some], method.rapid[some]) - push)[:, None] * towards


def compression(method, alpha, doubt) -> np.ndarray:
    """Return alpha - 1 of owned inner particles, within +-.1, and near the surface what is above the doubt: (n_owned,).

    alpha, doubt : (n_owned,)
    """
    p, d = method.particles, method.domain
    e = np.empty(p.n_owned)
    shifting.compression(e, alpha, p.role_all, p.x_all, p.kind_all, 0.1, doubt, schemes.WALL * method.spacing,
                         d.indptr, d.indices, method.axes)
    return e


def _compression(method, walls, h):
    """Return the density error that the position projection removes: (n_owned,). Also writes alpha.

    A wall for which no fluid stands does not lift rapid fluid off, nor attract it: e = min(e, max(e', 0)) with the
    error e' without the surplus. In calm fluid, which loses nothing to a slow move, the wall keeps its weight.
    """
    p, d = method.particles, method.domain
    surfaces.density_ratio(p.alpha, *walls, h, method.full, d.indptr, d.indices, method.axes)
    e, surplus = compression(method, p.alpha, method.doubt), _surplus(method, walls, h)[0]
    return _less_pushed(e, compression(method, p.alpha - surplus, method.doubt), method.rapid) if surplus.any() else e


def _project(method, strength, walls, h):
    """Solve A phi = kappa_i e with the pressure matrix, move by -grad phi, return the SolveRecord. Collective.

    strength : (n_owned,), kappa_i
    """
    p, d = method.particles, method.domain
    e = strength * _compression(method, walls, h)
    p.phi[:], solve = method.solver.solve_again(method.rows.right_hand_side(-e), p.phi, slack=SLACK)
    d.update("phi")
    move = -method.pressure_gradient(p.phi_all)
    shifting.limit_lengths(move, p.n_owned, CAP * method.spacing, method.axes)
    _move(method, move)
    d.update("x")
    return solve


def _move(method, move):
    """Displace the owned fluid, but not into a wall."""
    p, d, n = method.particles, method.domain, method.numerics
    if n.wall_guard > 0.0:
        collisions.keep_off_walls(move, p.x_all, p.kind_all, p.corner_all, p.normal_all,
                                  n.wall_guard * method.spacing, d.indptr, d.indices, method.axes)
    fluid = p.kind == FLUID
    p.x[fluid] += move[fluid]
