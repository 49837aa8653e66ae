"""The same scene on 1, 2 and 3 ranks is the same flow."""

import numpy as np
import pytest

from tests.scenes import difference, on_ranks

# 20 steps each; the solver's tolerance is as tight as rounding allows, so that nothing else differs.
TIGHT = {"rtol": 1e-13}
SCENES = {
    "dam_break": dict(spacing=0.025),
    "small_sloshing": dict(spacing=0.1),
    # so small that it lies in two cells of the partition: one of three ranks has no particle
    "free_drop": dict(spacing=0.5),
    "rotating_patch": dict(spacing=0.1, jitter=0.4),
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
    for n in (1, 2, 3):
        on_ranks(n, BODY, folder)
    return {(name, n): np.load(folder / f"{name}-{n}.npz") for name in SCENES for n in (1, 2, 3)}


@pytest.mark.parametrize("ranks", [2, 3])
@pytest.mark.parametrize("name", SCENES)
def test_ranks_agree(results, name, ranks):
    one, more = results[name, 1], results[name, ranks]
    assert len(one["x"]) == len(more["x"]) == more["owned"].sum() and len(more["owned"]) == ranks
    np.testing.assert_array_equal(more["role"], one["role"])
    assert np.abs(one["u"]).max() > 1e-4     # it has moved
    for field in ("start", "x", "u", "p"):
        assert difference(more[field], one[field]) < 1e-9, field


def test_ranks_have_particles_or_none(results):
    assert results["dam_break", 3]["owned"].min() > 200
    assert results["free_drop", 3]["owned"].min() == 0
