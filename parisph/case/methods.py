"""The methods that a case can name: each is a record of the parts it is made of."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True)
class Method:
    """A method: words for its parts, and numbers that replace those of the preset.

    Attributes
    ----------
    name : the word of a case
    source : paper and equation, such as "Z14 Eq 23" (Zheng, Ma & Duan 2014; Z17 is Zheng et al. 2017)
    values : {field of Numerics: value} that the method sets, unless the case does
    step : "projection"
    warning : what a user must know before running it, or ""
    """

    name: str
    source: str
    values: Mapping[str, Any] = field(default_factory=dict)
    step: str = "projection"
    warning: str = ""

    def __post_init__(self):
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))


METHODS = {
    method.name: method
    for method in (
        Method("ISPH_R", "Z14 Eq 23, normalised so that it converges", {"laplacian": "rankine"}),
        Method("ISPH", "Z14 Eq 20a", {"laplacian": "sph"}),
        Method("CISPH1", "Z14 Eqs 20b and 20c, sign corrected", {"laplacian": "cisph1"}),
        Method("CISPH2", "Z14 Eqs 20b and 20d, sign corrected", {"laplacian": "cisph2"}),
        Method("GFD", "generalised finite differences", {"laplacian": "gfd"}),
        Method("ISPH_R2", "Z14 Eqs 21-23 with quadratic moving least squares", {"laplacian": "rankine_quadratic"}),
        Method("FM", "Fatehi and Manzari 2011", {"laplacian": "fatehi"}),
        Method("ISPH_R_printed", "Z14 Eq 23 as printed, for comparison only", {"laplacian": "rankine_printed"},
               warning="as printed, the Laplacian is too large by a constant factor and does not converge"),
    )
}


def register(method: Method) -> Method:
    """Add a method from outside the package, and return it. Do it on every rank.

    Raises ValueError if another method has this name.
    """
    if METHODS.setdefault(method.name, method) != method:
        raise ValueError(f"there is another method {method.name!r}")
    return method
