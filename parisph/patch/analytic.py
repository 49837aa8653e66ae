"""Fields with exact derivatives, by name or made of functions."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from pydantic import Field, field_validator

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.text import class_name, of_error, shown
from parisph.case.model import Model

STEP = {"gradient": 1e-4, "laplacian": 1e-3}    # of the finite differences that check exact derivatives
SLACK = 0.05    # largest error of an exact derivative, over the largest difference in any direction

Values = Callable[[Floats], Floats]


class AnalyticField(Model):
    """A field of the unit square or cube. Its functions take positions (n, dim) and must accept any n.

    name : for tables; formula : for titles; value : -> (n,); gradient : -> (n, dim), for gradients and Neumann sides;
    laplacian : -> (n,), for Laplacians
    """

    name: str = Field(min_length=1, max_length=40, description="name of the field")
    value: Values = Field(exclude=True, description="function of positions (n, dim) that returns (n,)")
    gradient: Values | None = Field(
        default=None, exclude=True, description="function of positions (n, dim) that returns (n, dim)")
    laplacian: Values | None = Field(
        default=None, exclude=True, description="function of positions (n, dim) that returns (n,)")
    formula: str = Field(default="", max_length=80, description="formula for titles")

    @field_validator("value", "gradient", "laplacian", mode="before")
    @classmethod
    def _callable(cls, function: object) -> object:
        if function is not None and not callable(function):
            raise ValueError(f"{shown(function)}: must be a function of positions (n, dim)")
        return function

    def values(self, x: Floats) -> Floats:
        """Return the field at positions (n, dim): (n,). Raises CaseError if the function fails."""
        return self._call("value", x, (len(x),))

    def gradients(self, x: Floats) -> Floats:
        """Return the gradient at positions (n, dim): (n, dim). Raises CaseError."""
        return self._call("gradient", x, x.shape)

    def laplacians(self, x: Floats) -> Floats:
        """Return the Laplacian at positions (n, dim): (n,). Raises CaseError."""
        return self._call("laplacian", x, (len(x),))

    def check(self, dim: int, derivatives: tuple[str, ...]) -> None:
        """Raise CaseError if a derivative, "gradient" or "laplacian", is missing or is not that of the value.

        It is compared with finite differences at 20 points of the unit square or cube.
        """
        x = np.random.default_rng(0).uniform(0.1, 0.9, (20, dim))
        f = self.values(x)
        for name in derivatives:
            if getattr(self, name) is None:
                raise CaseError(f"field {shown(self.name)} has no {name}=: give the function that returns it")
            exact = self.gradients(x) if name == "gradient" else self.laplacians(x)
            along = self._differences(x, f, name)
            found = along if name == "gradient" else along.sum(axis=1)
            if np.abs(found - exact).max() > SLACK * np.abs(along).max() + 1e-6 * (1.0 + np.abs(f).max()):
                k = int(np.abs(found - exact).reshape(len(x), -1).max(axis=1).argmax())
                raise CaseError(f"field {shown(self.name)}: its {name} is not that of its value: {shown(exact[k])} "
                                f"instead of {shown(np.round(found[k], 4))} at {shown(np.round(x[k], 3))}")

    def _differences(self, x: Floats, f: Floats, name: str) -> Floats:
        """Return first or second derivatives in each direction at x by differences, (n, dim). f : value at x (n,)"""
        step, dim = STEP[name], x.shape[1]
        pairs = [(self.values(x + step * unit), self.values(x - step * unit)) for unit in np.eye(dim)]
        if name == "gradient":
            return np.stack([(plus - minus) / (2.0 * step) for plus, minus in pairs], axis=1)
        return np.stack([(plus - 2.0 * f + minus) / step**2 for plus, minus in pairs], axis=1)

    def _call(self, name: str, x: Floats, shape: tuple[int, ...]) -> Floats:
        try:
            found: Floats = np.asarray(getattr(self, name)(x), float)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise CaseError(f"field {shown(self.name)}: its {name} fails: "
                            f"{class_name(error)}: {of_error(error)}") from None
        if found.shape != shape:
            raise CaseError(f"field {shown(self.name)}: its {name} returns an array of shape {found.shape} "
                            f"for positions of shape {x.shape}: it must be {shape}")
        if not np.isfinite(found).all():
            raise CaseError(f"field {shown(self.name)}: its {name} is not finite everywhere in the unit square")
        return found


def _harmonic(x: Floats) -> Floats:
    values: Floats = np.exp(2.0 * x[:, 1]) * np.cos(2.0 * x[:, 0] + 0.3)
    return values


def _harmonic_gradient(x: Floats) -> Floats:
    return _beside(-2.0 * np.exp(2.0 * x[:, 1]) * np.sin(2.0 * x[:, 0] + 0.3), 2.0 * _harmonic(x), x)


def _beside(along_x: Floats, along_y: Floats, x: Floats) -> Floats:
    """Return a gradient without a component in z."""
    return np.stack([along_x, along_y, *[np.zeros(len(x))] * (x.shape[1] - 2)], axis=1)


def _plane(name: str, formula: str, k: tuple[float, float, float], value: Values, slope: Values,
           bend: Values) -> AnalyticField:
    """Return the field value(k . x). slope, bend : the first and the second derivative of `value`"""
    def way(x: Floats) -> Floats:
        return np.array(k[:x.shape[1]])

    return AnalyticField(name, lambda x: value(x @ way(x)), lambda x: slope(x @ way(x))[:, None] * way(x),
                         lambda x: bend(x @ way(x)) * (way(x) @ way(x)), formula)


_FIELDS = (
    _plane("wave", "cos(4 pi x + 8 pi y)", (4.0 * np.pi, 8.0 * np.pi, 0.0), np.cos, lambda s: -np.sin(s),
           lambda s: -np.cos(s)),    # Z14
    AnalyticField("parabola", lambda x: (x[:, :2] ** 2).sum(axis=1), lambda x: _beside(2.0 * x[:, 0], 2.0 * x[:, 1], x),
                  lambda x: np.full(len(x), 4.0), "x^2 + y^2"),    # Z17
    _plane("exponential", "exp(2x + 3y)", (2.0, 3.0, 0.0), np.exp, np.exp, np.exp),    # Z17
    _plane("smooth", "sin(x + 2y)", (1.0, 2.0, 3.0), np.sin, np.cos, lambda s: -np.sin(s)),    # in 3D sin(x + 2y + 3z)
    AnalyticField("harmonic", _harmonic, _harmonic_gradient, lambda x: np.zeros(len(x)), "exp(2y) cos(2x + 0.3)"),
)
FIELD_OF: Mapping[str, AnalyticField] = MappingProxyType({field.name: field for field in _FIELDS})
