"""The parts of a method: what each of them declares, and the registries that know them by name.

A part gets the Flow and arrays, never the method. What a scene needs follows from its parts: its fields, how far
neighbour lists reach, which dimensions it can have, its longest time step, and the stages that `parisph check` prints.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np

from parisph.base import vocabulary
from parisph.base.arrays import Array, Floats
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels.near import Form
from parisph.kernels.records import Cloud, Flux, Rows

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class Part(ABC):
    """What every part declares. Values that depend on numbers of the case are asked for with them.

    Attributes
    ----------
    name : the word of a case
    source : where it is from, such as "Z14 Eq 23", or "" for our own
    reach : radius in spacings within which it needs neighbours
    fields : names of the fields it needs (base.fields), beside those that every scene has
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
        """Whether `longest_step` can be less than infinite."""
        return type(self).longest_step is not Part.longest_step

    def longest_step(self, flow: "Flow") -> float:
        """Return the longest time step [s] that it allows on this rank, infinite if it does not limit it.

        Not collective.
        """
        return np.inf


class Laplacian(Part):
    """Rows of inner particles. With row_I(p) = p_I - sum_J values_J p_J they mean row_I(p) = -measure_I lap p.

    gives : name of the divergence whose stencils `fill` writes as well, or ""
    linear : whether the rows are exact for linear pressure on any particles; else the step balances the body force
    """

    gives: ClassVar[str] = ""
    linear: ClassVar[bool] = True

    @abstractmethod
    def fill(self, rows: Rows, cloud: Cloud, flux: Flux, u: Floats) -> None:
        """Write count, columns, values and measure of inner particles. Not collective.

        u : (n_all, dim) [m/s], for the flux divergence if it gives it
        """


class Divergence(Part):
    """Stencils of the divergence: div u_I = sum_J flux_J . (u_J - u_I) at inner particles."""

    @abstractmethod
    def fill(self, flux: Flux, cloud: Cloud, u: Floats) -> None:
        """Write count, columns and flux of inner particles, and div of u (n_all, dim). Not collective."""


class WallRows(Part):
    """Rows of wet wall particles: row_I(p) = -measure_I n . grad p."""

    @abstractmethod
    def fill(self, rows: Rows, cloud: Cloud) -> None:
        """Write count, columns, values and measure of wet wall particles. Not collective."""

    def complete(self, right: Floats, rows: Rows, cloud: Cloud, flow: "Flow") -> None:
        """Add what the rows need to know of the pressure beside its normal derivative to the right-hand side
        (n_owned,) [Pa]. Not collective.

        rows : as filled, with the roles of flow.particles
        """


class Gradient(Part):
    """The gradient of pressure at fluid particles.

    whole : whether the field laplacian must hold the whole Laplacian of the pressure, with that by the body force
    """

    whole: ClassVar[bool] = False

    @abstractmethod
    def write(self, out: Floats, f: Floats, flow: "Flow", along: Floats | None = None,
              laplacian: Floats | None = None) -> None:
        """Write the gradient of f (n_all,) at owned fluid particles to out (n_owned, dim). Not collective.

        along : (n_all, dim), what the gradient is across walls at rest (methods.boundary), None for 0
        laplacian : (n_owned,) of f, for parts that are `whole`, None for 0

        A particle with too few neighbours gets a zero gradient, and the role BALLISTIC.
        """

    def complete(self, out: Floats, flow: "Flow") -> None:
        """Add what is known of the pressure of the flow, and of no other field, to its gradient (n_owned, dim) [Pa/m].

        Not collective.
        """

    def form(self, spacing: float) -> Form | None:
        """Return the form of a fit by weighted least squares, which walls of any shape can mend.

        None for other gradients.
        """
        return None


class Surface(Part):
    """A rule for the free surface.

    open : whether there may be a free surface at all
    keeps : whether particles on it stay on it
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
        """Return what `parisph check` says of it with the numbers of a case, or nothing."""
        return ""

    @abstractmethod
    def target(self, flow: "Flow", dt: float) -> Floats:
        """Return what lap p shall be at owned particles (n_owned,) [Pa/m^2], before a step of dt [s]. Collective."""


class Force(Part):
    """A force per unit mass.

    only : word of vocabulary.PHYSICS, if only a scene with it feels the force, or "" if all scenes do
    cause : column of the energy budget, or "" if pressure works against it within a step
    words : what `parisph check` calls it, or "" for what every scene has
    """

    only: ClassVar[str] = ""
    cause: ClassVar[str] = ""
    words: ClassVar[str] = ""

    def __init_subclass__(cls, **further: Any) -> None:
        super().__init_subclass__(**further)
        if cls.only not in ("", *vocabulary.PHYSICS):
            raise ValueError(f"force {cls.__name__}: only = {cls.only!r} is no physics of a scene; "
                             f"choose {', '.join(vocabulary.PHYSICS)}, or leave it out")
        for word in ("viscous", "turning", "absorbing"):
            if getattr(cls, word, False) is True:    # how it was said before
                raise ValueError(f"force {cls.__name__}: {word} = True has no effect; write only = \"{word}\"")

    @abstractmethod
    def add(self, out: Floats, flow: "Flow", time: float) -> None:
        """Add the acceleration at a time [s] to out (n_all, dim) [m/s^2]. Collective."""

    def work(self, flow: "Flow", start: Floats) -> float:
        """Return what owned fluid has gained by it in the step [J, in 2D J/m], for a part with a cause. Not collective.

        start : (n_owned, dim) velocity before the step [m/s]
        """
        return 0.0


class Regulariser(Part):
    """Changes velocities or positions of particles, so that they stay evenly spread.

    moves : whether it changes positions; else velocities
    strain : whether its strength is in proportion to the strain of the step
    needs_fit : whether it uses StepState.beyond_fit, which the pass for the strain finds if there is one
    needs_potential : whether it uses StepState.potential
    free : whether it may move particles farther than positions.CAP
    carries : whether velocities follow its moves, by the field grad_u
    reads : the numbers of Numerics that only some regularisers read, and that this one does
    cause : column of the energy budget
    words : what `parisph check` calls it

    All regularisers of velocities see the same state, and so do those of positions: each is prepared, one message
    brings the ghosts all that is needed, and then the changes are computed, and added in their order.
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
        """Write the fields that `change` needs of neighbours, and put their names into flow.stale. Collective."""

    @abstractmethod
    def change(self, flow: "Flow", dt: float) -> Floats:
        """Return the change of velocity [m/s], or of position [m], of owned particles (n_owned, dim). Not collective.

        dt : of the step [s]
        """


class Limiter(Regulariser):
    """A regulariser that acts on what those before it have left."""

    def change(self, flow: "Flow", dt: float) -> Floats:
        """Return no change, because it is not known before the others have acted."""
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
        """Add a part and return it. Do it on every rank, before a case is made that names it.

        A case file may be read more than once: a part from outside the package replaces its own earlier self.

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
FORCES: Registry[Force] = Registry("force")
REGULARISERS: Registry[Regulariser] = Registry("regulariser")
