"""A solitary wave, made by a piston, runs up a slope of 60 degrees (Zheng et al. 2017, Sec. 6.1).

a/d = 0.6 in a tank of 10 m with the slope at its end, 1 m high. The pressure on the slope has its peak near
t sqrt(g/h) = 18.5, h = 1 m, and a second event, when the water runs down and overturns, near 22.5. Z17 does not print
the height of its sensor: `tap`. With the spacing of Z17, p1 has its peaks at 18.2 and 22.5, and the water climbs to
y = 0.70 m.

parisph run cases/solitary_slope.py        # 4 minutes on one core
mpirun -n 2 parisph run cases/solitary_slope.py --set spacing=0.008     # as Z17: 35 minutes on one core
"""

from math import radians, sqrt, tan

from parisph import (
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    PeakBand,
    Peaks,
    Piston,
    PressureTap,
    Profile,
    RunUp,
    SolitaryWave,
    StillWater,
    SurfaceGauge,
    Volume,
)


def case(
    spacing: float = 0.025,             # [m]; 0.008 in Z17
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 9.0,              # [s]
    time_step: float | None = None,     # [s]; none to adapt it
    height: float = 0.15,               # of the wave [m]
    angle: float = 60.0,                # of the slope [degrees]
    length: float = 10.0,               # of the tank [m]
    tap: float = 0.1,                   # height of the tap on the slope [m]
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.1,        # [s]
) -> Case:
    d, rise = 0.25, 1.0                 # depth, height of the slope [m]
    cotangent, unit = 1.0 / tan(radians(angle)), sqrt(rise / 9.81)
    printed = Peaks(
        (PeakBand(start=16.5 * unit, end=20.5 * unit, when=18.5 * unit),
         PeakBand(start=21.5 * unit, end=24.5 * unit, when=22.5 * unit)), name="Z17, Sec. 6.1",
        note="The paper prints no numbers but these times, and neither the height of its sensor nor when its time "
             "starts: here the piston starts at t = 0.",
    ) if (height, angle, length) == (0.15, 60.0, 10.0) else None
    toe = length - rise * cotangent
    return Case(
        title=f"Solitary wave on a slope of {angle:g} degrees, a/d = {height / d:g}",
        source="Zheng et al. (2017), Figs 14-16",
        fluid=Fluid(StillWater(level=d), density=1000.0),
        walls=(
            Profile([(-0.5, 0.0), (toe, 0.0), (length, rise)], name="bed"),
            Piston(at=0.0, wave=SolitaryWave(height=height, depth=d), name="piston"),
        ),
        gravity=(0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=snapshot_every, checkpoint_every=1.0),
        probes=[
            SurfaceGauge("middle", at=0.5 * length),
            SurfaceGauge("toe", at=toe),
            PressureTap("p1", at=(toe + tap * cotangent, tap), truth=printed, peak=True),
            RunUp("run_up", on="bed", side="right"),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
