"""From a case to a finished run: build, run, restart, describe."""

from importlib import import_module
from typing import TYPE_CHECKING

from parisph.base import libraries
from parisph.driver.preview import describe

__all__ = ["Simulation", "describe", "restart", "run"]

if TYPE_CHECKING:
    from parisph.driver.loop import restart, run
    from parisph.driver.simulation import Simulation
else:
    def __getattr__(name: str) -> object:
        """Load the engine on first use: describing a case must work without MPI.

        Raises MissingLibrary if MPI is missing.
        """
        if name not in __all__:
            raise AttributeError(f"module 'parisph.driver' has no attribute {name!r}")
        libraries.require(*libraries.ENGINE)
        value = getattr(import_module(f"parisph.driver.{'simulation' if name == 'Simulation' else 'loop'}"), name)
        globals()[name] = value
        return value
