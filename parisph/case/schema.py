"""The description of a scene: frozen, validated, JSON in and out."""

from collections.abc import Mapping
from typing import Any

from pydantic import PrivateAttr, ValidationInfo, model_validator

from parisph.base.errors import CaseError
from parisph.base.text import named, shown
from parisph.case import checks
from parisph.case.absorb import Relaxation, Sponge
from parisph.case.bodies import Flap, Obstacle, Piston, Plate, Profile, StillWater
from parisph.case.ellipsoid import Ellipsoid
from parisph.case.faults import first_lines
from parisph.case.fluids import Fluid
from parisph.case.friction import Friction
from parisph.case.methods import METHODS
from parisph.case.model import Model
from parisph.case.motion import (
    AtRest,
    Combined,
    FlapStroke,
    Heave,
    Moved,
    PistonStroke,
    Pitch,
    Roll,
    Series,
    Sway,
    Tabulated,
    Turn,
    Yaw,
)
from parisph.case.numerics import Numerics, Output, ResolvedNumerics
from parisph.case.origin import Origin
from parisph.case.presets import CLOSED, PRESETS, preset_values
from parisph.case.probes import ProbeArray
from parisph.case.profiles import Profiles
from parisph.case.scene import Scene
from parisph.case.shapes import Box, Disc, Lid, Polygon, Tank
from parisph.case.surface_body import Surface
from parisph.case.truths import PeakBand, Peaks, Truth, WaveTruth
from parisph.case.waves import Airy, Jonswap, Sloshing, SolitaryWave, StandingWave, Stokes, StreamFunction, TankMode

__all__ = [
    "METHODS", "PRESETS", "Airy", "AtRest", "Box", "Case", "Combined", "Disc", "Ellipsoid", "Flap", "FlapStroke",
    "Fluid", "Friction", "Heave", "Jonswap", "Lid", "Moved", "Numerics", "Obstacle", "Output", "PeakBand", "Peaks",
    "Piston", "PistonStroke", "Pitch", "Plate", "Polygon", "ProbeArray", "Profile", "Profiles", "Relaxation",
    "Roll", "Series", "Sloshing", "SolitaryWave", "Sponge", "StandingWave", "StillWater", "Stokes",
    "StreamFunction", "Surface", "Sway", "Tabulated", "Tank", "TankMode", "Truth", "Turn", "WaveTruth", "Yaw",
]

# Context of a validation that checks only names and types, to open an older run that this release would not compute.
READ_ONLY = "read only"


class Case(Scene):
    """A scene and how it is computed, in SI units.

    It is 3D if a Tank or a Profile has a breadth, or, without walls, a Box of fluid: x runs along the section, y across
    it, and z up. A vector of two components is then one of the section.

    title : one line, shown in pictures and tables
    source : where the scene is from, such as a paper and its figures; shown on pages
    fluid : Fluid, or several of one density and viscosity, which do not overlap
    walls : a Tank, Profile, Obstacle, Plate, Piston, Flap or Surface, several of them, or None
    gravity : components of the body force [m/s2], numbers or expressions of x, y and t, in 3D of x, y, z and t
    frame : motion of the tank; the flow is computed in its frame
    absorb : a Sponge or Relaxation zone, or several
    friction : Friction of turbulent flow on free-slip walls, or None
    numerics, output : Numerics, Output
    probes : a list of probes
    end_time : [s]
    asked : None, or in a stored case the numerics given by the user; `numerics` then also contains the preset's values

    Raises CaseError: with one line for each problem

    >>> case = Case(title="Water at rest", fluid=Fluid(Box(width=1.0, height=0.4), density=1000.0),
    ...             walls=Tank(width=1.0, height=0.6), gravity=(0.0, -9.81), numerics=Numerics(spacing=0.05),
    ...             probes=[PressureTap("tap", at=(0.0, 0.2))], end_time=1.0)
    >>> case.changed(**{"numerics.spacing": 0.1, "end_time": 2.0}).numerics.spacing
    0.1
    """

    _origin: Origin = PrivateAttr(default_factory=Origin)

    @property
    def origin(self) -> Origin:
        """The file of the case and the parameters of its function (case.origin). It is not a part of the case."""
        return self._origin

    def of(self, origin: Mapping[str, Any]) -> "Case":
        """Return the same case with this origin."""
        case = self.model_copy()
        setattr(case, "_origin", Origin(origin))    # type checkers treat a record as frozen
        return case

    @model_validator(mode="after")
    def _can_run(self, info: ValidationInfo) -> "Case":
        if info.context == READ_ONLY:
            return self
        found = checks.problems(self)
        if found:
            raise ValueError(first_lines(found))
        return self

    def complete_numerics(self) -> ResolvedNumerics:
        """Return the numerics with the values of method and preset, for a closed case without a free surface."""
        numerics = self.numerics
        if not self.closed:
            return numerics.resolved()
        values, method = preset_values(numerics.preset, closed=True), METHODS[numerics.method].values
        own = {name: values[name] for name in CLOSED
               if getattr(numerics, name) is None and (name == "surface_rule" or name not in method)}
        return numerics.resolved().model_copy(update=own)

    def resolved(self, numerics: ResolvedNumerics) -> "Case":
        """Return the case with the resolved `numerics`; `asked` keeps those given by the user."""
        return self.model_copy(update={"numerics": numerics, "asked": self.asked or self.numerics})

    def changed(self, **values: Any) -> "Case":
        """Return a validated copy with other values. Use dots for nested values: changed(**{"numerics.cfl": 0.3}).

        In a stored case, a new preset replaces the values of the old one, but not those given by the user.

        Raises CaseError: an unknown name, or a case that cannot run
        """
        data = self.model_dump()
        for name, value in values.items():
            _put(data, name, value)
        if self.asked is not None:
            _put_asked(data, values)
        asked = data.pop("asked")    # validated separately, or errors in the numerics would be reported twice
        case = Case.model_validate(data)
        case = case if asked is None else case.model_copy(update={"asked": Numerics.model_validate(asked)})
        before = self.origin.get("changed")
        return case.of({**self.origin, "changed": [*(before if isinstance(before, list) else ()), *values]}
                       if self.origin else {})


def _put(data: dict[str, Any], name: str, value: Any) -> None:
    """Set an entry of nested dictionaries by its dotted name."""
    *path, last = name.split(".")
    part = data
    for key in path:
        inner = part.get(key)
        if not isinstance(inner, dict):
            raise CaseError(f"{named(name)}: the case has no part {shown(key)}; it has {', '.join(data)}")
        part = inner
    part[last] = value.model_dump() if isinstance(value, Model) else value


def _put_asked(data: dict[str, Any], values: Mapping[str, Any]) -> None:
    """Apply the changes to the numerics given by the user, and replace values of the preset that depend on them."""
    names = {name.partition(".")[2] for name in values if name.startswith("numerics.")} & set(Numerics.model_fields)
    for name in names:
        data["asked"][name] = data["numerics"][name]
    if "numerics" in values:
        data["asked"] = None
    elif "preset" in names:
        data["numerics"], data["asked"] = data["asked"], None
    else:
        again = {other for name, other in (("zeta", "zeta_time"), ("zeta_time", "zeta")) if name in names}
        if any(name.partition(".")[0] in ("fluid", "walls") for name in values):
            again |= set(CLOSED)    # a full tank with a lid has other values
        for name in again - names:
            data["numerics"][name] = data["asked"][name]
