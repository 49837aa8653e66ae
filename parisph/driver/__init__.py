"""From a case to a finished run: build, run, restart, describe."""

from parisph.driver.describe import describe
from parisph.driver.loop import restart, run
from parisph.driver.simulation import Simulation

__all__ = ["Simulation", "describe", "restart", "run"]
