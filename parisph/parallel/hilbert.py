"""Hilbert's space-filling curve in any dimension: neighbours on the curve are neighbours in space.

The curve through a grid of 2^bits cells per side is built from the coarsest level to the finest. At each level it
visits the 2^dim corners of a cube in the order of a Gray code, in one of a few orientations. So a small state machine
computes the key: the state is the orientation, the input is the corner of a cell, the output is the place of this
corner on the curve and the next state (C. Hamilton, Compact Hilbert Indices, Dalhousie University CS-2006-07, Sec. 2).
The leading digits of a key are the key of the coarser cell that contains the cell.
"""

from functools import lru_cache

import numpy as np

from parisph.base.arrays import Ints
from parisph.kernels.jit import subkernel

KEY_BITS = 62  # bits in a key; int64 also represents the key one past the last


@lru_cache(maxsize=None)
def machine(dim: int) -> tuple[Ints, Ints]:
    """Return (place, following): (states, 2^dim) tables of the machine, int64, for `key_of`.

    A state is (entry corner, direction) of the curve in a cube: state = direction * 2^dim + entry.
    """
    corners = 1 << dim
    place = np.empty((dim * corners, corners), np.int64)
    following = np.empty_like(place)
    for direction in range(dim):
        for entry in range(corners):
            state = direction * corners + entry
            for corner in range(corners):
                w = _gray_inverse(_rotate(corner ^ entry, -(direction + 1), dim))
                entry_next = entry ^ _rotate(_entry(w), direction + 1, dim)
                direction_next = (direction + _direction(w, dim) + 1) % dim
                place[state, corner] = w
                following[state, corner] = direction_next * corners + entry_next
    return place, following


def _rotate(word: int, by: int, dim: int) -> int:
    """Rotate the dim bits of a word to the left."""
    by %= dim
    return ((word << by) | (word >> (dim - by))) & ((1 << dim) - 1)


def _gray(i: int) -> int:
    return i ^ (i >> 1)


def _gray_inverse(code: int) -> int:
    i = 0
    while code:
        i ^= code
        code >>= 1
    return i


def _entry(w: int) -> int:
    """Return the corner at which the curve enters sub-cube w."""
    return _gray(2 * ((w - 1) // 2)) if w else 0


def _direction(w: int, dim: int) -> int:
    """Return the axis along which the curve crosses sub-cube w."""
    if w == 0:
        return 0
    i, ones = (w if w % 2 else w - 1), 0
    while i & 1:
        i >>= 1
        ones += 1
    return ones % dim


@subkernel
def key_of(cell: Ints, bits: int, place: Ints, following: Ints) -> int:
    """Return the key of one cell, an int64 array or tuple of coordinates."""
    dim = len(cell)
    state, key = 0, 0
    for level in range(bits - 1, -1, -1):
        corner = 0
        for a in range(dim):
            corner |= ((cell[a] >> level) & 1) << a
        key = (key << dim) | place[state, corner]
        state = following[state, corner]
    return key
