"""Small sloshing in a square tank that sways along its diagonal, in the tank's frame.

X = a0 (1 - cos(Omega t)) along (1, 1), a0 = 0.001 d, Omega = 0.8 omega_1. By linear theory the elevation is that of two
plane tanks, one along each side. The errors are those of the wave part.

mpirun -n 2 parisph run cases/sloshing_3d.py --set end_time=2
parisph run cases/sloshing_3d.py --set spacing=0.2                                # coarse
"""

from math import inf, pi, sqrt

from parisph import Box, Case, Energy, Fluid, Numerics, Output, SurfaceGauge, Sway, Tank, Truth, Volume
from parisph.case.waves import angular_frequency


def case(
    spacing: float = 0.1,               # particle spacing / d
    method: str = "ISPH_R",
    preset: str = "gentle",
    end_time: float = 10.0,             # [s]; the exact solution ends there
    time_step: float | None = None,     # dt sqrt(g/d); none: as in small_sloshing.py
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    g = 9.81                            # [m/s2]
    d = 0.5                             # depth [m]
    L = 2.0 * d                         # length and breadth of the tank [m]
    unit = sqrt(d / g)                  # [s]
    longest = inf
    if time_step is None:
        time_step = 0.12 if (method, preset) == ("ISPH_R", "gentle") else 0.064
        longest = 0.76 * sqrt(spacing)    # 0.76 sqrt(s/g), beyond which the correction of long steps fades
    places = {"corner": (0.0, 0.0), "quarter": (0.25 * L, 0.25 * L), "side": (0.0, 0.5 * L)}
    return Case(
        title="Small sloshing along the diagonal of a square tank",
        fluid=Fluid(Box(width=L, height=d), density=1000.0),
        walls=Tank(width=L, height=1.5 * d, breadth=L),
        gravity=(0.0, 0.0, -g),
        frame=Sway(amplitude=0.001 * d, frequency=0.8 * angular_frequency(pi / L, d, g), direction=(1.0, 1.0, 0.0)),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * d, jitter=jitter, seed=seed,
            time_step=min(time_step, longest) * unit,
        ),
        output=Output(every=end_time / 20, checkpoint_every=end_time / 4),
        probes=[
            *(SurfaceGauge(name, at=at, truth=Truth("exact/diagonal_sway.csv", time="t_s", value=f"{name}_m", offset=d,
                                                    wave=True, name="linear theory"))
              for name, at in places.items()),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
