"""Lateral impact of water in a rolling tank: SPHERIC test 10 (Souto-Iglesias, Botia-Vera et al. 2011), in 2D.

The tank of 900 x 508 mm holds 93 mm of water, and rolls about the middle of its bottom as measured: its
period is .85 of the first natural one. The sensor is at the level of the still water on the left wall. Four waves hit
it. Peaks of such impacts scatter: each is compared with the band in which 95 % of 102 repeats lie. There is no air in
parisph, so that a cavity that closes at the wall collapses completely, with a spike of one step; `wide` is less
sensitive to it than `sensor`. The means over 5 ms of the four peaks, 4.7, 4.0, 7.9 and 6.8 kPa, lie in their bands (2.6
to 5.6, 3.1 to 8.4, 2.7 to 8.7 and 3.0 to 8.2 kPa). Of the peaks themselves, 23.7, 8.3, 33.3 and 21.8 kPa, only the
second does; the others are 18.0, 24.6 and 13.6 kPa beyond. The flow is computed in the frame of the tank. The same test
with oil is left out: its motion and the properties of the oil are not at hand.

The motion is not part of parisph: see the parameter `data`.

mpirun -n 2 parisph run cases/lateral_roll.py        # 12 minutes on one core
parisph run cases/lateral_roll.py --set spacing=0.00465 width=0.9021        # three minutes
"""

from math import pi

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    PeakBand,
    PressureTap,
    Roll,
    Series,
    SurfaceGauge,
    Tank,
    Truth,
    Volume,
)
from parisph.case.measured_data import measured, needed
from parisph.case.truths import read_truth

MOTION = "04a_spheric10_water_lateral_roll_motion.csv"
NOTE = (
    "Others: interFoam has a first peak of 4688 Pa (the mean of the experiments is 3710), and DualSPHysics with "
    "particles of 2 mm errs by 19.5 % in the mean of three peaks. Each band has 95 % of the peaks of 102 repeats of "
    "the experiment, as they were measured, also where the run is smoothed."
)
TIMES = (2.375, 4.067, 5.672, 7.303)    # of the four peaks in the reference run [s]


def case(
    spacing: float = 0.003,             # [m]; must divide 93 mm and the width: 0.003, 0.0015, 0.001
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 8.35,             # [s], as long as the motion was measured
    time_step: float | None = None,     # [s]; none to adapt it
    density: float = 998.0,             # [kg/m3]
    width: float = 0.9,                 # [m]; 0.9021, 0.2 % more, for a spacing of 0.00465
    face: float = 0.006,                # diameter of the sensor [m]
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.05,       # [s]
    data: str = "",                     # folder of the measured data, "" for ../shared/reference/measured
) -> Case:
    depth = 0.093                       # [m]
    motion = needed(MOTION, "the measured motion of the tank", data)
    angle = Series(file=motion, time="t_s", value="roll_deg", scale=pi / 180.0)
    return Case(
        title="Lateral impact in a rolling tank (SPHERIC 10, water)",
        source="SPHERIC test 10, Souto-Iglesias, Botia-Vera et al. (2011)",
        fluid=Fluid(Box(width=width, height=depth), density=density),
        walls=Tank(width=width, height=spacing * round(0.508 / spacing), lid=True),
        gravity=(0.0, -9.81),
        frame=Roll(angle, centre=(0.5 * width, 0.0)),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=snapshot_every, checkpoint_every=0.5),
        probes=[
            PressureTap("sensor", at=(0.0, depth), radius=0.5 * face, peak=True, truth=_pressure(data)),
            PressureTap("wide", at=(0.0, depth), truth=_pressure(data)),    # a face of six spacings
            PressureTap("bottom", at=(0.0, 0.5 * depth)),
            SurfaceGauge("left", at=0.1 * width),
            SurfaceGauge("right", at=0.9 * width),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )


def _pressure(data: str) -> Truth | None:
    """Return the run whose peaks are nearest to the mean of all, and the bands of the peaks of 102 runs."""
    file = measured("04b_spheric10_water_lateral_pressure.csv", data)
    if file is None:
        return None
    return Truth(file, time="t_s", value="p_Pa", name="experiment, one run", note=NOTE, peaks=_bands(data))


def _bands(data: str) -> tuple[PeakBand, ...]:
    file = measured("04d_spheric10_repeatability_stats.csv", data)
    if file is None:
        return ()
    low, high = (
        read_truth(Truth(file, time="peak", value=name, scale=100.0, rows={"case": "water_lateral"}))[1]    # of mbar
        for name in ("p2.5", "p97.5")
    )
    return tuple(
        PeakBand(start=time - 0.4, end=time + 0.4, low=low[k], high=high[k], smooth=smooth)
        for smooth in (None, 0.005) for k, time in enumerate(TIMES)
    )
