"""From a case to a finished run: build, run, restart, describe."""

from importlib import import_module
from typing import Any

from parisph.base import libraries
from parisph.driver.preview import describe

# Loaded when first asked for: describing a case must work where there is no MPI.
_ENGINE = {"Simulation": "parisph.driver.simulation", "restart": "parisph.driver.loop", "run": "parisph.driver.loop"}

__all__ = ["describe", *_ENGINE]


def __getattr__(name: str) -> Any:
    """Load the engine for `run`, `restart` and `Simulation`. Raises MissingLibrary where there is none."""
    if name not in _ENGINE:
        raise AttributeError(f"module 'parisph.driver' has no attribute {name!r}")
    libraries.require(*libraries.ENGINE)
    value = getattr(import_module(_ENGINE[name]), name)
    globals()[name] = value
    return value
