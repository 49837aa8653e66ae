"""Dam break on a dry bed with breaking waves (Zheng, Ma & Duan 2014, Sec. 3.1.1 and 3.1.2).

P2 and the energy are compared with converged solutions by volume of fluid, which differ by .065 in P2.

mpirun -n 2 parisph run cases/dam_break.py --set spacing=0.025
"""

from math import sqrt

from parisph import (
    Box,
    Case,
    ColumnHeight,
    Energy,
    Fluid,
    Momentum,
    Numerics,
    Output,
    PressureTap,
    Tank,
    Truth,
    Volume,
    WaterFront,
)


def case(
    spacing: float = 0.0125,            # particle spacing / H
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 10.0,             # t sqrt(g/H)
    time_step: float | None = None,     # dt sqrt(g/H) from H/40 to H/80, else in proportion to s; none to adapt it
    cfl: float | None = None,           # none: 1.5 with ISPH_R and violent, else the preset's
    rtol: float | None = None,          # none: 1e-4 with these, else the preset's
    gradient: str | None = None,        # this and the next five, if given, replace the preset's
    surface_rule: str | None = None,
    zeta_time: float | None = None,     # in sqrt(H/g)
    gamma: float | None = None,
    kappa: float | None = None,
    shift: float | None = None,
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.1,        # in sqrt(H/g)
    volume_every: int = 10,             # steps for one look at the volume
    budget: bool = False,               # whether energy is also followed by cause, and by current volumes
) -> Case:
    g = 9.81                            # [m/s2]
    L = 0.5                             # width of the column [m]
    H = 2.0 * L                         # height of the column [m]
    D = 4.0 * L                         # distance of the walls [m]
    unit = sqrt(H / g)                  # [s]
    if preset == "violent" and method == "ISPH_R":
        # The fastest are single drops of the jet. Steps that are shorter for them, and pressures to five digits, leave
        # the errors as they are.
        cfl = 1.5 if cfl is None else cfl
        rtol = 1e-4 if rtol is None else rtol
    return Case(
        title="Dam break, H/L = 2, D/L = 4",
        source="Zheng, Ma & Duan (2014), Figs 7-9 and 11-14",
        fluid=Fluid(Box(width=L, height=H), density=1000.0),
        walls=Tank(width=D, height=2.0 * H, lid=True),
        gravity=(0.0, -g),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * H, cfl=cfl, rtol=rtol, jitter=jitter, seed=seed,
            gradient=gradient, surface_rule=surface_rule, gamma=gamma, kappa=kappa, shift=shift,
            zeta_time=None if zeta_time is None else zeta_time * unit,
            time_step=None if time_step is None else time_step * unit * _scaled(spacing),
        ),
        output=Output(every=snapshot_every * unit, checkpoint_every=unit, budget=budget),
        probes=[
            PressureTap("P1", at=(0.0, 0.1 * H)),
            # a sensor with a face of .075 H, at least two spacings; the flow at its peak is kept
            PressureTap("P2", at=(D, 0.05 * H), radius=0.0375 * H, peak=True,
                        truth=_computed("P2", 1000.0 * g * H, (1.4 * unit, 3.4 * unit), unit)),
            WaterFront("front"),
            ColumnHeight("column", at=0.0),
            Energy("energy", current=budget, truth=_computed("E", 500.0 * g * H * H * L, (0.0, 2.3 * unit), unit)),
            Volume("volume", every=volume_every),
            Momentum("momentum"),
        ],
        end_time=end_time * unit,
    )


def _scaled(spacing: float) -> float:
    """Return by how much a fixed time step is longer or shorter than between H/40 and H/80.

    There it is that of the impact, which lasts as long with any spacing. Finer particles should not move farther than
    some .8 spacings.
    """
    return min(spacing * 80.0, max(1.0, spacing * 40.0))


def _computed(what: str, scale: float, window: tuple[float, float], unit: float) -> Truth:
    """Return the series of both grid codes; after t* = 2.3, when the jet meets the lid, their energies differ."""
    def of(code: str, name: str, others: tuple[Truth, ...] = ()) -> Truth:
        return Truth("computed/dam_break_vof.csv", time="t_star", value=f"{what}_{code}", scale=scale, time_scale=unit,
                     window=window, name=name, others=others)

    return of("basilisk_256", "Basilisk, 256 cells", (of("interfoam_25600", "interFoam, 25,600 cells"),))
