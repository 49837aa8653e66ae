"""Dam break against a far wall, with the pressure that Zhou, De Kat & Buchner (1999) measured (Z14, Fig 15).

L = 2 H, D = 161/30 H = 5.3667 H. The sensor is a disc of 90 mm (0.15 H with H = 0.6 m in the experiment) whose centre
is 160 mm (0.267 H) above the bed. P2 is the mean over this disc, and P2_point has a face of 0.02 H, as the sensors of
two codes that have converged (H/s = 400). Both are compared with these codes, smoothed over 0.1 sqrt(H/g), and with
two readings of the experiment, a single event: 2.5 < t sqrt(g/H) < 6.3, no shift. At H/s = 80 (spacing=1/80
distance=5.375) P2_point is .036 and .033 from the codes, which are .028 from each other, and .44 from the experiment.

mpirun -n 2 parisph run cases/dam_break_zhou.py --set spacing=1/30        # 15 s on one core; 1/60: 80 s; 1/80: 3 min
"""

from math import sqrt

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Friction,
    Momentum,
    Numerics,
    Output,
    PressureTap,
    Tank,
    Truth,
    Volume,
    WaterFront,
)
from parisph.case.measured_data import measured

EVENT = "02a_buchner2002_zhou1999_dambreak_pressure_exp.csv"
CODES = "02k_trixi_H400_dambreak_numerical.csv"
# Relative L2 errors against the first reading, without a shift and in the window of the run. The paper does not print
# them: its curves were digitised (02b_marrone2011_deltaSPH_buchner_numerical.csv) and compared as a run is (at even
# times of 2.5 < t sqrt(g/H) < 6.3), as were those of the codes that are further references.
OTHERS = {
    "weakly compressible SPH, H/s = 400, recomputed from the digitised curve": 0.459,
    "EDAC-SPH, H/s = 400, recomputed from the digitised curve": 0.454,
} | {
    f"Marrone et al. 2011, delta-SPH, H/s = {cells}, recomputed from the digitised curve": level
    for cells, level in ((40, 0.193), (80, 0.164), (320, 0.156))
}
NOTE = (
    "The probe is at 0.267 H, where the sensor was (160 mm of 600 mm). At 0.2 H, where it is often put, codes in 2D "
    "have the pressure of the experiment; at 0.267 H most of them have half of it."
)


def case(
    spacing: float = 1.0 / 60.0,        # particle spacing / H; must divide D = 161/30 H: 1/30, 1/60, 1/90, ...
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 7.5,              # t sqrt(g/H)
    time_step: float | None = None,     # dt sqrt(g/H) at spacing = 1/60, in proportion to it; none to adapt it
    distance: float = 161.0 / 30.0,     # of the walls, D / H; 5.375 for spacings of 1/40 and 1/80
    face: float = 0.15,                 # diameter of the sensor's disc / H
    friction: float = 0.0,              # viscosity of the water in the friction on walls [m2/s], 0 for none
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 0.1,        # in sqrt(H/g)
    data: str = "",                     # folder of the measured data, "" for ../shared/reference/measured
) -> Case:
    g = 9.81                            # [m/s2]
    L = 2.0                             # width of the column [m]
    H = 0.5 * L                         # height of the column [m]
    D = distance * H                    # distance of the walls [m]
    unit = sqrt(H / g)                  # [s]
    codes = _codes(measured(CODES, data), unit, 9810.0 * H)
    readings = _readings(measured(EVENT, data), unit, 9810.0 * H)
    low, high = 160.0 / 600.0 * H, 584.0 / 600.0 * H    # heights of the sensors [m]
    return Case(
        title=f"Dam break, L/H = 2, D/H = {distance:.4g} (Zhou, De Kat & Buchner)",
        source="Zhou, De Kat & Buchner (1999); Zheng, Ma & Duan (2014), Fig 15",
        fluid=Fluid(Box(width=L, height=H), density=1000.0),
        walls=Tank(width=D, height=3.0 * H, lid=True),
        gravity=(0.0, -g),
        friction=Friction(viscosity=friction) if friction else None,
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * H, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step * spacing * 60.0 * unit,
        ),
        output=Output(every=snapshot_every * unit, checkpoint_every=unit),
        probes=[
            PressureTap("P2", at=(D, low), diameter=face * H, peak=True, truth=_first([*readings, *codes])),
            PressureTap("P2_point", at=(D, low), radius=0.01 * H, truth=_first([*codes, *readings])),
            PressureTap("P3", at=(D, high), diameter=face * H),
            WaterFront("front"),
            Energy("energy"),
            Volume("volume", every=10),
            Momentum("momentum"),
        ],
        end_time=end_time * unit,
    )


def _codes(file: str | None, unit: float, pressure: float) -> list[Truth]:
    """Return two codes at 0.267 H, which differ by 0.028 from each other; nothing where the file is not there."""
    return [] if file is None else [
        Truth(file, time="t_sqrt_g_over_H", value="p_over_rho_g_H", scale=pressure, time_scale=unit,
              rows={"scheme": scheme, "sensor": "P4"}, window=(2.5 * unit, 6.3 * unit), smooth=0.1 * unit, name=name)
        for scheme, name in (("wcsph_400", "weakly compressible SPH, H/s = 400"), ("edac_400", "EDAC-SPH, H/s = 400"))
    ]


def _readings(file: str | None, unit: float, pressure: float) -> list[Truth]:
    """Return the one event that was measured, as two people have read it from the figure."""
    return [] if file is None else [
        Truth(file, time="t_sqrt_g_over_H", value="p_over_rho_g_H", scale=pressure, time_scale=unit,
              rows={"sensor": "P_160mm", "digitisation": by}, window=(2.5 * unit, 6.3 * unit), name=name, **more)
        for by, name, more in (
            ("TrixiParticles_history", "experiment", {"published": OTHERS, "note": NOTE}),
            ("PySPH_db_exp_data", "experiment, read again", {}),
        )
    ]


def _first(truths: list[Truth]) -> Truth | None:
    """Return the first truth with the others beside it; None if there is none."""
    return truths[0].model_copy(update={"others": tuple(truths[1:])}) if truths else None
