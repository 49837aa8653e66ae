"""What walls are to the parts of a method: they complete sums of kernels, keep fluid off, and close angular gaps.

`methods.wall_images` are flat walls in which fluid is mirrored, `methods.wall_solids` walls of any shape.
"""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from parisph.case.friction import Friction
from parisph.kernels import movement, wetness
from parisph.kernels.moving_mirrors import Solids, no_solids
from parisph.kernels.near import Form

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class Directions(NamedTuple):
    """How walls close the angular gaps around fluid, as kernels.surface.surface_by_gap takes it."""

    mirrors: bool
    corners: np.ndarray
    present: np.ndarray
    element_indptr: np.ndarray
    element_indices: np.ndarray


class Boundary(ABC):
    """The walls of a scene. Nothing here is collective.

    fields : that it needs
    shapes : whether walls may have any shape
    least : in arguments, the least `closing` of walls that count (kernels.wetness.FREE or CLOSING)
    """

    fields: ClassVar[tuple[str, ...]] = ()
    shapes: ClassVar[bool] = False

    def cover(self, flow: "Flow") -> tuple[str, ...]:
        """Find what the fluid in front of walls has to do with them; return the names of fields that ghosts need."""
        return ()

    def frictional(self, flow: "Flow", seen: np.ndarray) -> tuple[np.ndarray, Solids]:
        """Return which particles the viscous force sees, kind (n_all,) or ABSENT, and the elements of walls.

        seen : (n_all,) kind, ABSENT for walls behind air
        """
        return seen, no_solids(flow.particles.dim)

    @abstractmethod
    def density_ratio(self, out: np.ndarray, flow: "Flow", least: int) -> None:
        """Write the density ratio of owned fluid to out (n_owned,), 1 for walls."""

    @abstractmethod
    def concentration(self, alpha: np.ndarray, gradient: np.ndarray, flow: "Flow", least: int) -> None:
        """Write the density ratio of owned fluid to alpha (n_owned,), 1 for walls, and its gradient to `gradient`
        (n_owned, dim) [1/m], 0 for walls."""

    @abstractmethod
    def surplus(self, ratio: np.ndarray, gradient: np.ndarray, share: np.ndarray, flow: "Flow",
                further: np.ndarray | None = None, other: np.ndarray | None = None) -> None:
        """Add what half cells at walls for which no fluid stands contribute.

        share : (n_all,), for which part of its half cell fluid stands (halves.wall_share)
        ratio : (n_owned,); gradient : (n_owned, dim) [1/m]; both hold 0
        further : (n_owned,), holds 0, the ratio with `other` (n_all,) shares, or both None
        """

    @abstractmethod
    def keep_off(self, move: np.ndarray, flow: "Flow") -> None:
        """Remove from moves (n_owned, dim) [m] of fluid what leads too near to a wall."""

    @abstractmethod
    def guard(self, u: np.ndarray, flow: "Flow", dt: float) -> None:
        """Limit velocities u (n_all, dim) [m/s] of owned fluid, so that a step of dt [s] ends before a wall."""

    @abstractmethod
    def directions(self, flow: "Flow", least: int) -> Directions:
        """Return how walls close angular gaps."""

    @abstractmethod
    def rub(self, out: np.ndarray, flow: "Flow", law: Friction) -> None:
        """Add the friction of walls that fluid slips along to out (n_owned, dim) [m/s^2]."""

    def cells(self, flow: "Flow") -> np.ndarray:
        """Return the part (n_all,) of their cells that particles fill, as for kernels.surface_rows."""
        return flow.cells

    def leave_out(self, flow: "Flow") -> None:
        """Write the role of wall particles that are never in a stencil."""

    def move(self, flow: "Flow", at: float, start: float, stop: float) -> None:
        """Put walls where they are at a time [s], in a step from start to stop [s]."""

    def acceleration(self, flow: "Flow") -> np.ndarray | None:
        """Return the acceleration of owned wall particles in the step, (n_owned, dim) [m/s^2], 0 for fluid; None if all
        walls rest."""
        return None

    def normal_acceleration(self, flow: "Flow") -> np.ndarray | None:
        """Return that of fluid which slides along walls, at owned particles (n_owned,) [m/s^2]; None if all walls rest.

        n . a of the wall, and what turns the fluid with it: - 2 dn/dt . (u - u_w), as Coriolis' force in its frame.
        """
        return None

    def shear(self, flow: "Flow") -> np.ndarray:
        """Return what Flow.wall_shear is by the motion of walls: (n_owned, dim) [1/s]."""
        return np.zeros_like(flow.particles.x)

    def longest_step(self, flow: "Flow", time: float) -> float:
        """Return the longest step [s] after a time [s] that resolves the motion of walls, infinite if none moves."""
        return np.inf

    def known_slopes(self, flow: "Flow") -> np.ndarray:
        """Return which particles (n_all,) are walls with one normal, across which the slope of pressure is known.

        Also dry ones: the pressure of a wave goes on above its surface, as far as a stencil reaches. But not those
        that are apart and from which gravity pulls the water, as a lid above it.
        """
        p = flow.particles
        closing = p.closing_all if "closing" in p.fields else np.empty(0, np.int8)    # a full tank: all walls are wet
        return wetness.known_slopes(flow.cloud, closing, flow.body_force)

    def slope(self, flow: "Flow", along: np.ndarray | None) -> np.ndarray:
        """Return the slope across walls (n_all,) of a field with the gradient `along` (n_all, dim) in water at rest.

        None stands for 0. Of the pressure, along is rho times the force, and walls that move have less of it.
        """
        p = flow.particles
        return np.zeros(len(p.x_all)) if along is None else movement.along(p.normal_all, along)

    def mend_gradient(self, out: np.ndarray, known: np.ndarray, f: np.ndarray, slope: np.ndarray | None, flow: "Flow",
                      form: Form) -> None:
        """Repeat a linear fit out (n_owned, dim) of f (n_all,) where neighbours are too few but a wall is near.

        known : (n_owned,) bool, where out stays; slope : (n_all, dim), what the gradient is across walls at rest, None
        for 0
        """
