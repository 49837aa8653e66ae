"""The tasks of a patch study, each an operator on one arrangement of particles, and their results."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from parisph.base.arrays import Flags, Floats
from parisph.base.errors import CaseError, SolverDiverged
from parisph.base.fields import SURFACE
from parisph.base.text import clipped, named, shown
from parisph.methods.parts import GRADIENTS, LAPLACIANS, SURFACE_GRADIENTS, WALL_ROWS
from parisph.patch import arrangement, derivatives
from parisph.patch.analytic import AnalyticField
from parisph.patch.arrangement import Arrangement
from parisph.patch.solution import solution
from parisph.study.patch_study import OF_GRADIENTS, OF_LAPLACIANS, ON_TANKS, SOLUTIONS, PatchStudy, cells_of
from parisph.truth import norms

NEAR_WALL = 2      # layers of fluid beside a wall
FROM_SURFACE = 4   # layers below a surface that are left out there, because their errors are not those of walls
AXES = "xyz"

# {name of a norm in tables: its definition}
NORMS = {
    "Er": "Er of Z14: sqrt(sum (error/amplitude)^2 m/rho)", "Er_max": "Er_max of Z14: largest error/amplitude",
    **{f"Er_{axis}": f"Er of Z17 Eq 33, {axis} component: sqrt(sum error^2)/N" for axis in AXES},
    "L2": "relative L2", "Linf": "largest error over largest value",
}


@dataclass(frozen=True)
class Operator:
    """An operator. kind : "laplacian" or "gradient"; word : in its registry

    further : word of the wall rows of a Laplacian, or of the gradient at the surface; or ""
    """

    kind: str
    word: str
    further: str = ""

    @property
    def label(self) -> str:
        """Name in tables."""
        return f"{self.further} (at the surface)" if self.kind == "gradient" and self.further else self.word

    @property
    def walls(self) -> str:
        """Word of the wall rows, or ""."""
        return self.further if self.kind == "laplacian" else ""

    @property
    def parts(self) -> tuple[Any, ...]:
        """Its parts. Raises KeyError for a word without a part."""
        kinds: tuple[Any, ...] = (LAPLACIANS, WALL_ROWS) if self.kind == "laplacian" else (GRADIENTS, SURFACE_GRADIENTS)
        return tuple(kind[word] for kind, word in zip(kinds, (self.word, self.further)) if word)


@dataclass(frozen=True)
class Task:
    """An operator on one arrangement of particles. jitter : k; patch : as of PatchStudy."""

    field: AnalyticField
    patch: str
    operator: Operator
    spacing: float
    jitter: float
    seed: int

    @property
    def group(self) -> tuple[str, ...]:
        """Key of its table: kind of operator, patch, field, and wall rows if there are walls."""
        return self.operator.kind, self.patch, self.field.name, *([self.operator.walls] if self.operator.walls else [])

    def described(self) -> str:
        """Return the task as text, for people."""
        walls = f" with {self.operator.walls} walls" if self.operator.walls else ""
        return (f"{self.operator.kind} {self.operator.label}{walls}, {self.patch}, {self.field.name}, "
                f"spacing {self.spacing:.4g}, k = {self.jitter:g}, seed {self.seed}")


@dataclass
class PatchResult:
    """The result of a task.

    particles : number of compared ones
    lost : number of these without a value, which norms leave out; in a solution, their row is the mean of their
        neighbours
    norms : {name in NORMS: number}; problem : reason if there is none, in one line
    sizes : (particles - lost,) |error| of Laplacians over their amplitude if a histogram needs them, else empty
    """

    task: Task
    particles: int = 0
    lost: int = 0
    norms: dict[str, float] = field(default_factory=dict)
    problem: str = ""
    sizes: Floats = field(default_factory=lambda: np.empty(0), repr=False)

    def line(self) -> dict[str, Any]:
        """Return the line of the table as {column: value}."""
        task, operator = self.task, self.task.operator
        return {"operator": operator.label, "walls": operator.walls, "kind": operator.kind, "patch": task.patch,
                "field": task.field.name, "spacing": task.spacing, "jitter": task.jitter, "seed": task.seed,
                "particles": self.particles, "lost": self.lost,
                **{name: self.norms.get(name) for name in NORMS}, "problem": self.problem}


def operators(study: PatchStudy, patch: str) -> list[Operator]:
    """Return the operators that are applied to a patch."""
    found = []
    if patch in OF_LAPLACIANS:
        walls = study.wall_rows if patch in ON_TANKS else ("",)
        found += [Operator("laplacian", word, further) for word in study.laplacians for further in walls]
    if patch in OF_GRADIENTS:
        found += [Operator("gradient", word) for word in study.gradients]
        if patch == "surface":
            found += [Operator("gradient", study.gradients[0], word) for word in study.surface_gradients]
    return found


def tasks(study: PatchStudy, only: Sequence[str] = ()) -> list[Task]:
    """Return the tasks, each once: a lattice without disorder needs only the first seed.

    only : words of operators, all if empty

    Raises CaseError: a word of `only` is not in the study, a word has no part, or a part does not work in this number
    of dimensions
    """
    there = (*study.laplacians, *study.gradients)
    for word in only:
        if word not in there:
            raise CaseError(f"--only {named(word)}: the study has no such operator (it has: {', '.join(there)})")
    found: dict[Task, None] = {}
    for analytic in study.analytic:
        for patch in study.patches:
            for operator in operators(study, patch):
                if only and operator.word not in only and operator.label not in only:
                    continue
                _check(operator, study.dim)
                for s, k, seed in _places(study, patch, operator):
                    found[Task(analytic, patch, operator, s, k, seed)] = None
    return list(found)


def _places(study: PatchStudy, patch: str, operator: Operator) -> Iterator[tuple[float, float, int]]:
    """Yield spacing, jitter and seed."""
    pairs = [(s, k) for sweep in study.sweeps for k in sweep.jitters for s in sweep.spacings]
    if patch == "interior" and operator.kind == "laplacian":
        pairs += [(one.spacing, one.jitter) for one in study.histograms]
    for s, k in pairs:
        for seed in study.seeds if k else study.seeds[:1]:
            yield s, k, seed


def _check(operator: Operator, dim: int) -> None:
    try:
        parts = operator.parts
    except KeyError as error:
        raise CaseError(f"{operator.kind} {shown(error.args[0])} is a word without a part: register it in the study "
                        "file, or in a file given with --parts") from None
    for part in parts:
        if dim not in part.dims:
            raise CaseError(f"{part.name!r} works in {' and '.join(f'{n}D' for n in part.dims)} only: "
                            f"leave it out with dim={dim}")


def apply(task: Task, study: PatchStudy) -> PatchResult:
    """Apply the operator of a task and return its errors. Not collective."""
    try:
        return _solution(task, study) if task.patch in SOLUTIONS else _derivative(task, study)
    except SolverDiverged as error:
        return PatchResult(task, problem=clipped(" ".join(str(error).split("\n")[0].split()), 160))


def _derivative(task: Task, study: PatchStudy) -> PatchResult:
    a, of = _arrangement(task, study), task.field
    f, which = of.values(a.x), _compared(a, task.patch, study.margin)
    if task.operator.kind == "laplacian":
        found, exact = derivatives.discrete(a, task.operator.word).derivative(f)[which], of.laplacians(a.x)[which]
    else:
        at_surface = task.operator.further or "same"
        found, exact = derivatives.gradient(a, f, task.operator.word, at_surface)[which], of.gradients(a.x)[which]
    sound = np.isfinite(found.reshape(len(found), -1)).all(axis=1)
    result = PatchResult(task, len(found), int(np.count_nonzero(~sound)))
    if not sound.any() or not exact[sound].any():
        result.problem = (
            "the exact value is zero: there is no relative error" if sound.any() else "no particle has a value")
        return result
    found, exact = found[sound], exact[sound]
    result.norms = dict(zip(("L2", "Linf"), norms.relative_l2_linf(found, exact)))
    if task.operator.kind == "laplacian":
        # the amplitude over the whole square, 80 pi^2 for the field of Z14
        amplitude, volume = float(np.abs(of.laplacians(a.x[a.inside])).max()), a.spacing**a.dim
        if any(one.spacing == task.spacing and one.jitter == task.jitter for one in study.histograms):
            result.sizes = np.abs(found - exact) / amplitude
        result.norms |= {"Er": norms.z14_er(found - exact, amplitude, volume),
                         "Er_max": norms.z14_er_max(found - exact, amplitude)}
    elif task.patch in ("interior", "square"):
        result.norms |= {f"Er_{AXES[b]}": norms.z17_er((found - exact)[:, b]) for b in range(a.dim)}
    return result


def _solution(task: Task, study: PatchStudy) -> PatchResult:
    a, of = _arrangement(task, study), task.field
    system = derivatives.discrete(a, task.operator.word, task.operator.further or "sfdi")
    f = of.values(a.x)
    gradient = of.gradients(a.x) if task.patch in ON_TANKS else None
    p = solution(system, f, of.laplacians(a.x), gradient)[a.inside]
    exact = f[a.inside]
    if task.patch == "closed":    # known up to a constant
        p, exact = p - p.mean(), exact - exact.mean()
    lost = int(np.count_nonzero(~(system.measure[a.inside] > 0.0)))
    result = PatchResult(task, len(p), lost)
    if not exact.any():
        result.problem = "the exact value is zero: there is no relative error"
        return result
    result.norms = dict(zip(("L2", "Linf"), norms.relative_l2_linf(p, exact)))
    return result


def _arrangement(task: Task, study: PatchStudy) -> Arrangement:
    cells = cells_of(task.spacing)
    if task.patch in ON_TANKS:
        return arrangement.tank([cells] * study.dim, task.jitter, task.seed, lid=task.patch == "closed",
                                spacing=1.0 / cells)
    layers = 0
    if task.patch == "dirichlet" or (task.patch == "interior" and study.beyond):
        layers = int(np.ceil(max(part.reach for part in task.operator.parts))) + 1
    return arrangement.block(cells, task.jitter, task.seed, study.dim, layers, centred=task.patch != "dirichlet")


def _compared(a: Arrangement, patch: str, margin: float) -> Flags:
    """Return whether particles are compared, (n,) bool."""
    found: Flags = a.inside
    if patch == "surface":
        found = a.role == SURFACE
    elif patch == "walls":
        beside = np.minimum(a.index, a.cells - a.index)
        beside[:, -1] = a.index[:, -1]    # the last axis ends at the surface
        found = a.inside & (beside.min(axis=1) <= NEAR_WALL) & (a.index[:, -1] <= a.cells[-1] - FROM_SURFACE)
    elif patch != "square":
        found = a.inside & np.all(np.abs(a.x - 0.5) <= 0.5 - margin, axis=1)
    return found
