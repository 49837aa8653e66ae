"""A hard case: what is computed and measured."""

from collections.abc import Callable
from dataclasses import dataclass

from tests.hard.flow import Bench
from tests.hard.table import Line


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
