"""The falling column with three radii of the circle of ISPH_R: the case of z14_fig10_circle.py."""

from pathlib import Path

from parisph import Case, load
from parisph.methods.operators import Rankine
from parisph.methods.parts import LAPLACIANS

DAM_BREAK = Path(__file__).resolve().parents[2] / "cases" / "dam_break.py"


class Circle07(Rankine):
    """With R = 0.7 s."""

    name, circle = "rankine_07", 0.7


class Circle09(Rankine):
    """With R = 0.9 s."""

    name, circle = "rankine_09", 0.9


for part in (Circle07(), Circle09()):
    LAPLACIANS.register(part)


def case(
    spacing: float = 1 / 60,            # particle spacing / H
    method: str = "ISPH_R",
    laplacian: str = "rankine",         # R = 0.5 s; rankine_07 or rankine_09 for the others
    end_time: float = 3.0,              # t sqrt(g/H)
) -> Case:
    whole = load(DAM_BREAK, {"spacing": spacing, "method": method, "end_time": end_time})
    return whole.changed(**{"numerics.laplacian": laplacian})
