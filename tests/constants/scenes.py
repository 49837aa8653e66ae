"""The scenes in which a tuned number is tried out, by the measures of the validation and of the hard cases."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

from parisph import Case, open_run, run
from tests.hard.flow import Bench
from tests.hard.obstacles import against
from tests.scenes import scene
from tests.validation import dam_break

SPACING, JITTER = 0.05, 0.2    # of the wave, of 800 particles: jittered, so that its regularisers have something to do
SHORT = 0.02                   # part of the time that compiles the kernels
DAM = {"P2 against Basilisk": "P2", "E(2)": "E(2)", "impulse": "impulse", "quiet": "noise", "volume": "volume"}

# of the box: the energy of one splash, which differs twentyfold between starts
SCATTERED = "largest rise of the energy above what it was before, over its start"


@dataclass(frozen=True)
class Scene:
    """A scene, its words, function(seed, part of the time) that returns {measure: value}, and the seeds of the starts
    that are tried, and of those of the base line: one where starts do not matter.

    absent : the preset that it does not have
    """

    what: str
    measures: Callable[[int, float], dict[str, float]]
    tried: tuple[int, ...]
    base: tuple[int, ...]
    absent: str


def dam(seed: int, part: float) -> dict[str, float]:
    """The violent dam break at H/s = 40: P2, energy, impulse, noise, the largest error of the volume, and steps."""
    case = scene("dam_break", spacing=dam_break.COARSE, seed=seed, jitter=dam_break.JITTER,
                 end_time=part * dam_break.QUIET[1], volume_every=1)
    return _of_run(case, lambda run: {} if part < 1.0 else {
        name: value for key, value in dam_break.measures(run).items() if (name := DAM.get(key))})


def wave(seed: int, part: float) -> dict[str, float]:
    """The gentle standing wave with adaptive steps: the error of the wave part, and steps."""
    case = scene("standing_wave", {"time_step": None}, spacing=SPACING, jitter=JITTER, seed=seed, end_time=9.0 * part)
    return _of_run(case, lambda run: {"error": run.summary["errors"]["centre"]["relative_l2"]} if part == 1.0 else {})


def box(seed: int, part: float) -> dict[str, float]:
    """The dam break against a box, to the impact on the far wall: the lines of the hard case, and steps."""
    bench = Bench(seed)
    lines = against(bench, "box", 800, 0.4, end=0.6 * part)
    return {line.what: line.value for line in lines if line.what != SCATTERED} | {"steps": float(bench.steps)}


def _of_run(case: Case, look: Callable) -> dict[str, float]:
    """Run a case, and return what `look` sees in the run, and the number of steps."""
    with tempfile.TemporaryDirectory(prefix="parisph-constants-") as folder:
        summary = run(case, MPI.COMM_SELF, Path(folder) / "run", progress=False)
        return {**look(open_run(Path(folder) / "run")), "steps": float(summary["steps"])}


STARTS = tuple(range(1, 13))
SCENES = {"dam": Scene("dam break", dam, dam_break.SEEDS, STARTS, "GENTLE"),
          "wave": Scene("standing wave", wave, (1,), (1,), "violent"),
          "box": Scene("dam break against a box", box, (1,), STARTS, "GENTLE")}
