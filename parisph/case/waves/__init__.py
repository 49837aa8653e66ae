"""Wave theories, as records of a case and as pure functions of numbers and arrays. SI units.

Every record gives `elevation(x, t)` and `velocity(x, y, t)`, and `surface` and `flow` at places of a scene, see
wavefield.py.
"""

from typing import Annotated, Union

from pydantic import Field

from parisph.case.waves.airy import Airy, StandingWave
from parisph.case.waves.exact_flows import column_start_pressure, drop_half_axes, ellipsoid_half_axes
from parisph.case.waves.jonswap import Jonswap
from parisph.case.waves.linear import (
    angular_frequency,
    standing_wave_elevation,
    standing_wave_start,
    standing_wave_velocity,
    wave_number,
)
from parisph.case.waves.sloshing import Sloshing, sway_sloshing_elevation
from parisph.case.waves.solitary import SolitaryWave
from parisph.case.waves.stokes import Stokes
from parisph.case.waves.stream_function import StreamFunction
from parisph.case.waves.tank_mode import TankMode
from parisph.case.waves.wavefield import WaveField

__all__ = [
    "Airy",
    "AnyWave",
    "Jonswap",
    "Sloshing",
    "SolitaryWave",
    "StandingWave",
    "Stokes",
    "StreamFunction",
    "TankMode",
    "WaveField",
    "angular_frequency",
    "column_start_pressure",
    "drop_half_axes",
    "ellipsoid_half_axes",
    "standing_wave_elevation",
    "standing_wave_start",
    "standing_wave_velocity",
    "sway_sloshing_elevation",
    "wave_number",
]

AnyWave = Annotated[
    Union[Airy, Stokes, StreamFunction, SolitaryWave, StandingWave, TankMode, Sloshing, Jonswap],
    Field(discriminator="kind", description="a wave"),
]
