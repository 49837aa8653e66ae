"""Mirror images in walls, and the density ratio that they complete."""

import numpy as np
import pytest

from parisph.base.fields import FLUID
from parisph.kernels import mirrors, surface
from parisph.kernels.smoothing import cubic_spline
from tests.pools import block, free, tank

dims = pytest.mark.parametrize("dim", [2, 3])
H = 1.3


def planes(pool, i):
    """Return the wall particles that stand for the planes near particle i."""
    member = np.full(pool.dim, -1, np.int64)
    found = mirrors.near_planes(member, i, *pool.walls, *pool.csr)
    return member[:found]


def ratio(pool, h=H):
    full = surface.lattice_sum(pool.spacing, h * pool.spacing, pool.axes)
    alpha = np.full(pool.n, np.nan)
    surface.density_ratio(alpha, *pool.walls, h * pool.spacing, full, *pool.csr)
    return alpha


# -- planes and images -------------------------------------------------------------------------------


@dims
@pytest.mark.parametrize("faces", [0, 1, 2])
def test_one_wall_particle_for_each_orientation(dim, faces):
    pool = tank((10,) * dim, jitter=0.4)
    i = pool.at(*[1] * faces, *[5] * (dim - faces))
    found = planes(pool, i)
    normals = sorted(map(tuple, pool.normal[found]))
    assert normals == sorted(map(tuple, np.eye(dim)[:faces]))
    assert np.all(pool.corner[found] == 0)


def test_three_planes_in_the_corner_of_a_cube():
    pool = tank((8, 8, 8))
    assert len(planes(pool, pool.at(1, 1, 1))) == 3


@dims
@pytest.mark.parametrize(("above", "expected"), [(-0.5, 1), (0.0, 1), (0.5, 0), (1.5, 0)])
def test_no_plane_above_the_rim(dim, above, expected):
    """Wall particles are near, but the wall ends below: what is higher than the rim can pass over it."""
    pool = tank((8,) * dim)
    i = pool.at(1, *[4] * (dim - 2), 8)
    pool.x[i, -1] += above * pool.spacing
    pool.relist()
    assert len(planes(pool, i)) == expected


@dims
def test_fluid_beside_walls(dim):
    pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.5)
    due = [i for i in range(pool.n) if pool.fluid[i]
           and not pool.fluid[pool.indices[pool.indptr[i]:pool.indptr[i + 1]]].all()]
    beside, start, walls = mirrors.beside_walls(pool.kind, *pool.csr[:2])
    assert beside.tolist() == due and 0 < len(due) < np.count_nonzero(pool.fluid)
    for i in range(pool.n):
        listed = pool.indices[pool.indptr[i]:pool.indptr[i + 1]]
        assert walls[start[i]:start[i + 1]].tolist() == (listed[~pool.fluid[listed]].tolist() if pool.fluid[i] else [])


@dims
def test_lists_of_walls_alone_give_the_same_planes(dim):
    pool = tank((8,) * dim if dim == 2 else (6,) * dim, jitter=0.5)
    beside, *walls = mirrors.beside_walls(pool.kind, *pool.csr[:2])
    for i in beside:
        whole, some = np.empty(dim, np.int64), np.empty(dim, np.int64)
        n = mirrors.near_planes(whole, i, *pool.walls, *pool.csr)
        assert mirrors.near_planes(some, i, *pool.walls, *walls, pool.axes) == n
        assert some[:n].tolist() == whole[:n].tolist()


@dims
def test_planes_reach_into_corners(dim):
    """Fluid between an edge and the wall particles beside it has both walls, wherever it stands."""
    pool = tank((8,) * dim)
    i = pool.at(*[1] * dim)
    for place in (0.1, 0.5, 0.9, 1.4):
        pool.x[i] = place * pool.spacing
        pool.relist()
        assert len(planes(pool, i)) == dim, place


def test_opposite_walls_are_two_planes_and_parallel_ones_give_the_nearest():
    channel = tank((3, 8), spacing=0.1)
    found = planes(channel, channel.at(1, 4))
    assert sorted(channel.normal[found][:, 0]) == [-1.0, 1.0]
    # a step in the bed: two planes with the same normal, at heights 0 and 1
    pool = tank((10, 8))
    i = pool.at(5, 2)
    pool.x[pool.at(5, 0)] += [0.0, 1.0 * pool.spacing]
    pool.relist()
    found = planes(pool, i)
    assert len(found) == 1 and found[0] == pool.at(5, 0)
    assert mirrors.height(i, found[0], pool.x, pool.normal, pool.axes) == pytest.approx(pool.spacing, rel=1e-12)


@dims
def test_images(dim):
    pool = tank((8,) * dim)
    i = pool.at(*[1] * dim)
    member = np.full(dim, -1, np.int64)
    count = mirrors.near_planes(member, i, *pool.walls, *pool.csr)
    axis = np.argmax(pool.normal[member[:count]], axis=1)
    image = np.empty(dim)
    for subset in range(1 << count):
        mirrors.reflect(image, i, subset, member, pool.x, pool.normal, pool.axes)
        sign = np.ones(dim)
        for p in range(count):
            if subset >> p & 1:
                sign[axis[p]] = -1.0
        np.testing.assert_allclose(image, sign * pool.x[i], atol=1e-15)


def test_image_in_a_slanting_wall():
    pool = free([[0.3, 0.4], [1.0, 0.2]], spacing=1.0)
    pool.normal[1] = 0.6, 0.8
    image = np.empty(2)
    mirrors.reflect(image, 0, 1, np.array([1, 0]), pool.x, pool.normal, pool.axes)
    middle, along = 0.5 * (image + pool.x[0]), image - pool.x[0]
    assert (middle - pool.x[1]) @ pool.normal[1] == pytest.approx(0.0, abs=1e-15)
    assert along @ [-0.8, 0.6] == pytest.approx(0.0, abs=1e-15)


# -- density ratio -----------------------------------------------------------------------------------


@dims
@pytest.mark.parametrize("h", [1.0, 1.3, 1.8])
def test_lattice_sum(dim, h):
    pool = block(dim, 11 if dim == 2 else 9, reach=4.0)
    middle = pool.x[pool.at(*[pool.top[0] // 2] * dim)]
    distance = np.linalg.norm(pool.x - middle, axis=1)
    expected = sum(cubic_spline(r, h * pool.spacing, dim) for r in distance)
    found = surface.lattice_sum(pool.spacing, h * pool.spacing, pool.axes)
    assert found == pytest.approx(expected, rel=1e-13)
    assert found * pool.spacing**dim == pytest.approx(1.0, abs=0.03)


@dims
@pytest.mark.parametrize("lid", [False, True])
def test_ratio_is_one_inside_at_walls_and_in_corners(dim, lid):
    pool = tank((12, 12) if dim == 2 else (9, 9, 9), lid)
    alpha = ratio(pool)
    full = pool.fluid & (lid | (pool.index[:, -1] <= pool.top[-1] - 3))
    assert full[pool.at(*[1] * dim)] and full[pool.at(pool.top[0] - 1, *[1] * (dim - 1))]
    np.testing.assert_allclose(alpha[full], 1.0, atol=1e-13)
    assert np.all(alpha[~pool.fluid] == 1.0)


@dims
def test_who_casts_an_image(dim):
    pool = tank((8,) * dim)
    i = pool.at(*[1] * dim)
    member = np.full(dim, -1, np.int64)
    count = mirrors.near_planes(member, i, *pool.walls, *pool.csr)
    axis = np.argmax(pool.normal[member[:count]], axis=1)
    for j in pool.indices[pool.indptr[i]:pool.indptr[i + 1]]:
        for subset in range(1, 1 << count):
            crossed = [axis[p] for p in range(count) if subset >> p & 1]
            expected = pool.kind[j] == FLUID or np.all(pool.index[j, crossed] > 0)
            assert mirrors.casts_image(j, subset, member, pool.x, pool.kind, pool.normal, 0.01, pool.axes) == expected


@dims
def test_ratio_of_sparse_and_dense_fluid(dim):
    pool = block(dim, 9)
    middle = pool.at(*[4] * dim)
    assert ratio(pool)[middle] == pytest.approx(1.0, abs=1e-13)
    full = surface.lattice_sum(0.1, 0.13, pool.axes)
    alone = free(np.zeros((1, dim)))
    assert ratio(alone)[0] == pytest.approx(cubic_spline(0.0, 0.13, dim) / full, rel=1e-13)
    pool.x[pool.at(*[5] * dim)] = pool.x[middle]  # a second particle in the same place
    pool.relist()
    assert ratio(pool)[middle] > 1.1


@dims
def test_ratio_on_a_flat_surface(dim):
    pool = tank((12, 12) if dim == 2 else (9, 9, 9))
    alpha = ratio(pool)
    top = pool.at(*[pool.top[0] // 2] * (dim - 1), pool.top[-1])
    # half of the neighbourhood, and the layer of the surface itself
    assert 0.5 < alpha[top] < 0.8
    first = pool.at(1, *[pool.top[0] // 2] * (dim - 2), pool.top[-1])
    assert alpha[first] == pytest.approx(alpha[top], abs=0.01)
