"""Dam break with the impact measured by Hu & Kashiwagi (2004) (Zheng et al. 2017, Sec. 6.2).

A column of 0.68 m x 0.12 m in a tank of 1.18 m. The first peak at P2, 0.01 m above the bed of the right wall, comes
near 0.36 s; there are two peaks at this height, and one above it. At the left wall, P1, the pressure is nearly that of
still water. The papers do not print the tank's height.

parisph run cases/hu_kashiwagi.py        # 30 s on one core
mpirun -n 2 parisph run cases/hu_kashiwagi.py --set spacing=0.00125     # 17 minutes on one core; Z17 has 0.0012, which
                                                                        # divides neither length
"""

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    PeakBand,
    Peaks,
    PressureTap,
    Tank,
    Volume,
    WaterFront,
)

FIRST = Peaks(
    (PeakBand(start=0.25, end=0.5, when=0.36),), name="Z17, Sec. 6.2",
    note="The papers print no numbers but the time of the first peak, and no data is at hand. A second, later peak at "
         "this height comes from the wave that falls back.",
)


def case(
    spacing: float = 0.005,             # [m]; must divide 0.02: 0.01, 0.005, 0.004, 0.0025, 0.002, 0.00125, ...
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 1.0,              # [s]
    time_step: float | None = None,     # [s]; none to adapt it
    face: float = 0.0,                  # diameter of the taps [m]; two spacings if it is less
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.02,       # [s]
) -> Case:
    width = 1.18                        # of the tank [m]
    radius = max(0.5 * face, spacing)
    heights = (0.01, 0.02, 0.03, 0.04, 0.05)    # [m]
    return Case(
        title="Dam break, 0.68 m x 0.12 m (Hu & Kashiwagi)",
        source="Hu & Kashiwagi (2004); Zheng et al. (2017), Figs 18-20",
        fluid=Fluid(Box(width=0.68, height=0.12), density=1000.0),
        walls=Tank(width=width, height=0.36, lid=True),
        gravity=(0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=snapshot_every, checkpoint_every=0.2),
        probes=[
            *(PressureTap(f"P{side}_{1e3 * y:.0f}mm", at=(x, y), radius=radius,
                          truth=FIRST if (side, y) == (2, 0.01) else None, peak=(side, y) == (2, 0.01))
              for side, x in ((1, 0.0), (2, width)) for y in heights),
            WaterFront("front"),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
