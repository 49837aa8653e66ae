"""Moves that keep the distances of neighbours even."""

import numpy as np
import pytest

from parisph.base.fields import SURFACE, WALL
from parisph.kernels import even_spacing
from tests.pools import block, dims, tank

STRENGTH = 0.1
STIFFNESS = {2: 1.67, 3: 1.96}    # push of a lattice over the displacement of one particle of it


def moves(pool, strength=STRENGTH):
    """Return the moves (n, dim) in spacings, of a surface across the last axis."""
    move, across = np.full((pool.n, pool.dim), np.nan), np.tile(3.0 * np.eye(pool.dim)[-1], (pool.n, 1))
    known = (pool.kind == WALL) & (pool.corner == 0)
    even_spacing.even_out(move, pool.cloud, across, known, np.full(pool.n, strength))
    return move / pool.spacing


@dims
def test_nothing_moves_on_a_lattice_that_is_strained(dim):
    pool = block(dim, 9 if dim == 2 else 7)
    strain = np.eye(dim)
    strain[0, 0], strain[1, 1], strain[0, 1] = 1.15, 1.0 / 1.15, 0.1
    pool.x[:] = pool.x @ strain
    pool.relist()
    np.testing.assert_allclose(moves(pool)[pool.far_inside(3)], 0.0, atol=1e-14)


@dims
def test_nothing_moves_in_a_tank_at_rest(dim):
    """Beside walls, in corners and at the contact line, too."""
    pool = tank((7,) * dim if dim == 2 else (5,) * dim)
    np.testing.assert_allclose(moves(pool), 0.0, atol=1e-14)


@dims
def test_a_displacement_of_one_particle_is_undone_in_part(dim):
    pool = block(dim, 7)
    i = pool.at(*[3] * dim)
    displaced = 0.05 * np.array([0.8, -0.6, 0.0][:dim])
    pool.x[i] += displaced * pool.spacing
    pool.relist()
    due = -STRENGTH * STIFFNESS[dim] / even_spacing.STIFFNESS * displaced
    np.testing.assert_allclose(moves(pool)[i], due, rtol=0.02, atol=1e-5)
    np.testing.assert_allclose(moves(pool, 2.0 * STRENGTH)[i], 2.0 * moves(pool)[i], rtol=1e-14)


@dims
@pytest.mark.parametrize("off", [-0.2, 0.2])
def test_the_distance_from_a_wall_is_kept(dim, off):
    side = 7 if dim == 2 else 5
    pool = tank((side,) * dim)
    i = pool.at(1, *[side // 2] * (dim - 1))
    pool.x[i, 0] += off * pool.spacing
    pool.relist()
    move = moves(pool)[i]
    assert -1.3 * STRENGTH < move[0] / off < -0.7 * STRENGTH
    np.testing.assert_allclose(move[1:], 0.0, atol=1e-14)


@dims
@pytest.mark.parametrize("beside", [False, True])
def test_particles_of_the_surface_are_moved_along_it(dim, beside):
    side = 7 if dim == 2 else 5
    pool = tank((side,) * dim)
    i = pool.at(1 if beside else side // 2, *[side // 2] * (dim - 2), side)
    assert pool.role[i] == SURFACE
    pool.x[i, 0] += 0.1 * pool.spacing
    pool.x[i, -1] += 0.1 * pool.spacing
    pool.relist()
    move = moves(pool)[i]
    assert -1.4 * STRENGTH < move[0] / 0.1 < -0.5 * STRENGTH
    np.testing.assert_allclose(move[1:], 0.0, atol=1e-14)


def test_two_particles_in_one_place_are_not_thrown_apart():
    pool = block(2, 7)
    i, j = pool.at(3, 3), pool.at(4, 3)
    pool.x[j] = pool.x[i]
    pool.relist()
    found = moves(pool)[[i, j]]
    assert np.all(np.isfinite(found)) and np.abs(found).max() < STRENGTH
