"""The message of a failed run: the cause, the step, and the worst particles."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from parisph.base.errors import Interrupted, ParisphError, ParticleLost, SolverDiverged, StoreError
from parisph.base.fields import FLUID
from parisph.case.numerics import ResolvedNumerics
from parisph.driver.simulation import Simulation
from parisph.parallel.particles import Particles

WORST = 5       # named particles
HUGE = 1e300    # faster than any particle


def explained(error: ParisphError, simulation: Simulation, last_checkpoint: Path | None,
              note: str | None = None) -> ParisphError:
    """Return the error, extended by the step, the worst particles and the last checkpoint. Collective.

    error : ParisphError, on every rank
    last_checkpoint : path or None
    note : a further line, for a lost particle or a diverged flow
    """
    if isinstance(error, (Interrupted, StoreError)):
        return error
    s = simulation
    lines = [str(error), f"  in step {s.steps + 1}, from t = {s.time:.6g} s"]
    bad = [t for t in s.comm.allgather(s.bad_force) if t is not None]
    if bad:
        lines.insert(0, f"the body force is not a finite number at t = {bad[0]:.6g} s: "
                        "see `gravity` and `frame` of the case")
    found = suspects(s, bad[0] if bad else None)
    if found:
        lines += ["  particles to look at:", *(f"    {line}" for line in found)]
    if note and isinstance(error, (ParticleLost, SolverDiverged)):
        lines.append(note)
    for_waves = s.numerics.wave_step or s.numerics.surface_rule == "frozen"
    if not bad and for_waves and isinstance(error, (ParticleLost, SolverDiverged)):
        lines.append(f"  {_beyond_range(s.numerics)}")
    if last_checkpoint:
        lines.append(f"  last good checkpoint: {last_checkpoint}")
    return type(error)("\n".join(lines))


def _beyond_range(numerics: ResolvedNumerics) -> str:
    """Return a remedy for numerics of non-breaking waves, and for surface_rule="frozen"."""
    frozen = numerics.surface_rule == "frozen"
    chosen = 'surface_rule="frozen"' if frozen else f'preset="{numerics.preset}"'
    instead = 'surface_rule="gap"' if frozen else 'preset="violent"'
    return f"{chosen} fails if waves break: use {instead}, a smaller spacing, or a smaller amplitude"


def suspects(simulation: Simulation, bad_force: float | None = None, count: int = WORST) -> list[str]:
    """Describe the worst particles: first those with non-finite values, then the fastest. Collective.

    bad_force : time [s] at which the body force is checked too, or None
    """
    s, p = simulation, simulation.particles
    speed = np.linalg.norm(p.u, axis=1)
    bad = ~(np.isfinite(p.x).all(axis=1) & np.isfinite(speed) & np.isfinite(p.p))
    if bad_force is not None:
        bad |= ~np.isfinite(s.case.body_force(p.x, bad_force)).all(axis=1)
    key = np.where(bad, np.where(p.kind == FLUID, np.inf, HUGE), np.nan_to_num(speed))
    worst = [i for i in np.argsort(-key, kind="stable")[:count] if key[i] > 0.0]
    mine = [(float(key[i]), _text(p, i)) for i in worst]
    found = sorted((item for part in p.comm.allgather(mine) for item in part), key=lambda item: -item[0])
    return [text for _, text in found[:count]]


def _text(p: Particles, i: int) -> str:
    def vector(values: Iterable[float]) -> str:
        return "(" + ", ".join(f"{value:.5g}" for value in values) + ")"

    return f"id {p.id[i]} role {p.role[i]} at {vector(p.x[i])} m, u {vector(p.u[i])} m/s, p {p.p[i]:.4g} Pa"
