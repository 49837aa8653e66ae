"""The triangles of the Surfaces of a scene: read from files, joined at equal points, and turned to the fluid (3D).

What cannot be mended is a fault, with the number of places and the first of them.
"""

import io
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base import libraries
from parisph.base.arrays import Array, Flags, Floats, Ints
from parisph.base.errors import CaseError
from parisph.base.text import named, of_error, point
from parisph.case.surface_body import Surface, digest_of
from parisph.geometry.distance import area_vectors
from parisph.geometry.triangle_mesh import Edges, edges_of

SAME = 1e-6      # of the size of a surface: nearer points are one, as a file in single precision has them
FLAT = 1e-12     # of the square of the size: smaller triangles are dropped
SHOWN = 3        # places in a message


@dataclass(frozen=True)
class Triangles:
    """A surface as triangles.

    points : (N, 3) [m]; corners : (M, 3) int, anticlockwise from outside, or from above if it is open
    closed : whether it has no rim; notes : what was mended, one line each
    """

    points: Floats
    corners: Array
    closed: bool
    notes: tuple[str, ...] = ()

    @property
    def places(self) -> Floats:
        """The corners (M, 3, 3) [m] of the triangles."""
        found: Floats = self.points[self.corners]
        return found

    @property
    def volume(self) -> float:
        """Volume [m3] inside, of a closed surface."""
        return signed_volume(self.places)


@lru_cache(maxsize=16)
def read(surface: Surface) -> Triangles:
    """Return the Triangles of a Surface [m]. Cached: callers must not change the arrays. Not collective.

    Raises CaseError if the file cannot be read, has changed, or has holes or other faults; MissingLibrary.
    """
    where = f"walls, {surface.name or 'surface'}: {named(Path(surface.file).name)}"
    places = _raw(surface, where) * surface.scale + np.array(surface.at)
    if not np.all(np.isfinite(places)) or not len(places):
        raise CaseError(f"{where}: has no triangles with finite numbers")
    return sound(places, where)


def crossing(surface: Surface) -> tuple[int, Floats]:
    """Return the number of triangles of a Surface that cross others of it, and the middle (3,) [m] of the first."""
    pymeshlab = libraries.loaded("pymeshlab")
    found, meshes = read(surface), pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=found.points, face_matrix=found.corners))
    meshes.compute_selection_by_self_intersections_per_face()
    which = np.flatnonzero(meshes.current_mesh().face_selection_array())
    return len(which), found.places[which[0]].mean(axis=0) if len(which) else np.zeros(3)


def _raw(surface: Surface, where: str) -> Floats:
    """Return the corners (M, 3, 3) of the triangles in a file."""
    libraries.require(*libraries.SURFACES)
    import trimesh

    path = Path(surface.file)
    try:
        if digest_of(path) != surface.digest:
            raise CaseError(f"{where}: has changed since the case was made; load the case again from its file")
        loaded: Any = trimesh.load(io.BytesIO(path.read_bytes()), file_type=path.suffix.lower()[1:], process=False,
                                   force="mesh")
        return np.array(loaded.triangles, dtype=float)
    except CaseError:
        raise
    except Exception as error:    # the library raises errors of many kinds
        raise CaseError(f"{where}: cannot be read as triangles ({of_error(error)})") from None


def sound(places: Floats, where: str) -> Triangles:
    """Return triangles (M, 3, 3) [m] as a surface whose points are joined and whose triangles all face the same side.

    where : name of the surface, for messages. Raises CaseError where it has holes, or more than two triangles meet.
    """
    points, corners = _joined(places)
    if not len(corners):
        raise CaseError(f"{where}: has no triangle with an area")
    corners, notes = _without_copies(points, corners, where)
    _check_edges(points, corners, where)
    edges = edges_of(corners)
    closed = not edges.rim.any()
    flip = _reversed(points[corners], corners, edges, where)
    if flip.any():
        many = "all" if flip.all() else f"{np.count_nonzero(flip):,} of {len(flip):,}"
        notes += (f"{where}: {many} triangles are reversed{_at(points[corners[flip]].mean(axis=1))}; they were turned "
                  "round",)
    turned = np.where(flip[:, None], corners[:, ::-1], corners)
    return Triangles(points, turned.astype(np.int32), closed, notes)


def signed_volume(places: Floats) -> float:
    """Return the volume [m3] inside closed triangles (M, 3, 3) [m], negative if they face inward."""
    a, b, c = np.moveaxis(places - places[:1, :1], 1, 0)
    return float(np.sum(a * np.cross(b, c))) / 6.0


def _joined(places: Floats) -> tuple[Floats, Ints]:
    """Return points (N, 3), of which no two are nearer than SAME, and the corners (M, 3) of triangles with an area.

    Points are compared on a grid, and again on one moved by half a step, so that no pair falls between two cells.
    """
    x = places.reshape(-1, 3)
    step = SAME * max(float(np.ptp(x, axis=0).max()), 1e-300)
    number = np.arange(len(x))
    for shift in (0.0, 0.5):
        cell = np.floor((x - x.min(axis=0)) / step + shift).astype(np.int64)
        _, first, own = np.unique(cell, axis=0, return_index=True, return_inverse=True)
        x, number = x[first], own.reshape(-1)[number]
    corners = number.reshape(-1, 3)
    a, b, c = corners.T
    size = np.linalg.norm(area_vectors(x[corners]), axis=1)
    kept = (a != b) & (b != c) & (c != a) & (size > FLAT * (step / SAME) ** 2)
    return x, corners[kept]


def _without_copies(points: Floats, corners: Ints, where: str) -> tuple[Ints, tuple[str, ...]]:
    """Return triangles without copies of others, and a note if there were any."""
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    if len(first) == len(corners):
        return corners, ()
    copies = np.setdiff1d(np.arange(len(corners)), first)
    note = f"{where}: {len(copies):,} triangles are there twice{_at(points[corners[copies]].mean(axis=1))}; one of " \
           "each pair was left out"
    return corners[np.sort(first)], (note,)


def _check_edges(points: Floats, corners: Ints, where: str) -> None:
    """Raise CaseError where more than two triangles meet at an edge, or where a surface has holes."""
    pair, own, many = np.unique(np.sort(_directed(corners), axis=1), axis=0, return_inverse=True, return_counts=True)
    if np.any(many > 2):
        raise CaseError(f"{where}: at {np.count_nonzero(many > 2):,} edges more than two triangles "
                        f"meet{_at(points[pair[many > 2]].mean(axis=1))}; give each solid a surface of its own, in a "
                        "file of its own, or join the solids in the program that made it")
    rim = pair[many == 1]
    label = components(len(points), rim)
    loops = [np.unique(rim[label[rim[:, 0]] == one]) for one in np.unique(label[rim[:, 0]])]
    if not loops or len(loops) == 1 and _is_bed(points, corners, (many == 1)[own.reshape(-1)]):
        return
    broad = max(float(np.linalg.norm(np.ptp(points[loop], axis=0))) for loop in loops)
    raise CaseError(f"{where}: has {len(loops):,} hole{'s' * (len(loops) > 1)} with {len(rim):,} open "
                    f"edges{_at([points[loop].mean(axis=0) for loop in loops])}, the largest {broad:.3g} m across; a "
                    "solid must be closed: fill them, for instance with MeshLab or Blender. A bed with fluid above it "
                    "may be open, but must not overhang, and has one rim")


def _directed(corners: Ints) -> Ints:
    """Return the edges (3 M, 2) of triangles, in their order around each."""
    found: Ints = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    return found


def components(count: int, pairs: Ints) -> Ints:
    """Return for each of `count` things the least number of those joined to it by pairs (n, 2), (count,) int."""
    label: Ints = np.arange(count)
    while True:
        before, ends = label.copy(), label[pairs]
        for end in ends.T:
            np.minimum.at(label, end, ends.min(axis=1))
        label = label[label]
        if np.array_equal(label, before):
            return label


def _is_bed(points: Floats, corners: Ints, alone: Flags) -> bool:
    """Return whether vertical lines meet an open surface once at most.

    Then the areas of its triangles in the plan add up to what its rim encloses. alone : (3 M,), edges on the rim
    """
    upward = area_vectors(points[corners])[:, 2]
    way = np.where(np.repeat(upward < 0.0, 3)[:, None], _directed(corners)[:, ::-1], _directed(corners))[alone]
    a, b = np.moveaxis(points[way][..., :2] - points[0, :2], 1, 0)
    enclosed, covered = 0.5 * abs(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))), float(np.abs(upward).sum())
    return covered > 0.0 and abs(enclosed - covered) <= SAME * covered


def _reversed(places: Floats, corners: Ints, edges: Edges, where: str) -> Flags:
    """Return which triangles (M,) must be reversed.

    Each connected surface then faces the side that most of its area faces in the file, so that an inner one may be that
    of a hole. But all are reversed if the whole is inside out, or, of an open one, faces downward.

    Each triangle is there twice, as it is and reversed (its number plus M); those that face the same side are joined.
    """
    count, (one, other), nodes = len(corners), edges.beside[~edges.rim].T, edges.nodes[~edges.rim]
    along = [np.any(np.all(_directed(corners).reshape(-1, 3, 2)[side] == nodes[:, None], axis=2), axis=1)
             for side in (one, other)]
    turn = np.where(along[0] == along[1], count, 0)    # both go the same way along their edge: one is reversed
    label = components(2 * count, np.concatenate([np.stack([one, other + turn], axis=1),
                                                  np.stack([one + count, other + count - turn], axis=1)]))
    same = label[:count] == label[count:]
    if same.any():
        raise CaseError(f"{where}: {np.count_nonzero(same):,} triangles belong to a one-sided surface, like a Moebius "
                        f"strip{_at(places[same].mean(axis=1))}; repair it in the program that made it")
    whole = np.minimum(label[:count], label[count:])
    flip: Flags = label[:count] != whole
    size = np.linalg.norm(area_vectors(places), axis=1)
    flip ^= (np.bincount(whole, weights=size * flip) > 0.5 * np.bincount(whole, weights=size))[whole]
    now = np.where(flip[:, None, None], places[:, ::-1], places)
    facing = float(area_vectors(now)[:, 2].sum()) if edges.rim.any() else signed_volume(now)
    found: Flags = flip if facing > 0.0 else ~flip
    return found


def _at(places: Iterable[Floats] | Floats) -> str:
    """Return where something is: the first few of places (n, 3) [m]."""
    found = [np.asarray(place) for place in places]
    return " at " + ", ".join(point(place) for place in found[:SHOWN]) + ", ..." * (len(found) > SHOWN)
