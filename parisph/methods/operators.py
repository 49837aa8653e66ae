"""Operators of the pressure equation: Laplacians, divergences, wall rows and gradients."""

from abc import abstractmethod
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.arrays import Flags, Floats, sizes
from parisph.base.fields import INNER, SURFACE
from parisph.kernels import (
    curvature,
    fatehi,
    gfd,
    gradient,
    harmonic_gradient,
    laplacian,
    quadratic_circle,
    rankine,
    row,
    schwaiger,
    walls,
)
from parisph.kernels import flux as fluxes
from parisph.kernels.circle import Circle
from parisph.kernels.curvature import Bending
from parisph.kernels.harmonic import Slopes
from parisph.kernels.near import SPLINE, SPLINE_SLOPE, Form
from parisph.kernels.records import Cloud, DivergenceRows, Rows
from parisph.methods import lengths, straining
from parisph.methods.parts import (
    DIVERGENCES,
    GRADIENTS,
    LAPLACIANS,
    SURFACE_GRADIENTS,
    SURFACES,
    WALL_ROWS,
    Divergence,
    Gradient,
    Laplacian,
    WallRows,
)

if TYPE_CHECKING:
    from parisph.methods.flow import Flow

# Harmonic terms raise the variance of a slope by 2 to 4 beside a vertical wall, also in waves.
INFLATION = 6.0    # tuned 3 to 12: limit on the variance of a slope where water does not break; measured
NEVER = -1.0    # no harmonic terms
RAPID_INFLATION = 60.0    # tuned 30 to 120: limit on that variance on a surface that breaks; measured
# In wall rows on a lattice, harmonic terms multiply the variance by 1.3 to 1.4, just below the surface by 2.8, and in
# corners by 5. Harmonic rows below the tip of a tongue of water delay it: with a limit of 3 or more the dam break
# (H/s = 40) reaches the wall .02 sqrt(H/g) late, with 1.8 or 2.5 in time. The limit was chosen on three starts. On
# three other starts the error of P2 is .042, with SFDI wall rows .055.
RAPID_WALL_INFLATION = 2.5    # tuned 1.25 to 5: limit on that variance in wall rows of water that breaks; measured
# Floors of det/(trace/dim)^dim of the neighbours' moment, below which a particle is ballistic.
SFDI_FLOOR = 0.2    # tuned 0.1 to 0.4: floor of the neighbours' moment with the weight over r^2; judged

directions = cache(rankine.directions)    # kernels only read them


def _circle(cloud: Cloud, size: float, radius: float) -> Circle:
    """Return the Circle around particles. size, radius : in spacings"""
    return Circle(directions(len(cloud.axes)), size * cloud.spacing, radius * cloud.spacing)


class Rankine(Laplacian):
    """ISPH_R: the mean over a circle of moving least squares, normalised by its result for a parabola.

    circle : its radius R in spacings, which a subclass may change (Z14 Fig 10 compares three)
    """

    name, source, reach = "rankine", "Z14 Eq 23, normalised", lengths.MLS
    gives = "flux"
    normalised = True
    circle = lengths.CIRCLE

    def fill(self, rows: Rows, cloud: Cloud, flux: DivergenceRows, u: Floats) -> None:
        rankine.rankine_rows(rows, flux, cloud, u, _circle(cloud, self.circle, lengths.MLS), self.normalised)


class RankinePrinted(Rankine):
    """ISPH_R as printed, which does not converge."""

    name, source, normalised = "rankine_printed", "Z14 Eq 23", False


class Sparse(Laplacian):
    """Rows that become the mean of the neighbours where these do not suffice."""

    def fill(self, rows: Rows, cloud: Cloud, flux: DivergenceRows, u: Floats) -> None:
        self.laplacian(rows, cloud)
        row.mean_rows(rows, cloud, self.reach * cloud.spacing)

    @abstractmethod
    def laplacian(self, rows: Rows, cloud: Cloud) -> None:
        """Fill the rows of inner particles with enough neighbours."""


class Sph(Sparse):
    """The SPH Laplacian with positive weights."""

    name, source, reach = "sph", "Z14 Eq 20a", 2.0 * lengths.SPH
    linear = False

    def laplacian(self, rows: Rows, cloud: Cloud) -> None:
        laplacian.isph_rows(rows, cloud, lengths.SPH * cloud.spacing, cloud.spacing ** len(cloud.axes))


class Cisph1(Sparse):
    """The Laplacian of Schwaiger with the gradient of a kernel sum."""

    name, source, reach = "cisph1", "Z14 Eqs 20b and 20c, sign corrected", 2.0 * lengths.SPH
    linear = False

    def laplacian(self, rows: Rows, cloud: Cloud) -> None:
        schwaiger.cisph1_rows(rows, cloud, lengths.SPH * cloud.spacing, cloud.spacing ** len(cloud.axes))


class Cisph2(Sparse):
    """The Laplacian of Schwaiger with a gradient that is exact for linear functions."""

    name, source, reach = "cisph2", "Z14 Eqs 20b and 20d, sign corrected", 2.0 * lengths.SPH

    def laplacian(self, rows: Rows, cloud: Cloud) -> None:
        schwaiger.cisph2_rows(rows, cloud, lengths.SPH * cloud.spacing)


class Gfd(Sparse):
    """Generalised finite differences: least squares of a polynomial of degree 2."""

    name, source, reach = "gfd", "generalised finite differences", lengths.WALL

    def laplacian(self, rows: Rows, cloud: Cloud) -> None:
        gfd.gfd_rows(rows, cloud, lengths.WALL * cloud.spacing)


class QuadraticRankine(Sparse):
    """ISPH_R with quadratic moving least squares, which needs no normalisation."""

    name, source, reach = "rankine_quadratic", "Z14 Eqs 21-23", lengths.QUADRATIC_CIRCLE + lengths.WALL

    def laplacian(self, rows: Rows, cloud: Cloud) -> None:
        circle = _circle(cloud, lengths.QUADRATIC_CIRCLE, lengths.WALL)
        quadratic_circle.quadratic_rankine_rows(rows, cloud, circle)


class Fatehi(Sparse):
    """The corrected SPH Laplacian that is exact for quadratic functions."""

    name, source, reach = "fatehi", "Fatehi and Manzari 2011", 2.0 * lengths.SPH

    def laplacian(self, rows: Rows, cloud: Cloud) -> None:
        fatehi.fatehi_rows(rows, cloud, lengths.SPH * cloud.spacing)


class FluxDivergence(Divergence):
    """The mean over a circle of the normal velocity, by moving least squares."""

    name, source, reach = "flux", "Z14 Eq 23, right-hand side", lengths.MLS

    def fill(self, flux: DivergenceRows, cloud: Cloud, u: Floats) -> None:
        fluxes.flux_rows(flux, cloud, u, _circle(cloud, lengths.CIRCLE, lengths.MLS))


class SfdiWalls(WallRows):
    """First-order weighted least squares.

    The error has one sign: for p = y^2/2 above a flat wall every neighbour gives a slope that is too large, in
    proportion to its height.
    """

    name, source, reach = "sfdi", "Z14 Eq 26b, with Eq A6 corrected", lengths.WALL

    def fill(self, rows: Rows, cloud: Cloud) -> None:
        walls.sfdi_rows(rows, cloud, lengths.WALL * cloud.spacing)

    def complete(self, right: Floats, rows: Rows, cloud: Cloud, flow: "Flow") -> None:
        """Add the effect of a non-uniform body force and of vorticity, for which water can then be at rest."""
        if (bending := flow.bending) is not None:
            _complete_rows(right, rows, cloud, bending)


def _complete_rows(right: Floats, rows: Rows, cloud: Cloud, bending: Bending) -> None:
    for add in (curvature.add_at_walls, curvature.add_at_surface):
        add(right, rows, cloud, bending)


class HarmonicWalls(SfdiWalls):
    """Least squares exact for harmonic pressure; first-order ones where neighbours do not suffice."""

    name, source = "harmonic", ""
    most = np.inf    # factor by which terms of degree 2 may raise the variance of a slope

    def fill(self, rows: Rows, cloud: Cloud) -> None:
        super().fill(rows, cloud)
        walls.harmonic_rows(rows, cloud, lengths.WALL * cloud.spacing, self.most)


class CurvedWalls(HarmonicWalls):
    """Harmonic rows with known second differences of the pressure, exact for quadratics.

    They need a gradient that knows these too ("curved", "cubic"): with a linear one, the mismatch of rows and gradient
    leaves divergence in each step, and the level rises (kernels.curvature). Not for violent flow: columns two particles
    wide beside a wall gain .4 % of their energy, and falls against a box .5 %.
    """

    name, fields = "curved", ("laplacian",)

    def complete(self, right: Floats, rows: Rows, cloud: Cloud, flow: "Flow") -> None:
        _complete_rows(right, rows, cloud, Bending(flow.particles.laplacian_all, flow.pull))


class CurvedBreakingWalls(CurvedWalls):
    """CurvedWalls for water that runs along walls: first-order rows where neighbours are few."""

    name, most = "curved_breaking", RAPID_WALL_INFLATION


class LeastSquares(Gradient):
    """First-order weighted least squares, with the weight over r^power.

    floor : value of det/(trace/dim)^dim of the neighbours' moment below which a particle is ballistic
    """

    power, floor = 0, straining.FLOOR

    def form(self, spacing: float) -> Form:
        return Form(self.reach * spacing, self.power, self.floor)

    def write(self, out: Floats, f: Floats, flow: "Flow", along: Floats | None = None,
              laplacian: Floats | None = None) -> None:
        self.fit(out, np.zeros(len(out), np.bool_), f, flow, along)

    def fit(self, out: Floats, known: Flags, f: Floats, flow: "Flow", along: Floats | None) -> None:
        """Write the linear fit to out (n_owned, dim), except where `known` (n_owned,) bool; others as of `write`."""
        gradient.least_squares_gradient(out, known, flow.cloud, f, self.form(flow.spacing))
        flow.walls.mend_gradient(out, known, f, along, flow, self.form(flow.spacing))

    def complete(self, out: Floats, flow: "Flow") -> None:
        """Add the effect of a non-uniform body force and of vorticity."""
        if (bending := flow.bending) is not None:
            _bend(out, flow, bending, INNER, self.form(flow.spacing), NEVER, NEVER)


def _fit_with_walls(out: Floats, where: Flags, f: Floats, flow: "Flow", reach: float, along: Floats | None,
                    laplacian: Floats | None = None) -> Flags:
    """Write the harmonic fit that knows the slopes across walls; return where it exists (n_owned,) bool.

    where : (n_owned,) bool, particles at which `out` may change; reach : of the fit [spacings]; others as of `write`
    """
    slopes = Slopes(flow.walls.slope(flow, along), flow.walls.known_slopes(flow))
    found: Flags = harmonic_gradient.harmonic_gradient(
        out, where, flow.cloud, f, slopes, np.empty(0) if laplacian is None else laplacian,
        reach * flow.spacing, INFLATION)
    return found


class MixedGradient(LeastSquares):
    """With the plain weight, which averages over more neighbours."""

    name, source, reach = "mixed", "Z17 Eq 28", lengths.WALL


class Cubic(MixedGradient):
    """Least squares by harmonic polynomials of degree 3, with the slopes across walls and the Laplacian as data.

    Where neighbours do not suffice, the degree is 2, or the gradient is "mixed". It also applies at the surface if the
    gradient there is "same". Errors on a lattice that a wave strains have a mean in time, which drives vortices: with
    terms of degree 2 alone inside it is ten times as large.
    """

    name, source, reach, fields, whole = "cubic", "", lengths.WALL, ("laplacian",), True

    def write(self, out: Floats, f: Floats, flow: "Flow", along: Floats | None = None,
              laplacian: Floats | None = None) -> None:
        found = _fit_with_walls(out, np.ones(len(out), np.bool_), f, flow, self.reach, along, laplacian)
        self.fit(out, found, f, flow, along)

    def complete(self, out: Floats, flow: "Flow") -> None:
        pass    # `write` includes the second differences


class Sfdi(LeastSquares):
    """With the weight over r^2."""

    name, source, reach = "sfdi", "Z17 Eqs 29-32", lengths.MLS
    power, floor = 2, SFDI_FLOOR


class Spline(LeastSquares):
    """With the cubic spline as weight, over the support of the SPH kernels."""

    name, source, reach, power = "spline", "Z17 Eq 28", 2.0 * lengths.SPH, SPLINE


class Corrected(LeastSquares):
    """The SPH gradient with a corrected kernel gradient: the weight is the kernel's slope."""

    name, source, reach, power = "corrected", "Z17 Eqs 26-27", 2.0 * lengths.SPH, SPLINE_SLOPE


class Nodal(Divergence):
    """Least squares of the velocities of neighbours."""

    name, source, reach = "nodal", "Z17 Eqs 29-32", lengths.MLS

    def fill(self, flux: DivergenceRows, cloud: Cloud, u: Floats) -> None:
        fluxes.least_squares_flux(flux, cloud, u, Form(lengths.MLS * cloud.spacing, Sfdi.power, Sfdi.floor))


class Symmetric(LeastSquares):
    """The SPH gradient that conserves momentum."""

    name, source, reach = "symmetric", "Z17 Eq 25", 2.0 * lengths.SPH

    def write(self, out: Floats, f: Floats, flow: "Flow", along: Floats | None = None,
              laplacian: Floats | None = None) -> None:
        s = flow.spacing
        gradient.symmetric_gradient(out, flow.cloud, f, lengths.SPH * s, s ** len(flow.axes))
        flow.walls.mend_gradient(out, np.zeros(len(out), np.bool_), f, along, flow, self.form(s))

    def complete(self, out: Floats, flow: "Flow") -> None:
        pass    # not even exact for linear pressure


class Same(Gradient):
    """Surface particles have the gradient of all others."""

    name = "same"

    def write(self, out: Floats, f: Floats, flow: "Flow", along: Floats | None = None,
              laplacian: Floats | None = None) -> None:
        pass


class HarmonicSurface(Gradient):
    """At surface particles, least squares exact for harmonic pressure.

    Where the neighbours alone raise the variance of a slope to more than INFLATION times, and the fluid hardly moves,
    the slopes across walls are data too, if the fit is then within that limit. The last particle of water at rest on a
    slope has few neighbours, and without these data its gradient fed a wave along the water line, at .01 to .04 in a
    step of 1.3 sqrt(s/g) on slopes of 20, 30, 35 and 60 degrees. With them in all fluid, P2 of the dam break (H/s = 40,
    five starts) errs by .062 to .081 instead of .048 to .067.

    A frozen surface also keeps a single particle in the tip of a wedge. Its few neighbours suffice for the harmonic
    terms, but these amplify its velocity: at rest on slopes of 20 to 60 degrees, it crept away (a factor e in .2 to 6
    s, where the inflation was above 7; without the terms in 90 s or more). In violent flow the tip of a tongue needs
    them: with the same limit, the pressure of its impact errs by .12 to .21 instead of .07. The limit there only stops
    single particles of a collapsing sheet from moving towards higher pressure.
    """

    name, reach = "harmonic", lengths.WALL

    def write(self, out: Floats, f: Floats, flow: "Flow", along: Floats | None = None,
              laplacian: Floats | None = None) -> None:
        unsure = gradient.harmonic_gradient(out, flow.cloud, f, self.reach * flow.spacing, INFLATION, self.most(flow))
        if flow.wave_time < np.inf:    # with gravity
            unsure &= sizes(flow.particles.u) * flow.wave_time < straining.RAPID * flow.spacing
            if np.any(unsure):
                _fit_with_walls(out, unsure, f, flow, self.reach, along)

    def complete(self, out: Floats, flow: "Flow") -> None:
        """Add the effect of a non-uniform body force and of vorticity."""
        if (bending := flow.bending) is not None:
            _bend(out, flow, bending, SURFACE, _form(flow), self.most(flow), NEVER)

    def most(self, flow: "Flow") -> float:
        """Return the factor by which the harmonic terms may raise the variance of the slope."""
        return INFLATION if SURFACES[flow.numerics.surface_rule].keeps else RAPID_INFLATION


class CurvedSurface(HarmonicSurface):
    """Harmonic gradients with known second differences of the pressure, exact for quadratics.

    Only where the fit is good, in violent flow as well: elsewhere it would feed single particles of a sheet. In the dam
    break (H/s = 40, three starts) P2 errs by .05 to .16 if it is used up to RAPID_INFLATION, else by .05.
    """

    name, fields = "curved", ("laplacian",)

    def complete(self, out: Floats, flow: "Flow") -> None:
        bending = Bending(flow.particles.laplacian_all, flow.pull)
        _bend(out, flow, bending, SURFACE, _form(flow), INFLATION, self.most(flow))


class Curved(MixedGradient):
    """The gradient of pressure by a fit with known second differences, exact for quadratics; of other fields "mixed".
    """

    name, source, reach, fields = "curved", "", lengths.WALL, ("laplacian",)

    def complete(self, out: Floats, flow: "Flow") -> None:
        bending = Bending(flow.particles.laplacian_all, flow.pull)
        _bend(out, flow, bending, INNER, _form(flow), INFLATION, INFLATION)


def _form(flow: "Flow") -> Form:
    """Return the form of fits with known second differences."""
    return Form(lengths.WALL * flow.spacing, LeastSquares.power, LeastSquares.floor)


def _bend(out: Floats, flow: "Flow", bending: Bending, where: int, form: Form, most: float, kept: float) -> None:
    """Replace the gradient of the pressure (n_owned, dim) [Pa/m] at particles of one role by `curvature.gradient`.

    form : of the linear fit in `out`
    """
    curvature.gradient(out, flow.cloud, flow.particles.p_all, bending, where, form, most, kept)


for part in (Rankine(), RankinePrinted(), Sph(), Cisph1(), Cisph2(), Gfd(), QuadraticRankine(), Fatehi()):
    LAPLACIANS.register(part)
for divergence_part in (FluxDivergence(), Nodal()):
    DIVERGENCES.register(divergence_part)
for walls_part in (SfdiWalls(), HarmonicWalls(), CurvedWalls(), CurvedBreakingWalls()):
    WALL_ROWS.register(walls_part)
for gradient_part in (MixedGradient(), Sfdi(), Symmetric(), Spline(), Corrected(), Curved(), Cubic()):
    GRADIENTS.register(gradient_part)
for surface_part in (Same(), HarmonicSurface(), CurvedSurface()):
    SURFACE_GRADIENTS.register(surface_part)
