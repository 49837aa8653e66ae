"""Violent sloshing in a swaying tank, in the tank's frame (Zheng, Ma & Duan 2014, Sec. 3.2.2, Figs 21 to 23).

L = 0.6 m, h = 0.5 L, d = 0.4 h; X = a0 (1 - cos(Omega t)) with a0 = 0.05 m and T0 = 1.5 s, as Kishev, Hu & Kashiwagi.
There is no reference series: the paper shows that surfaces and pressures of several spacings agree (Fig 21), and
shifts the time of the experiment so that peaks coincide (Fig 23).

mpirun -n 2 parisph run cases/violent_sloshing.py --set spacing=0.01     # a minute on one core
"""

from math import pi, sqrt

from parisph import Box, Case, Energy, Fluid, Numerics, Output, PressureTap, SurfaceGauge, Sway, Tank, Volume


def case(
    spacing: float = 0.005,             # [m]: 0.005, 0.004, 1/300, 1/350 for 2880, 4500, 6480, 8820 particles
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 7.5,              # [s], five periods
    time_step: float | None = 0.008,    # dt sqrt(g/d) at spacing = 0.005, in proportion to it; none to adapt it
    amplitude: float = 0.05,            # a0 [m]
    period: float = 1.5,                # T0 [s]
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.05,       # [s]
) -> Case:
    g = 9.81                            # [m/s2]
    L = 0.6                             # length of the tank [m]
    h = 0.5 * L                         # height of the tank [m]
    d = 0.4 * h                         # depth of the water [m]
    return Case(
        title=f"Violent sloshing, a0 = {amplitude:g} m, T0 = {period:g} s",
        source="Zheng, Ma & Duan (2014), Figs 21-23",
        fluid=Fluid(Box(width=L, height=d), density=1000.0),
        walls=Tank(width=L, height=h, lid=True),
        gravity=(0.0, -g),
        frame=Sway(amplitude=amplitude, frequency=2.0 * pi / period),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step * spacing / 0.005 * sqrt(d / g),
        ),
        output=Output(every=snapshot_every, checkpoint_every=0.5),
        probes=[
            PressureTap("P_upper", at=(0.0, L / 6.0), peak=True),
            PressureTap("P_lower", at=(0.0, L / 12.0)),
            SurfaceGauge("left", at=0.1 * L),
            SurfaceGauge("right", at=0.9 * L),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
