"""Mirror images of fluid in the walls nearby, without storing a single ghost particle.

A particle near a wall sees too few neighbours. For i and j on the same side of a plane the
image of j is never nearer to i than j itself, so every image within a radius belongs to a
neighbour within that radius: the neighbour lists already hold all that is needed.
"""

from parisph.base.fields import WALL
from parisph.kernels.jit import kernel

PARALLEL = 0.9  # cosine above which two wall normals belong to the same plane


@kernel
def near_planes(points, normals, i, x, kind, corner, normal, indptr, indices, axes):
    """Collect the walls next to particle i, one plane per orientation, nearest first choice.

    points, normals : (dim, dim) output, a point on each plane and its normal.
    Returns the number of planes, at most dim.
    """
    dim = len(axes)
    found = 0
    for k in range(indptr[i], indptr[i + 1]):
        j = indices[k]
        if kind[j] != WALL or corner[j]:
            continue
        same = -1
        for p in range(found):
            cosine = 0.0
            for a in range(dim):
                cosine += normals[p, a] * normal[j, a]
            if cosine > PARALLEL:
                same = p
        if same >= 0:
            if height(i, points[same], normals[same], x, axes) <= height(i, x[j], normal[j], x, axes):
                continue
        elif found < dim:
            same = found
            found += 1
        else:
            continue
        for a in range(dim):
            points[same, a] = x[j, a]
            normals[same, a] = normal[j, a]
    return found


@kernel
def height(i, point, direction, x, axes):
    """Return the distance of particle i from a plane, positive on the fluid's side."""
    h = 0.0
    for a in range(len(axes)):
        h += (x[i, a] - point[a]) * direction[a]
    return h


@kernel
def reflect(image, j, subset, points, normals, x, axes):
    """Write the image of particle j in the planes whose bits are set in subset."""
    dim = len(axes)
    for a in range(dim):
        image[a] = x[j, a]
    for p in range(dim):
        if (subset >> p) & 1:
            h = 0.0
            for a in range(dim):
                h += (image[a] - points[p, a]) * normals[p, a]
            for a in range(dim):
                image[a] -= 2.0 * h * normals[p, a]
