"""A solitary wave that a piston makes in a flat tank (Zheng et al. 2017, Sec. 5.2, Figs 6 to 8).

a/d = 0.2 in a tank of 10 m. The piston moves as Goring's theory says, with the mean velocity of the wave where it is;
Z17 does not say how its own moved. The gauges are compared with the exact wave that this motion is made for: its crest
is where the piston is when this has gone half its way. Z17 compares with Boussinesq's wave, whose form is 5 % off.

parisph run cases/solitary_piston.py       # 20 s on one core
mpirun -n 2 parisph run cases/solitary_piston.py --set spacing=1/30     # as Z17 Fig 6: 3 minutes on one core
"""

from parisph import (
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    Piston,
    PistonStroke,
    Profile,
    SolitaryWave,
    StillWater,
    SurfaceGauge,
    Volume,
    WaveTruth,
)


def case(
    spacing: float = 1 / 16,            # particle spacing / d; 1/30 in Z17 Fig 6
    method: str = "ISPH_R",
    preset: str = "solitary",
    end_time: float = 5.0,              # [s]
    time_step: float | None = None,     # [s]; 0.001 in Z17; none to adapt it
    height: float = 0.2,                # a / d
    theory: str = "exact",              # of the piston's motion; "boussinesq" is that of Goring
    length: float = 10.0,               # of the tank [m]
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    d = 0.25                            # depth [m]
    wave = SolitaryWave(height=height * d, depth=d, theory=theory)
    stroke = PistonStroke(wave)
    truth = WaveTruth(stroke.made.model_copy(update={"theory": "exact"}), level=d)
    return Case(
        title=f"Solitary wave by a piston, a/d = {height:g}",
        source="Zheng et al. (2017), Figs 6-8",
        fluid=Fluid(StillWater(level=d), density=1000.0),
        walls=(
            Profile([(-0.5, 0.0), (length, 0.0), (length, 2.0 * d)], name="bed"),
            Piston(at=0.0, motion=stroke, side="right", name="piston"),
        ),
        gravity=(0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * d, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=0.25, checkpoint_every=1.0),
        probes=[
            *(SurfaceGauge(f"x{k}d", at=k * d, truth=truth) for k in (6, 13, 20) if k * d < length),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
