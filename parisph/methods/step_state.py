"""Findings of a step about the flow, and of its regularisers for each other."""

from dataclasses import InitVar, dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from parisph.base.arrays import Floats
from parisph.kernels.potential_fit import Potential
from parisph.kernels.records import Cloud
from parisph.parallel.particles import Particles

if TYPE_CHECKING:
    from parisph.pressure.solver import SolveRecord


class Completion(NamedTuple):
    """Completion of kernel sums, as for kernels.density: present (M,) of elements, weight (n_all,), area (n_all, dim).
    """

    present: Floats
    weight: Floats
    area: Floats


@dataclass(slots=True)
class StepState:
    """Findings of one step, new for each sum of forces. Each stage writes its own part.

    particles : with their current positions
    """

    particles: InitVar[Particles]
    time: float = 0.0    # of the operators [s]
    dt: float = 0.0    # length of the step [s], 0 at an instant
    usual: float = 0.0    # its length if it were not shortened to meet a time [s]
    # forces
    force: Floats = field(init=False)    # (n_all, dim) [m/s^2]
    body_force: Floats = field(init=False)    # its part by gravity and the inertia of the tank, read-only
    absorbed: Floats = field(init=False)    # (n_owned, dim) its part by zones
    varies: bool = False    # whether the body force is non-uniform, the same on all ranks
    # surface
    completions: dict[int, Completion] = field(default_factory=dict)    # {`least` that counts: Boundary.completion}
    potential: Potential | None = None    # of the initial velocity, if a part needs it
    # correction
    by_pressure: Floats = field(init=False)    # (n_owned,) size of the acceleration by pressure alone [m/s^2]
    # strain (methods.straining), 0 if no part needs it
    strained: Floats = field(init=False)    # (n_owned,), also the next two
    rapid: Floats = field(init=False)
    doubt: Floats = field(init=False)
    whole: float = 1.0
    beyond_fit: Floats | None = None    # (n_owned, dim) [m/s] of kernels.strain.velocity_gradient, if a part needs it
    # regularisers
    collisions: int = 0    # pairs of owned particles that have collided
    position_solve: "SolveRecord | None" = None    # of the position projection

    def __post_init__(self, particles: Particles) -> None:
        self.force, self.body_force = np.zeros((2, *particles.x_all.shape))
        self.absorbed = np.zeros_like(particles.x)
        self.by_pressure, self.strained, self.rapid, self.doubt = np.zeros((4, particles.n_owned))

    @property
    def uneven(self) -> bool:
        """Whether the body force varies among the particles of this rank."""
        force = self.body_force
        return force.strides[0] != 0 and bool(np.any(force != force[:1]))    # mostly one broadcast row


@dataclass(slots=True)
class Preparation:
    """Findings of regularisers for each other from one state of the particles, new in each `regularising.prepare`."""

    pairs: dict[float, Cloud] = field(default_factory=dict)    # {distance [spacings]: Flow.close_pairs}
    dense: Floats | None = None    # of positions.dense
    top_speed: float = 0.0    # of fluid, on all ranks [m/s], if a part needs it
