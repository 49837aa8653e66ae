"""The same scene on 1, 2 and 3 ranks is the same flow."""

import numpy as np
import pytest

from tests.scenes import assert_same, on_one_and_more, on_ranks

# 20 steps each; the solver's tolerance is as tight as rounding allows, so that nothing else differs.
TIGHT = {"rtol": 1e-13}
SCENES = {
    "dam_break": dict(spacing=0.025, jitter=0.4),
    "small_sloshing": dict(spacing=0.1),
    "solitary_wave": dict(spacing=0.2, preset="violent"),    # from a stretched lattice
    # so small that it lies in two cells of the partition: one of three ranks has no particle
    "free_drop": dict(spacing=0.5),
    "rotating_patch": dict(spacing=0.1, jitter=0.4),
    "lid_driven_cavity": dict(spacing=0.05),
}
STEPS = 20

BODY = f"""
for name, sets in {SCENES!r}.items():
    s = Simulation(scene(name, {TIGHT!r}, **sets), comm)
    s.solve_start()
    start = s.gather("p")
    for _ in range({STEPS}):
        s.advance()
    owned = comm.gather(s.particles.n_owned)
    found = s.gather("x", "u", "p", "role", "kind")
    if comm.rank == 0:
        np.savez(f"{{name}}-{{comm.size}}.npz", start=start["p"], owned=owned, time=s.time, **found)
    s.destroy()
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ranks")
    on_one_and_more(BODY, folder)
    return {(name, n): np.load(folder / f"{name}-{n}.npz") for name in SCENES for n in (1, 2, 3)}


@pytest.mark.parametrize("ranks", [2, 3])
@pytest.mark.parametrize("name", SCENES)
def test_ranks_agree(results, name, ranks):
    one, more = results[name, 1], results[name, ranks]
    assert len(one["x"]) == len(more["x"]) == more["owned"].sum() and len(more["owned"]) == ranks
    assert np.abs(one["u"]).max() > 1e-4     # it has moved
    assert_same(one, more, fields=("start", "x", "u", "p"))


def test_ranks_have_particles_or_none(results):
    assert results["dam_break", 3]["owned"].min() > 200
    assert results["free_drop", 3]["owned"].min() == 0


# four ranks, and one of them alone
ADAPTIVE = """
for comm in (comm, MPI.COMM_SELF)[:2 if comm.rank == 0 else 1]:
    s = Simulation(scene("dam_break", {"rtol": 1e-13}, spacing=0.05, time_step="none"), comm)
    s.domain.tolerated = np.inf     # else each rank gets some fluid
    times = []
    for _ in range(5):
        s.advance()
        times.append(s.time)
    fluid = comm.gather(int((s.particles.kind == 0).sum()))
    everyone = comm.gather(times)
    if comm.rank == 0:
        np.savez(f"adaptive-{comm.size}.npz", fluid=fluid, times=everyone)
"""


def test_adaptive_step_is_the_same_on_all_ranks_also_without_fluid(tmp_path):
    on_ranks(4, ADAPTIVE, tmp_path)
    one, four = np.load(tmp_path / "adaptive-1.npz"), np.load(tmp_path / "adaptive-4.npz")
    assert four["fluid"].min() == 0, "a rank with walls only"
    assert np.all(four["times"] == four["times"][0])
    np.testing.assert_allclose(four["times"][0], one["times"][0], rtol=1e-9)


SLANTED = """
case = scene("dam_break", spacing=0.05, time_step="none").changed(gravity=("2*x", "-9.81*(1 + x)"))
s = Simulation(case, comm)
times = [s.advance() and s.time for _ in range(4)]
assert comm.allgather(times) == [times] * comm.size, comm.allgather(times)
"""


def test_adaptive_step_in_a_force_that_depends_on_the_place(tmp_path):
    on_ranks(2, SLANTED, tmp_path)


LATE = """
s = Simulation(scene("dam_break", spacing=0.05, time_step=0.006), comm)
p, ballistic = s.particles, 0
while s.time < 4.0 * 0.32:
    s.advance()
    ballistic += int((p.role == 5).sum())
    ghosts = p.role_all[p.n_owned:].copy()
    s.domain.update("role")
    assert np.array_equal(ghosts, p.role_all[p.n_owned:]), s.time
assert comm.allreduce(ballistic) > 0
"""


def test_ghosts_know_which_particles_fly_free(tmp_path):
    on_ranks(2, LATE, tmp_path)
