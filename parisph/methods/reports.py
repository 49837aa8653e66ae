"""Report of a step: a line of steps.csv."""

from dataclasses import dataclass, fields
from typing import Any, ClassVar

UNITS = {"dt": "s", "setup_seconds": "s", "solve_seconds": "s"}


@dataclass(frozen=True)
class StepReport:
    """The results of one step of any method.

    dt [s]; surface : number of fluid particles with p = 0; left : particles that have left an open tank over its rim
    since the start of the run; works : None, or the energy that the fluid gained by each part of the step, {column: J,
    in 2D J/m} (methods.budget)
    """

    dt: float
    surface: int = 0
    left: int = 0
    works: dict[str, float] | None = None

    LAST: ClassVar[tuple[str, ...]] = ("left", "works")

    @classmethod
    def columns(cls) -> dict[str, str]:
        """Return {column: unit} of its line, without energies."""
        names = [field.name for field in fields(cls) if field.name not in cls.LAST]
        return {name: UNITS.get(name, "") for name in (*names, "left")}

    def line(self) -> dict[str, Any]:
        """Return {column: value} of its line in steps.csv."""
        return {name: getattr(self, name) for name in self.columns()} | (self.works or {})

    def words(self) -> str:
        """Return its part of the progress line."""
        return ""

    @property
    def fallbacks(self) -> int:
        """Number of solves in the step that needed a fallback solver."""
        return 0


@dataclass(frozen=True)
class ProjectionReport(StepReport):
    """The results of one step of a projection method.

    iterations, residual, reason, fallback, rebuilt, setup_seconds, solve_seconds : of the pressure solve
    divergence : rms of div u after the step times dt; collisions : pairs that collided
    isolated : particles in groups without contact with a free surface
    position_iterations, position_residual, position_fallback : of the position projection; 0, 0 and "" without one
    """

    iterations: int = 0
    residual: float = 0.0
    reason: int = 0
    fallback: str = ""
    rebuilt: bool = False
    setup_seconds: float = 0.0
    solve_seconds: float = 0.0
    divergence: float = 0.0
    isolated: int = 0
    collisions: int = 0
    position_iterations: int = 0
    position_residual: float = 0.0
    position_fallback: str = ""

    @classmethod
    def columns(cls) -> dict[str, str]:
        """Return {column: unit} of its line, without energies, in the order of older runs."""
        names = ("dt", "iterations", "residual", "reason", "fallback", "rebuilt", "setup_seconds", "solve_seconds",
                 "divergence", "surface", "isolated", "collisions", "position_iterations", "position_residual",
                 "position_fallback", "left")
        return {name: UNITS.get(name, "") for name in names}

    def words(self) -> str:
        """Return its part of the progress line."""
        return f"{self.iterations} iterations  div u dt {self.divergence:.1e}"

    @property
    def fallbacks(self) -> int:
        """Number of solves in the step that needed a fallback solver."""
        return (self.fallback != "") + (self.position_fallback != "")
