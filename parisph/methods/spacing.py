"""Shift that keeps the distances of neighbours even, for non-breaking waves."""

from typing import TYPE_CHECKING

from parisph.base.arrays import Floats
from parisph.case.numerics import ResolvedNumerics
from parisph.kernels import even_spacing, shifting
from parisph.methods import lengths, straining
from parisph.methods.further_shifts import Shift
from parisph.methods.parts import REGULARISERS
from parisph.methods.positions import CAP

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


class EvenShift(Shift):
    """Moves particles away from neighbours that are too close; velocities follow by their gradient."""

    name, words, carries = "shift_even", "even distances", True
    reach, fields = lengths.WALL, ("acceleration",)

    def needs(self, numerics: ResolvedNumerics) -> tuple[str, ...]:
        return (*self.fields, *straining.FIELDS)

    def write(self, move: Floats, flow: "Flow", dt: float) -> None:
        p = flow.particles
        across = p.acceleration - flow.step.force[:p.n_owned]
        even_spacing.even_out(move, flow.cloud, across, flow.walls.known_slopes(flow), self.strength(flow))
        shifting.limit_lengths(move, p.n_owned, CAP * flow.spacing, flow.axes)


REGULARISERS.register(EvenShift())
