"""The third dimension of a scene: extents across it, and vectors of its section.

x runs along the section of a scene, z up, and y across. A vector of two components is one of the section.
"""

from collections.abc import Sequence
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, field_validator, model_serializer

from parisph.base.arrays import Flags, Floats
from parisph.base.text import shown
from parisph.case.model import Model

_T = TypeVar("_T")
LATER = ("breadth", "across")    # fields that a 2D scene does not store: releases before 3D do not know them
Across = Annotated[tuple[float, float] | None,
                   Field(description="ends (ya, yb) across a 3D scene [m], None for its whole breadth")]

Breadth = Annotated[float | None, Field(gt=0, description="length across the scene [m], which makes it 3D")]


class Spread(Model):
    """Base of shapes and bodies that have a place across a 3D scene, in a field `breadth` or `across`."""

    @field_validator("across", check_fields=False)
    @classmethod
    def _in_order(cls, across: tuple[float, float] | None) -> tuple[float, float] | None:
        if across is not None and not across[0] < across[1]:
            raise ValueError(f"{shown(across)}: the first end must be below the second; give (ya, yb) with ya < yb")
        return across

    @model_serializer(mode="wrap")
    def _as_before(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        fields: dict[str, Any] = handler(self)
        return {name: value for name, value in fields.items() if value is not None or name not in LATER}

    @property
    def extent(self) -> tuple[float, float] | None:
        """Ends across a 3D scene [m], or None for its whole breadth."""
        own: tuple[float, float] | None = getattr(self, "across", None)
        return own


def flat(vector: Sequence[_T]) -> tuple[_T, ...]:
    """Return the components of a vector in the section: the first and the last."""
    return vector[0], vector[-1]


def lifted(vector: tuple[_T, ...], dim: int) -> tuple[_T | float, ...]:
    """Return the dim components of a vector, of which (a, b) means (a, 0, b) in 3D."""
    return (vector[0], 0.0, vector[1]) if dim == 3 and len(vector) == 2 else vector


def section_of(x: Floats) -> Floats:
    """Return the components (..., 2) in the section of vectors x (..., dim): x itself in 2D."""
    return x if x.shape[-1] == 2 else x[..., [0, 2]]


def solid_box(lower: Floats, upper: Floats, extent: tuple[float, float] | None) -> tuple[Floats, Floats]:
    """Return the corners of a box with an extent [m] across. lower, upper : of the section, (2,) each [m]"""
    if extent is None:
        return lower, upper
    return np.insert(lower, 1, extent[0]), np.insert(upper, 1, extent[1])


def within(x: Floats, extent: tuple[float, float] | None, tolerance: float) -> Flags:
    """Return which of the points x (n, dim) [m] lie in an extent across, widened by a tolerance [m]; in 2D all."""
    if extent is None or np.shape(x)[1] == 2:
        return np.ones(len(x), dtype=bool)
    found: Flags = (x[:, 1] >= extent[0] - tolerance) & (x[:, 1] <= extent[1] + tolerance)
    return found
