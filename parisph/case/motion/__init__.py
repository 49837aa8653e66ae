"""Motions of tanks and walls as records of a case: oscillations, measured motions and wavemakers.

rigid.py defines the interface, spatial.py that of motions that do not stay in the section of a 3D scene. The flow is
computed in the frame of the tank, whose inertia is added to gravity.
"""

from typing import Annotated, Union

from pydantic import Field

from parisph.case.motion.measured import Series
from parisph.case.motion.oscillations import Angular, AtRest, Heave, Moved, Roll, Sway, Tabulated
from parisph.case.motion.rigid import SHARE, Motion, Rotation, Translation, course
from parisph.case.motion.spatial import Spatial, leaves_section
from parisph.case.motion.turning import Combined, Pitch, Turn, Yaw
from parisph.case.motion.wavemaker import FlapStroke, PistonStroke

__all__ = [
    "SHARE",
    "Angular",
    "AnyMotion",
    "AtRest",
    "Combined",
    "FlapStroke",
    "Frame",
    "Heave",
    "Motion",
    "Moved",
    "PistonStroke",
    "Pitch",
    "Roll",
    "Rotation",
    "Series",
    "Spatial",
    "Sway",
    "Tabulated",
    "Translation",
    "Turn",
    "Yaw",
    "course",
    "leaves_section",
]

Frame = Annotated[
    Union[AtRest, Sway, Heave, Roll, Pitch, Yaw, Turn, Moved, Tabulated, Combined],
    Field(discriminator="kind",
          description="AtRest, Sway, Heave, Roll, Moved or Tabulated, in 3D also Pitch, Yaw, Turn or Combined"),
]
AnyMotion = Annotated[
    Union[AtRest, Sway, Heave, Roll, Pitch, Yaw, Turn, Moved, Tabulated, Combined, PistonStroke, FlapStroke],
    Field(discriminator="kind", description="a motion"),
]
