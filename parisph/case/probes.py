"""Descriptions of probes; parisph.watch.instruments computes their values."""

import re
from typing import Annotated, Literal, Union

import numpy as np
from pydantic import Field, field_validator

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.model import Model
from parisph.case.truths import Truth, WaveTruth

Peak = Annotated[bool, Field(description="whether the flow at the greatest value is kept")]


class Probe(Model):
    """A named probe, written to probes/NAME.csv.

    With peak=True the run writes the flow at the greatest value of the probe (of its first column) to
    peaks/NAME.vtkhdf. Every step counts for this, even if samples are written less often.
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

    kind: Literal["surface_gauge"] = "surface_gauge"
    at: float = Field(description="position x of the gauge [m]")
    truth: Union[Truth, WaveTruth, None] = None
    peak: Peak = False


class PressureTap(Probe):
    """Pressure [Pa] on a wall at the point `at` [m].

    It is the value there of a linear pressure fitted to the wall within `radius`, as of a sensor with a face. One wall
    particle alone is wetted from one step to the next, and tells of an impact too late and too abruptly.

    Examples
    --------
    >>> PressureTap("P2", at=(2.0, 0.05), radius=0.0375, peak=True).peak
    True
    """

    kind: Literal["pressure_tap"] = "pressure_tap"
    at: Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="point (x, y) on a wall [m]")]
    truth: Union[Truth, None] = None
    peak: Peak = False
    radius: Union[float, None] = Field(
        None, gt=0, description="radius of the face of the tap [m]; one spacing if it is less; default 3 spacings")


class WaterFront(Probe):
    """Position x [m] of the water's foremost particle along the bed.

    Examples
    --------
    >>> WaterFront("front").kind
    'water_front'
    """

    kind: Literal["water_front"] = "water_front"
    truth: Union[Truth, None] = None
    peak: Peak = False


class ColumnHeight(Probe):
    """Height y [m] of the topmost water connected to the bed at x = `at` [m].

    Examples
    --------
    >>> ColumnHeight("column", at=0.0).at
    0.0
    """

    kind: Literal["column_height"] = "column_height"
    at: float = Field(description="position x of the column [m]")
    truth: Union[Truth, None] = None
    peak: Peak = False


class Energy(Probe):
    """Kinetic and potential energy of the fluid [J/m].

    current : whether also by the volumes that particles represent now, not only by those at the start

    Examples
    --------
    >>> Energy("energy", current=True).current
    True
    """

    kind: Literal["energy"] = "energy"
    truth: Union[Truth, None] = None
    peak: Peak = False
    current: bool = Field(False, description="whether also by the volumes that particles represent now")


class Volume(Probe):
    """Relative volume of the fluid: mean interior Voronoi cell over its start [-].

    Examples
    --------
    >>> Volume("volume").name
    'volume'
    """

    kind: Literal["volume"] = "volume"
    truth: Union[Truth, None] = None
    peak: Peak = False


class Momentum(Probe):
    """Momentum of the fluid [kg/s per metre of width].

    Examples
    --------
    >>> Momentum("momentum").name
    'momentum'
    """

    kind: Literal["momentum"] = "momentum"
    truth: Union[Truth, None] = None
    peak: Peak = False


class VelocityProfile(Probe):
    """Velocity [m/s] and pressure [Pa] at `points` points, evenly from `start` to `end` [m].

    The columns of point k are u_k, v_k and p_k; the first point is 0. Points outside the fluid have nan.

    Examples
    --------
    >>> VelocityProfile("middle", start=(0.5, 0.0), end=(0.5, 1.0), points=3).places.tolist()
    [[0.5, 0.0], [0.5, 0.5], [0.5, 1.0]]
    """

    kind: Literal["velocity_profile"] = "velocity_profile"
    start: Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="first point (x, y) [m]")]
    end: Annotated[tuple[float, ...], Field(min_length=2, max_length=3, description="last point (x, y) [m]")]
    points: int = Field(21, ge=2, le=1000, description="number of points")
    truth: Union[Truth, None] = None
    peak: Peak = False

    @property
    def places(self) -> Floats:
        """The points (points, dim) [m]."""
        return np.linspace(self.start, self.end, self.points)


AnyProbe = Annotated[
    Union[SurfaceGauge, PressureTap, WaterFront, ColumnHeight, Energy, Volume, Momentum, VelocityProfile],
    Field(discriminator="kind", description="a probe"),
]
