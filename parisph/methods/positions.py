"""Regularisers of positions: position projection, close pairs, and Fick shift."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import INNER
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import movement, pairs, shifting, strain, wetness
from parisph.methods import lengths, straining
from parisph.methods.parts import REGULARISERS, SURFACES, Limiter, Regulariser
from parisph.parallel.sums import sums

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

# The solver caps the product at a relative residual of 1e-3 (pressure.solver.LOOSEST), enough for small displacements.
SLACK = 1e3  # tuned 500 to 2000: tolerance of the position solve over that of the pressure; judged
CAP = 0.1    # tuned 0.05 to 0.2: longest move of the projection, the shift and a sweep, in spacings; judged
LIMIT = 0.1  # tuned 0.05 to 0.2: largest density error that counts, either way; judged
# Waves have errors of up to .023 in phase with them, where their divergence is not exact (a = .6 d, d/s = 10; .017 with
# a = .05 d), and disorder of .4 has .02. With .035 a heaving box raises the level of a flume two to three times as
# much; with .02 that wave errs twice as much.
VOID = 0.025    # tuned 0.0125 to 0.05: mean density error of a void in calm fluid; measured
NEAR_SURFACE = 2.0    # tuned 1 to 4: distance from the surface within which a shift is along it, in spacings; judged

# Close pairs; lengths in spacings.
TURN_WITHIN = 0.7    # tuned 0.35 to 1: distance of inner pairs that rotate; judged
# A lattice collapses within a few long steps, at the full strength of the shift.
TURN = 0.05     # tuned 0.025 to 0.1: rotating move at the full strength of the shift, in spacings; judged
TURNS = 3.0     # tuned 1.5 to 6: largest multiple of this move in a step; measured
PART_WITHIN = 0.6    # tuned 0.3 to 1: distance of pairs without pressure that separate; judged
PART = 0.5      # tuned 0.25 to 1: fraction of the missing distance by which they separate; judged
CLOSE = max(TURN_WITHIN, PART_WITHIN)
APART = 0.45    # tuned 0.225 to 0.9: least distance of all pairs; judged
SWEEPS = 8      # tuned 4 to 16: most sweeps that separate pairs; judged
# Distance of the pairs in the sweeps. Those farther apart, or coincident, are left to the next step.
WATCHED = APART + 3.0 * CAP


class PositionProjection(Regulariser):
    """Moves particles along -grad phi, lap phi = -kappa e, with the matrix of the pressure and the density error e.

    In rapid flow e = alpha - 1, in calm flow it is that of voids only, with StepState.rapid in between: in a wave alpha
    errs in phase with it, and moves that follow alpha would feed the wave. The whole error counts in full closed tanks,
    and for a strength that is not in proportion to the strain.

    Neighbour lists and matrix are those of the pressure solve: within half a step, neighbours move relative to each
    other by far less than a spacing. A shift in every second step only would save a tenth of the cost, but the dam
    break at H/s = 80 then gains .5 % of its energy, and P2 errs by .04 to .12 instead of .03 to .06.
    """

    name, cause, words, moves = "projection", "projection", "position projection", True
    fields = (*straining.FIELDS, "alpha", "lack", "hollow", "phi")
    reads = ("kappa", "kappa_strain")

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.kappa > 0.0

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        return (*self.fields, *_share_of(numerics))

    def prepare(self, flow: "Flow", dt: float) -> None:
        n, error = flow.numerics, self.error(flow)
        solve(flow, straining.strength(flow, n.kappa, n.kappa_strain) * error)

    def error(self, flow: "Flow") -> Floats:
        """Return the density error (n_owned,) to be removed. Collective."""
        if flow.closed or not flow.numerics.kappa_strain:
            return density_error(flow)
        error = density_error(flow)
        # 1/2 at a strain rate of RAPID/sqrt(2) sqrt(a/s)
        rapid = 2.0 * flow.step.rapid / (1.0 + flow.step.rapid)
        return rapid * error + (1.0 - rapid) * voids(flow)

    def change(self, flow: "Flow", dt: float) -> Floats:
        p = flow.particles
        move = -flow.pressure_gradient(p.phi_all)
        shifting.limit_lengths(move, p.n_owned, CAP * flow.spacing, flow.axes)
        return move


class VoidFilling(PositionProjection):
    """Position projection for waves, of voids only, as particles leave them that oscillate around an edge.

    It does not act where initial cells differ from those of the lattice by more than VOID: there `shift_even` equalises
    distances instead of volumes, and leaves no voids.
    """

    name, words = "fill_voids", "filling of voids"

    def prepare(self, flow: "Flow", dt: float) -> None:
        p, n = flow.particles, flow.numerics
        error = voids(flow)
        error[np.abs(p.weight - 1.0) > VOID] = 0.0
        if sums(p.comm, int(np.any(error)))[0]:
            solve(flow, straining.strength(flow, n.kappa, n.kappa_strain) * error)

    def change(self, flow: "Flow", dt: float) -> Floats:
        return np.zeros_like(flow.particles.x) if flow.step.position_solve is None else super().change(flow, dt)


def voids(flow: "Flow") -> Floats:
    """Return the excess of the mean density error around each inner particle below -VOID: (n_owned,). Collective.

    The mean removes the scatter of disorder. Its initial value is not a void, and is subtracted.
    """
    p, d = flow.particles, flow.domain
    p.lack[:] = density_error(flow)
    d.update("lack")
    found = np.zeros(p.n_owned)
    if np.any(p.lack_all < -VOID):    # otherwise all means are above -VOID
        strain.mean_over_fluid(found, flow.cloud, p.lack_all, lengths.MLS * flow.spacing)
        found = np.where(p.role == INNER, np.minimum(found + VOID, 0.0), 0.0)
    np.copyto(p.hollow, found, where=np.isnan(p.hollow))
    return np.minimum(found - p.hollow, 0.0)


def solve(flow: "Flow", error: Floats) -> None:
    """Solve lap phi = -error (n_owned,) with the matrix of the pressure. Collective."""
    p = flow.particles
    p.phi[:], flow.step.position_solve = flow.solver.solve_again(flow.rows.right_hand_side(-error), p.phi, slack=SLACK)
    flow.stale.add("phi")


class Parting(Regulariser):
    """Separates close pairs without pressure."""

    name, cause, words, fields = "parting", "parting", "parting of close pairs", ("pairs",)
    reads = ("shift",)
    moves, strain, free = True, False, True

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.shift > 0.0

    def prepare(self, flow: "Flow", dt: float) -> None:
        pairs.count_close(flow.particles.pairs, flow.close_pairs(CLOSE), PART_WITHIN * flow.spacing)
        flow.stale.add("pairs")

    def change(self, flow: "Flow", dt: float) -> Floats:
        p = flow.particles
        move = np.empty_like(p.x)
        pairs.part_pairs(move, flow.close_pairs(CLOSE), p.pairs_all, p.id_all, PART_WITHIN * flow.spacing, PART)
        return move


class FickShift(Regulariser):
    """Shifts by C_i h^2 along -grad alpha, at the surface along it, and rotates close pairs."""

    name, source, cause, words, moves = "shift", "Lind et al. 2012", "shift", "Fick shift", True
    reads = ("shift", "shift_strain")
    fields = ("grad_alpha", "turn")

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.shift > 0.0

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        strain = (*straining.FIELDS, *_share_of(numerics)) if numerics.shift_strain else ()
        return (*self.fields, "alpha", *strain)

    def prepare(self, flow: "Flow", dt: float) -> None:
        p, n = flow.particles, flow.numerics
        p.grad_alpha[:] = dense(flow)
        if n.shift_strain and flow.open:
            shifting.stiffen(p.grad_alpha, flow.cloud, p.covered_all, p.weight_all)
        turns = TURNS if n.shift_strain and not flow.closed else 1.0
        p.turn[:] = TURN * flow.spacing * straining.strength(flow, turns, n.shift_strain / n.shift)
        flow.stale.update(self.fields)

    def change(self, flow: "Flow", dt: float) -> Floats:
        p, n = flow.particles, flow.numerics
        h = lengths.DENSITY * flow.spacing
        move = np.empty_like(p.x)
        shifting.fick_shift(move, flow.cloud, p.grad_alpha_all,
                            straining.strength(flow, n.shift, n.shift_strain) * h * h, CAP * flow.spacing,
                            NEAR_SURFACE * flow.spacing)
        pairs.turn_pairs(move, flow.close_pairs(CLOSE), p.id_all, p.turn_all, TURN_WITHIN * flow.spacing)
        return move


class KeepApart(Limiter):
    """Brings all pairs of fluid to a least distance, as far as a few sweeps can.

    Columns and jets one or two particles wide have no pressure. In a collision, their particles would end in one place.
    """

    name, cause, words, moves, strain = "keep_apart", "parting", "least distance", True, False
    reads = ("shift",)

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.shift > 0.0

    def apply(self, flow: "Flow", dt: float) -> None:
        p = flow.particles
        flow.fresh("x")
        watched = pairs.close_pairs(flow.cloud, WATCHED * flow.spacing)
        move, near = np.zeros_like(p.x), np.arange(p.n_owned, dtype=np.int32)
        for _ in range(SWEEPS):
            flow.fresh("x")
            crowded, left = pairs.keep_apart(move, near, watched, p.id_all, APART * flow.spacing, CAP * flow.spacing)
            if not sums(p.comm, crowded)[0]:
                break
            near = near[:left]
            displace(flow, move)


def _share_of(numerics: ResolvedNumerics) -> tuple[str, ...]:
    """Return the fields of half cells (methods.surfaces), if fluid may leave walls and reach others."""
    return ("share", "spare", "beside") if SURFACES[numerics.surface_rule].open else ()


def dense(flow: "Flow") -> Floats:
    """Write alpha, and return its gradient (n_owned, dim) [1/m]. Computed once in a preparation."""
    if flow.preparation.dense is None:
        flow.preparation.dense = flow.walls.density(flow.particles.alpha, flow, wetness.FREE)
    return flow.preparation.dense


def density_error(flow: "Flow") -> Floats:
    """Return the density error for the position projection: (n_owned,). Also writes alpha."""
    dense(flow)
    return compression(flow, flow.step.doubt)


def compression(flow: "Flow", doubt: Floats | None = None) -> Floats:
    """Return alpha - 1 (n_owned,) of inner particles, within +-LIMIT, near the surface only its excess over the doubt.

    doubt : (n_owned,), default 0
    """
    alpha = flow.particles.alpha
    found = np.empty_like(alpha)
    shifting.compression(found, flow.cloud, alpha, np.zeros_like(alpha) if doubt is None else doubt, LIMIT,
                         lengths.WALL * flow.spacing)
    return found


def displace(flow: "Flow", move: Floats) -> None:
    """Displace the owned fluid by move (n_owned, dim) [m], but not into a wall. Not collective."""
    p = flow.particles
    if flow.numerics.wall_guard > 0.0:
        flow.walls.keep_off(move, flow)
    movement.add_to_fluid(p.x, move, p.kind)
    flow.stale.add("x")


for part in (PositionProjection(), VoidFilling(), Parting(), FickShift(), KeepApart()):
    REGULARISERS.register(part)
