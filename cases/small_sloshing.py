"""Small sloshing in a swaying tank, in the tank's frame (Zheng, Ma & Duan 2014, Sec. 3.2.1).

X = a0 (1 - cos(Omega t)), a0 = 0.001 d, Omega = 0.8 omega_1. The error is that of the wave part. The
paper's error is relative to depth and wave together, where 0.0004 is already 18 % of the wave.

parisph run cases/small_sloshing.py --set spacing=0.1
"""

from math import inf, pi, sqrt

from parisph import Box, Case, Energy, Fluid, Numerics, Output, SurfaceGauge, Sway, Tank, Truth, Volume
from parisph.case.waves import angular_frequency


def case(
    spacing: float = 0.05,              # particle spacing / d: 0.1, 0.05, 0.025 for 200, 800, 3200 particles
    method: str = "ISPH_R",
    preset: str = "gentle",
    end_time: float = 50.0,             # t sqrt(g/d)
    time_step: float | None = None,     # dt sqrt(g/d) at spacing = 0.05; none: see below
    refine_time: bool = False,          # time step in proportion to the spacing
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    g = 9.81                            # [m/s2]
    d = 0.5                             # depth [m]
    L = 2.0 * d                         # length of the tank [m]
    unit = sqrt(d / g)                  # [s]
    longest = inf
    if time_step is None:    # other methods leave more divergence in long steps, other presets do not correct these
        time_step = 0.12 if (method, preset) == ("ISPH_R", "gentle") else 0.064
        longest = 0.76 * sqrt(spacing)    # 0.76 sqrt(s/g), beyond which the correction fades
    step = min(time_step * (spacing / 0.05 if refine_time else 1.0), longest)
    omega_1 = angular_frequency(pi / L, d, g)
    truth = Truth("exact/small_sloshing.csv", time="t_s", value="eta_nonlinear_m", offset=d, wave=True)
    return Case(
        title="Small sloshing, Omega = 0.8 omega_1",
        source="Zheng, Ma & Duan (2014), Figs 17-20",
        fluid=Fluid(Box(width=L, height=d), density=1000.0),
        walls=Tank(width=L, height=1.5 * d),
        gravity=(0.0, -g),
        frame=Sway(amplitude=0.001 * d, frequency=0.8 * omega_1),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * d, jitter=jitter, seed=seed,
            time_step=step * unit,
        ),
        output=Output(every=end_time * unit / 20, checkpoint_every=end_time * unit / 4),
        probes=[SurfaceGauge("left", at=0.0, truth=truth), Energy("energy"), Volume("volume", every=10)],
        end_time=end_time * unit,
    )
