"""All hard cases by name, in their order; and the quick selection, which the default tests run."""

from tests.hard import columns, dam, drops, obstacles, rectangles, swirls, symmetry, tanks, waves
from tests.hard.scene import Scene

PARTS = (dam, obstacles, columns, drops, rectangles, swirls, waves, tanks, symmetry)
SCENES: dict[str, Scene] = {name: scene for part in PARTS for name, scene in part.SCENES.items()}
SHORT = (obstacles, columns, rectangles, symmetry)
QUICK: dict[str, Scene] = {name: scene for part in SHORT for name, scene in part.QUICK.items()}


def chosen(words: list[str], among: dict[str, Scene]) -> list[str]:
    """Return the scenes that words name: `columns-1-wall`, or `columns` for all whose name begins so. All for no words.

    Raises ValueError: a word names none
    """
    for word in words:
        if not any(_fits(name, word) for name in among):
            raise ValueError(f"no case {word} (there are {', '.join(among)})")
    return [name for name in among if not words or any(_fits(name, word) for word in words)]


def _fits(name, word):
    return name == word or name.startswith(word + "-")
