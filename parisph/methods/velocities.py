"""Regularisers of velocities: filter, films, pair collisions and wall guard."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import collisions, films, movement
from parisph.methods import lengths, straining
from parisph.methods.parts import REGULARISERS, Limiter, Regulariser

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class Filter(Regulariser):
    """Removes a part of the deviation of velocities from the moving least squares of neighbours."""

    name, cause, words, reach = "filter", "filter", "velocity filter", lengths.MLS
    reads = ("filter", "filter_strain")
    needs_fit = True

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.filter > 0.0

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        return straining.FIELDS if numerics.filter_strain else ()

    def change(self, flow: "Flow", dt: float) -> Floats:
        n = flow.numerics
        return -straining.strength(flow, n.filter, n.filter_strain)[:, None] * straining.beyond_fit(flow)


class Film(Regulariser):
    """Makes the depth of fluid one particle deep on a wall obey continuity."""

    name, cause, words, strain, reach = "film", "film", "films of one layer", False, lengths.MLS

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.surface_rule != "none"    # a full tank has no film

    def change(self, flow: "Flow", dt: float) -> Floats:
        p = flow.particles
        change = np.empty_like(p.u)
        films.settle(change, flow.cloud, p.u_all, flow.step.force, lengths.MLS * flow.spacing, straining.FLOOR, dt)
        return change


class Collisions(Regulariser):
    """Makes close pairs collide with the part of their velocity beyond the strain around them."""

    name, cause, words, fields = "collisions", "collisions", "pair collisions", (*straining.FIELDS, "pairs")
    reads = ("collision_distance", "restitution")

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.collision_distance > 0.0

    def prepare(self, flow: "Flow", dt: float) -> None:
        p, distance = flow.particles, flow.numerics.collision_distance
        collisions.count_collisions(p.pairs, flow.close_pairs(distance), p.u_all, distance * flow.spacing)
        flow.stale.add("pairs")

    def change(self, flow: "Flow", dt: float) -> Floats:
        p, n = flow.particles, flow.numerics
        change, distance = np.empty_like(p.u), n.collision_distance
        flow.step.collisions = collisions.pair_collisions(change, flow.close_pairs(distance), p.pairs_all, p.u_all,
                                                     p.grad_u_all, distance * flow.spacing, n.restitution)
        return change


class WallGuard(Limiter):
    """Stops particles before they pass a wall.

    A particle inside a wall sees its neighbours on the wrong side, with an unbounded pressure. With a distance of .5
    spacings instead of .25, a tongue would hit a wall late.
    """

    name, cause, words = "wall_guard", "guard", "wall guard"

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.wall_guard > 0.0

    def apply(self, flow: "Flow", dt: float) -> None:
        flow.walls.guard(flow.particles.u_all, flow, dt)
        flow.stale.add("u")


def keep_in_tank(flow: "Flow", u: Floats, dt: float) -> Floats:
    """Limit the velocity (n_owned, dim) by which fluid will move, with the wall guard. Not collective.

    Particles move by the mean of two velocities. The guard of the new one alone would let a particle that stops in this
    step pass the wall, and stop one that only slows down.
    """
    p = flow.particles
    if not flow.numerics.wall_guard:
        return u
    both = p.u_all.copy()    # with the velocity of walls
    movement.give_to_fluid(both, u, p.kind)
    flow.walls.guard(both, flow, dt)
    return both[:p.n_owned]


for part in (Filter(), Film(), Collisions(), WallGuard()):
    REGULARISERS.register(part)
