"""Descriptions of probes; parisph.watch.instruments computes their values."""

import re
from collections.abc import Sequence
from typing import Annotated, Literal, Optional, Union

import numpy as np
from pydantic import Field, field_validator, model_validator

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.model import Model, Several
from parisph.case.profiles import Profiles
from parisph.case.truths import Peaks, Truth, WaveTruth

Peak = Annotated[bool, Field(description="whether the flow at the greatest value is kept, in the window of its truth")]
Arrival = Annotated[
    Optional[float], Field(description="value whose first passing is told in the summary, in the probe's unit")]
Acted = Annotated[bool, Field(description="whether the pressure that acts in the step is given beside its mean")]
Every = Annotated[int, Field(ge=1, description="how many of the run's samples there are for one of this probe")]
Point = Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="point (x, y) [m]")]


class Probe(Model):
    """A named probe, written to probes/NAME.csv.

    With peak=True the run writes the flow at the greatest value of the probe (of its first column, in the bands or the
    window of its truth if it has one) to peaks/NAME.vtkhdf. Every step counts for this, even if samples are written
    less often.

    With arrival=VALUE the summary tells when the probe first passes this value, upwards or downwards, by linear
    interpolation between its samples: when a front comes by, or a gauge notices a wave.

    With every=N only one in N of the run's samples is taken (Output.probe_every, probe_interval), from the first on:
    for what changes slowly and costs much, such as a Volume. With Output.probe_interval it saves lines, not time.
    """

    name: str = Field(description="name of the probe and of its file")

    @field_validator("name")
    @classmethod
    def _file_name(cls, name: str) -> str:
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}", name):
            raise ValueError(
                f"{shown(name)} cannot name a file: use up to 64 letters, digits, '_', '-' or '.', "
                "and start with a letter or digit"
            )
        return name


class SurfaceGauge(Probe):
    """Height y of the free surface [m] above x = `at` [m].

    Examples
    --------
    >>> SurfaceGauge("gauge", at=0.25).name
    'gauge'
    """

    kind: Literal["surface_gauge"] = Field(default="surface_gauge", init=False)
    at: float = Field(description="position x of the gauge [m]")
    truth: Union[Truth, WaveTruth, Peaks, None] = None
    peak: Peak = False
    arrival: Arrival = None
    every: Every = 1


class PressureTap(Probe):
    """Pressure [Pa] on a wall at the point `at` [m]; on a wall that moves, a point of it at rest, which moves with it.

    It is the value there of a linear pressure fitted to the wall within `radius`, as of a sensor with a face. One wall
    particle alone is wetted from one step to the next, and tells of an impact too late and too abruptly.

    diameter : [m] of a round sensor, over whose disc the pressure is averaged instead: in 2D over a stretch, with
        the chord of the disc at each place as its weight
    side : of a Plate, as seen along its points
    acted : whether the pressure that acts in the step comes beside the mean in time, in the column pressure_acted

    On a body that moves, `at` is where the tap is at t = 0; it moves with the body.

    A sample has the time for which its pressure is solved, the middle of a step; with method="SPH", the end. It is a
    mean in time, as of a Force.

    Examples
    --------
    >>> PressureTap("P2", at=(2.0, 0.05), radius=0.0375, peak=True).peak
    True
    >>> PressureTap("P1", at=(3.22, 0.16), diameter=0.09).diameter
    0.09
    """

    kind: Literal["pressure_tap"] = Field(default="pressure_tap", init=False)
    at: Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="point (x, y) on a wall [m]")]
    truth: Union[Truth, Peaks, None] = None
    peak: Peak = False
    radius: Union[float, None] = Field(
        default=None, gt=0, description="radius of the face of the tap [m], at least one spacing; default 3 spacings")
    diameter: Optional[float] = Field(default=None, gt=0, description="diameter of the disc of the sensor [m]")
    side: Literal["left", "right"] | None = Field(default=None, description="side of a plate, as seen along its points")
    acted: Acted = False
    arrival: Arrival = None
    every: Every = 1

    @model_validator(mode="after")
    def _one_face(self) -> "PressureTap":
        if self.radius is not None and self.diameter is not None:
            raise ValueError(f"radius = {self.radius:g} and diameter = {self.diameter:g}: give only one of them, a fit "
                             "over a stretch of wall or the mean over a disc")
        return self


class WaterFront(Probe):
    """Position x [m] of the water's foremost particle along the bed.

    Examples
    --------
    >>> WaterFront("front").kind
    'water_front'
    """

    kind: Literal["water_front"] = Field(default="water_front", init=False)
    truth: Union[Truth, Peaks, None] = None
    peak: Peak = False
    arrival: Arrival = None
    every: Every = 1


class ColumnHeight(Probe):
    """Height y [m] of the topmost water connected to the bed at x = `at` [m].

    Examples
    --------
    >>> ColumnHeight("column", at=0.0).at
    0.0
    """

    kind: Literal["column_height"] = Field(default="column_height", init=False)
    at: float = Field(description="position x of the column [m]")
    truth: Union[Truth, Peaks, None] = None
    peak: Peak = False
    arrival: Arrival = None
    every: Every = 1


class Energy(Probe):
    """Kinetic and potential energy of the fluid [J/m].

    current : whether also by the volumes that particles represent now, not only by those at the start

    Examples
    --------
    >>> Energy("energy", current=True).current
    True
    """

    kind: Literal["energy"] = Field(default="energy", init=False)
    truth: Union[Truth, None] = None
    peak: Peak = False
    current: bool = Field(default=False, description="whether also by the volumes that particles represent now")
    every: Every = 1


class Volume(Probe):
    """Relative volume of the fluid: mean Voronoi cell inside the fluid over the square of the spacing [-].

    It is 1 on a lattice of the spacing. Scenes with a fluid of another shape may start with other cells.

    Examples
    --------
    >>> Volume("volume", every=10).every
    10
    """

    kind: Literal["volume"] = Field(default="volume", init=False)
    truth: Union[Truth, None] = None
    peak: Peak = False
    every: Every = 1


class Momentum(Probe):
    """Momentum of the fluid [kg/s per metre of width].

    Examples
    --------
    >>> Momentum("momentum").name
    'momentum'
    """

    kind: Literal["momentum"] = Field(default="momentum", init=False)
    truth: Union[Truth, None] = None
    peak: Peak = False
    every: Every = 1


class VelocityProfile(Probe):
    """Velocity [m/s] and pressure [Pa] at `points` points, evenly from `start` to `end` [m].

    The columns of point k are u_k, v_k and p_k; the first point is 0. Points outside the fluid have nan.

    Examples
    --------
    >>> VelocityProfile("middle", start=(0.5, 0.0), end=(0.5, 1.0), points=3).places.tolist()
    [[0.5, 0.0], [0.5, 0.5], [0.5, 1.0]]
    """

    kind: Literal["velocity_profile"] = Field(default="velocity_profile", init=False)
    start: Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="first point (x, y) [m]")]
    end: Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="last point (x, y) [m]")]
    points: int = Field(default=21, ge=2, le=1000, description="number of points")
    truth: Union[Truth, None] = None
    peak: Peak = False
    every: Every = 1

    @property
    def places(self) -> Floats:
        """The points (points, dim) [m]."""
        return np.linspace(self.start, self.end, self.points)


class VelocityPoint(Probe):
    """Velocity u, v [m/s] and pressure p [Pa] at the point `at` [m]; nan outside the fluid.

    Examples
    --------
    >>> VelocityPoint("below", at=(2.0, 0.1)).at
    (2.0, 0.1)
    """

    kind: Literal["velocity_point"] = Field(default="velocity_point", init=False)
    at: Point
    truth: Union[Truth, None] = None
    peak: Peak = False
    every: Every = 1


class RunUp(Probe):
    """Height y [m] of the highest point at which water touches a wall, and its x [m].

    The water counts that is connected, along the wall, with the lower end of the wall. At a vertical side of a tank it
    is the surface's height as of a SurfaceGauge; along a line, the surface is continued straight to the line. The line
    moves with its body.

    on : name of the body
    side : of a Tank, an Obstacle or a Plate; or the end of a Profile, to which the line goes from its lowest point. A
        Piston and a Flap need none
    points : the line itself [m], from below the water upwards, in place of a side, as it is at t = 0
    film : along a line: thinnest film that counts [m]. In one of thickness h, particles of spacing s are s^2/h apart.
        None to let water end where they are 2.1 spacings apart, in a film of half a spacing, and to leave out spray

    Examples
    --------
    >>> RunUp("wall", side="right").on
    'tank'
    >>> RunUp("beach", points=[(4.0, 0.0), (6.0, 0.5)]).points[1]
    (6.0, 0.5)
    """

    kind: Literal["run_up"] = Field(default="run_up", init=False)
    on: str = Field(default="tank", description="name of the body")
    side: Literal["left", "right"] | None = Field(default=None, description="side of the body, or end of the profile")
    points: Several[Point] | None = Field(default=None, min_length=2, max_length=10_000,
                                         description="line along the wall, from below the water upwards [m]")
    film: Optional[float] = Field(default=None, gt=0.0, description="thinnest film that counts [m]")
    truth: Union[Truth, Peaks, None] = None
    peak: Peak = False
    arrival: Arrival = None
    every: Every = 1

    @model_validator(mode="after")
    def _one_line(self) -> "RunUp":
        neither = self.side is None and self.points is None and self.on == "tank"
        if neither or (self.side is not None and self.points is not None):
            raise ValueError("give either a side of the tank, side='left' or 'right', or the points of a line")
        return self


class Force(Probe):
    """Force [N/m] of the fluid's pressure on a body, and its moment [N m/m] against the clock.

    It is the whole pressure, with its hydrostatic part: water at rest presses, too. With `still`, the columns
    fx_dynamic, fy_dynamic and moment_dynamic come beside it: the same less the force of water at rest up to the height
    `still`, rho g (still - y) below it and 0 above, on the wall where it is at that time. They are 0 for water at rest.

    Friction on the body is not included. A sample has the time for which its pressure is solved, the middle of a step;
    with method="SPH", the end.

    It is a mean over the steps around, with weights that fall linearly to 0 at the means before and after. These are a
    step away, or with Numerics(pressure_mean=) at least that many times 2 min(0.3 s/u, 0.025 sqrt(s/a)), with the
    largest speed u and the largest one of the body force, the mean acceleration by pressure and the acceleration of
    walls as a: particles do not resolve what is shorter. The trapezoidal rule over the samples of all steps gives the
    impulse of the pressure that acts, up to the ends of the run. With method="SPH" a sample is the pressure of one
    step.

    on : name of the body
    side : of a tank; None for all of it
    about : point of the moment [m]
    still : height y of the still level [m], for the dynamic part
    acted : whether the force that acts in the step comes beside this mean, in the columns fx_acted, fy_acted and
        moment_acted

    Examples
    --------
    >>> Force("load", side="right", about=(1.0, 0.0)).side
    'right'
    """

    kind: Literal["force"] = Field(default="force", init=False)
    on: str = Field(default="tank", description="name of the body")
    side: Optional[Literal["left", "right", "bed", "lid"]] = Field(default=None, description="side of the tank")
    about: Point = (0.0, 0.0)
    still: Optional[float] = Field(default=None, description="height of the still level, for the dynamic part [m]")
    acted: Acted = False
    truth: Union[Truth, Peaks, None] = None
    peak: Peak = False
    every: Every = 1


class Flux(Probe):
    """Water that passes the straight line from `start` to `end` [m]: its rate [m2/s] and the total so far [m2].

    Both are positive for water that passes from the left of the line to its right, as seen from `start` to `end`:
    towards +x, if the line goes upwards. They are per metre of width. The line stands still in the frame of the scene.

    total : the sum of the volumes of all particles that have passed, less those that have come back. It is exact: water
        behind a line that closes a basin has gained as much
    rate : by the velocities of particles within a spacing of the line at that time. Its integral is the total up to
        what particles are moved to keep their distances even

    pause : time without water passing that ends an event [s]. With it, the summary tells each event with its start, its
        end and its volume, as of crests that come over a wall; their sum is the total. None for no events

    Examples
    --------
    >>> Flux("over", start=(4.0, 0.5), end=(4.0, 1.0), pause=0.3).pause
    0.3
    """

    kind: Literal["flux"] = Field(default="flux", init=False)
    start: Annotated[tuple[float, ...], Field(min_length=2, max_length=2, description="first point (x, y) [m]")]
    end: Annotated[tuple[float, ...], Field(min_length=2, max_length=2, description="last point (x, y) [m]")]
    pause: Optional[float] = Field(default=None, gt=0, description="time without water passing that ends an event [s]")
    truth: Union[Truth, Peaks, None] = None
    peak: Peak = False
    every: Every = 1


Single = Annotated[
    Union[SurfaceGauge, PressureTap, WaterFront, ColumnHeight, Energy, Volume, Momentum, VelocityProfile, VelocityPoint,
          RunUp, Force, Flux],
    Field(discriminator="kind", description="a probe"),
]


class ProbeArray(Probe):
    """Several probes with one file: its columns are the names of the probes, NAME_COLUMN for one with more columns.

    truth : Profiles of the surface, for an array of nothing but SurfaceGauges

    Examples
    --------
    >>> gauges = ProbeArray("gauges", [SurfaceGauge(f"x{x}", at=x) for x in (1, 2, 3)])
    >>> [probe.name for probe in gauges.probes]
    ['x1', 'x2', 'x3']
    """

    kind: Literal["probe_array"] = Field(default="probe_array", init=False)
    probes: Several[Single] = Field(min_length=1, max_length=1000, description="probes")
    truth: Optional[Profiles] = None
    peak: Literal[False] = False
    every: Every = 1

    @model_validator(mode="after")
    def _plain(self) -> "ProbeArray":
        names = [probe.name for probe in self.probes]
        for probe in self.probes:
            if names.count(probe.name) > 1:
                raise ValueError(f"the name {probe.name!r} is given {names.count(probe.name)} times; "
                                 "give each probe a name of its own")
            if probe.truth is not None or probe.peak or probe.every != 1:
                raise ValueError(f"probe {probe.name!r}: a truth, peak=True or every=N is for a probe with a file of "
                                 "its own; take it out of the array, or give every=N to the array")
        if self.truth is not None and not all(isinstance(probe, SurfaceGauge) for probe in self.probes):
            raise ValueError("truth: Profiles are compared with an array of nothing but SurfaceGauges")
        return self


AnyProbe = Annotated[
    Union[SurfaceGauge, PressureTap, WaterFront, ColumnHeight, Energy, Volume, Momentum, VelocityProfile, VelocityPoint,
          RunUp, Force, Flux, ProbeArray],
    Field(discriminator="kind", description="a probe"),
]


def singles(probes: Sequence[Probe]) -> list[tuple[str, Probe]]:
    """Return (name, probe) of all probes, those in arrays too: their names are as in "gauges.x1"."""
    found: list[tuple[str, Probe]] = []
    for probe in probes:
        inside: Sequence[Probe] = probe.probes if isinstance(probe, ProbeArray) else ()
        found += [(f"{probe.name}.{one.name}", one) for one in inside] if inside else [(probe.name, probe)]
    return found
