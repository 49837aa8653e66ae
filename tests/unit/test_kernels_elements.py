"""Shapes of wall elements and the numbers of their planes."""

import numpy as np

from parisph.kernels.elements import plane_numbers, shapes_of
from tests.pools import mesh_of

S = 0.05


def test_elements_in_one_plane_share_its_number():
    corners = mesh_of((4, 4, 4), spacing=S).corners()
    numbers = plane_numbers(corners, np.zeros(len(corners), np.int64), S)
    shapes = shapes_of(corners, numbers)
    assert len(set(numbers)) == 6
    for number in range(6):
        plane = shapes.plane[numbers == number]
        np.testing.assert_allclose(plane, np.broadcast_to(plane[0], plane.shape), atol=1e-14)
    motion = (np.arange(len(corners)) % 2).astype(np.int64)    # what moves does not stay in the plane
    assert len(set(plane_numbers(corners, motion, S))) == 12
    np.testing.assert_allclose(shapes.middle, corners.mean(axis=1), atol=1e-15)
    np.testing.assert_allclose(shapes.size, S * np.sqrt(5.0) / 3.0)    # of half a square
