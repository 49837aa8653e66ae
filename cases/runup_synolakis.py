"""Run-up of a solitary wave on a plane beach of 1:19.85 (Synolakis 1987, J. Fluid Mech. 185, 523-545).

The wave starts exact, with its crest half its length before the toe: L = arccosh(sqrt 20)/sqrt(3H/4d). One
with H/d = 0.30 breaks, before and after it has reached the shore; profiles were measured at t sqrt(g/d) = 15, 20,
25 and 30, and the run-up of such waves is some 0.55 d. The beach is a wedge of 2.9 degrees, whose tip is not resolved,
and its film tears: `run_up` is where the particles part, `run_up_film` where a film of 1 mm would end. The beach rubs
the water (friction). With that, they are 0.52 and 0.65 d at d/s = 32, and the surface is 0.15, 0.135, 0.08 and 0.05 H
(rms) off at the four times; at d/s = 48 0.15, 0.15, 0.07 and 0.045 H. Without friction, the run-ups are 0.27 and 0.62
to 0.85 d at d/s = 16, 0.40 to 0.43 and 0.51 to 0.53 d at d/s = 32.

The measured wave is 0.7 d behind this one at t sqrt(g/d) = 15, before it breaks: 0.13 H (rms), and 0.03 H if this one
is moved. Particles are not the cause. The equations of Serre, Green & Naghdi on a fine grid, the other truth of
`profile` for H/d = 0.3, have the wave 0.7 d ahead as well (0.13 H, 0.03 H if moved), and this one comes to theirs:
0.09, 0.03 and 0.02 H at d/s = 8, 16 and 32. So a wave of this height without loss, started like that, does not meet
that profile as it stands, and a coarse run that is nearer to it is not better (run_scripts/studies/README.md).

parisph run cases/runup_synolakis.py                                    # 2 min on one core; spacing=1/32: 10 min
parisph run cases/runup_synolakis.py --set height=0.0185 end_time=70    # does not break
"""

from math import acosh, sqrt

from parisph import (
    Case,
    Energy,
    Fluid,
    Friction,
    Numerics,
    Output,
    PeakBand,
    Peaks,
    ProbeArray,
    Profile,
    Profiles,
    RunUp,
    SolitaryWave,
    StillWater,
    SurfaceGauge,
    Volume,
    WaterFront,
)
from parisph.case.measured_data import measured

SLOPE = 1.0 / 19.85
FILE = "05b_synolakis1987_profiles.csv"
COMPUTED = "computed/solitary_shoaling.csv"    # for H/d = 0.3, until it breaks
# {H/d: R/d} of single runs, Synolakis (1987)
RUN_UP = {0.018: 0.074, 0.0181: 0.075, 0.019: 0.078, 0.0191: 0.076,
          0.283: 0.527, 0.286: 0.513, 0.294: 0.542, 0.298: 0.551, 0.322: 0.591, 0.323: 0.555}
LEAD = (
    "At t sqrt(g/d) = 15, before it breaks, the measured wave is 0.7 d behind that of the run: an rms of 0.13 H, which "
    "is 0.03 H if the run is moved by 0.7 d. It is also 0.7 d behind that of the equations of Serre, Green and Naghdi. "
    "So the distance does not come from the particles, and finer spacing does not remove it."
)
NEAR = 0.1    # of H: runs whose run-up is compared
FILM = 0.005  # d: a film of 1 mm, which an eye still sees


def case(
    spacing: float = 0.0625,            # particle spacing / d
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 40.0,             # t sqrt(g/d)
    time_step: float | None = None,     # dt sqrt(g/d); none to adapt it
    height: float = 0.3,                # H / d
    before: float = 12.0,               # distance of the crest at the start from the left wall / d
    friction: float = 1e-6,             # viscosity of the water in the friction on the beach [m2/s], 0 for none
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 1.0,        # in sqrt(d/g)
    data: str = "",                     # folder of the measured data, "" for ../shared/reference/measured
) -> Case:
    g, d = 9.81, 0.2                    # [m/s2], [m]
    unit = sqrt(d / g)                  # [s]
    start = before * d
    toe = start + d * acosh(sqrt(20.0)) / sqrt(0.75 * height)
    shore = toe + d / SLOPE             # of the still water
    top = 2.0 * d
    gauges = {f"{k}d": shore - k * d for k in (20, 10, 5, 2)}    # distances from the shore
    return Case(
        title=f"Run-up on a beach of 1:19.85, H/d = {height:g} (Synolakis)",
        source="Synolakis (1987)",
        fluid=Fluid(StillWater(level=d), density=1000.0, wave=SolitaryWave(height=height * d, depth=d, at=start)),
        walls=Profile([(0.0, top), (0.0, 0.0), (toe, 0.0), (toe + top / SLOPE, top)], name="beach"),
        gravity=(0.0, -g),
        friction=Friction(viscosity=friction) if friction else None,
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * d, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step * unit,
        ),
        # its 56 gauges would cost more than the steps
        output=Output(every=snapshot_every * unit, checkpoint_every=5.0 * unit, probe_every=5),
        probes=[
            *(SurfaceGauge(name, at=x) for name, x in gauges.items()),
            ProbeArray("profile", [SurfaceGauge(f"at{k}", at=shore - 0.5 * k * d) for k in range(-12, 39)],
                       truth=_profiles(height, shore, d, unit, data)),
            RunUp("run_up", on="beach", side="right", truth=_run_up(height, d, end_time * unit)),
            RunUp("run_up_film", on="beach", side="right", film=FILM * d, truth=_run_up(height, d, end_time * unit)),
            WaterFront("shoreline"),
            Energy("energy"),
            Volume("volume", every=2),
        ],
        end_time=end_time * unit,
    )


def _profiles(height: float, shore: float, d: float, unit: float, data: str) -> Profiles | None:
    """Return the measured surfaces of waves of this height (H/d = 0.0185 and 0.3), and computed ones (0.3)."""
    file = measured(FILE, data) if height in (0.0185, 0.3) else None
    found = [] if file is None else [(file, "experiment", {"H_over_d": f"{height:g}"})]
    found += [(COMPUTED, "Serre-Green-Naghdi", {})] if height == 0.3 else []
    truths = [Profiles(name, time="t_sqrt_g_over_d", x="x_over_d", value="eta_over_d", offset=d, scale=d,
                       x_offset=shore, x_scale=-d, time_scale=unit, wave=True, rows=rows, name=whose,
                       note=LEAD if whose == "experiment" and height == 0.3 else "")
              for name, whose, rows in found]
    return truths[0].model_copy(update={"others": tuple(truths[1:])}) if truths else None


def _run_up(height: float, d: float, end: float) -> Peaks | None:
    """Return between which run-ups those of waves of nearly this height lie, each in proportion to its height."""
    near = [rise * height / other for other, rise in RUN_UP.items() if abs(other - height) < NEAR * height]
    if not near:
        return None
    # the last steps may have no sample
    band = PeakBand(start=0.0, end=0.99 * end, low=d * (1.0 + min(near)), high=d * (1.0 + max(near)), level=d)
    return Peaks((band,), name="experiment", note=f"{len(near)} runs with H/d within {NEAR:.0%}. The values are "
                 f"heights above the bed; the still water is at {d:g} m.")
