"""A hard case: what is computed and measured."""

import traceback
from collections.abc import Callable
from dataclasses import dataclass

from parisph.base.errors import ParisphError, unforeseen
from tests.hard.flow import Bench
from tests.hard.table import Line, Outcome


@dataclass(frozen=True)
class Scene:
    """One hard case, computed in a process of its own.

    what : a few words for people
    measure : function(Bench) that computes it and returns list of Line
    limit : wall time [s] after which it is ended
    may_stop : whether it may stop with an error that names cause and remedy instead
    jittered : whether its start depends on the seed
    """

    what: str
    measure: Callable[[Bench], list[Line]]
    limit: float = 600.0
    may_stop: bool = False
    jittered: bool = False

    def outcome(self, name: str, seed: int = 1) -> Outcome:
        """Compute the case and return its Outcome, also if it fails."""
        bench, found = Bench(seed), Outcome(name, may_stop=self.may_stop, seed=seed)
        try:
            found.lines = self.measure(bench)
        except Exception as error:
            traceback.print_exc()
            stopped = isinstance(error, ParisphError) and not unforeseen(error)
            found.ended = f"{'stopped' if stopped else 'failed'}: {type(error).__name__}: {error}"
        found.steps, found.cpu_seconds = bench.steps, bench.cpu_seconds
        return found
