"""A first run on three ranks, from an empty cache of compiled kernels: one rank compiles for all."""

from tests.launch import mpirun
from tests.scenes import PROGRAM
from tests.validation.record import Row

BODY = """
s = Simulation(scene("hydrostatic", {"preset": "violent"}, spacing=0.25), comm)
s.advance()
"""


def rows(bench):
    """Return how many kernels were compiled by more than one rank, and how many by a second run."""
    program = bench.folder / "cold_start.py"
    program.write_text(PROGRAM + BODY)
    found = []
    for what in ("first", "second"):
        done = mpirun(3, [program], timeout=600, cwd=bench.folder, NUMBA_DEBUG_CACHE="1",
                      NUMBA_CACHE_DIR=str(bench.folder / "kernels"))
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
        # lines of the ranks may run into each other: count what was said, not lines
        saved = [part.split("'")[0].rpartition("/")[2] for part in done.stdout.split("data saved to '")[1:]]
        if what == "first":
            twice = {name for name in saved if saved.count(name) > 1}
            found += [Row("cold start: kernels compiled", len(saved), 1, least=True),
                      Row("cold start: kernels that several ranks compiled", len(twice), 0)]
        else:
            found.append(Row("warm start: kernels compiled", len(saved), 0))
    return found
