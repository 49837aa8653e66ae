"""All hard cases by name, in their order; and the quick selection, which the default tests run."""

from typing import NamedTuple

from tests.hard import columns, dam, drops, obstacles, rectangles, swirls, symmetry, tanks, waves
from tests.hard.scene import Scene
from tests.hard.table import Outcome

PARTS = (dam, obstacles, columns, drops, rectangles, swirls, waves, tanks, symmetry)
SCENES: dict[str, Scene] = {name: scene for part in PARTS for name, scene in part.SCENES.items()}
SHORT = (obstacles, columns, rectangles, symmetry)
QUICK: dict[str, Scene] = {name: scene for part in SHORT for name, scene in part.QUICK.items()}


class Start(NamedTuple):
    """One start of a hard case, a job (tests.apart)."""

    name: str
    seed: int = 1
    quick: bool = False

    @property
    def scene(self) -> Scene:
        """The case."""
        return (QUICK if self.quick else SCENES)[self.name]

    @property
    def what(self) -> str:
        """A few words for people."""
        return self.scene.what

    @property
    def limit(self) -> float:
        """Wall time [s]."""
        return self.scene.limit

    def outcome(self) -> Outcome:
        """Compute it."""
        return self.scene.outcome(self.name, self.seed)
