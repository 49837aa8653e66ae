"""Water at rest in an open tank: nothing may move, and the pressure is rho g (d - y).

parisph run cases/hydrostatic.py --set jitter=0.4
"""

from math import sqrt

from parisph import Box, Case, Energy, Fluid, Numerics, Output, PressureTap, SurfaceGauge, Tank, Truth, Volume


def case(
    spacing: float = 0.05,              # particle spacing / d
    method: str = "ISPH_R",
    preset: str = "gentle",
    end_time: float = 10.0,             # t sqrt(g/d)
    time_step: float | None = 0.01,     # dt sqrt(g/d), or none to adapt it
    width: float = 1.0,                 # of the tank / d
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    g, density = 9.81, 1000.0           # [m/s2], [kg/m3]
    d = 1.0                             # depth [m]
    unit = sqrt(d / g)                  # [s]
    rest = Truth("exact/constant.csv", time="t_s", value="one", scale=density * g * d)
    level = Truth("exact/constant.csv", time="t_s", value="one", scale=d)
    return Case(
        title="Hydrostatic tank",
        fluid=Fluid(Box(width=width * d, height=d), density=density),
        walls=Tank(width=width * d, height=1.5 * d),
        gravity=(0.0, -g),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * d, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step * unit,
        ),
        output=Output(every=end_time * unit / 10, checkpoint_every=end_time * unit / 2),
        probes=[
            PressureTap("bed", at=(0.5 * width * d, 0.0), truth=rest),
            SurfaceGauge("middle", at=0.5 * width * d, truth=level),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time * unit,
    )
