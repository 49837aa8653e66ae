"""The names of parisph/__init__.py for type checkers, which do not see what is loaded when asked for."""

from parisph.base.errors import CaseError as CaseError
from parisph.base.errors import Interrupted as Interrupted
from parisph.base.errors import MissingLibrary as MissingLibrary
from parisph.base.errors import ParisphError as ParisphError
from parisph.base.errors import ParticleLost as ParticleLost
from parisph.base.errors import SolverDiverged as SolverDiverged
from parisph.base.errors import StoreError as StoreError
from parisph.case.load import load as load
from parisph.case.schema import Airy as Airy
from parisph.case.schema import AtRest as AtRest
from parisph.case.schema import Box as Box
from parisph.case.schema import Case as Case
from parisph.case.schema import ColumnHeight as ColumnHeight
from parisph.case.schema import Disc as Disc
from parisph.case.schema import Energy as Energy
from parisph.case.schema import Fluid as Fluid
from parisph.case.schema import Jonswap as Jonswap
from parisph.case.schema import Lid as Lid
from parisph.case.schema import Momentum as Momentum
from parisph.case.schema import Numerics as Numerics
from parisph.case.schema import Output as Output
from parisph.case.schema import Polygon as Polygon
from parisph.case.schema import PressureTap as PressureTap
from parisph.case.schema import Sloshing as Sloshing
from parisph.case.schema import SolitaryWave as SolitaryWave
from parisph.case.schema import StandingWave as StandingWave
from parisph.case.schema import Stokes as Stokes
from parisph.case.schema import StreamFunction as StreamFunction
from parisph.case.schema import SurfaceGauge as SurfaceGauge
from parisph.case.schema import Sway as Sway
from parisph.case.schema import Tabulated as Tabulated
from parisph.case.schema import Tank as Tank
from parisph.case.schema import Truth as Truth
from parisph.case.schema import VelocityProfile as VelocityProfile
from parisph.case.schema import Volume as Volume
from parisph.case.schema import WaterFront as WaterFront
from parisph.case.schema import WaveTruth as WaveTruth
from parisph.driver.loop import restart as restart
from parisph.driver.loop import run as run
from parisph.driver.simulation import Simulation as Simulation
from parisph.io.reader import open_run as open_run

__version__: str
