"""A flow that has exploded: a run stops there, rather than take ever shorter steps to its end."""

from collections.abc import Mapping

from parisph.base.errors import SolverDiverged
from parisph.driver.conservation import Conservation
from parisph.driver.doubts import LIMITS, advice

# Kinetic energy over all energy at the start, of a flow on which no work is done: it cannot be above 1. Explosions that
# calm down, with parts of methods that no preset has, were seen to come to 3.5; others went on to 1e5 and more within
# some hundred steps. All the water would have ten times the speed that its energy allows.
MOST = 100.0
RISES = ("energy", "motion", "grown")    # limits of conservation and doubts that tell of energy without a source


def check(conservation: Conservation, preset: str) -> None:
    """Raise SolverDiverged if the flow has exploded. Not collective: its numbers are the same on all ranks."""
    start, now = conservation.energy.start, conservation.kinetic.now
    if conservation.driven or start is None or now is None or not start > 0.0 or now <= MOST * start:
        return
    raise SolverDiverged(f"the kinetic energy has come to {now / start:.3g} times all energy at the start, though "
                         f"nothing does work on the fluid: the flow has exploded; {advice(LIMITS['motion'], preset)}")


def first_rise(passed: Mapping[str, float]) -> str | None:
    """Return when energy first rose beyond its limit, as a line of a message, None if it did not.

    passed : {limit: time [s] at which it was passed}
    """
    times = [passed[name] for name in RISES if name in passed]
    return f"  energy first rose beyond its limit at t = {min(times):.4g} s" if times else None
