"""A solitary wave meets a breakwater with a round head, whose surface is in an STL file.

The breakwater stands at the front of a flume 1 m broad and closes 0.43 m of it at the level of the water, with slopes
of 1 : 1.25. The wave runs up its side, and bends around its head. `breakwater.stl` is closed and reaches below the bed
and beyond the front wall, so that the flume cuts it; it was made by `python cases/breakwater_stl.py`.

mpirun -n 2 parisph run cases/breakwater_stl.py
mpirun -n 2 parisph run cases/breakwater_stl.py --set spacing=0.075      # coarse
"""

from math import cos, pi, sin
from pathlib import Path

from parisph import (
    Case,
    Energy,
    Fluid,
    Force,
    Numerics,
    Output,
    SolitaryWave,
    StillWater,
    Surface,
    SurfaceGauge,
    Tank,
    VelocityPoint,
)

DEPTH, LENGTH, BREADTH, HEIGHT = 0.3, 4.0, 1.0, 0.6     # of the water; of the flume [m]


def case(
    spacing: float = 0.05,              # [m]
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 3.0,              # [s]
    time_step: float | None = None,     # [s]; none to adapt it
    height: float = 0.1,                # of the wave [m]
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.1,        # [s]
) -> Case:
    return Case(
        title=f"Solitary wave on a breakwater, a/d = {height / DEPTH:g}",
        fluid=Fluid(StillWater(level=DEPTH), density=1000.0,
                    wave=SolitaryWave(height=height, depth=DEPTH, at=0.8)),
        walls=[
            Tank(width=LENGTH, height=HEIGHT, breadth=BREADTH),
            Surface("breakwater.stl", name="breakwater"),
        ],
        gravity=(0.0, 0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(every=snapshot_every, checkpoint_every=0.5),
        probes=[
            VelocityPoint("slope", at=(1.9, 0.1, 0.2)),
            VelocityPoint("head", at=(2.4, 0.85, 0.12)),
            SurfaceGauge("before", at=(1.4, 0.5 * BREADTH)),
            SurfaceGauge("behind", at=(3.4, 0.5 * BREADTH)),
            Force("load", on="breakwater", still=DEPTH),
            Energy("energy"),
        ],
        end_time=end_time,
    )


def write_stl(path: Path, sides: int = 24) -> None:
    """Write the surface of the breakwater: a mound with its crest along y, half of a cone at its end (ASCII STL)."""
    from trimesh import convex  # of the extra parisph[surfaces]

    points = []
    for radius, z in ((0.61, -0.04), (0.06, 0.4)):
        points += [(2.4 - radius, -0.2, z), (2.4 + radius, -0.2, z)]
        points += [(2.4 + radius * sin(angle), 0.25 + radius * cos(angle), z)
                   for angle in (pi * (k / sides - 0.5) for k in range(sides + 1))]
    convex.convex_hull(points).export(path, file_type="stl_ascii")


if __name__ == "__main__":
    write_stl(Path(__file__).with_name("breakwater.stl"))
