"""Flow in a square cavity, driven by its lid, from rest to a steady vortex (Z14 Sec. 3.3, Ghia, Ghia and Shin 1982).

The probes `vertical` and `horizontal` give velocity and pressure on the two lines through the centre.

parisph run cases/lid_driven_cavity.py --set reynolds=400 --set spacing=1/60 --set end_time=40
"""

from parisph import Box, Case, Energy, Fluid, Lid, Numerics, Output, Tank, VelocityProfile, Volume


def case(
    spacing: float = 0.02,              # particle spacing / side
    reynolds: float = 100.0,            # speed of the lid times side over viscosity
    method: str = "ISPH_R",
    preset: str = "closed",
    end_time: float = 30.0,             # t U / side
    time_step: float = 0.25,            # dt U / spacing, at most
    points: int = 41,                   # of each profile
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    side, speed = 1.0, 1.0              # [m], [m/s]
    s = spacing * side
    return Case(
        title=f"Lid-driven cavity, Re = {reynolds:g}",
        source="Zheng, Ma & Duan (2014), Sec. 3.3; Ghia, Ghia & Shin (1982)",
        fluid=Fluid(Box(width=side, height=side), density=1.0, viscosity=speed * side / reynolds),
        walls=Tank(width=side, height=side, lid=Lid(speed), no_slip=True),
        gravity=(0.0, 0.0),
        numerics=Numerics(method=method, preset=preset, spacing=s, time_step=time_step * s / speed,
                          jitter=jitter, seed=seed),
        output=Output(every=end_time * side / speed / 10, probe_interval=0.1 * side / speed),
        probes=[
            VelocityProfile("vertical", start=(0.5 * side, 0.0), end=(0.5 * side, side), points=points),
            VelocityProfile("horizontal", start=(0.0, 0.5 * side), end=(side, 0.5 * side), points=points),
            Energy("energy"), Volume("volume"),
        ],
        end_time=end_time * side / speed,
    )
