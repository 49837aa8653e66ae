"""The walls of a scene with Surfaces as they were meshed, in walls.h5 of its run.

With it, neither the files of the Surfaces nor the libraries that read them are needed to continue or to show a run, on
any machine. Layout: /nodes (N, 3) [m], /triangles (M, 3), /body (M,); attributes of the root: format, version, volume
[m3], run; after the HDF5 part a digest (parisph.io.digest).
"""

from pathlib import Path

import h5py
import numpy as np

from parisph.base.communicator import Communicator
from parisph.base.errors import StoreError
from parisph.case.scene import Scene
from parisph.geometry.room import Room
from parisph.geometry.scene_room import know, scene_room
from parisph.io import digest, slabs
from parisph.io.files import on_first
from parisph.io.layout import WALLS
from parisph.io.slabs import Slab

FORMAT, VERSION = "parisph walls", 1


def keep(comm: Communicator, folder: Path, case: Scene, run: str) -> None:
    """Write the walls of a scene with Surfaces into the folder of its run, unless they are there. Collective.

    run : its identity. Raises StoreError on every rank.
    """
    path = folder / WALLS
    if not case.surfaces or comm.bcast(on_first(comm, f"write {path}", path.exists)):
        return
    room, first = scene_room(case), comm.rank == 0
    parts = {"nodes": room.nodes, "triangles": room.triangles, "body": room.body}
    rows = [Slab(name, np.ascontiguousarray(data if first else data[:0]), 0 if first else len(data), len(data))
            for name, data in parts.items()]

    def decorate(file: h5py.File) -> None:
        file.attrs.update({"format": FORMAT, "version": VERSION, "volume": room.volume, "run": run})
    slabs.write(comm, path, rows, decorate)


def remember(folder: Path, case: Scene) -> None:
    """Let the geometry take the walls of a scene with Surfaces from the folder of its run, if they are there.

    Not collective. Raises StoreError if the file is damaged.
    """
    path = folder / WALLS
    if not case.surfaces or not path.exists():
        return
    digest.check(path)
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") != FORMAT or int(file.attrs["version"]) > VERSION:
                raise StoreError(f"{path} was not written by parisph, or by a newer one")
            know(case, Room(file["nodes"][:], file["triangles"][:], file["body"][:], float(file.attrs["volume"])))
    except (OSError, KeyError, ValueError) as error:
        raise StoreError(f"{path} does not hold whole walls: {error}") from None


def share(comm: Communicator, case: Scene) -> None:
    """Let all ranks have the room of a scene with Surfaces that rank 0 makes. Collective; raises on every rank."""
    if not case.surfaces or comm.size == 1:
        return
    room = comm.bcast(on_first(comm, "mesh the walls", lambda: scene_room(case)))
    if comm.rank > 0:
        know(case, room)
