"""Moments of velocities in a fit of u = grad f by harmonic polynomials f of degree 3 in 3D.

The polynomials are those of kernels.harmonic, P_r. Their moments sum_k w_k grad P_r . grad P_c, and those of the data,
sum_k w_k grad P_r . u_k, are combinations of sums of w times monomials, 35 up to degree 4 and, with each component of
u, ten up to degree 2: a fifth of the products of a column for each component.
"""

from itertools import product

import numpy as np

from parisph.kernels.jit import inlined

Polynomial = dict[tuple[int, ...], float]    # exponents of x, y, z -> coefficient

POWERS = sorted((e for e in product(range(5), repeat=3) if sum(e) <= 4), key=lambda e: (sum(e), e))
WITH_DATA = sum(sum(e) <= 2 for e in POWERS)    # monomials that also occur with velocities, the first ones


def _times(p: Polynomial, q: Polynomial) -> Polynomial:
    found: Polynomial = {}
    for (e, a), (f, b) in product(p.items(), q.items()):
        key = tuple(map(sum, zip(e, f)))
        found[key] = found.get(key, 0.0) + a * b
    return found


def _slope(p: Polynomial, axis: int) -> Polynomial:
    return {tuple(n - (a == axis) for a, n in enumerate(e)): e[axis] * c
            for e, c in p.items() if e[axis]}


def _polynomials() -> list[Polynomial]:
    """Return the polynomials in the order of harmonic.fill_values."""
    x, y, z = ({tuple(int(a == axis) for a in range(3)): 1.0} for axis in range(3))

    def squares(a: float, b: float, c: float) -> Polynomial:
        return {(2, 0, 0): a, (0, 2, 0): b, (0, 0, 2): c}

    return [x, y, z, squares(1, -1, 0), squares(0, 1, -1), _times(x, y), _times(x, z), _times(y, z),
            _times(_times(x, y), z), _times(x, squares(0, 1, -1)), _times(y, squares(-1, 0, 1)),
            _times(z, squares(1, -1, 0)), _times(x, squares(2, -3, -3)), _times(y, squares(-3, 2, -3)),
            _times(z, squares(-3, -3, 2))]


def _parents() -> np.ndarray:
    """Return (35, 2): each monomial is an earlier one times a coordinate. The first, 1, has none."""
    found = [(0, 0)]
    for e in POWERS[1:]:
        axis = next(a for a in range(3) if e[a])
        found.append((POWERS.index(tuple(n - (a == axis) for a, n in enumerate(e))), axis))
    return np.array(found, np.uint32)


def _combinations() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the entries (r, c, monomial) and coefficients of the matrix, and (r, monomial, axis) of the data.

    Both are in the order of r.
    """
    matrix: list[tuple[int, int, int]] = []
    data: list[tuple[int, int, int]] = []
    of_matrix: list[float] = []
    of_data: list[float] = []
    slopes = [[_slope(p, axis) for axis in range(3)] for p in _polynomials()]
    for r in range(len(slopes)):
        for c in range(r + 1):
            total: Polynomial = {}
            for axis in range(3):
                for e, value in _times(slopes[r][axis], slopes[c][axis]).items():
                    total[e] = total.get(e, 0.0) + value
            for e, value in total.items():
                if value:
                    matrix.append((r, c, POWERS.index(e)))
                    of_matrix.append(value)
        for axis in range(3):
            for e, value in slopes[r][axis].items():
                data.append((r, POWERS.index(e), axis))
                of_data.append(value)
    return np.array(matrix, np.uint32), np.array(of_matrix), np.array(data, np.uint32), np.array(of_data)


PARENT = _parents()
MATRIX, OF_MATRIX, DATA, OF_DATA = _combinations()
ROOM = len(POWERS)


@inlined
def add_moments(work: np.ndarray, right: np.ndarray, power: np.ndarray, sums: np.ndarray, near: np.ndarray,
                v: np.ndarray, m: int, size: int) -> None:
    """Add the moments of the first `size` polynomials and of m velocities to work (lower triangle) and right.

    power : (ROOM, columns), of which row 0 holds the weights of the places; sums : (ROOM, 4) scratch
    near, v : (3, columns), places and velocities
    """
    for q in range(ROOM):
        total, parent, axis = 0.0, PARENT[q, 0], PARENT[q, 1]
        if q == 0:
            for k in range(m):
                total += power[0, k]
        else:
            for k in range(m):
                value = power[parent, k] * near[axis, k]
                power[q, k] = value
                total += value
        sums[q, 3] = total
    for q in range(WITH_DATA):
        first, second, third = 0.0, 0.0, 0.0
        for k in range(m):
            first += power[q, k] * v[0, k]
            second += power[q, k] * v[1, k]
            third += power[q, k] * v[2, k]
        sums[q, 0], sums[q, 1], sums[q, 2] = first, second, third
    for k in range(len(OF_MATRIX)):
        if MATRIX[k, 0] >= size:
            break
        work[MATRIX[k, 0], MATRIX[k, 1]] += OF_MATRIX[k] * sums[MATRIX[k, 2], 3]
    for k in range(len(OF_DATA)):
        if DATA[k, 0] >= size:
            break
        right[DATA[k, 0]] += OF_DATA[k] * sums[DATA[k, 1], DATA[k, 2]]
