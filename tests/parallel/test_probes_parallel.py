"""Probes of particles that are spread over ranks give what one rank with all of them gives, on every rank."""

from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from parisph import (
    Box,
    Case,
    ColumnHeight,
    Disc,
    Energy,
    Fluid,
    Flux,
    Force,
    Momentum,
    Numerics,
    Obstacle,
    PressureTap,
    ProbeArray,
    RunUp,
    SurfaceGauge,
    Tank,
    VelocityPoint,
    VelocityProfile,
    Volume,
    WaterFront,
)
from parisph.base.errors import CaseError
from parisph.base.fields import FLUID, SURFACE, WALL
from parisph.driver.solid_walls import elements_of
from parisph.kernels.cells import neighbour_lists
from parisph.parallel.particles import Particles
from parisph.watch import instruments
from parisph.watch.sampling import ProbeScene
from tests.driver.test_flux import counted_and_behind, over_a_plate
from tests.watched import DENSITY, G, Watch, scene

ALL = [
    *(SurfaceGauge(name=f"gauge{k}", at=at) for k, at in enumerate((0.0, 0.123, 0.5, 0.72, 1.0))),
    *(PressureTap(name=f"tap{k}", at=at) for k, at in enumerate(((0.0, 0.21), (0.5, 0.0), (1.0, 0.4)))),
    WaterFront(name="front"), ColumnHeight(name="left", at=0.0), ColumnHeight(name="middle", at=0.52),
    Energy(name="energy", current=True), Volume(name="volume"), Momentum(name="momentum"),
    VelocityProfile(name="line", start=(0.1, 0.3), end=(0.9, 0.2), points=9),
    VelocityPoint(name="point", at=(0.4, 0.3)), RunUp(name="left_side", side="left"),
    Force(name="load", about=(0.3, 0.1)), Flux(name="through", start=(0.4, 0.0), end=(0.5, 1.0)),
    RunUp(name="up", points=[(1.0, 0.0), (1.0, 1.0)]), PressureTap(name="disc", at=(0.45, 0.0), diameter=0.3),
    ProbeArray(name="several", probes=[SurfaceGauge(name="a", at=0.3), Force(name="b", side="bed"), Volume(name="c")]),
]
ALL_IN_3D = [
    *(SurfaceGauge(f"gauge{k}", at=at) for k, at in enumerate(((0.0, 0.0), (0.123, 0.4), (0.5, 0.5), (0.72, 0.31)))),
    *(PressureTap(f"tap{k}", at=at) for k, at in enumerate(((0.0, 0.21, 0.2), (0.45, 0.0, 0.3), (0.7, 0.33, 0.1)))),
    WaterFront("front"), WaterFront("front_at", y=0.2), ColumnHeight("corner", at=(1.0, 0.6)),
    Energy("energy"), Volume("volume"), Momentum("momentum"),
    VelocityProfile("line", start=(0.1, 0.3, 0.1), end=(0.9, 0.2, 0.3), points=5), RunUp("side", side="left", y=0.3),
    RunUp("up", points=[(1.0, 0.0), (1.0, 1.0)], y=0.2), Force("tank"), Force("box", on="box", about=(0.3, 0.1, 0.2)),
    Flux("through", start=(0.4, 0.0), end=(0.5, 1.0)), Flux("beside", start=(0.5, 0.1, 0.0), end=(0.6, 0.4, 0.5)),
    ProbeArray("several", probes=[SurfaceGauge("a", at=(0.3, 0.2)), Force("b", side="back"), Volume("c")]),
]
WAVE = {"spacing": 0.025, "elevation": "0.04*cos(3*pi*x)", "velocity": ("sin(pi*x)", "y"), "jitter": 0.5}


def pressed(arrays):
    """Give each particle a pressure that depends on its place."""
    arrays["p"][:] = DENSITY * G * (0.5 - arrays["x"][:, -1]) * np.cos(3.0 * arrays["x"][:, 0])


def stir(p, by):
    """Move the fluid by up to `by` [m], whatever the rank and the order of its particles."""
    fluid = p.kind == FLUID
    phase = 7.0 * p.id[fluid]
    p.x[fluid] += by * np.stack([np.cos(phase), np.sin(phase)], axis=1)
    p.u[fluid] += np.stack([np.sin(phase), np.cos(phase)], axis=1)


def same_as_on_one_rank(comm, watch, alone):
    found, truth = watch.sample(), alone.sample()
    assert list(found) == list(truth)
    for name in truth:
        for other in comm.allgather(found[name]):
            np.testing.assert_array_equal(other, found[name], err_msg=name)
        np.testing.assert_allclose(found[name], truth[name], rtol=1e-12, atol=1e-12, err_msg=name)
    return found


@pytest.mark.parametrize("shape", ["wave", "column", "drop"])
def test_ranks_agree_with_each_other_and_with_one(comm, shape):
    options = {"wave": WAVE, "column": {"width": 0.5, "depth": 0.9, "spacing": 0.025, "jitter": 0.8},
               "drop": {"shape": Disc(radius=0.2, at=(0.5, 0.225)), "spacing": 0.025}}[shape]
    case = scene(ALL, **options)
    watch, alone = Watch(case, comm, pressed), Watch(case, MPI.COMM_SELF, pressed)
    found = same_as_on_one_rank(comm, watch, alone)
    assert found["energy"][1] > 0.0 and found["volume"][1] > 10
    # a flat column is as high at its wall as inside, however disordered; the others are not flat
    assert (found["middle"] == found["left"]) == (shape == "column")
    watch.destroy()


def test_ranks_agree_in_3d(comm):
    case = Case(title="box", fluid=Fluid(Box(1.0, 0.5), DENSITY, elevation="0.04*cos(pi*x)*cos(pi*y/0.6)",
                                         velocity=("sin(pi*x)", "y", "z")),
                walls=(Tank(1.0, 1.0, breadth=0.6),
                       Obstacle(Box(0.2, 0.2, breadth=0.3, at=(0.5, 0.2, 0.0)), name="box")),
                gravity=(0.0, -G), numerics=Numerics(spacing=0.05, jitter=0.5), probes=ALL_IN_3D, end_time=1.0)
    watch, alone = Watch(case, comm, pressed), Watch(case, MPI.COMM_SELF, pressed)
    found = same_as_on_one_rank(comm, watch, alone)
    assert found["energy"][1] > 0.0 and found["volume"][1] > 10 and abs(found["box"][2]) > 10.0
    watch.destroy()


def test_the_force_on_a_body_whose_nodes_are_on_all_ranks(comm):
    case = scene([]).changed(walls=[Tank(1.0, 1.0), Obstacle(Disc(0.2, at=(0.5, 0.25)), name="stone")],
                             probes=[Force("load", on="stone"), Force("right", side="right", about=(1.0, 0.0))])
    watch, alone = Watch(case, comm, pressed), Watch(case, MPI.COMM_SELF, pressed)
    assert abs(same_as_on_one_rank(comm, watch, alone)["load"][1]) > 10.0
    watch.destroy()


def test_after_particles_have_moved_and_changed_owners(comm):
    case = scene(ALL, **WAVE)
    watch, alone = Watch(case, comm, pressed), Watch(case, MPI.COMM_SELF, pressed)
    plans = watch.domain.n_plans
    for _ in range(3):
        for each in (watch, alone):
            stir(each.particles, 0.006)
            each.domain.refresh()
        same_as_on_one_rank(comm, watch, alone)
    assert watch.domain.n_plans > plans
    watch.destroy()


def test_volume_sees_ghosts_where_they_are_now(comm):
    """As after a step: positions have changed since ghosts and lists were made."""
    case = scene([Volume(name="volume")], spacing=0.025)
    watch, alone = Watch(case, comm), Watch(case, MPI.COMM_SELF)
    before = watch.sample()["volume"]
    for each in (watch, alone):
        stir(each.particles, 0.004)
    ghosts = watch.particles.x_all[watch.particles.n_owned:].copy()
    found = same_as_on_one_rank(comm, watch, alone)["volume"]
    assert abs(found[0] - before[0]) > 1e-6
    assert comm.size == 1 or not np.array_equal(ghosts, watch.particles.x_all[watch.particles.n_owned:])
    watch.destroy()


def test_water_in_many_pieces_on_many_ranks(comm):
    """Each rank sees pieces only; together they are one body with a gap or two."""
    def torn(arrays):
        x, y = arrays["x"][:, 0], arrays["x"][:, 1]
        gone = (arrays["kind"] == FLUID) & (((x > 0.61) & (x < 0.69)) | ((y > 0.31) & (y < 0.39)))
        for name in arrays:
            arrays[name] = arrays[name][~gone]

    case = scene([WaterFront(name="front"), ColumnHeight(name="column", at=0.3)], spacing=0.025)
    watch = Watch(case, comm, torn)
    found = watch.sample()
    assert found["front"] == pytest.approx((0.6,)) and found["column"] == pytest.approx((0.3,))
    watch.destroy()


def test_ranks_without_particles_take_part(comm):
    case = scene(ALL, **WAVE)
    alone = Watch(case, MPI.COMM_SELF, pressed)
    mine = slice(None if comm.rank == comm.size - 1 else 0)  # all of them on the last rank
    p = Particles(comm, 2)
    p.assign({name: getattr(alone.particles, name)[mine] for name in alone.particles.fields})
    radius = alone.domain.radius
    indptr, indices = neighbour_lists(p.x_all, p.n_owned, radius)
    elements = elements_of(case, p)
    elements.settle(p, radius)
    elements.renew(p, radius)
    elements.look(p, radius, indptr, indices)
    domain = SimpleNamespace(indptr=indptr, indices=indices, radius=radius, elements=elements, update=lambda *n: None)
    found, truth = instruments.sample_all(alone.samplers, p, domain, 0.0), alone.sample()
    assert p.n_owned == (alone.particles.n_owned if comm.rank == comm.size - 1 else 0)
    for name in truth:
        np.testing.assert_allclose(found[name], truth[name], rtol=1e-12, atol=1e-12, err_msg=name)


def test_what_exists_in_2d_only_is_refused_on_every_rank(comm, monkeypatch):
    real = ProbeScene.of
    cube = ProbeScene(3, 0.1, np.full(3, 0.1), 1.0, np.zeros(3), np.ones(3), True, np.zeros(3))
    last = comm.rank == comm.size - 1
    monkeypatch.setattr(Volume, "dims", (2,))
    monkeypatch.setattr(ProbeScene, "of", classmethod(lambda cls, case: cube if last else real(case)))
    with pytest.raises(CaseError, match="'volume': volume exists in 2D only"):
        instruments.build(scene([Volume(name="volume")]), comm)



def test_a_surface_particle_of_another_rank_is_near(comm):
    """Deep means deep under all surface particles, those of other ranks too."""
    def spotted(arrays):
        arrays["role"][(arrays["id"] % 97 == 0) & (arrays["kind"] != WALL)] = SURFACE

    case = scene([Volume(name="volume")], spacing=0.025, lid=True, depth=1.0)
    watch, alone = Watch(case, comm, spotted), Watch(case, MPI.COMM_SELF, spotted)
    count = same_as_on_one_rank(comm, watch, alone)["volume"][1]
    assert 0.7 * 39 * 39 < count < 39 * 39
    watch.destroy()


def test_what_passed_a_rim_on_ranks_is_what_lies_behind_it(comm):
    counted, behind = counted_and_behind(over_a_plate(0.36), comm)
    assert behind > 0.0 and counted == pytest.approx([behind, -behind], rel=1e-12)
