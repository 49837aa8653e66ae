"""Dam break over a trapezoidal sill (Zheng et al. 2017, Sec. 6.3; measured by Ozmen-Cagatay & Kocaman 2011).

A reservoir of 4.65 m x 0.25 m empties into a dry flume. 1.5 m downstream the water meets a sill of 0.075 m: at 1.9 s
it jumps and passes over the crest, and from 2.8 s on a bore runs back upstream. Z17 says nothing of the crest's width.

parisph run cases/dam_break_sill.py        # 6 minutes on one core
mpirun -n 2 parisph run cases/dam_break_sill.py --set spacing=0.007      # as Z17: 24 minutes on one core
"""

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Numerics,
    Obstacle,
    Output,
    Polygon,
    PressureTap,
    SurfaceGauge,
    Tank,
    Volume,
    WaterFront,
)


def case(
    spacing: float = 0.0125,            # [m]; 0.007 in Z17
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 7.0,              # [s]
    time_step: float | None = None,     # [s]; none to adapt it
    crest: float = 0.3,                 # width of the sill's top [m]
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.1,        # [s]
) -> Case:
    dam, foot, base, height = 4.65, 6.15, 1.0, 0.075    # [m]
    side = 0.5 * (base - crest)
    sill = Polygon([(foot, 0.0), (foot + side, height), (foot + side + crest, height), (foot + base, 0.0)])
    return Case(
        title="Dam break over a trapezoidal sill",
        source="Zheng et al. (2017), Figs 22-24; Ozmen-Cagatay & Kocaman (2011)",
        fluid=Fluid(Box(width=dam, height=0.25), density=1000.0),
        walls=(Tank(width=9.0, height=0.34), Obstacle(sill, name="sill")),
        gravity=(0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=snapshot_every, checkpoint_every=1.0),
        probes=[
            SurfaceGauge("reservoir", at=2.0),
            SurfaceGauge("upstream", at=5.5, arrival=0.14),    # of the bore
            SurfaceGauge("crest", at=foot + 0.5 * base, arrival=height + 0.02),
            SurfaceGauge("downstream", at=8.0, arrival=0.02),
            PressureTap("face", at=(foot + 0.5 * side, 0.5 * height)),
            WaterFront("front"),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
