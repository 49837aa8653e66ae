"""Motions of tanks and walls as records of a case: oscillations, measured motions and wavemakers.

rigid.py defines the interface. The flow is computed in the frame of the tank, whose inertia is added to gravity.
"""

from typing import Annotated, Union

from pydantic import Field

from parisph.case.motion.measured import Series
from parisph.case.motion.oscillations import AtRest, Heave, Moved, Roll, Sway, Tabulated
from parisph.case.motion.rigid import SHARE, Motion, Rotation, Translation, course
from parisph.case.motion.wavemaker import FlapStroke, PistonStroke

__all__ = [
    "SHARE",
    "AnyMotion",
    "AtRest",
    "FlapStroke",
    "Frame",
    "Heave",
    "Motion",
    "Moved",
    "PistonStroke",
    "Roll",
    "Rotation",
    "Series",
    "Sway",
    "Tabulated",
    "Translation",
    "course",
]

Frame = Annotated[
    Union[AtRest, Sway, Heave, Roll, Moved, Tabulated],
    Field(discriminator="kind", description="AtRest, Sway, Heave, Roll, Moved or Tabulated"),
]
AnyMotion = Annotated[
    Union[AtRest, Sway, Heave, Roll, Moved, Tabulated, PistonStroke, FlapStroke],
    Field(discriminator="kind", description="a motion"),
]
