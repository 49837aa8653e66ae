"""A solitary wave meets an upright cylinder in a flume, or a pier across a part of it.

The cylinder, 0.3 m thick, is in `cylinder.stl`, which was made by `python cases/flume_3d.py`; it is closed and reaches
below the bed. The wave rises at its front, bends around it, and goes on. `before` is a gauge where the wave has not met
it yet, and is compared with the exact wave until its crest has passed by one metre.

mpirun -n 2 parisph run cases/flume_3d.py
mpirun -n 2 parisph run cases/flume_3d.py --set spacing=0.075 --set end_time=1     # coarse
parisph run cases/flume_3d.py --set pier=true
"""

from math import cos, pi, sin
from pathlib import Path

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Numerics,
    Obstacle,
    Output,
    SolitaryWave,
    StillWater,
    Surface,
    SurfaceGauge,
    Tank,
    VelocityPoint,
    Volume,
    WaveTruth,
)

DEPTH, LENGTH, BREADTH, HEIGHT = 0.3, 5.0, 1.0, 0.6     # of the water; of the flume [m]
PLACE, RADIUS = 3.0, 0.15                               # x of the axis, radius of the cylinder [m]


def case(
    spacing: float = 0.05,              # [m]
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 2.0,              # [s]
    time_step: float | None = None,     # [s]; none to adapt it
    height: float = 0.06,               # of the wave [m]
    pier: bool = False,                 # a pier of the same width instead of the cylinder
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.1,        # [s]
) -> Case:
    wave = SolitaryWave(height=height, depth=DEPTH, at=1.2)
    block = Obstacle(Box(width=2.0 * RADIUS, height=HEIGHT, at=(PLACE - RADIUS, 0.0)), name="pier",
                    across=(0.5 * BREADTH - RADIUS, 0.5 * BREADTH + RADIUS))
    passed = (1.7 + 1.0 - wave.at) / wave.celerity    # by a gauge at 1.7 m [s]
    truth = WaveTruth(wave, level=DEPTH, window=(0.0, min(passed, end_time)))
    side = 0.5 * (0.5 * BREADTH + RADIUS + BREADTH)
    return Case(
        title=f"Solitary wave on a {'pier' if pier else 'cylinder'}, a/d = {height / DEPTH:g}",
        fluid=Fluid(StillWater(level=DEPTH), density=1000.0, wave=wave),
        walls=[
            Tank(width=LENGTH, height=HEIGHT, breadth=BREADTH),
            block if pier else Surface("cylinder.stl", name="cylinder"),
        ],
        gravity=(0.0, 0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=snapshot_every, checkpoint_every=0.5),
        probes=[
            SurfaceGauge("before", at=(1.7, 0.5 * BREADTH), truth=truth),
            SurfaceGauge("front", at=(PLACE - 1.5 * RADIUS, 0.5 * BREADTH)),
            SurfaceGauge("side", at=(PLACE, side)),
            SurfaceGauge("behind", at=(PLACE + 1.5 * RADIUS, 0.5 * BREADTH)),
            VelocityPoint("beside", at=(PLACE, side, 0.5 * DEPTH)),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )


def write_stl(path: Path, sides: int = 24) -> None:
    """Write the surface of the cylinder, from below the bed to above the flume (ASCII STL)."""
    from trimesh import convex  # of the extra parisph[surfaces]

    radius = RADIUS * (2.0 * pi / (sides * sin(2.0 * pi / sides))) ** 0.5    # the polygon has the area of the circle
    convex.convex_hull([(PLACE + radius * cos(angle), 0.5 * BREADTH + radius * sin(angle), z)
                        for angle in (2.0 * pi * k / sides for k in range(sides)) for z in (-0.1, HEIGHT + 0.1)]
                       ).export(path, file_type="stl_ascii")


if __name__ == "__main__":
    write_stl(Path(__file__).with_name("cylinder.stl"))
