"""The base of all probes of a case, and the registry of their kinds.

The kinds of parisph are in the folder watch/probes, one in each file.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Optional, Union

import numpy as np
from pydantic import (
    Field,
    PlainValidator,
    SerializeAsAny,
    SerializerFunctionWrapHandler,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticKnownError, SchemaValidator, core_schema

from parisph.base import vocabulary
from parisph.base.arrays import Flags, Floats
from parisph.base.probe_rows import WIDTH as WIDTH
from parisph.base.text import shown
from parisph.case.model import Model, Several
from parisph.case.profiles import Profiles
from parisph.case.truths import Peaks, Truth, WaveTruth

OURS = "parisph.watch.probes"    # a module for each kind
LAST = ("acted", "truth", "peak", "arrival", "every", "y")    # fields that follow those of a kind
DRY = 1e-6    # of the spacing, above the bed: a gauge with less is dry

Point = Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="point (x, y), in 3D (x, y, z) [m]")]


def up(dim: int) -> str:
    """Return the name of the axis upwards."""
    return "xyz"[dim - 1]


class Measure:
    """The measurement of a probe in a run. Nothing here is collective.

    view : watch.sampling.View, the particles of this rank and the scene at the time of a sample
    """

    def sums(self, view: Any) -> Any:
        """Return numbers (n,) to be added over the ranks."""
        return ()

    def rows(self, view: Any) -> Floats:
        """Return rows (n, WIDTH) of numbers; every rank gets the rows of all ranks."""
        return np.empty((0, WIDTH))

    def values(self, sums: Floats, rows: Floats, view: Any) -> Any:
        """Return the values, in the order of the columns, from the sums and the rows of all ranks."""
        return sums


class Probe(Measure, Model):
    """A named probe, written to probes/NAME.csv. A new kind is a class derived from this one.

    With peak=True the run writes the flow at the greatest value of the probe (of its first column, in the bands or the
    window of its truth if it has one) to peaks/NAME.vtkhdf. This checks every step, also between samples.

    With arrival=VALUE the summary gives the time when the probe first passes this value, upwards or downwards,
    interpolated linearly between its samples: the arrival of a front or of a wave.

    With every=N it takes each N-th of the run's samples (Output.probe_every, probe_interval): for expensive probes that
    change slowly, such as a Volume. With Output.probe_interval it saves lines, not time.

    A kind has a field `kind` with its name, further fields, and these:

    columns : {name: unit} of what it measures; `columns_in` if they depend on its fields
    dims : numbers of dimensions in which it works
    judged : column to which a truth refers, "" for the first
    impacts : columns whose peaks and their durations are in the summary
    quantity : label of axes in pictures, "" to derive it from the unit; quantities : {column: label} of other columns
    family : of kinds that share axes, "" for none; of_potential : beginnings of columns omitted if gravity varies
    """

    columns: ClassVar[Mapping[str, str]] = {}
    dims: ClassVar[tuple[int, ...]] = (2, 3)
    judged: ClassVar[str] = ""
    impacts: ClassVar[tuple[str, ...]] = ()
    quantity: ClassVar[str] = ""
    quantities: ClassVar[Mapping[str, str]] = {}
    family: ClassVar[str] = ""
    of_potential: ClassVar[tuple[str, ...]] = ()

    name: str = Field(description="name of the probe and of its file")
    truth: Union[Truth, Peaks, None] = Field(default=None, kw_only=True)
    peak: bool = Field(default=False, kw_only=True,
                       description="whether the flow at the greatest value is written, in the window of its truth")
    arrival: Optional[float] = Field(
        default=None, kw_only=True, description="value whose first passing is in the summary, in the probe's unit")
    every: int = Field(default=1, ge=1, kw_only=True,
                       description="samples of the run for each sample of this probe")

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        fields = cls.model_fields
        for name in LAST:
            if name in fields:
                fields[name] = fields.pop(name)
        if "kind" in fields and not fields["kind"].is_required():
            _register(fields["kind"].default, cls)

    @field_validator("name")
    @classmethod
    def _file_name(cls, name: str) -> str:
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}", name):
            raise ValueError(
                f"{shown(name)} cannot name a file: use up to 64 letters, digits, '_', '-' or '.', "
                "and start with a letter or digit"
            )
        return name

    def gate(self, dim: int) -> Any:
        """Return the watch.passages.Gate through which water is counted in every step, or None."""
        return None

    def title(self, scene: Any) -> str:
        """Return the title of its file: the first line of the class docstring. scene : watch.sampling.ProbeScene"""
        return (type(self).__doc__ or type(self).__name__).strip().partition("\n")[0].rstrip(".")

    def columns_in(self, scene: Any) -> dict[str, str]:
        """Return {column: unit}. scene : watch.sampling.ProbeScene"""
        return dict(self.columns)

    def problems(self, case: Any) -> Iterator[str]:
        """Yield one line for each fault in a case (case.scene.Scene): field, value, limit and remedy."""
        return iter(())

    def misplaced(self, places: Any) -> Iterator[str]:
        """Yield one line for each fault of its place between walls. places : geometry.probe_places.Places"""
        return iter(())

    def drawn(self, heights: tuple[float, float]) -> Optional[Floats]:
        """Return its place in pictures, a point or those of a line (n, 2) [m] in the section, or None.

        It is from the fields `at`, or `start` and `end`, or `points`. heights : ends of vertical lines [m]
        """
        at, start = getattr(self, "at", None), getattr(self, "start", None)
        if isinstance(at, float):
            return np.array([(at, height) for height in heights])
        points = (start, getattr(self, "end", start)) if start is not None else getattr(self, "points", None)
        points = (at,) if at is not None else points
        return np.array([(point[0], point[-1]) for point in points]) if points else None

    def touched(self, values: Floats, case: Any, scene: Any) -> Iterator[tuple[str, Flags]]:
        """Yield each disturbance of the measurement, and which samples (n,) bool it affects.

        values : (columns, n) of a run of the case; scene : watch.sampling.ProbeScene
        """
        yield "no value, outside the fluid,", ~np.isfinite(values).all(axis=0)

    def ghosts(self) -> tuple[str, ...]:
        """Return the fields that must be current on ghosts."""
        return ()

    def begin(self, scene: Any) -> Measure:
        """Return the Measure of a run: this record, or an object with more state. scene : watch.sampling.ProbeScene"""
        return self


class Unknown(Probe):
    """A probe of an unknown kind, in a run opened only for reading."""

    model_config = {"extra": "allow"}

    kind: str = Field(init=False)
    truth: Union[Truth, WaveTruth, Peaks, None] = Field(    # type: ignore[assignment]    # also that of a SurfaceGauge
        default=None, kw_only=True)


class OfPressure(Probe):
    """A probe that is linear in the pressure; a run writes its means in time (watch.means).

    A sample has the time for which its pressure is solved.
    """

    acted: bool = Field(
        default=False, kw_only=True, description="whether to write the pressure of the step beside its mean")


class AcrossProbe(Probe):
    """A probe with a place `y` across a 3D scene."""

    y: Optional[float] = Field(default=None, kw_only=True, description="position y across a 3D scene [m]")

    @model_serializer(mode="wrap")
    def _as_before(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out y of a 2D scene: releases before 3D do not know it."""
        return {name: value for name, value in handler(self).items() if name != "y" or value is not None}

    def wrong_y(self, case: Any) -> Iterator[str]:
        """Yield one line if y is not within the breadth of the scene."""
        if self.y is None:
            return
        low, high = case.breadth or (-np.inf, np.inf)
        if case.dim == 2:
            yield f"y = {self.y:g}: only a 3D scene has places across; leave it out"
        elif not low <= self.y <= high:
            yield f"y = {self.y:g} must lie within the breadth, from y = {low:g} to {high:g}; move it"


class Gauge(AcrossProbe):
    """A probe of a height above x = `at` [m], in 3D above `at` = (x, y), which becomes `at` = x and `y`.

    of_surface : whether it is that of the free surface, as in theories
    """

    columns = {"y": "m"}
    family = "height $y$"
    of_surface: ClassVar[bool] = False

    at: float = Field(description="position x [m], in 3D (x, y)")
    y: Optional[float] = Field(
        default=None, kw_only=True, description="position y [m] across a 3D scene, from at=(x, y)")

    @model_validator(mode="before")
    @classmethod
    def _place_across(cls, data: Any) -> Any:
        at = data.get("at") if isinstance(data, dict) else None
        if not isinstance(at, (list, tuple)) or len(at) != 2:
            return data
        if data.get("y") is not None:
            raise ValueError(f"at = {shown(at)} and y = {shown(data['y'])}: give y once")
        return {**data, "at": at[0], "y": at[1]}

    @property
    def place(self) -> tuple[float, ...]:
        """Its place (x,), in 3D (x, y) [m]."""
        return (self.at,) if self.y is None else (self.at, self.y)

    @property
    def where(self) -> str:
        """Its place as text."""
        return ", ".join(f"{axis} = {value:g}" for axis, value in zip("xy", self.place)) + " m"

    def columns_in(self, scene: Any) -> dict[str, str]:
        return {up(scene.dim): "m"}

    def problems(self, case: Any) -> Iterator[str]:
        """See Probe: it must stand between the walls."""
        if (self.y is None) != (case.dim == 2):
            yield (f"at = {self.at:g}: a gauge of a 3D scene stands at (x, y); give both" if self.y is None else
                   f"at = ({self.at:g}, {self.y:g}): a gauge of a 2D scene stands at x; leave out y = {self.y:g}")
        elif case.wall_bounds is not None:
            low, high = case.wall_bounds
            for axis, value in enumerate(self.place):
                if not low[axis] <= value <= high[axis]:
                    yield (f"at = {shown(self.place) if self.y is not None else format(self.at, 'g')} must lie within "
                           f"the walls, from {'xy'[axis]} = {low[axis]:g} to {high[axis]:g}")

    def misplaced(self, places: Any) -> Iterator[str]:
        """See Probe: there must be room for fluid."""
        if not places.has_room(*self.place):
            at = f"({self.at:g}, {self.y:g})" if self.y is not None else f"{self.at:g}"
            yield f"at = {at}: there is no room for fluid above or below it; move it"

    def touched(self, values: Floats, case: Any, scene: Any) -> Iterator[tuple[str, Flags]]:
        """See Probe: gauges run dry, and the surface may be above the walls."""
        yield from super().touched(values, case, scene)
        bed, first, s = scene.bed_at(np.array([self.place])), values[0], case.numerics.spacing
        moving = scene.now is not None and scene.now.moving
        if bed is not None and not moving and first[0] > bed[0] + s:
            yield "emptied", first <= bed[0] + DRY * s
        if case.tank is not None and not case.lidded:
            yield "out of range, above the walls,", first > float(case.tank.bounds[1][-1])


_LOADED: dict[str, type[Probe]] = {}


@cache
def ours() -> dict[str, str]:
    """Return {kind: module} of the kinds of parisph."""
    folder = Path(__file__).parent.parent.joinpath(*OURS.split(".")[1:])
    return {path.stem.removesuffix("_probe"): f"{OURS}.{path.stem}" for path in sorted(folder.glob("[a-z]*.py"))}


def class_of(kind: Any) -> Optional[type[Probe]]:
    """Return the class of a kind, or None. A kind of parisph is imported when needed."""
    if kind not in _LOADED and kind in ours():
        import_module(ours()[kind])
    return _LOADED.get(kind)


def _register(kind: str, cls: type[Probe]) -> None:
    """Register the class of a kind. If a case file is read again, its class replaces the earlier one.

    Raises ValueError if a class from outside has a kind of the package.
    """
    if not cls.__module__.startswith("parisph."):
        if kind in ours() or kind == "probe_array":
            raise ValueError(f"there is another probe {kind!r}: give yours a kind of its own")
        vocabulary.add("probe", kind)
    _LOADED[kind] = cls
    _validator.cache_clear()


@cache
def _validator(kind: str) -> SchemaValidator:
    """Return a validator of a kind that puts the kind into the place of an error, as pydantic's unions do."""
    cls: Any = _LOADED[kind]
    cls.model_rebuild()
    return SchemaValidator(core_schema.tagged_union_schema({kind: cls.__pydantic_core_schema__}, "kind"))


def _of_its_kind(value: Any, info: ValidationInfo) -> Probe:
    """Return a probe, or make one from a dictionary by its kind. In a run opened only for reading it may be Unknown."""
    if isinstance(value, Probe) and getattr(value, "kind", None):
        return value
    kind = value.get("kind") if isinstance(value, dict) else None
    cls = class_of(kind) if isinstance(kind, str) else None
    if cls is not None:
        found: Probe = _validator(str(kind)).validate_python(value, context=info.context)
        return found
    if info.context and isinstance(kind, str):
        return Unknown.model_validate(value, context=info.context)
    known = f"{', '.join(map(repr, dict.fromkeys((*ours(), *_LOADED))))}, or of a file that is named by --parts"
    raise PydanticKnownError("union_tag_invalid", {"discriminator": "'kind'", "tag": str(kind), "expected_tags": known})


AnyProbe = Annotated[SerializeAsAny[Probe], PlainValidator(_of_its_kind), Field(description="a probe")]


class ProbeArray(Probe):
    """Several probes in one file, with a column NAME for each probe, or NAME_COLUMN if it has several columns.

    truth : Profiles of the surface, if all probes are SurfaceGauges

    >>> gauges = ProbeArray("gauges", [SurfaceGauge(f"x{x}", at=x) for x in (1, 2, 3)])
    >>> [probe.name for probe in gauges.probes]
    ['x1', 'x2', 'x3']
    """

    kind: Literal["probe_array"] = Field(default="probe_array", init=False)
    probes: Several[AnyProbe] = Field(min_length=1, max_length=1000, description="probes")
    truth: Optional[Profiles] = Field(default=None, kw_only=True)    # type: ignore[assignment]    # no series
    peak: Literal[False] = Field(default=False, kw_only=True)
    arrival: None = Field(default=None, kw_only=True)

    @model_validator(mode="after")
    def _plain(self) -> "ProbeArray":
        names = [probe.name for probe in self.probes]
        for probe in self.probes:
            if isinstance(probe, ProbeArray):
                raise ValueError(f"{probe.name!r} is an array itself; give its probes one by one")
            if names.count(probe.name) > 1:
                raise ValueError(f"the name {probe.name!r} is given {names.count(probe.name)} times; "
                                 "give each probe a name of its own")
            if probe.truth is not None or probe.peak or probe.every != 1:
                raise ValueError(f"probe {probe.name!r}: a truth, peak=True or every=N is for a probe with a file of "
                                 "its own; take it out of the array, or give every=N to the array")
        if self.truth is not None and not all(isinstance(probe, Gauge) and probe.of_surface for probe in self.probes):
            raise ValueError("truth: Profiles are compared with an array of nothing but SurfaceGauges")
        return self


def singles(probes: Sequence[Probe]) -> list[tuple[str, Probe]]:
    """Return (name, probe) of all probes; in arrays, with names like "gauges.x1"."""
    found: list[tuple[str, Probe]] = []
    for probe in probes:
        inside: Sequence[Probe] = probe.probes if isinstance(probe, ProbeArray) else ()
        found += [(f"{probe.name}.{one.name}", one) for one in inside] if inside else [(probe.name, probe)]
    return found


def surface_gauges(probes: Sequence[Probe]) -> dict[str, Gauge]:
    """Return {name: gauge} of all gauges of the free surface, named as in `singles`."""
    return {name: probe for name, probe in singles(probes) if isinstance(probe, Gauge) and probe.of_surface}
