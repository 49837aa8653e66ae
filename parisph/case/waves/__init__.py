"""Wave theories, as records of a case and as pure functions of numbers and arrays. SI units.

Every record gives `elevation(x, t)` and `velocity(x, y, t)`, see wavefield.py.
"""

from typing import Annotated, Union

from pydantic import Field

from parisph.case.waves.airy import Airy, StandingWave
from parisph.case.waves.exact_flows import column_start_pressure, drop_half_axes
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
from parisph.case.waves.wavefield import WaveField, wave_velocity

__all__ = [
    "Airy",
    "AnyWave",
    "Jonswap",
    "Sloshing",
    "SolitaryWave",
    "StandingWave",
    "Stokes",
    "StreamFunction",
    "WaveField",
    "angular_frequency",
    "column_start_pressure",
    "drop_half_axes",
    "standing_wave_elevation",
    "standing_wave_start",
    "standing_wave_velocity",
    "sway_sloshing_elevation",
    "wave_number",
    "wave_velocity",
]

AnyWave = Annotated[
    Union[Airy, Stokes, StreamFunction, SolitaryWave, StandingWave, Sloshing, Jonswap],
    Field(discriminator="kind", description="a wave"),
]
