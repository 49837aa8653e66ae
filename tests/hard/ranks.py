"""The same flow on 1, 2, 3 and 5 ranks."""

import tempfile
from pathlib import Path

import numpy as np

from tests.hard.flow import Bench
from tests.hard.scene import Scene
from tests.hard.table import Line
from tests.scenes import difference, on_ranks

RANKS = (1, 2, 3, 5)
STEPS = 20
FLOWS = {"dam_break": dict(spacing=0.025, jitter=0.4), "rotating_patch": dict(spacing=0.05, jitter=0.4)}
SAME = 1e-9
BODY = f"""
import time
for name, sets in {FLOWS!r}.items():
    s = Simulation(scene(name, {{"rtol": 1e-13}}, **sets), comm)
    s.solve_start()
    for _ in range({STEPS}):
        s.advance()
    found = s.gather("x", "u", "p", "role")
    if comm.rank == 0:
        np.savez(f"{{name}}-{{comm.size}}.npz", **found)
    s.destroy()
seconds = comm.reduce(time.process_time())
if comm.rank == 0:
    print(seconds)
"""


def agree(bench: Bench) -> list[Line]:
    """The largest difference from one rank over 20 steps, in each flow."""
    with tempfile.TemporaryDirectory(prefix="parisph-hard-") as name:
        folder = Path(name)
        for n in RANKS:
            bench.cpu_seconds += float(on_ranks(n, BODY, folder, timeout=200))
            bench.steps += STEPS * len(FLOWS)
        return [line for flow in FLOWS for line in _compared(folder, flow)]


def _compared(folder, flow):
    found = {n: np.load(folder / f"{flow}-{n}.npz") for n in RANKS}
    for n in RANKS[1:]:
        worst = max(difference(found[n][field], found[1][field]) for field in ("x", "u", "p"))
        yield Line(f"{flow}, {n} ranks: largest difference of x, u, p after {STEPS} steps", worst, SAME)
        others = np.count_nonzero(found[n]["role"] != found[1]["role"])
        yield Line(f"{flow}, {n} ranks: particles with another role", others, 0)


SCENES = {"ranks": Scene("dam break and rotating patch on 1, 2, 3 and 5 ranks", agree)}
