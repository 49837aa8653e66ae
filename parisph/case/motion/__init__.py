"""How tanks and walls move: oscillations, measured motions and wavemakers, as records that are part of a case.

rigid.py says what a motion gives. The flow is computed in the frame of the tank; the driver adds what follows from its
motion to gravity.
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
