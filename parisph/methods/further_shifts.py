"""Particle shifts from the literature, other than the Fick shift of `positions`.

A case names one of them instead of "shift" among its regularisers. None of them rotates close pairs.
"""

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import FLUID
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import shifting, shifts, wetness
from parisph.kernels.records import Cloud, Walls
from parisph.methods import lengths, straining
from parisph.methods.parts import REGULARISERS, Regulariser
from parisph.methods.positions import CAP, NEAR_SURFACE

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class Shift(Regulariser):
    """A shift whose weight and strain factor are the numbers `shift` and `shift_strain`."""

    cause, moves = "shift", True
    reads: ClassVar[tuple[str, ...]] = ("shift", "shift_strain")

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        return numerics.shift > 0.0

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        return (*self.fields, *(straining.FIELDS if numerics.shift_strain else ()))

    def change(self, flow: "Flow", dt: float) -> Floats:
        move = np.empty_like(flow.particles.x)
        self.write(move, flow, dt)
        return move

    def strength(self, flow: "Flow") -> Floats:
        """Return the weight of this step at owned particles (n_owned,)."""
        return straining.strength(flow, flow.numerics.shift, flow.numerics.shift_strain)

    @abstractmethod
    def write(self, move: Floats, flow: "Flow", dt: float) -> None:
        """Write the displacement of owned fluid in a step of dt [s] to move (n_owned, dim) [m]. Not collective."""


class TensileShift(Shift):
    """Shifts by C h^2 along -grad C with the term against pairing; at the surface along it."""

    name, source, words = "shift_tensile", "Lind et al. 2012, Eqs 23 and 27", "shift with tensile term"
    fields = ("grad_alpha",)

    def prepare(self, flow: "Flow", dt: float) -> None:
        shifts.tensile_gradient(flow.particles.grad_alpha, *_seen(flow), lengths.DENSITY * flow.spacing, flow.full)
        flow.stale.add("grad_alpha")

    def write(self, move: Floats, flow: "Flow", dt: float) -> None:
        h = lengths.DENSITY * flow.spacing
        shifting.fick_shift(move, flow.cloud, flow.particles.grad_alpha_all, self.strength(flow) * h * h,
                            CAP * flow.spacing, NEAR_SURFACE * flow.spacing)


def _seen(flow: "Flow") -> tuple[Cloud, Walls]:
    """Return the cloud and the walls without those apart from the fluid."""
    return flow.cloud._replace(kind=flow.seen(wetness.FREE)), flow.walls.present(flow, wetness.FREE)


class XuShift(Shift):
    """Shifts by C v dt away from near neighbours, with the largest speed v of the fluid.

    For fluid without a free surface.
    """

    name, source, words, reach = "shift_xu", "Xu et al. 2009, Eqs 25 and 26", "shift of Xu et al.", lengths.MLS

    def prepare(self, flow: "Flow", dt: float) -> None:
        p = flow.particles
        top = float(np.linalg.norm(p.u[p.kind == FLUID], axis=1).max(initial=0.0))
        flow.preparation.top_speed = max(p.comm.allgather(top))    # not MPI.MAX: laptops describe cases without MPI

    def write(self, move: Floats, flow: "Flow", dt: float) -> None:
        most = self.strength(flow) * flow.preparation.top_speed * dt
        shifts.xu_shift(move, *_seen(flow), most, lengths.MLS * flow.spacing, CAP * flow.spacing)


class LindShift(TensileShift):
    """Shifts by C h^2 along -grad C with the tensile term; surface particles move along the surface."""

    name, source, words = "shift_lind", "Lind et al. 2012, Eqs 23 to 27, beta = 0", "shift of Lind et al."

    def write(self, move: Floats, flow: "Flow", dt: float) -> None:
        p, h = flow.particles, lengths.DENSITY * flow.spacing
        normal, close = np.empty_like(p.x), np.empty(p.n_owned, bool)
        shifts.surface_normals(normal, close, flow.cloud, p.grad_alpha_all, NEAR_SURFACE * flow.spacing)
        shifts.surface_shift(move, flow.cloud, p.grad_alpha, normal, close, self.strength(flow) * h * h,
                             CAP * flow.spacing)


class PressureShift(Shift):
    """Shifts by dt^2/(2 rho) times the excess of the pressure gradient relative to the least pressure nearby."""

    name, source, words = "shift_pressure", "Sriram and Ma 2012, as in Z14 Sec 2.2", "shift by pressure"
    reach, reads = lengths.MLS, ("shift",)

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        return self.fields

    def write(self, move: Floats, flow: "Flow", dt: float) -> None:
        shifts.pressure_shift(move, *_seen(flow), flow.particles.p_all, 0.5 * dt * dt / flow.density,
                              lengths.MLS * flow.spacing, CAP * flow.spacing)


for part in (TensileShift(), XuShift(), LindShift(), PressureShift()):
    REGULARISERS.register(part)
