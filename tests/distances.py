"""The distance of points from walls, with a sign, for tests of what lies where."""

import numpy as np

from parisph.geometry.distance import area_vectors, nearest


def signed_distance(x, corners):
    """Return the distance (n,) [m] of points from elements, negative behind the nearest one, positive beside plates."""
    distance, element, foot = nearest(x, corners)
    behind = np.sum((x - foot) * area_vectors(corners[element]), axis=1) < 0.0
    return np.where(behind, -distance, distance)
