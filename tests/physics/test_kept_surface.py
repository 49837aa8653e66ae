"""A surface that keeps its particles: a particle that flies off has its old role again when it returns."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE
from parisph.io import checkpoint
from parisph.kernels import gradient
from parisph.methods.operators import INFLATION, RAPID_INFLATION
from tests.scenes import scene, simulated

S = 0.1
# no shift and no collisions: they would push the particle where it is put among others
KEPT = {"surface_rule": "frozen", "shift": 0.0, "collision_distance": 0.0,
        "regularisers": ("filter", "collisions", "wall_guard", "parting", "keep_apart")}


def thrown(layer):
    """Return water at rest, and the id of a particle of a layer (10 is the surface) that is thrown up from the
    surface."""
    s = simulated(scene("hydrostatic", KEPT, spacing=S, end_time=1e3))
    s.solve_start()
    p = s.particles
    i = np.argmin(np.linalg.norm(p.x - [0.5, S * layer], axis=1))
    assert p.kind[i] == FLUID and p.role[i] == (SURFACE if layer == 10 else INNER)
    p.x[i] = [0.52, 1.05]
    p.u[i] = [0.0, 3.0]
    return s, int(p.id[i])


def role_of(s, number):
    return int(s.particles.role[s.particles.id == number][0])


@pytest.mark.parametrize(("layer", "role"), [(10, SURFACE), (8, INNER)])
def test_particle_that_is_back_among_others_has_its_role_back(layer, role):
    s, number = thrown(layer)
    seen = []
    for _ in range(300):
        s.advance()
        seen.append(role_of(s, number))
    height = s.particles.x[s.particles.id == number][0, 1]
    assert seen[0] != BALLISTIC and seen[-1] == role and height < 1.0 + S
    flying = np.flatnonzero(np.array(seen) == BALLISTIC)
    assert 20 < len(flying) < 250 and np.all(np.diff(flying) == 1), "one flight, from which it comes back for good"


def test_role_comes_back_after_a_restart(tmp_path):
    s, number = thrown(8)
    while role_of(s, number) != BALLISTIC:
        s.advance()
    path = checkpoint.write(s.comm, tmp_path, s.particles, s.time, s.steps, s.dt, s.case.model_dump_json(), {}, {})
    whole = [(s.advance(), role_of(s, number), s.particles.x[s.particles.id == number][0].copy()) for _ in range(150)]
    again = simulated(s.case, start=checkpoint.read(MPI.COMM_SELF, path))
    for _, role, x in whole:
        again.advance()
        assert role_of(again, number) == role
        np.testing.assert_allclose(again.particles.x[again.particles.id == number][0], x, atol=1e-6)
    assert role == INNER


@pytest.mark.parametrize(("rule", "most"), [("frozen", INFLATION), ("gap", RAPID_INFLATION)])
def test_harmonic_terms_have_a_lower_limit_where_the_surface_keeps_its_particles(rule, most, monkeypatch):
    """The tip of a tongue needs them: with the limit of gentle flow, P2 of the dam break is off by .12 to .21."""
    used, full = [], gradient.harmonic_gradient

    def watched(out, cloud, f, radius, sure, limit):
        used.append(limit)
        return full(out, cloud, f, radius, sure, limit)
    monkeypatch.setattr(gradient, "harmonic_gradient", watched)
    s = simulated(scene("hydrostatic", {"surface_rule": rule}, spacing=S, preset="violent", end_time=1.0))
    s.advance()
    assert used and set(used) == {most}
