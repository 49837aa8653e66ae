"""Walls as elements in a step: where they are, what fluid covers of them, and what they do for gradients and gaps."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph import Box, Obstacle, Profile, Roll, StillWater, Sway, Tank
from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE, WALL, FieldSet
from parisph.geometry.mesh import motions_of, wall_mesh
from parisph.kernels import gradient, surface, wetness
from parisph.kernels.jit import axes_of
from parisph.kernels.near import Form
from parisph.kernels.records import cloud_of, no_walls
from parisph.methods.boundary import Boundary
from parisph.methods.rigid_bodies import Prescribed
from parisph.parallel.particles import Particles
from parisph.parallel.wall_elements import WallElements
from tests.pools import nowhere
from tests.wall_scenes import filled

S = 0.05
ROLL = Roll(angle=0.4, frequency=2.0, centre=(0.3, 0.2))


def turning():
    """Return the elements of a tank at rest with a block that turns, and its nodes as particles after two of fluid."""
    walls = [Tank(1.0, 1.0, name="tank"), Obstacle(Box(width=0.2, height=0.2, at=(0.4, 0.4)), motion=ROLL)]
    mesh = wall_mesh(walls, S)
    elements = WallElements(mesh, 2, S, [Prescribed(motion) for motion in motions_of(walls)])
    n = len(mesh.x0) + 2
    p = Particles(MPI.COMM_SELF, 2, FieldSet((*Boundary.fields, "wall_u")))
    p.assign({"id": np.arange(n)[::-1], "kind": np.repeat(np.array([WALL, FLUID], np.int8), [n - 2, 2]),
              "x": np.concatenate([mesh.x0[::-1], np.full((2, 2), 0.1)])})
    elements.settle(p, 10.0)
    return elements, p, mesh


def test_walls_are_placed_by_their_motions():
    elements, p, mesh = turning()
    elements.place(0.25, 0.2, 0.3)
    elements.put(p)
    moves = elements.moves
    assert 0 < moves.sum() < len(moves)
    np.testing.assert_array_equal(elements.x[~moves], mesh.x0[~moves])
    np.testing.assert_allclose(elements.x[moves], ROLL.placed(mesh.x0[moves], 0.25), rtol=1e-14)
    np.testing.assert_allclose(p.x[p.kind == WALL][::-1], elements.x, rtol=1e-14)
    np.testing.assert_allclose(p.normal[p.kind == WALL][::-1][moves], ROLL.turned(mesh.normal0[moves], 0.25))
    np.testing.assert_allclose(elements.walls.corners[:, 0], elements.x[mesh.elements[:, 0]], rtol=1e-14)
    # the velocity at the start, and what it changes by, and the mean velocity of elements
    at = [ROLL.velocity_at(ROLL.placed(mesh.x0[moves], t), t) for t in (0.2, 0.3)]
    np.testing.assert_allclose(elements.u[moves], at[0])
    np.testing.assert_allclose(elements.a[moves], (at[1] - at[0]) / 0.1)
    np.testing.assert_allclose(p.wall_u[p.kind == WALL][::-1], elements.u)
    way = (ROLL.placed(mesh.x0, 0.3) - ROLL.placed(mesh.x0, 0.2)) / 0.1
    turns = elements.motion > 0
    np.testing.assert_allclose(elements.velocity[turns], way[mesh.elements[turns]].mean(axis=1))
    assert turns.any() and not elements.velocity[~turns].any()


def test_turn_is_the_rate_of_the_normal():
    elements, _, mesh = turning()
    elements.place(0.2, 0.2, 0.2)
    step = 1e-6
    rate = (ROLL.turned(mesh.normal0, 0.2 + step) - ROLL.turned(mesh.normal0, 0.2 - step)) / (2.0 * step)
    np.testing.assert_allclose(elements.turn[elements.moves], rate[elements.moves], atol=1e-8)
    assert not elements.turn[~elements.moves].any()
    np.testing.assert_allclose(elements.a[elements.moves],
                               ROLL.acceleration_at(ROLL.placed(mesh.x0, 0.2), 0.2)[elements.moves])


def test_a_wall_that_comes_near_is_seen_where_none_of_its_nodes_is():
    """On a rank with fluid alone, which rests."""
    block = Obstacle(Box(width=0.2, height=0.2, at=(0.4, 0.4)), motion=Sway(0.3, frequency=1.0))
    elements = WallElements(wall_mesh([block], S), 1, S, [Prescribed(motion) for motion in motions_of([block])])
    p = Particles(MPI.COMM_SELF, 2, FieldSet(Boundary.fields))
    p.assign({"id": np.zeros(1, np.int64), "kind": np.array([FLUID], np.int8), "x": np.array([[0.85, 0.5]])})
    elements.settle(p, 1.0)
    for time, seen in ((0.0, False), (0.5 * np.pi, True)):
        elements.place(time, time, time)
        elements.renew(p, 2.6 * S)
        elements.look(p, 2.6 * S, np.zeros(2, np.int32), np.zeros(0, np.int32))
        assert (len(elements.walls.indices) > 0) == seen


def test_step_is_limited_by_speed_and_acceleration():
    walls = [Tank(1.0, 1.0), Obstacle(Box(width=0.2, height=0.2, at=(0.4, 0.4)), motion=Sway(0.1, frequency=3.0))]
    elements = WallElements(wall_mesh(walls, S), 0, S, [Prescribed(motion) for motion in motions_of(walls)])
    assert elements.longest_step(0.0, 0.3) == pytest.approx(min(0.3 * S / 0.3, 2.0 * np.pi / 3.0 / 50.0), rel=1e-6)
    # it starts from rest, with an acceleration alone
    assert elements.longest_step(0.0, 0.001) == pytest.approx(np.sqrt(2.0 * 0.001 * S / 0.9), rel=1e-6)
    assert WallElements(wall_mesh(walls[:1], S), 0, S).longest_step(0.0, 0.3) == np.inf


def test_nodes_that_are_not_here_do_not_count():
    elements, p, mesh = turning()
    values = np.arange(p.n_all, dtype=float)
    elements.nodes[0, 1] = -1
    assert elements.mean_of_nodes(values)[0] == values[elements.nodes[0, 0]]
    assert elements.mean_of_nodes(values)[1] == values[elements.nodes[1]].mean()


def test_water_covers_walls_up_to_its_level():
    scene = filled(StillWater(0.5), [Tank(1.0, 1.0)], S)
    covered = np.empty(len(scene.x))
    wetness.covered_walls(covered, scene.records()[0])
    side = (scene.kind == WALL) & (scene.x[:, 1] > 0.1)
    np.testing.assert_allclose(covered[side & (scene.x[:, 1] < 0.51)], 1.0)
    np.testing.assert_allclose(covered[side & (scene.x[:, 1] > 0.54)], 0.0, atol=1e-12)
    assert (covered[scene.kind == FLUID] == 1.0).all()


def lone(x, corners):
    """Return arguments of kernels for points of fluid x (n, 2) before elements: element lists and neighbour lists."""
    n, m = len(x), len(corners)
    element_indptr = np.arange(n + 1, dtype=np.int32) * m
    indptr = np.arange(n + 1, dtype=np.int32) * (n - 1)
    indices = np.array([j for i in range(n) for j in range(n) if j != i], np.int32)
    return element_indptr, np.tile(np.arange(m, dtype=np.int32), n), indptr, indices


def test_one_neighbour_and_a_wall_make_a_gradient():
    """Two particles in the tip of a wedge: f is linear, and its slope is known at the wall."""
    x, slope = np.array([[0.0, 0.5 * S], [S, 0.6 * S]]), np.array([3.0, -2.0])
    bed = np.array([[[-5.0 * S, 0.0], [5.0 * S, 0.0]]])
    role = np.array([BALLISTIC, BALLISTIC], np.int8)
    out, less = np.zeros((2, 2)), np.array([[0.0, 1.0]])
    seen, elements, *lists = lone(x, bed)
    cloud = cloud_of(x, np.full(2, FLUID, np.int8), role, np.zeros_like(x), *lists, S)
    walls = no_walls(2, 2)._replace(corners=bed, indptr=seen, indices=elements)

    def run(within):
        gradient.gradient_at_walls(out, nowhere(out), cloud._replace(spacing=within / gradient.DATUM), walls, x @ slope,
                                   np.tile(slope + less[0], (2, 1)), less, Form(2.6 * S, 0, 0.05))
    run(0.3 * S)
    assert not out.any() and (role == BALLISTIC).all()
    run(S)
    np.testing.assert_allclose(out, np.tile(slope, (2, 1)), rtol=1e-12)
    assert (role == SURFACE).all()


def test_a_wall_between_its_nodes_closes_a_gap():
    """A particle half a spacing above a bed that fluid surrounds on all other sides."""
    ring = np.linspace(-0.1, np.pi + 0.1, 9)
    x = np.concatenate([[[0.0, 0.5 * S]], [0.0, 0.5 * S] + 0.9 * S * np.stack([np.cos(ring), np.sin(ring)], axis=1)])
    bed = np.array([[[-S, 0.0], [S, 0.0]]])
    kind = np.full(len(x), FLUID, np.int8)
    lists = lone(x, bed)

    def found(present):
        role = np.full(len(x), SURFACE, np.int8)
        cloud = cloud_of(x, kind, role, np.zeros_like(x), *lists[2:], S)
        walls = no_walls(0, 2)._replace(corners=bed, present=np.array([present]), indptr=lists[0], indices=lists[1])
        surface.surface_by_gap(role, role.copy(), cloud, walls, np.ones(len(x)), 2.0 * S, surface.Gap(2.3, 1.55, 0.55))
        return role[0]
    assert found(0.0) == SURFACE and found(1.0) == INNER


def test_bed_before_a_piston_and_behind_it():
    bed = Profile([(0.0, 0.0), (1.0, 0.0)])
    face = np.array([[[0.52, S], [0.52, 0.0]]])    # faces right
    mesh = wall_mesh([bed], S)
    x, n = mesh.x0, len(mesh.x0)
    indptr, indices, *_ = lone(x, face)
    walls = no_walls(n, 2)._replace(corners=face, indptr=indptr, indices=indices)
    apart, rest = np.full((2, n), np.inf)
    for found, own in ((apart, 0), (rest, 1)):
        wetness.before_moving_walls(found, x, np.full(n, own), walls, np.array([1]), axes_of(2))
    np.testing.assert_allclose(apart, np.maximum(x[:, 0] - 0.52, 0.0), atol=1e-12)
    assert np.isinf(rest).all()


def test_elements_are_looked_for_again_where_particles_have_moved():
    """Walls rest: the lists of all are those of a search for all, after one particle has moved far and others a bit."""
    mesh = wall_mesh([Tank(1.0, 1.0)], S)
    x = np.concatenate([mesh.x0, np.random.default_rng(5).random((60, 2))])
    n, kinds = len(x), np.repeat(np.array([WALL, FLUID], np.int8), [len(mesh.x0), 60])

    def seen(*steps):
        elements, p = WallElements(mesh, 0, S), Particles(MPI.COMM_SELF, 2, FieldSet((*Boundary.fields, "wall_u")))
        none = np.zeros(n + 1, np.int32), np.zeros(0, np.int32)
        p.assign({"id": np.arange(n), "kind": kinds, "x": steps[0]})
        p.normal[:len(mesh.x0)] = mesh.normal0
        elements.settle(p, 10.0)
        for places in steps:
            p.x[:] = places
            elements.renew(p, 2.6 * S)
            elements.look(p, 2.6 * S, *none)
        return elements.walls

    later = x.copy()
    later[-1] = (0.02, 0.5) if x[-1, 0] > 0.5 else (0.98, 0.5)
    later[-30:-1] += 0.1 * S
    anew, updated = seen(later), seen(x, later)
    np.testing.assert_array_equal(updated.indptr, anew.indptr)
    np.testing.assert_array_equal(updated.indices, anew.indices)
    assert not np.array_equal(seen(x).indptr, anew.indptr)


@pytest.mark.parametrize("block", [False, True])
def test_nodes_at_rest_see_elements_only_where_something_is_hidden_and_water_is_near(block):
    """Lists of fluid are the same with and without nodes that need none; so are those of the other nodes."""
    walls = [Tank(1.0, 1.0), *([Obstacle(Box(width=0.2, height=0.2, at=(0.4, 0.0)))] if block else [])]
    mesh = wall_mesh(walls, S)
    nodes, fluid = len(mesh.x0), 0.05 + 0.3 * np.random.default_rng(6).random((40, 2))
    x, kind = np.concatenate([mesh.x0, fluid]), np.repeat(np.array([WALL, FLUID], np.int8), [nodes, 40])
    apart = (kind == WALL) & (x[:, 1] > 0.7)

    def seen(*sleeping):
        elements, p = WallElements(mesh, 0, S), Particles(MPI.COMM_SELF, 2, FieldSet((*Boundary.fields, "wall_u")))
        none = np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32)
        p.assign({"id": np.arange(len(x)), "kind": kind, "x": x})
        p.normal[:nodes] = mesh.normal0
        elements.settle(p, 10.0)
        for which in sleeping:
            elements.renew(p, 2.6 * S, which)
            elements.look(p, 2.6 * S, *none)
        found = elements.walls
        return [found.indices[a:b].tolist() for a, b in zip(found.indptr[:-1], found.indptr[1:])]

    every, fewer = seen(np.zeros_like(apart)), seen(apart)
    assert [bool(row) for row in every[:nodes]] == [block] * nodes
    assert all(fewer[i] == ([] if apart[i] else every[i]) for i in range(len(x)))
    assert seen(apart, np.zeros_like(apart)) == every    # the water has come near
