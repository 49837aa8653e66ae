"""parisph: MPI-parallel incompressible SPH for violent water waves."""

from importlib import import_module
from pathlib import Path
from typing import Any

__version__ = "0.1.0"

# What `from parisph import ...` offers, and where it lives. Loaded when first asked for, so that
# `import parisph` costs nothing, and describing a case needs neither MPI nor PETSc.
_SCHEMA = (
    "Case Fluid StillWater Box Disc Polygon Tank Lid Profile Obstacle Plate Piston Flap Numerics Output PeakBand Peaks "
    "Truth AtRest Sway Heave Roll Moved Series Tabulated PistonStroke FlapStroke Sponge Relaxation "
    "Friction ProbeArray Profiles "
    "Airy Jonswap Sloshing SolitaryWave StandingWave Stokes StreamFunction WaveTruth"
)
# The module of a kind of probe is named after its class.
_PROBES = Path(__file__).parent.joinpath("watch", "probes").glob("[a-z]*.py")
_PUBLIC = {
    **{path.stem.removesuffix("_probe").title().replace("_", ""): f"parisph.watch.probes.{path.stem}"
       for path in sorted(_PROBES)},
    **{name: "parisph.case.schema" for name in _SCHEMA.split()},
    "load": "parisph.case.load",
    **{
        name: "parisph.base.errors"
        for name in ("ParisphError", "CaseError", "SolverDiverged", "ParticleLost", "StoreError", "Interrupted",
                     "MissingLibrary", "BadEnvironment")
    },
    **{name: "parisph.driver" for name in ("run", "restart", "Simulation")},
    "open_run": "parisph.io.reader",
}

__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'parisph' has no attribute {name!r}")
    value = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
