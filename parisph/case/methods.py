"""The methods that a case can name: each is a record of its parts."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from parisph.case.presets import USUAL, WITHOUT_FILMS


@dataclass(frozen=True)
class Method:
    """A method: names of its parts, and numbers that replace those of the preset.

    name : as in a case
    source : paper and equation, such as "Z14 Eq 23" (Zheng, Ma & Duan 2014; Z17 is Zheng et al. 2017)
    values : {field of Numerics: value}, defaults that the method sets
    step : "projection", or "compressible" for weakly compressible SPH
    warning : shown to the user before a run, or ""
    """

    name: str
    source: str
    values: Mapping[str, Any] = field(default_factory=dict)
    step: str = "projection"
    warning: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))


# Common to both papers: no filter, no films, no shift, no second solve, p = 0 at surface particles. The papers do not
# define div u* for rows other than those of ISPH_R. With the nodal form of the gradient's stencils, water at rest
# leaves the tank within half a second.
_PAPER = {
    "divergence": "flux", "wall_guard": 0.25, "gradient": "sfdi", "surface_gradient": "same", "wall_rows": "sfdi",
    "surface_rule": "auxiliary",
    "stepping": "predicted", "strain": 0.0, "residual_strain": 0.0, "volume_time": 0.0, "kappa": 0.0, "shift": 0.0,
    "filter": 0.0, "collision_distance": 0.0, "surface_offset": 0.0, "pressure_mean": 0.0,
    "zeta_time": 0.0, "regularisers": WITHOUT_FILMS,
}
_DENSITY = ("with these settings, water at rest on disordered particles begins to move, "
            "and may leave the tank within 1000 steps")
_Z14 = {**_PAPER, "zeta": 0.9, "gamma": 0.1}
_Z17 = {**_PAPER, "laplacian": "sph", "zeta": 0.99, "gamma": 0.01}

# Rows that are not exact for linear pressure, with a harmonic gradient at the surface, let errors of rounding grow
# within thousands of steps.
METHODS = {
    method.name: method
    for method in (
        Method("ISPH_R", "Z14 Eq 23, normalised so that it converges", {"laplacian": "rankine"}),
        Method("ISPH", "Z14 Eq 20a", {"laplacian": "sph", "surface_gradient": "same"}),
        Method("CISPH1", "Z14 Eqs 20b and 20c, sign corrected", {"laplacian": "cisph1", "surface_gradient": "same"}),
        Method("CISPH2", "Z14 Eqs 20b and 20d, sign corrected", {"laplacian": "cisph2"}),
        # with a filter of 0.03 an error of rounding grows to 6e-6 sqrt(g d) in 10,000 steps of water at rest
        Method("GFD", "generalised finite differences", {"laplacian": "gfd", "filter": 0.06}),
        Method("ISPH_R2", "Z14 Eqs 21-23 with quadratic moving least squares", {"laplacian": "rankine_quadratic"}),
        Method("FM", "Fatehi and Manzari 2011", {"laplacian": "fatehi"}),
        Method("ISPH_R_printed", "Z14 Eq 23 as printed, for comparison only", {"laplacian": "rankine_printed"},
               warning="as printed, the Laplacian is too large by a constant factor and does not converge"),
        Method("HuAdams", "Z14 Eq 17, and Eq 18 in a second solve for positions", {
            "laplacian": "rankine", "source": "divergence", "kappa": 1.0, "kappa_strain": 0.0, "shift": 0.0,
            "residual_strain": 0.0, "regularisers": USUAL["regularisers"]}, warning=_DENSITY),
        Method("KG", "Z14 Eq 23, with the source of Khayyer and Gotoh", {
            "laplacian": "rankine", "source": "compensating", "kappa": 0.0, "shift": 0.0, "residual_strain": 0.0}),
        Method("SPH", "Z14 Eqs 3-9: weakly compressible, with artificial viscosity", {"laplacian": "sph"},
               "compressible"),
        Method("Z14_ISPH_R", "Z14, its own settings", {**_Z14, "laplacian": "rankine_printed"}, warning=_DENSITY),
        Method("Z14_ISPH", "Z14, its own settings", {**_Z14, "laplacian": "sph"}, warning=_DENSITY),
        Method("Z14_CISPH1", "Z14, its own settings", {**_Z14, "laplacian": "cisph1"}, warning=_DENSITY),
        Method("Z14_CISPH2", "Z14, its own settings", {**_Z14, "laplacian": "cisph2"}, warning=_DENSITY),
        Method("Z17_ISPH", "Z17 Eq 25, its own settings", {**_Z17, "gradient": "symmetric"},
               warning="its gradient of a constant pressure is not zero beside walls: "
                       "disordered particles do not stay in the tank"),
        Method("Z17_CISPH1", "Z17 Eqs 26-27, its own settings", {**_Z17, "gradient": "corrected"}, warning=_DENSITY),
        Method("Z17_CISPH2", "Z17 Eq 28, its own settings", {**_Z17, "gradient": "spline"}, warning=_DENSITY),
        Method("Z17_CISPH3", "Z17 Eqs 29-32, its own settings", {**_Z17, "gradient": "sfdi"}, warning=_DENSITY),
    )
}


def register(method: Method) -> Method:
    """Add a method from outside the package, and return it. Call it on every rank.

    Raises ValueError if another method has this name.
    """
    if METHODS.setdefault(method.name, method) != method:
        raise ValueError(f"there is another method {method.name!r}")
    return method
