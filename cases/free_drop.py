"""A round drop in a straining flow, without tank or gravity, with or without a central force.

It stays an ellipse. parisph.case.waves.drop_half_axes gives the exact half axes.

parisph run cases/free_drop.py --set stiffness=1 --set end_time=4
"""

from parisph import Case, Disc, Energy, Fluid, Momentum, Numerics, Output, Volume


def case(
    spacing: float = 0.05,              # particle spacing / R
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 1.0,              # t times the rate of strain
    time_step: float | None = 0.01,     # dt times the rate of strain, or none to adapt it
    stiffness: float = 0.0,             # B of the central force -B^2 r, over the rate of strain
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    R = 1.0                             # radius [m]
    rate = 1.0                          # rate of strain [1/s]
    B2 = (stiffness * rate) ** 2        # [1/s2]
    return Case(
        title="Free drop in a straining flow",
        fluid=Fluid(Disc(radius=R), density=1000.0, velocity=(f"{rate}*x", f"-{rate}*y")),
        gravity=(f"-{B2}*x", f"-{B2}*y"),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * R, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step / rate,
        ),
        output=Output(every=end_time / rate / 20, checkpoint_every=end_time / rate / 2),
        probes=[Energy("energy"), Volume("volume", every=10), Momentum("momentum")],
        end_time=end_time / rate,
    )
