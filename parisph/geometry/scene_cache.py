"""A cache of what depends on the geometry of a scene."""

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import TypeVar

from parisph.case.scene import Scene

_T = TypeVar("_T")


def cached(maxsize: int) -> Callable[[Callable[[Scene], _T]], Callable[[Scene], _T]]:
    """Return a decorator that keeps the results of a function of a scene for the last `maxsize` scenes.

    Scenes that differ only by their probes are the same. A probe with a truth cannot be a key of a dictionary.
    """
    def decorate(function: Callable[[Scene], _T]) -> Callable[[Scene], _T]:
        kept = lru_cache(maxsize)(function)

        @wraps(function)
        def found(case: Scene) -> _T:
            return kept(case.model_copy(update={"probes": ()}) if case.probes else case)

        setattr(found, "cache_clear", kept.cache_clear)
        return found
    return decorate
