"""Regular waves over a submerged bar, as Beji & Battjes (1993) and Dingemans (1994) measured them.

The water is 0.4 m deep. The bar rises with 1:20 from 6 m to a crest 0.1 m below the surface at 12 m, and falls with
1:10 from 14 m on: on it the waves steepen, and behind it they fall apart into shorter ones. A sponge of two of their
lengths takes them up where the experiments have a beach of 1:25, a wedge of 2.3 degrees whose tip is not
resolved. There is no data beside parisph; seaward of the bar the wave is compared with stream-function theory. Heights
with s = 25 mm are 1 to 3 % less than with 17 mm up to the bar's crest, and 3 to 5 % behind it.

parisph run cases/submerged_bar.py        # 6 minutes on one core
mpirun -n 2 parisph run cases/submerged_bar.py --set spacing=0.0125
"""

from parisph import (
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    Piston,
    Profile,
    Sponge,
    StillWater,
    StreamFunction,
    SurfaceGauge,
    Volume,
    WaveTruth,
)


def case(
    spacing: float = 0.025,             # [m]
    method: str = "ISPH_R",
    preset: str = "gentle",
    end_time: float = 40.0,             # [s]
    time_step: float | None = 0.01,     # [s]; none to adapt it
    height: float = 0.02,               # of the waves [m]
    period: float = 2.02,               # [s]
    sponge: float = 7.5,                # its length [m]: two of the waves, at this period
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.5,        # [s]
) -> Case:
    d, crest, top = 0.4, 0.3, 0.6       # depth, height of the bar, height of the walls [m]
    begin, end = 20.0, 20.0 + sponge
    wave = StreamFunction(height=height, period=period, depth=d, closed=True)
    # from the first full wave at 4 m until the reflection of the bar's crest is there
    seaward = WaveTruth(wave, level=d, window=(8.0, 12.0)) if period == 2.02 else None
    bed = [(-0.5, 0.0), (6.0, 0.0), (12.0, crest), (14.0, crest), (17.0, 0.0), (end, 0.0), (end, top)]
    return Case(
        title=f"Waves over a submerged bar, H = {1e3 * height:g} mm, T = {period:g} s",
        source="Beji & Battjes (1993), Dingemans (1994)",
        fluid=Fluid(StillWater(level=d), density=1000.0),
        walls=(
            Profile(bed, name="bed"),
            Piston(at=0.0, wave=wave, name="piston"),
        ),
        gravity=(0.0, -9.81),
        absorb=Sponge(begin, sponge),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
            wall_guard=0.25,    # else the piston squeezes the last particle through its toe after some periods
        ),
        output=Output(every=snapshot_every, checkpoint_every=5.0),
        probes=[
            SurfaceGauge("x4m", at=4.0, truth=seaward),
            *(SurfaceGauge(f"x{x:g}m", at=x) for x in (10.5, 12.5, 13.5, 14.5, 15.7, 17.3, 19.0)),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
