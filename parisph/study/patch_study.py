"""The description of a patch study: operators, fields and arrangements of particles."""

from collections.abc import Iterator
from typing import Annotated, Literal, TypeVar, Union

from pydantic import AfterValidator, Field, field_validator, model_validator

from parisph.base import text, vocabulary
from parisph.base.text import shown
from parisph.case.model import Model, Several
from parisph.patch.analytic import FIELD_OF, AnalyticField
from parisph.study.definition import Each, Listed, Whole, each_once

OF_LAPLACIANS = ("interior", "square", "dirichlet", "neumann", "closed")
OF_GRADIENTS = ("interior", "square", "walls", "surface")
SOLUTIONS = ("dirichlet", "neumann", "closed")
ON_TANKS = ("neumann", "closed", "walls", "surface")
MOST_CELLS = {2: 2000, 3: 100}    # across the unit square, and the unit cube
FEWEST_CELLS = 8                  # for an interior
WORDS = {
    "laplacians": "laplacian", "gradients": "gradient", "wall_rows": "wall_rows",
    "surface_gradients": "surface_gradient",
}

Spacing = Annotated[float, Field(gt=0, le=1 / FEWEST_CELLS)]
Jitter = Annotated[float, Field(ge=0, le=2)]
Item = TypeVar("Item")


def _some(values: tuple[Item, ...]) -> tuple[Item, ...]:
    if not values:
        raise ValueError("must be a list of at least one")
    return values


Some = Annotated[Listed[Item], AfterValidator(_some)]
SomeEach = Annotated[Each[Item], AfterValidator(_some)]


class Sweep(Model):
    """Spacings and disorders that are combined. Errors are drawn against that with several values.

    spacings : s, with 1/s a whole number; jitters : k of a displacement by k s (Rn - 1/2)
    """

    spacings: SomeEach[Spacing] = Field(description=f"spacings, each greater than 0 and at most 1/{FEWEST_CELLS}")
    jitters: SomeEach[Jitter] = Field(description="disorders k, each 0 to 2")

    @field_validator("spacings")
    @classmethod
    def _whole(cls, values: tuple[float, ...]) -> tuple[float, ...]:
        for s in values:
            cells_of(s)
        return values


class Histogram(Model):
    """Counts of particles by the error of their Laplacian, over the largest exact one (Z14 Fig 3).

    spacing, jitter : s and k; edges : of the ranges, increasing; a last range has no upper edge
    """

    spacing: Spacing = Field(description="spacing")
    jitter: Jitter = Field(description="disorder k")
    edges: Annotated[Several[Annotated[float, Field(ge=0)]], AfterValidator(_some)] = Field(
        default=tuple(k / 10 for k in range(1, 11)), description="edges of the ranges, which increase")

    @model_validator(mode="after")
    def _increases(self) -> "Histogram":
        cells_of(self.spacing)
        if any(b <= a for a, b in zip(self.edges, self.edges[1:])):
            raise ValueError(f"edges = {shown(self.edges)}: must increase")
        return self


class PatchStudy(Model):
    """Operators on fields with known derivatives, in the unit square or cube. All choices are combined.

    fields : names (patch.analytic.FIELD_OF), or AnalyticField(...)
    laplacians, gradients : words of registered parts, also of those that the study file registers
    patches : what is measured

        "interior"   Laplacians and gradients themselves, at particles farther than `margin` from the sides
        "square"     the same at all particles of a square without particles around it
        "dirichlet"  solution of lap p = lap f with p = f on all particles around the square
        "neumann"    the same with walls on all sides except the last, with p = f; n . grad p = n . grad f at the walls
        "closed"     the same with walls on all sides, up to a constant
        "walls"      gradients in the two layers of fluid beside walls
        "surface"    gradients of the particles on a free surface
    sweeps : list of Sweep
    seeds : of the disorder; results are given as mean and range over them
    dim : 2 or 3
    margin : distance from the sides of the particles that count in the interior
    beyond : whether the lattice of "interior" extends beyond the sides, so that no support is cut off
    wall_rows : words of wall rows; problems with walls are solved with each
    surface_gradients : words of gradients that replace others at the surface, for "surface"
    histograms : list of Histogram, of Laplacians in the interior
    title : one line for tables and pictures

    Raises CaseError with one line for each problem.
    """

    kind: Literal["patch"] = Field(default="patch", init=False)
    fields: Some[Union[str, AnalyticField]] = Field(description="names of fields, or AnalyticField(...)")
    sweeps: Some[Sweep] = Field(description="a list of Sweep(spacings=[...], jitters=[...])")
    laplacians: Each[str] = ()
    gradients: Each[str] = ()
    patches: SomeEach[Literal["interior", "square", "dirichlet", "neumann", "closed", "walls", "surface"]] = Field(
        default=("interior",), description="what is measured")
    seeds: SomeEach[Whole] = Field(default=(1, 2, 3), description="seeds, each a whole number of at least 0")
    dim: int = Field(default=2, ge=2, le=3, description="number of dimensions")
    margin: float = Field(default=0.2, ge=0, le=0.4, description="distance of the interior from the sides")
    beyond: bool = True
    wall_rows: SomeEach[str] = Field(default=("sfdi",), description="names of wall rows")
    surface_gradients: Each[str] = ()
    histograms: Listed[Histogram] = ()
    title: str = Field(default="", max_length=200, description="one line for people")

    @model_validator(mode="after")
    def _fits(self) -> "PatchStudy":
        problems = [*self._unknown(), *self._unused()]
        most = MOST_CELLS[self.dim]
        for s in self.all_spacings:
            if cells_of(s) > most:
                problems.append(f"spacing {s:g}: must be at least 1/{most} in {self.dim} dimensions")
        if problems:
            raise ValueError("\n".join(problems))
        each_once(tuple(field.name for field in self.analytic))
        for field in self.analytic:
            field.check(self.dim, self.derivatives)
        return self

    def _unknown(self) -> Iterator[str]:
        """Yield faults of words."""
        for name, kind in WORDS.items():
            for word in getattr(self, name):
                if word not in vocabulary.known(kind):
                    yield f"{name}: unknown {kind} {shown(word)}; known are {', '.join(vocabulary.known(kind))}"
        for field in self.fields:
            if isinstance(field, str) and field not in FIELD_OF:
                yield (f"fields: unknown field {shown(field)}; known are {', '.join(FIELD_OF)}, "
                       "or give AnalyticField(...)")

    def _unused(self) -> Iterator[str]:
        """Yield faults of choices that have no effect, or need others."""
        if not self.laplacians and not self.gradients:
            yield "give laplacians=[...] or gradients=[...], or both"
            return
        for patch in self.patches:
            if patch not in OF_GRADIENTS and not self.laplacians:
                yield f"patches: {shown(patch)} needs laplacians=[...]"
            if patch not in OF_LAPLACIANS and not self.gradients:
                yield f"patches: {shown(patch)} needs gradients=[...]"
        for name, of in (("laplacians", OF_LAPLACIANS), ("gradients", OF_GRADIENTS)):
            if getattr(self, name) and not set(of) & set(self.patches):
                yield f"{name}: none of the patches is for them; add one of {text.listed(map(shown, of))}"
        if self.surface_gradients and ("surface" not in self.patches or not self.gradients):
            yield "surface_gradients: need gradients=[...] and the patch 'surface'"
        if self.histograms and ("interior" not in self.patches or not self.laplacians):
            yield "histograms: need laplacians=[...] and the patch 'interior'"

    @property
    def analytic(self) -> tuple[AnalyticField, ...]:
        """The fields, with those that are given by name."""
        return tuple(FIELD_OF[field] if isinstance(field, str) else field for field in self.fields)

    @property
    def derivatives(self) -> tuple[str, ...]:
        """Names of the exact derivatives that the fields must have."""
        needs_gradient = self.gradients or {"neumann", "closed"} & set(self.patches)
        return (*(["gradient"] if needs_gradient else []), *(["laplacian"] if self.laplacians else []))

    @property
    def all_spacings(self) -> tuple[float, ...]:
        """Spacings of all sweeps and histograms."""
        return (*(s for sweep in self.sweeps for s in sweep.spacings), *(one.spacing for one in self.histograms))


def cells_of(spacing: float) -> int:
    """Return 1/spacing. Raises ValueError, which names the nearest spacing, unless it is a whole number."""
    cells = round(1.0 / spacing)
    if abs(cells * spacing - 1.0) > 1e-6:
        raise ValueError(f"spacing {spacing:g}: a whole number of spacings must fit into 1; write 1/{cells}")
    return cells
