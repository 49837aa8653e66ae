"""What a step finds about the flow, and what its regularisers find for each other."""

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
    """What completes sums of kernels: present (M,) of elements, weight (n_all,) and area (n_all, dim) of particles, as
    for kernels.density."""

    present: Floats
    weight: Floats
    area: Floats


@dataclass(slots=True)
class StepState:
    """What one step finds, made anew when its forces are summed. Each stage writes its own part.

    particles : where they are then
    """

    particles: InitVar[Particles]
    time: float = 0.0    # at which the operators act [s]
    dt: float = 0.0    # length of the step [s], 0 for a look at an instant
    usual: float = 0.0    # its length if it were not shortened to meet a time [s]
    # forces
    force: Floats = field(init=False)    # (n_all, dim) [m/s^2]
    body_force: Floats = field(init=False)    # the part of it by gravity and the inertia of the tank, not to be changed
    absorbed: Floats = field(init=False)    # (n_owned, dim) the part by zones that absorb
    varies: bool = False    # whether the body force differs from place to place, the same on all ranks
    # surface
    completions: dict[int, Completion] = field(default_factory=dict)    # {`least` that counts: Boundary.completion}
    potential: Potential | None = None    # of the velocity at the start of the step, if a part needs it
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
        return force.strides[0] != 0 and bool(np.any(force != force[:1]))    # one row for all is the usual force


@dataclass(slots=True)
class Preparation:
    """What regularisers find for each other from one state of the particles, made anew by `regularising.prepare`."""

    pairs: dict[float, Cloud] = field(default_factory=dict)    # {distance [spacings]: Flow.close_pairs}
    dense: Floats | None = None    # positions.dense, once it is known
    surplus: tuple[Floats, Floats] | None = None    # positions.surplus, once it is known
    top_speed: float = 0.0    # of fluid, on all ranks [m/s], where a part has found it
