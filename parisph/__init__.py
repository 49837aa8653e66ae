"""parisph: MPI-parallel incompressible SPH for violent water waves."""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from parisph.base.errors import *
    from parisph.case.load import load
    from parisph.case.schema import *
    from parisph.driver.loop import restart, run
    from parisph.driver.simulation import Simulation
    from parisph.io.reader import open_run
    from parisph.watch.probes.column_height import ColumnHeight
    from parisph.watch.probes.energy_probe import Energy
    from parisph.watch.probes.flux_probe import Flux
    from parisph.watch.probes.force_probe import Force
    from parisph.watch.probes.momentum import Momentum
    from parisph.watch.probes.pressure_tap import PressureTap
    from parisph.watch.probes.run_up import RunUp
    from parisph.watch.probes.surface_gauge import SurfaceGauge
    from parisph.watch.probes.velocity_point import VelocityPoint
    from parisph.watch.probes.velocity_profile import VelocityProfile
    from parisph.watch.probes.volume import Volume
    from parisph.watch.probes.water_front import WaterFront

__version__ = "0.1.0"

# Written out for type checkers.
__all__ = [
    "__version__",
    "Case", "Fluid", "StillWater", "Box", "Disc", "Ellipsoid", "Polygon", "Tank", "Lid", "Profile", "Obstacle",
    "Plate", "Piston", "Flap", "Surface", "Numerics", "Output", "PeakBand", "Peaks", "Truth", "AtRest", "Sway",
    "Heave", "Roll", "Pitch", "Yaw", "Turn", "Combined", "Moved", "Series", "Tabulated", "PistonStroke",
    "FlapStroke", "Sponge", "Relaxation", "SurfaceGauge", "PressureTap", "WaterFront", "ColumnHeight", "Energy",
    "Volume", "Momentum", "VelocityPoint", "VelocityProfile", "RunUp", "Force", "Flux", "Friction", "ProbeArray",
    "Profiles", "Airy", "Jonswap", "Sloshing", "SolitaryWave", "StandingWave", "Stokes", "StreamFunction",
    "TankMode", "WaveTruth",
    "load", "run", "restart", "Simulation", "open_run",
    "ParisphError", "CaseError", "SolverDiverged", "ParticleLost", "StoreError", "Interrupted", "MissingLibrary",
    "BadEnvironment",
]

if not TYPE_CHECKING:
    # Names are loaded on first use, so that `import parisph` is fast, and cases need neither MPI nor PETSc. The module
    # of a kind of probe is named after its class.
    _PUBLIC = {
        **dict.fromkeys(__all__[1:], "parisph.case.schema"),
        **{path.stem.removesuffix("_probe").title().replace("_", ""): f"parisph.watch.probes.{path.stem}"
           for path in Path(__file__).parent.joinpath("watch", "probes").glob("[a-z]*.py")},
        "load": "parisph.case.load", "open_run": "parisph.io.reader",
        **dict.fromkeys(("run", "restart", "Simulation"), "parisph.driver"),
        **dict.fromkeys(__all__[__all__.index("ParisphError"):], "parisph.base.errors"),
    }

    def __getattr__(name: str) -> object:
        if name not in _PUBLIC:
            raise AttributeError(f"module 'parisph' has no attribute {name!r}")
        value = getattr(import_module(_PUBLIC[name]), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
