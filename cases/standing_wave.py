"""Standing wave in a tank (Zheng et al. 2017, Sec. 5.3), against fully nonlinear potential flow.

It starts as in the paper: a flat surface with the velocities of linear theory (Eqs 37, 38).

parisph run cases/standing_wave.py --set spacing=0.05
"""

from math import pi, sqrt

from parisph import Box, Case, Energy, Fluid, Numerics, Output, SurfaceGauge, Tank, Truth, Volume
from parisph.case.waves import standing_wave_start


def case(
    spacing: float = 0.025,             # particle spacing / d
    method: str = "ISPH_R",
    preset: str = "gentle",
    end_time: float = 9.0,              # [s]
    time_step: float = 0.064,           # dt sqrt(g/d) at spacing = 0.05
    refine_time: bool = False,          # time step in proportion to the spacing
    amplitude: float = 0.025,           # a / d
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    g = 9.81                            # [m/s2]
    d = 1.0                             # depth [m]
    k = pi / d                          # wave number [1/m]
    step = time_step * sqrt(d / g) * (spacing / 0.05 if refine_time else 1.0)
    # The reference was computed for this amplitude only.
    known = abs(amplitude - 0.025) < 1e-12
    truth = Truth("exact/standing_wave.csv", time="t_s", value="eta_nonlinear_m", offset=d, wave=True)
    return Case(
        title="Standing wave, kd = pi",
        source="Zheng et al. (2017), Figs 9-12",
        fluid=Fluid(Box(width=2.0 * d, height=d), density=1000.0, velocity=standing_wave_start(amplitude * d, k, d, g)),
        walls=Tank(width=2.0 * d, height=1.5 * d),
        gravity=(0.0, -g),
        numerics=Numerics(method=method, preset=preset, spacing=spacing * d, jitter=jitter, seed=seed, time_step=step),
        output=Output(every=0.25, checkpoint_every=3.0),
        probes=[
            SurfaceGauge("centre", at=d, truth=truth if known else None),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
