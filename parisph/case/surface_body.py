"""A body whose surface is in a file of triangles: a solid of any form, or the bathymetry."""

import hashlib
import os
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from parisph.base import paths, reading
from parisph.base.errors import CaseError
from parisph.base.text import shown
from parisph.case.model import Model
from parisph.case.motion import AtRest
from parisph.case.shapes import Name, Slip

KINDS = ("stl", "obj", "ply", "off")    # endings of files that are read
MOST = 10**9                            # bytes of a file
Vector = Annotated[tuple[float, float, float], Field(description="a point (x, y, z) [m]")]


class Surface(Model):
    """A resting body in a 3D scene whose surface is in a file of triangles: STL, OBJ, PLY or OFF.

    A closed surface is a solid with fluid around it; with side="inside" the fluid is inside it. An open surface, such
    as a bathymetry, is a bed with fluid above it: it must reach beyond the walls of the scene on all sides, and must
    not overhang. A point x of the file becomes scale * x + at [m]; z is up. Other solids may overlap it.

    The file is read when the case is checked and when the run starts, by libraries of the extra parisph[surfaces]. The
    run keeps what was made of it, so a restart needs neither.

    file : path, relative to the case file
    digest : of the content of the file, found when the case is made

    >>> Surface("bed.stl", scale=0.001, name="bed").slip
    'free'
    """

    kind: Literal["surface"] = Field(default="surface", init=False)
    file: str
    scale: float = Field(default=1.0, gt=0, description="metres for one unit of the file, 0.001 for millimetres")
    at: Vector = (0.0, 0.0, 0.0)
    name: Name = ""
    slip: Slip = "free"
    side: Literal["outside", "inside"] | None = Field(
        default=None, description="side of a closed surface on which fluid is, None for outside")
    digest: str = Field(default="", max_length=64, description="of the content of the file")

    @model_validator(mode="before")
    @classmethod
    def _with_digest(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("file"), (str, os.PathLike)) or data.get("digest"):
            return data
        path = _found(os.fspath(data["file"]))
        return {**data, "file": str(path), "digest": digest_of(path)}

    @property
    def motion(self) -> AtRest:
        """Surfaces rest."""
        return AtRest()


def digest_of(path: Path) -> str:
    """Return the digest of the content of a file. Raises ValueError if it cannot be read."""
    try:
        reading.check_regular(os.stat(path), MOST)
        with open(path, "rb") as file:
            return hashlib.blake2b(file.read(), digest_size=16).hexdigest()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise ValueError(f"file = {shown(str(path))}: cannot be read ({why})") from None


def _found(file: str) -> Path:
    """Return the absolute path of a file that a case names. Raises ValueError."""
    try:
        path = (paths.FOLDER.get() / paths.checked(file, "file")).resolve()
    except (CaseError, OSError, RuntimeError) as error:
        raise ValueError(str(error)) from None
    if path.suffix.lower().removeprefix(".") not in KINDS:
        raise ValueError(f"file = {shown(file)}: must be a file of triangles that ends in "
                         f"{', '.join('.' + kind for kind in KINDS)}; convert it, for instance with MeshLab or Blender")
    return path
