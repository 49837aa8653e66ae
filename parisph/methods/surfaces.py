"""Rules for the free surface and the wet walls."""

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Array
from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE, WET
from parisph.kernels import cone, gradient, halves, surface, wetness
from parisph.methods import lengths
from parisph.methods.parts import GRADIENTS, SURFACES, Surface

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

GAP = surface.Gap(
    enter=2.3,    # tuned 1.15 to 4.6: angle without neighbours above which a particle joins the surface; judged
    leave=1.4,    # tuned 0.7 to 2.3: angle below which it leaves the surface; judged
    thin=0.55,    # tuned 0.275 to 1: density ratio below which a particle is on the surface; judged
)
ENTER = 60.0    # tuned 50 to 80: half angle [degrees] of a free cone above which a particle joins the surface; measured
LEAVE = 42.0    # tuned 30 to 55: half angle [degrees] of a free cone below which it leaves the surface; measured
REGAIN = 1.5    # tuned 1 to 3: floor at which free flight on a frozen surface ends, over that of the gradient; judged


def classify(flow: "Flow", rule: Surface, dt: float) -> None:
    """Write the field role by the free surface and the wet walls. Collective.

    If a part needs them, also write the fields share and spare of half cells at walls. Fluid that fills a closed tank
    represents all of them.

    flow.step.force : (n_all, dim) [m/s^2], and dt [s]: of the step that begins
    """
    p, d = flow.particles, flow.domain
    if not rule.open:
        rule.find(flow, p.kind_all)
        return
    wetness.closing_walls(p.closing_all, flow.cloud, p.u_all, flow.step.force, dt)
    also = flow.walls.cover(flow)
    if flow.half_cells:
        weight = flow.walls.claimed(flow)
        halves.claims(p.share_all, p.spare_all, flow.cloud, p.beside, weight)
        d.update("share", "spare")
        halves.wall_share(p.share_all, flow.cloud, weight)
        also = (*also, "share")
    flow.step.completions.clear()
    d.update("closing", *also)
    if flow.weighed:
        flow.walls.density(p.alpha, flow, wetness.CLOSING)
    rule.find(flow, flow.seen(wetness.CLOSING))
    d.update("role")
    # also for a frozen surface, which moves along the walls
    wetness.wet_walls(flow.cloud, p.closing_all)
    flow.walls.leave_out(flow)


class Closed(Surface):
    """No surface: fluid fills a closed tank. The mean pressure is zero, as nothing else fixes its level.

    Other scenes need the surface's p = 0 as a datum, and to find wet walls: a case without one is refused
    (case.checks).
    """

    name, open = "none", False

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        p.role[:] = np.where(p.kind == FLUID, INNER, WET)
        flow.walls.leave_out(flow)


class Frozen(Surface):
    """Fluid keeps its initial role, also after free flight once it has neighbours again.

    For non-breaking waves: a breaking dam blows up, at H/s = 20 three times sqrt(H/g) after its start.
    """

    name, keeps, fields = "frozen", True, ("closing", "start_role")

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        p.role[:] = np.where((p.kind == FLUID) & (p.role != BALLISTIC), p.start_role, p.role)
        if (form := GRADIENTS[flow.numerics.gradient].form(flow.spacing)) is not None:
            gradient.regain_role(p.start_role, flow.cloud, form._replace(floor=REGAIN * form.floor))


@lru_cache(maxsize=1)
def free_cone() -> cone.Cone:
    """Return the gap rule in 3D. Cached, as its tables take some milliseconds."""
    return cone.cone(math.radians(ENTER), math.radians(LEAVE), GAP.thin)


class AngularGap(Surface):
    """The largest angular gap between neighbours, in 3D the widest cone without any, with hysteresis."""

    name, reach, fields = "gap", lengths.SURFACE_GAP, ("closing", "alpha")

    def find(self, flow: "Flow", seen: Array) -> None:
        p, radius = flow.particles, lengths.SURFACE_GAP * flow.spacing
        around = flow.cloud._replace(kind=seen), flow.walls.present(flow, wetness.CLOSING), p.alpha, radius
        if p.dim == 2:
            surface.surface_by_gap(p.role_all, p.role_all.copy(), *around, GAP)
        else:
            cone.surface_by_cone(p.role_all, p.role_all.copy(), *around, free_cone())


class Auxiliary(Surface):
    """Three auxiliary functions of the neighbours' positions.

    Density is one of its conditions. With a jitter of 0.8 spacings some particles below the surface are taken for
    surface, and water at rest moves with 0.1 sqrt(g d); with 0.4, it rests.
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

    With a jitter of 0.4 spacings some particles below the surface are taken for surface (as in Z14 Fig 5), and water at
    rest moves with 0.03 sqrt(g d); with 0.8, it may leave the tank; with 0.2, it rests. Three of twelve dam breaks at
    H/s = 20 gain energy after the impact; leave "irrotational" out of the regularisers, with which more do.
    """

    name, source, fields = "density", "Z14 Sec 2.4", ("closing", "alpha")

    def find(self, flow: "Flow", seen: Array) -> None:
        p = flow.particles
        surface.surface_by_density(p.role_all, flow.cloud, p.alpha, 0.9)


class PositionDivergence(Surface):
    """Divergence of position below 1.5 in 2D and 2.4 in 3D, three and four fifths of the inner value.

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
