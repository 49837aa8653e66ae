"""Weak scaling on this machine: 100 steps of the dam break with as many particles on every rank.

    parisph study run_scripts/studies/weak_scaling.py

About 20 s of CPU time with ranks on cores of their own. More ranks, on a cluster: scaling.slurm. Times are in
ms for a step, on the slowest rank: they would not change if nothing grew with the number of ranks.
"""

from math import sqrt

from scaling_measures import MEASURES

from parisph.study import Study, Variant

METHODS = ["ISPH_R"]
COLUMN = 40                 # particles in the width of the column on one rank: 3840 in all
STEPS = 100
RANKS = [1, 2, 4]


def shared(ranks: int) -> Variant:
    """Return the runs on some ranks, with `ranks` times the particles of one."""
    spacing = 0.5 / round(COLUMN * sqrt(ranks))
    return Variant(label=f"{ranks} rank{'s' * (ranks > 1)}", spacings=[spacing], ranks=[ranks],
                   parameters={"end_time": STEPS * 0.32 * spacing})    # the case's step is 0.32 spacings


study = Study(
    title="Weak scaling, dam break",
    case="../../cases/dam_break.py",
    methods=METHODS, parameters={"jitter": 0.2}, variants=[shared(ranks) for ranks in RANKS],
    errors=MEASURES, histories=["P2"],
)
