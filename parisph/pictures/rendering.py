"""Rendered pictures of triangles and spheres in 3D, off the screen. Needs pyvista."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parisph.base import libraries
from parisph.base.arrays import Floats, Ints
from parisph.base.errors import MissingLibrary

AWAY = 2.5      # distance of the eye from the middle of the scene, in its half diagonals
MARGIN = 1.04
SHARP = 40.0    # [degrees] of an edge that is not rounded by shading
AMBIENT = 0.3   # share of the light that comes from everywhere, so that colours are legible in the shade
FINE = 10       # meridians and parallels of a sphere


@dataclass(frozen=True)
class Piece:
    """Triangles, or spheres, of one colour or coloured by values.

    points : (n, 3) [m]; triangles : (m, 3), or None for spheres of `radius` [m] at the points
    values : (n,) with `limits` and a colour map `colours`, or None for the colour `colour`
    smooth : of a closed surface: edges are rounded by shading, but sharp ones; lit : whether there is shading
    lines : triangles are drawn as their sharp edges
    """

    points: Floats
    triangles: Ints | None
    values: Floats | None = None
    limits: tuple[float, float] = (0.0, 1.0)
    colours: str = "viridis"
    colour: str = "#d9d9d9"
    opacity: float = 1.0
    radius: float = 0.0
    smooth: bool = False
    lit: bool = True
    lines: bool = False


@dataclass(frozen=True)
class Eye:
    """Where a picture is seen from. place, target : (3,) [m]; angle : [degrees], of its height; aspect : width / height

    A picture contains all points that it was made for.
    """

    place: Floats
    target: Floats
    angle: float
    aspect: float

    @classmethod
    def of(cls, points: Floats, azimuth: float, elevation: float) -> "Eye":
        """Return the eye for points (n, 3) [m], from the front (along y) for 0, 0; angles in degrees."""
        lower, upper = points.min(axis=0), points.max(axis=0)
        middle, far = 0.5 * (lower + upper), AWAY * 0.5 * float(np.linalg.norm(upper - lower)) or 1.0
        a, e = np.deg2rad([azimuth, elevation])
        outward = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
        right = np.array([np.cos(a), np.sin(a), 0.0])
        upward = np.cross(outward, right)
        depth = far - (points - middle) @ outward
        across, up = (points - middle) @ right / depth, (points - middle) @ upward / depth
        # aim at the middle of the picture, to first order in its size
        middle = middle + far * (0.5 * (across.max() + across.min()) * right + 0.5 * (up.max() + up.min()) * upward)
        wide, high = MARGIN * np.ptp(across), max(MARGIN * np.ptp(up), 1e-3)
        return cls(middle + far * outward, middle, float(np.rad2deg(2.0 * np.arctan(0.5 * high))),
                   float(np.clip(wide / high, 0.5, 6.0)))


def available() -> bool:
    """Return whether pyvista is installed. It is not loaded, which takes seconds."""
    return find_spec("pyvista") is not None


def image(pieces: Sequence[Piece], eye: Eye, width: int = 1600) -> NDArray[np.uint8]:
    """Return a picture (height, width, 3). Raises MissingLibrary without pyvista, or where it cannot draw."""
    libraries.require("pyvista")
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)    # it tells at length that there is no screen
    try:
        plotter = pyvista.Plotter(off_screen=True, window_size=[width, int(round(width / eye.aspect))],
                                  lighting="light kit")
        plotter.set_background("white")
        for piece in pieces:
            if len(piece.points) and (piece.triangles is None or len(piece.triangles)):
                _add(plotter, piece)
        plotter.enable_anti_aliasing("ssaa")
        plotter.enable_depth_peeling(8)
        camera = plotter.camera
        camera.position, camera.focal_point, camera.up = eye.place.tolist(), eye.target.tolist(), (0.0, 0.0, 1.0)
        camera.view_angle = eye.angle
        plotter.reset_camera_clipping_range()
        found: NDArray[np.uint8] = np.asarray(plotter.screenshot(return_img=True))
        plotter.close()
    except (RuntimeError, AttributeError) as error:
        raise MissingLibrary(f"pyvista cannot draw without a screen here ({error}): install vtk 9.4 or later") from None
    return found[:, :, :3]


def _add(plotter: Any, piece: Piece) -> None:
    import pyvista

    if piece.triangles is None:
        mesh = pyvista.PolyData(piece.points)
    else:
        mesh = pyvista.PolyData.from_regular_faces(piece.points, piece.triangles)
    how: dict[str, Any] = {"color": piece.colour}
    if piece.values is not None:
        mesh.point_data["values"] = piece.values
        how = {"scalars": "values", "clim": piece.limits, "cmap": piece.colours, "show_scalar_bar": False}
    how |= {"opacity": piece.opacity, "lighting": piece.lit, **({"ambient": AMBIENT} if piece.lit else {})}
    if piece.lines:
        mesh = mesh.clean().extract_feature_edges(SHARP, non_manifold_edges=False, manifold_edges=False)
        how["line_width"] = 2.5
    elif piece.triangles is None:
        ball = pyvista.Sphere(radius=piece.radius, theta_resolution=FINE, phi_resolution=FINE)
        mesh = mesh.glyph(geom=ball, scale=False, orient=False)
        how["smooth_shading"] = True
    elif piece.smooth:
        how |= {"culling": "back", "smooth_shading": True, "split_sharp_edges": True, "feature_angle": SHARP,
                "specular": 0.25, "specular_power": 20.0}
    plotter.add_mesh(mesh, **how)
