"""Parts of a method: their declarations, and the registries that know them by name.

A part gets the Flow and arrays, never the method. The parts of a scene determine its fields, the reach of neighbour
lists, its possible dimensions, its longest time step, and the stages that `parisph check` prints.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np

from parisph.base import vocabulary
from parisph.base.arrays import Array, Floats
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels.near import Form
from parisph.kernels.records import Cloud, DivergenceRows, Rows

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class Part(ABC):
    """Base of all parts. Methods take the numbers of the case for properties that depend on them.

    Attributes
    ----------
    name : the word of a case
    source : such as "Z14 Eq 23", or "" for our own
    reach : radius in spacings within which it needs neighbours
    fields : names of the fields it needs (base.fields), in addition to those of every scene
    dims : numbers of dimensions in which it works
    """

    name: ClassVar[str]
    source: ClassVar[str] = ""
    reach: ClassVar[float] = 0.0
    fields: ClassVar[tuple[str, ...]] = ()
    dims: ClassVar[tuple[int, ...]] = (2, 3)

    def wanted(self, numerics: ResolvedNumerics) -> bool:
        """Return whether the numbers of a case switch it on."""
        return True

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        """Return the names of the fields it needs with the numbers of a case."""
        return self.fields

    @property
    def limits_step(self) -> bool:
        """Whether `longest_step` can be finite."""
        return type(self).longest_step is not Part.longest_step

    def longest_step(self, flow: "Flow") -> float:
        """Return the longest time step [s] that it allows on this rank, infinite without a limit. Not collective."""
        return np.inf


class Laplacian(Part):
    """Rows of inner particles: p_I - sum_J values_J p_J = -measure_I lap p.

    gives : name of the divergence whose stencils `fill` writes as well, or ""
    linear : whether the rows are exact for linear pressure on any particles; else the step balances the body force
    """

    gives: ClassVar[str] = ""
    linear: ClassVar[bool] = True

    @abstractmethod
    def fill(self, rows: Rows, cloud: Cloud, flux: DivergenceRows, u: Floats) -> None:
        """Write count, columns, values and measure of inner particles. Not collective.

        u : (n_all, dim) [m/s], for the flux divergence if it gives one
        """


class Divergence(Part):
    """Stencils of the divergence: div u_I = sum_J flux_J . (u_J - u_I) at inner particles."""

    @abstractmethod
    def fill(self, flux: DivergenceRows, cloud: Cloud, u: Floats) -> None:
        """Write count, columns and flux of inner particles, and div of u (n_all, dim). Not collective."""


class WallRows(Part):
    """Rows of wet wall particles: row_I(p) = -measure_I n . grad p."""

    @abstractmethod
    def fill(self, rows: Rows, cloud: Cloud) -> None:
        """Write count, columns, values and measure of wet wall particles. Not collective."""

    def complete(self, right: Floats, rows: Rows, cloud: Cloud, flow: "Flow") -> None:
        """Add other known effects of the pressure to the right-hand side (n_owned,) [Pa]. Not collective.

        rows : as filled, with the roles of flow.particles
        """


class Gradient(Part):
    """The gradient of pressure at fluid particles.

    whole : whether the field laplacian must hold the whole Laplacian of the pressure, including that by the body force
    """

    whole: ClassVar[bool] = False

    @abstractmethod
    def write(self, out: Floats, f: Floats, flow: "Flow", along: Floats | None = None,
              laplacian: Floats | None = None) -> None:
        """Write the gradient of f (n_all,) at owned fluid particles to out (n_owned, dim). Not collective.

        A particle with too few neighbours gets a zero gradient, and the role BALLISTIC.

        along : (n_all, dim), the gradient across walls at rest (methods.boundary), None for 0
        laplacian : (n_owned,) of f, for parts that are `whole`, None for 0
        """

    def complete(self, out: Floats, flow: "Flow") -> None:
        """Add effects known only of the flow's pressure to its gradient (n_owned, dim) [Pa/m]. Not collective."""

    def form(self, spacing: float) -> Form | None:
        """Return the form of a fit by weighted least squares that walls can mend, or None."""
        return None


class Surface(Part):
    """A rule for the free surface.

    open : whether a free surface is possible
    keeps : whether particles stay on it
    """

    open: ClassVar[bool] = True
    keeps: ClassVar[bool] = False

    @abstractmethod
    def find(self, flow: "Flow", seen: Array) -> None:
        """Write the roles of owned fluid particles. Not collective.

        seen : (n_all,) kind, ABSENT for walls that do not count
        """


class Source(Part):
    """The right-hand side of the pressure equation."""

    def words(self, numerics: ResolvedNumerics) -> str:
        """Return its description in `parisph check` with the numbers of a case, or ""."""
        return ""

    @abstractmethod
    def target(self, flow: "Flow", dt: float) -> Floats:
        """Return the wanted lap p at owned particles (n_owned,) [Pa/m^2], before a step of dt [s]. Collective."""


class ForceTerm(Part):
    """A force per unit mass.

    only : word of vocabulary.PHYSICS of the scenes that feel it, or "" for all scenes
    cause : column of the energy budget, or "" if pressure works against it within a step
    words : its name in `parisph check`, or "" for forces of every scene
    """

    only: ClassVar[str] = ""
    cause: ClassVar[str] = ""
    words: ClassVar[str] = ""

    def __init_subclass__(cls, **further: Any) -> None:
        super().__init_subclass__(**further)
        if cls.only not in ("", *vocabulary.PHYSICS):
            raise ValueError(f"force {cls.__name__}: only = {cls.only!r} is not a kind of physics; "
                             f"choose {', '.join(vocabulary.PHYSICS)}, or leave it out")
        for word in ("viscous", "turning", "absorbing"):
            if getattr(cls, word, False) is True:    # an older form
                raise ValueError(f"force {cls.__name__}: {word} = True has no effect; write only = \"{word}\"")

    @abstractmethod
    def add(self, out: Floats, flow: "Flow", time: float) -> None:
        """Add the acceleration at a time [s] to out (n_all, dim) [m/s^2]. Collective."""

    def given(self, flow: "Flow") -> Floats:
        """Return the acceleration (n_owned, dim) [m/s^2] that it added in this step; 0 unless it says so."""
        return np.zeros_like(flow.particles.x)

    def work(self, flow: "Flow", start: Floats) -> float:
        """Return the energy that it gave to owned fluid in the step [J, in 2D J/m], if it has a cause. Not collective.

        It is the force times the mean of the old and new velocities, a part of the change of kinetic energy.

        start : (n_owned, dim) velocity before the step [m/s]
        """
        p = flow.particles
        power = np.einsum("ia,ia->i", self.given(flow), 0.5 * (start + p.u))
        return flow.density * flow.step.dt * float(p.volume @ power)


class Regulariser(Part):
    """Changes velocities or positions of particles, so that they stay evenly spread.

    moves : whether it changes positions; else velocities
    strain : whether its strength is in proportion to the strain of the step
    needs_fit : whether it uses StepState.beyond_fit, which the pass for the strain computes if there is one
    needs_potential : whether it uses StepState.potential
    free : whether it may move particles farther than positions.CAP
    carries : whether velocities follow its moves, by the field grad_u
    reads : numbers of Numerics that it reads, and that only some regularisers do
    cause : column of the energy budget
    words : its name in `parisph check`

    All regularisers of velocities see the same state, and so do those of positions: after each is prepared, one message
    updates the ghosts, and all changes are computed, then added in order.
    """

    moves: ClassVar[bool] = False
    strain: ClassVar[bool] = True
    needs_fit: ClassVar[bool] = False
    needs_potential: ClassVar[bool] = False
    free: ClassVar[bool] = False
    carries: ClassVar[bool] = False
    reads: ClassVar[tuple[str, ...]] = ()
    cause: ClassVar[str]
    words: ClassVar[str]

    def prepare(self, flow: "Flow", dt: float) -> None:
        """Write the fields that `change` needs of neighbours, and add their names to flow.stale. Collective."""

    @abstractmethod
    def change(self, flow: "Flow", dt: float) -> Floats:
        """Return the change of velocity [m/s], or of position [m], of owned particles (n_owned, dim). Not collective.

        dt : of the step [s]
        """


class Limiter(Regulariser):
    """A regulariser that acts on the result of those before it."""

    def change(self, flow: "Flow", dt: float) -> Floats:
        """Return no change, as it depends on the result of the others."""
        return np.zeros_like(flow.particles.x)

    @abstractmethod
    def apply(self, flow: "Flow", dt: float) -> None:
        """Change the velocities or positions of owned fluid in a step of dt [s]. Collective."""


P = TypeVar("P", bound=Part)


class Registry(Mapping[str, P], Generic[P]):
    """The parts of one kind, by name.

    Parameters
    ----------
    what : kind of part, a key of base.vocabulary.WORDS
    """

    def __init__(self, what: str) -> None:
        self.what = what
        self._parts: dict[str, P] = {}

    def register(self, part: P) -> P:
        """Add a part and return it. Do it on every rank, before a case names it.

        A case file may be read more than once, so a part from outside the package replaces one of the same name.

        Raises ValueError if a part of the package has this name.
        """
        there = self._parts.get(part.name)
        if there is not None and type(there).__module__.startswith("parisph."):
            raise ValueError(f"there is another {self.what} {part.name!r}: give yours a name of its own")
        self._parts[part.name] = part
        vocabulary.add(self.what, part.name)
        return part

    def __getitem__(self, name: str) -> P:
        return self._parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)


LAPLACIANS: Registry[Laplacian] = Registry("laplacian")
DIVERGENCES: Registry[Divergence] = Registry("divergence")
GRADIENTS: Registry[Gradient] = Registry("gradient")
SURFACE_GRADIENTS: Registry[Gradient] = Registry("surface_gradient")
WALL_ROWS: Registry[WallRows] = Registry("wall_rows")
SURFACES: Registry[Surface] = Registry("surface_rule")
SOURCES: Registry[Source] = Registry("source")
FORCES: Registry[ForceTerm] = Registry("force")
REGULARISERS: Registry[Regulariser] = Registry("regulariser")
