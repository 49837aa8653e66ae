"""The parts of a scene, found from the words and numbers of its case."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from parisph.base.errors import CaseError
from parisph.base.fields import FieldSet
from parisph.case.methods import METHODS
from parisph.case.numerics import Numerics, ResolvedNumerics
from parisph.case.presets import PRESETS
from parisph.methods import (  # noqa: F401 (they register)
    absorbing,
    forces,
    further_shifts,
    lengths,
    operators,
    positions,
    potential,
    sources,
    spacing,
    straining,
    surfaces,
    velocities,
    wall_friction,
)
from parisph.methods.guesses import Guesses
from parisph.methods.parts import (
    DIVERGENCES,
    FORCES,
    GRADIENTS,
    LAPLACIANS,
    REGULARISERS,
    SOURCES,
    SURFACE_GRADIENTS,
    SURFACES,
    WALL_ROWS,
    Divergence,
    ForceTerm,
    Gradient,
    Laplacian,
    Part,
    Registry,
    Regulariser,
    Source,
    Surface,
    WallRows,
)
from parisph.methods.stepping import STEPPINGS

WORDS: dict[str, Registry[Any]] = {    # the fields of Numerics that name one part
    "laplacian": LAPLACIANS, "divergence": DIVERGENCES, "wall_rows": WALL_ROWS, "gradient": GRADIENTS,
    "surface_gradient": SURFACE_GRADIENTS, "surface_rule": SURFACES, "source": SOURCES}

# Fields of a case that switch on the forces of some physics.
ASKED = {"viscous": "fluid.viscosity or numerics.smagorinsky", "friction": "friction"}


@dataclass(frozen=True)
class Parts:
    """The parts that the numbers of a case switch on, and their properties.

    numerics : ResolvedNumerics
    """

    numerics: ResolvedNumerics
    laplacian: Laplacian
    divergence: Divergence
    wall_rows: WallRows
    gradient: Gradient
    surface_gradient: Gradient
    surface: Surface
    source: Source
    forces: tuple[ForceTerm, ...]
    regularisers: tuple[Regulariser, ...]

    @classmethod
    def of(cls, numerics: ResolvedNumerics, physics: Collection[str] = ()) -> "Parts":
        """Return the parts of a scene. Not collective.

        physics : of the scene, words of vocabulary.PHYSICS
        """
        n = numerics
        return cls(n, LAPLACIANS[n.laplacian], DIVERGENCES[n.divergence], WALL_ROWS[n.wall_rows], GRADIENTS[n.gradient],
                   SURFACE_GRADIENTS[n.surface_gradient], SURFACES[n.surface_rule], SOURCES[n.source],
                   tuple(part for part in (FORCES[name] for name in n.forces)
                         if part.wanted(n) and (not part.only or part.only in physics)),
                   tuple(part for part in (REGULARISERS[name] for name in n.regularisers) if part.wanted(n)))

    def __iter__(self) -> Iterator[Part]:
        yield from (self.laplacian, self.divergence, self.wall_rows, self.gradient, self.surface_gradient, self.surface,
                    self.source)
        yield from (*self.forces, *self.regularisers)

    @cached_property
    def velocity_regularisers(self) -> tuple[Regulariser, ...]:
        """Regularisers of velocities, in order."""
        return tuple(part for part in self.regularisers if not part.moves)

    @cached_property
    def position_regularisers(self) -> tuple[Regulariser, ...]:
        """Regularisers of positions, in order."""
        return tuple(part for part in self.regularisers if part.moves)

    @cached_property
    def measures_strain(self) -> bool:
        """Whether the strain of a step is needed."""
        return set(straining.FIELDS) <= set(self.fields)

    @property
    def reach(self) -> float:
        """Radius of the neighbour lists, in spacings."""
        return max(lengths.NEAR, *(part.reach for part in self))

    @cached_property
    def fields(self) -> FieldSet:
        """The fields of the scene's particles."""
        stepping = STEPPINGS[self.numerics.stepping]
        return FieldSet((*Guesses.fields, *(Guesses.of_waves if stepping.corrected else ()), *stepping.fields,
                         *(name for part in self for name in part.needs(self.numerics))))

    @property
    def causes(self) -> tuple[str, ...]:
        """Possible causes of energy changes in a step: columns of the budget."""
        working = (part.cause for part in self.forces if part.cause)
        return tuple(dict.fromkeys(("pressure", *working, *(part.cause for part in self.regularisers))))

    def stages(self, closed: bool) -> list[str]:
        """Return the names of the stages of a step, in order. closed : whether the fluid fills a closed tank."""
        n = self.numerics
        found = ["predict (corrected)" if STEPPINGS[n.stepping].corrected else "predict", "redistribute"]
        if self.surface.open and not self.surface.keeps:
            found.append(f"surface ({self.surface.name})")
        further = [part.words for part in self.forces if part.words]
        source = self.source.words(n) and f", {self.source.words(n)}"
        flux = f", {self.divergence.name} divergence" if self.laplacian.gives != self.divergence.name else ""
        own = self.surface.open and self.surface_gradient.name != "same"
        surface = f", {self.surface_gradient.name} at the surface" if own else ""
        return [*found, *further, f"assemble ({n.method}, {self.wall_rows.name} walls{flux}{source})",
                "solve" + (" (null space)" if closed else ""), f"correct ({self.gradient.name} gradient{surface})",
                *(part.words for part in self.regularisers)]

    def check(self, dim: int) -> None:
        """Raise CaseError for a part that does not work in this number of dimensions."""
        for field, part in self._asked():
            if dim not in part.dims:
                known = " and ".join(f"{n}D" for n in part.dims)
                raise CaseError(f"{field}: works in {known} only, and this scene has {dim} dimensions; "
                                f"{self._remedy(part, dim)}")

    def _asked(self) -> Iterator[tuple[str, Part]]:
        """Yield each part with the words of the case that switch it on."""
        n = self.numerics
        for field in WORDS:
            word = getattr(n, field)
            own = f", of method {n.method}" if METHODS[n.method].values.get(field) == word else ""
            yield f"numerics.{field} = {word}{own}", WORDS[field][word]
        for force in self.forces:
            yield ASKED.get(force.only, f"numerics.forces = {force.name}"), force
        for part in self.regularisers:
            own = f", of preset {n.preset}" if part.name in PRESETS[n.preset].get("regularisers", ()) else ""
            yield f"numerics.regularisers = {part.name}{own}", part

    def _remedy(self, part: Part, dim: int) -> str:
        """Return the remedy for a part that does not work."""
        field = next((field for field in WORDS if WORDS[field].get(part.name) is part), None)
        if field is None:
            if isinstance(part, Regulariser):
                return "choose another preset, or give numerics.regularisers without it"
            return "leave them out" if getattr(part, "only", "") == "viscous" else "leave it out"
        fit = [name for name, other in WORDS[field].items() if dim in other.dims
               and not (field == "surface_rule" and name == "none")]
        return f"give numerics.{field} = {' or '.join(fit)}, or choose another method"


class CompressibleParts:
    """The counterpart of `catalogue.Parts` for weakly compressible SPH."""

    reach = 2.0 * lengths.SPH
    causes = ("pressure",)

    def __init__(self, numerics: ResolvedNumerics) -> None:
        self.numerics = numerics
        self.keeps_surface = SURFACES[numerics.surface_rule].keeps
        self.fields = FieldSet(("rho", "pull", *(("start_role",) if self.keeps_surface else ())))

    def stages(self, closed: bool) -> list[str]:
        """Return the names of the stages of a step, in order."""
        n = self.numerics
        xsph = [f"XSPH ({n.xsph:g})"] if n.xsph else []
        viscosity = f" and artificial viscosity ({n.artificial_viscosity:g})" if n.artificial_viscosity else ""
        return ["half step of velocities", *xsph, "move", "redistribute", "densities",
                f"equation of state ({n.equation_of_state})", "pressure of walls", f"pressure{viscosity}",
                "half step of velocities"]

    def check(self, dim: int) -> None:
        """Raise CaseError for numbers that weakly compressible SPH does not support."""
        n = self.numerics
        if n.smagorinsky:
            raise CaseError(f"numerics.smagorinsky = {n.smagorinsky:g}: "
                            "weakly compressible SPH has artificial viscosity only; leave it out, "
                            "or choose a projection method")


def parts_of(numerics: ResolvedNumerics, physics: Collection[str] = ()) -> Parts | CompressibleParts:
    """Return the Parts of a projection method, or CompressibleParts. Not collective. Arguments as of Parts.of."""
    if METHODS[numerics.method].step == "compressible":
        return CompressibleParts(numerics)
    return Parts.of(numerics, physics)


def unread(numerics: Numerics) -> list[str]:
    """Return a line for each given number, not 0, that no regulariser of the case reads.

    numerics : as the user gave them
    """
    given, found = numerics.resolved(), []
    own = {word for name in given.regularisers for word in REGULARISERS[name].reads}
    if METHODS[numerics.method].step == "compressible":
        own = set()
    for word in sorted({word for part in REGULARISERS.values() for word in part.reads} - own):
        if word in numerics.model_fields_set and getattr(numerics, word):
            readers = [name for name, part in REGULARISERS.items() if word in part.reads]
            found.append(f"numerics.{word} = {getattr(numerics, word):g} has no effect: this scene has none of the "
                         f"regularisers that read it: {', '.join(readers)}; leave it out, or choose another preset")
    return found


def warning(numerics: Numerics) -> str:
    """Return a warning about the method of a case, or ""."""
    return METHODS[numerics.method].warning
