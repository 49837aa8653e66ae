"""Dam break against a box, as Koshizuka & Oka (1996) set it up.

A column of L x 2L, L = 0.146 m, falls in a tank 4L wide against a box of 24 mm x 48 mm that stands 2L from the left
wall. The water shoots up at the box and strikes the far wall: there is a jet, a cavity behind the box, and thin sheets.

parisph run cases/dam_break_box.py        # 40 s on one core
"""

from parisph import (
    Box,
    Case,
    ColumnHeight,
    Energy,
    Fluid,
    Numerics,
    Obstacle,
    Output,
    PressureTap,
    Tank,
    Volume,
)


def case(
    spacing: float = 0.00365,           # [m]; a part of 0.146, or the lattice first has to settle
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 0.6,              # [s]
    time_step: float | None = None,     # [s]; none to adapt it
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.02,       # [s]
) -> Case:
    L, side = 0.146, 0.024              # widths of the column and of the box [m]
    return Case(
        title="Dam break against a box",
        source="Koshizuka & Oka (1996)",
        fluid=Fluid(Box(width=L, height=2.0 * L), density=1000.0),
        walls=(
            Tank(width=4.0 * L, height=4.0 * L, lid=True),
            Obstacle(Box(width=side, height=2.0 * side, at=(2.0 * L, 0.0)), name="box"),
        ),
        gravity=(0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=snapshot_every, checkpoint_every=0.2),
        probes=[
            PressureTap("face", at=(2.0 * L, 0.5 * side)),
            PressureTap("wall", at=(4.0 * L, side)),
            ColumnHeight("column", at=0.0),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
