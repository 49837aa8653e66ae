"""A ball of fluid in a straining flow in 3D, without tank or gravity, with or without a central force.

It stays an ellipsoid with three half axes. parisph.case.waves.ellipsoid_half_axes gives the exact ones, the rates of
strain, and the pressure in the centre. The probe `rate` is compared with the exact velocity, the energy with its start.

parisph run cases/drop_3d.py --set spacing=0.2                                    # coarse
parisph run cases/drop_3d.py --set stiffness=1 --set end_time=4
"""

from math import pi

from parisph import Case, Ellipsoid, Energy, Fluid, Momentum, Numerics, Output, Truth, VelocityPoint, Volume

FREE, FORCED = (0.5, 0.5, -1.0), (0.4, -0.1, -0.3)      # rates of strain without and with a force [1/s]


def case(
    spacing: float = 0.1,               # particle spacing / R
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 1.0,              # [s]; the exact solution ends at 2 s, with a force at 12 s
    time_step: float | None = 0.01,     # [s], or none to adapt it
    stiffness: float = 0.0,             # B of the central force -B^2 r [1/s]; known for 0 and 1
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    R = 1.0                             # radius [m]
    u, v, w = FREE if stiffness == 0.0 else FORCED
    B2 = stiffness**2                   # [1/s2]
    # Kinetic energy, rho volume/10 times the sum of squared speeds at the ends of the half axes. That of the central
    # force does not count.
    energy = 1000.0 * 4.0 / 3.0 * pi * R**5 * 0.1 * (u * u + v * v + w * w)
    name = "straining" if stiffness == 0.0 else "central_force"
    rate = Truth(f"exact/drop_{name}_3d.csv", time="t_s", value="rate_a_1_s", scale=0.5 * R, name="exact")
    kept = Truth("exact/constant.csv", time="t_s", value="one", scale=energy, name="exact")
    return Case(
        title="Drop with three half axes in a straining flow",
        fluid=Fluid(Ellipsoid(axes=(R, R, R)), density=1000.0, velocity=(f"{u}*x", f"{v}*y", f"{w}*z")),
        gravity=(f"-{B2}*x", f"-{B2}*y", f"-{B2}*z"),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * R, jitter=jitter, seed=seed, time_step=time_step,
        ),
        output=Output(every=end_time / 20, checkpoint_every=end_time / 2),
        probes=[
            VelocityPoint("rate", at=(0.5 * R, 0.0, 0.0), truth=rate if stiffness in (0.0, 1.0) else None),
            VelocityPoint("centre", at=(0.0, 0.0, 0.0)),
            Energy("energy", truth=kept if stiffness == 0.0 else None),
            Volume("volume", every=10),
            Momentum("momentum"),
        ],
        end_time=end_time,
    )
