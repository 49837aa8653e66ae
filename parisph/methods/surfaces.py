"""The rules that find the free surface, and the walls that are wet."""

from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Array
from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE, WET
from parisph.kernels import gradient, halves, surface, wetness
from parisph.methods import lengths
from parisph.methods.parts import GRADIENTS, SURFACES, Surface

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

GAP = surface.Gap(
    enter=2.3,    # tuned 1.15 to 4.6: angle without neighbours from which on a particle joins the surface; judged
    leave=1.4,    # tuned 0.7 to 2.3: angle below which it leaves the surface; judged
    thin=0.55,    # tuned 0.275 to 1: density ratio below which a particle is on the surface; judged
)
REGAIN = 1.5    # tuned 1 to 3: times the floor of the gradient: when free flight of a kept surface ends; judged


def classify(flow: "Flow", rule: Surface, dt: float) -> None:
    """Find the free surface and the wet walls, and write the field role. Collective.

    Where a part needs it, also the field share, of the half cells at walls for which fluid stands: fluid that fills a
    closed tank started at all of its walls.

    flow.step.force : (n_all, dim) [m/s^2], and dt [s]: of the step that begins
    """
    p, d = flow.particles, flow.domain
    if not rule.open:
        rule.find(flow, p.kind_all)
        return
    wetness.closing_walls(p.closing_all, flow.cloud, p.u_all, flow.step.force, dt)
    if flow.half_cells:
        halves.wall_share(p.share, flow.cloud, flow.cells, 1.0, halves.LAYER)
    also = flow.walls.cover(flow)
    flow.step.completions.clear()
    d.update("closing", *(("share",) if flow.half_cells else ()), *also)
    if flow.weighed:
        flow.walls.density(p.alpha, flow, wetness.CLOSING)
    rule.find(flow, flow.seen(wetness.CLOSING))
    d.update("role")
    # also for a frozen surface: it falls and rises past the nodes of the walls
    wetness.wet_walls(flow.cloud, p.closing_all)
    flow.walls.leave_out(flow)


class Closed(Surface):
    """No surface: fluid fills a closed tank. Nothing fixes the level of its pressure, whose mean is zero.

    In any other scene p = 0 at the surface is the only datum that pressure has: a case without one is refused
    (case.checks), and neither do walls know there whether they are wet.
    """

    name, open = "none", False

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        p.role[:] = np.where(p.kind == FLUID, INNER, WET)
        flow.walls.leave_out(flow)


class Frozen(Surface):
    """Fluid keeps the role of the start, also particles that have flown freely and have neighbours again.

    For waves that do not break: a breaking dam blows up, at H/s = 20 three times sqrt(H/g) after its start.
    """

    name, keeps, fields = "frozen", True, ("closing", "start_role")

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        p.role[:] = np.where((p.kind == FLUID) & (p.role != BALLISTIC), p.start_role, p.role)
        if (form := GRADIENTS[flow.numerics.gradient].form(flow.spacing)) is not None:
            gradient.regain_role(p.start_role, flow.cloud, form._replace(floor=REGAIN * form.floor))


class AngularGap(Surface):
    """The largest angular gap between neighbours, with hysteresis."""

    name, reach, fields = "gap", lengths.SURFACE_GAP, ("closing", "alpha")
    dims = (2,)

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        surface.surface_by_gap(p.role_all, p.role_all.copy(), flow.cloud._replace(kind=seen),
                               flow.walls.present(flow, wetness.CLOSING), p.alpha, lengths.SURFACE_GAP * flow.spacing,
                               GAP)


class Auxiliary(Surface):
    """Three auxiliary functions of the neighbours' places.

    Density is one of its conditions. On particles jittered by 0.8 spacings some of those below the surface seem to be
    on it, and water at rest moves with 0.1 sqrt(g d); jittered by 0.4, it rests.
    """

    name, source, reach, fields = "auxiliary", "Z14 Sec 2.4", lengths.WALL, ("closing", "alpha")
    dims = (2,)

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        surface.surface_by_auxiliary_functions(p.role_all, p.role_all.copy(), flow.cloud._replace(kind=seen),
                                               flow.walls.present(flow, wetness.CLOSING), p.alpha,
                                               lengths.WALL * flow.spacing, 0.9)


class DensityRatio(Surface):
    """Density ratio below .9.

    Of particles jittered by 0.4 spacings some below the surface seem to be on it (Z14 Fig 5 shows the same), and water
    at rest moves with 0.03 sqrt(g d); by 0.8, it may leave the tank. Jittered by 0.2, it rests. Three of twelve dam
    breaks at H/s = 20 gain energy after the impact; leave "irrotational" out of the regularisers, with which more do.
    """

    name, source, fields = "density", "Z14 Sec 2.4", ("closing", "alpha")

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        surface.surface_by_density(p.role_all, flow.cloud, p.alpha, 0.9)


class PositionDivergence(Surface):
    """Divergence of position below 1.5 in 2D and 2.4 in 3D: three and four fifths of that inside.

    Near neighbours count less than in the density ratio: water rests on particles jittered by 0.8 spacings, too.
    """

    name, source, fields = "divergence", "Lee et al. 2008", ("closing",)
    limits = {2: 1.5, 3: 2.4}

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        found = np.empty(p.n_owned)
        surface.position_divergence(found, flow.cloud._replace(kind=seen), flow.walls.present(flow, wetness.CLOSING),
                                    lengths.DENSITY * flow.spacing)
        fluid = p.kind == FLUID
        p.role[fluid] = np.where(found[fluid] < self.limits[p.dim], SURFACE, INNER)


for part in (AngularGap(), Auxiliary(), DensityRatio(), PositionDivergence(), Frozen(), Closed()):
    SURFACES.register(part)
