"""Run-up of a solitary wave on a plane beach of 1:19.85 (Synolakis 1987, J. Fluid Mech. 185, 523-545).

The wave starts exact, with its crest half its length before the toe: L = arccosh(sqrt 20)/sqrt(3H/4d). One
with H/d = 0.30 breaks, before and after it has reached the shore; profiles were measured at t sqrt(g/d) = 15, 20,
25 and 30, and the run-up of such waves is some 0.55 d. The beach is a wedge of 2.9 degrees, whose tip is not resolved.

parisph run cases/runup_synolakis.py
parisph run cases/runup_synolakis.py --set height=0.0185 end_time=70    # does not break
"""

from math import acosh, sqrt

from parisph import (
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    Profile,
    SolitaryWave,
    StillWater,
    SurfaceGauge,
    Volume,
    WaterFront,
)

SLOPE = 1.0 / 19.85


def case(
    spacing: float = 0.0625,            # particle spacing / d
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 40.0,             # t sqrt(g/d)
    time_step: float | None = None,     # dt sqrt(g/d); none to adapt it
    height: float = 0.3,                # H / d
    before: float = 12.0,               # distance of the crest at the start from the left wall / d
    jitter: float = 0.0,
    seed: int = 0,
    snapshot_every: float = 1.0,        # in sqrt(d/g)
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
        fluid=Fluid(StillWater(level=d), density=1000.0, wave=SolitaryWave(height=height * d, depth=d, at=start)),
        walls=Profile([(0.0, top), (0.0, 0.0), (toe, 0.0), (toe + top / SLOPE, top)], name="beach"),
        gravity=(0.0, -g),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing * d, jitter=jitter, seed=seed,
            time_step=None if time_step is None else time_step * unit,
        ),
        output=Output(every=snapshot_every * unit, checkpoint_every=5.0 * unit),
        probes=[
            *(SurfaceGauge(name, at=x) for name, x in gauges.items()),
            WaterFront("shoreline"),
            Energy("energy"),
            Volume("volume"),
        ],
        end_time=end_time * unit,
    )
