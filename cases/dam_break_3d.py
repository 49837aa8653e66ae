"""Dam break on a dry bed in 3D: the slab of `dam_break.py`, or a column in the corner of a tank.

A column of L x H, H = 2 L = 1 m, falls in a tank 4 L long. Across the slab nothing changes, so that it is compared with
the same solutions in 2D. With `column` narrower than the breadth it stands in a corner, and the water spreads.

mpirun -n 2 parisph run cases/dam_break_3d.py
mpirun -n 2 parisph run cases/dam_break_3d.py --set breadth=2 --set column=0.5 --set spacing=0.1     # in a corner
"""

from math import sqrt

from parisph import (
    Box,
    Case,
    ColumnHeight,
    Energy,
    Fluid,
    Momentum,
    Numerics,
    Output,
    PressureTap,
    Tank,
    Truth,
    Volume,
    WaterFront,
)


def case(
    spacing: float = 0.05,              # particle spacing / H
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 4.0,              # t sqrt(g/H)
    time_step: float | None = None,     # dt sqrt(g/H), none to adapt it
    breadth: float = 0.6,               # of the tank / H
    column: float | None = None,        # breadth of the column / H, none for that of the tank
    cfl: float = 1.5,
    rtol: float = 1e-4,
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.1,        # in sqrt(H/g)
) -> Case:
    g, H = 9.81, 1.0                    # [m/s2], height of the column [m]
    L, D, B = 0.5 * H, 2.0 * H, breadth * H    # width of the column, length and breadth of the tank [m]
    unit = sqrt(H / g)                  # [s]
    slab = column is None or column >= breadth
    across = B if column is None or slab else column * H
    impact = _computed("P2", 1000.0 * g * H, (1.4, 3.4), unit)
    energy = _computed("E", 500.0 * g * H * H * L * B, (0.0, 2.3), unit)
    return Case(
        title="Dam break in 3D, H/L = 2, D/L = 4" + ("" if slab else ", in a corner"),
        fluid=Fluid(Box(width=L, height=H, breadth=across), density=1000.0),
        walls=Tank(width=D, height=2.0 * H, breadth=B, lid=True),
        gravity=(0.0, 0.0, -g),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * H, cfl=cfl, rtol=rtol, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step * unit,
        ),
        output=Output(every=snapshot_every * unit, checkpoint_every=unit),
        probes=[
            PressureTap("P1", at=(0.0, 0.5 * across, 0.1 * H)),
            PressureTap("P2", at=(D, 0.5 * B, 0.05 * H), radius=max(0.0375 * H, spacing * H),
                        truth=impact if slab else None),
            WaterFront("front"),
            ColumnHeight("column", at=(0.0, 0.5 * across)),
            Energy("energy", truth=energy if slab else None),
            Volume("volume", every=10),
            Momentum("momentum"),
        ],
        end_time=end_time * unit,
    )


def _computed(what: str, scale: float, window: tuple[float, float], unit: float) -> Truth:
    """Return the series of both grid codes in 2D; window : in sqrt(H/g)."""
    def of(code: str, name: str, others: tuple[Truth, ...] = ()) -> Truth:
        return Truth("computed/dam_break_vof.csv", time="t_star", value=f"{what}_{code}", scale=scale, time_scale=unit,
                     window=(window[0] * unit, window[1] * unit), name=name, others=others)

    return of("basilisk_256", "Basilisk, 256 cells", (of("interfoam_25600", "interFoam, 25,600 cells"),))
