"""Closed surfaces of triangles, and STL files of them, for tests."""

import itertools

import numpy as np

# What Surfaces need, to be imported in this order: see parisph.base.libraries.
LIBRARIES = ("h5py", "trimesh", "manifold3d", "pymeshlab")


def box(size, at=(0.0, 0.0, 0.0)):
    """Return the twelve triangles (12, 3, 3) [m] of a box with its lower corner `at`, normals outward."""
    found = []
    for axis, side in itertools.product(range(3), (0, 1)):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        corners = np.zeros((4, 3))
        corners[:, axis] = side
        corners[:, one], corners[:, other] = (0, 1, 1, 0), (0, 0, 1, 1)
        corners = corners if side else corners[::-1]
        found += [corners[[0, 1, 2]], corners[[0, 2, 3]]]
    return np.array(found) * size + at


def sphere(halvings, radius, at=(0.0, 0.0, 0.0)):
    """Return the 8 * 4^halvings triangles [m] of a sphere, made from an octahedron, normals outward."""
    x, y, z = np.eye(3)
    found = np.array([(a, b, c) if np.linalg.det([a, b, c]) > 0 else (a, c, b)
                      for a, b, c in itertools.product((x, -x), (y, -y), (z, -z))])
    for _ in range(halvings):
        a, b, c = np.moveaxis(found, 1, 0)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        found = np.concatenate([np.stack(part, axis=1) for part in parts])
        found /= np.linalg.norm(found, axis=2, keepdims=True)
    return found * radius + at


def prism(outline, low, high):
    """Return the triangles [m] of an upright prism from z = low to high over a convex outline (n, 2), counterclockwise,
    normals outward."""
    bottom, top = (np.column_stack([outline, np.full(len(outline), z)]) for z in (low, high))
    after = np.roll(np.arange(len(outline)), -1)
    sides = [(bottom, bottom[after], top[after]), (bottom, top[after], top)]
    ends = [(np.broadcast_to(z.mean(axis=0), z.shape), *(way)) for z, way in (
        (bottom, (bottom[after], bottom)), (top, (top, top[after])))]
    return np.concatenate([np.stack(part, axis=1) for part in (*sides, *ends)])


def sheet(height, lower, upper, pieces):
    """Return the triangles [m] of a surface z = height(x, y) over a rectangle, pieces (nx, ny), normals upward."""
    x, y = (np.linspace(a, b, n + 1) for a, b, n in zip(lower, upper, pieces))
    x, y = np.meshgrid(x, y, indexing="ij")
    points = np.stack([x, y, height(x, y) + 0.0 * x], axis=2)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(part, axis=2).reshape(-1, 3, 3) for part in ((a, b, c), (a, c, d))])


def volume(corners):
    """Return the volume [m3] inside closed triangles (n, 3, 3) [m]."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return float(np.sum(a * np.cross(b, c))) / 6.0


def write_stl(path, corners, binary=True):
    """Write triangles (n, 3, 3) as an STL file."""
    a, b, c = np.moveaxis(np.asarray(corners, dtype=float), 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    if binary:
        rows = np.zeros(len(corners), dtype=[("numbers", "<f4", (4, 3)), ("attribute", "<u2")])
        rows["numbers"] = np.concatenate([normal[:, None], corners], axis=1)
        path.write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + rows.tobytes())
        return path
    lines = ["solid test"]
    for n, triangle in zip(normal, corners):
        points = "\n".join("vertex {:.9g} {:.9g} {:.9g}".format(*point) for point in triangle)
        lines.append("facet normal {:g} {:g} {:g}\nouter loop\n".format(*n) + points + "\nendloop\nendfacet")
    path.write_text("\n".join([*lines, "endsolid test\n"]))
    return path
