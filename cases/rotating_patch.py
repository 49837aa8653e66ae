"""A square patch of fluid in rotation, without tank or gravity (Colagrossi 2005).

The corners move outwards and the pressure in the middle is negative: a hard test of the free surface.

parisph run cases/rotating_patch.py --set spacing=0.05
"""

from parisph import Box, Case, Energy, Fluid, Momentum, Numerics, Output, Volume


def case(
    spacing: float = 0.025,             # particle spacing / L
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 2.0,              # t omega
    time_step: float | None = None,     # dt omega, or none to adapt it
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    L = 1.0                             # side of the patch [m]
    omega = 1.0                         # rate of rotation, clockwise [rad/s]
    return Case(
        title="Rotating square patch",
        source="Colagrossi (2005)",
        fluid=Fluid(
            Box(width=L, height=L, at=(-0.5 * L, -0.5 * L)), density=1000.0, velocity=(f"{omega}*y", f"-{omega}*x"),
        ),
        gravity=(0.0, 0.0),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * L, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step / omega,
        ),
        output=Output(every=end_time / omega / 20, checkpoint_every=end_time / omega / 2),
        probes=[Energy("energy"), Volume("volume", every=10), Momentum("momentum")],
        end_time=end_time / omega,
    )
