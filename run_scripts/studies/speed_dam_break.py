"""Speed against error in the dam break: parisph beside two grid codes, and beside itself at commit bf3cce2.

    parisph study run_scripts/studies/speed_dam_break.py

About two minutes of CPU time, for three starts of 800 and 3200 particles. The points of the others are in
speed_dam_break.csv; their times are those of another day on the same kind of machine, so a factor of 1.4 says nothing.
"""

from dam_break_measures import against_code, energy_at

from parisph.study import Function, OtherCodes, Study

KEPT = energy_at(2.0)


def loss(run) -> float:
    """Return the part of the energy that is lost until t* = 2; the converged flow loses none."""
    return 1.0 - KEPT.of(run)


METHODS = ["ISPH_R"]

study = Study(
    title="Speed against error in the dam break",
    case="../../cases/dam_break.py",
    methods=METHODS,
    spacings=[1 / 40, 1 / 80],          # over H
    parameters={"end_time": 4.0, "jitter": 0.2},
    seeds=[1, 2, 3],
    errors=[against_code("Basilisk"), Function("loss of energy", of=loss)],
    others=[OtherCodes("speed_dam_break.csv", error="p2", of="P2, Basilisk"),
            OtherCodes("speed_dam_break.csv", error="loss", of="loss of energy")],
    levels={"P2, Basilisk": [0.07], "loss of energy": [0.04, 0.02]},
    histories=["P2", "energy"],
)
