"""A solitary wave in a flat tank, from the exact steady solution, which keeps its form and its speed for ever.

The gauges are compared with that solution. parisph/case/waves/solitary.py has the theories; "grimshaw" and "boussinesq"
show what a start that is not exact costs: such a wave sheds others, and becomes a lower or a higher one.

parisph run cases/solitary_wave.py --set spacing=0.1
parisph run cases/solitary_wave.py --set spacing=0.1 length=20 start=10 end_time=2.1     # up the wall
"""

from math import sqrt

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    RunUp,
    SolitaryWave,
    SurfaceGauge,
    Tank,
    Volume,
    WaveTruth,
)


def case(
    spacing: float = 0.05,              # particle spacing / d
    method: str = "ISPH_R",
    preset: str = "solitary",
    end_time: float = 5.0,              # [s]
    time_step: float = 0.064,           # dt sqrt(g/d) at spacing = 0.05
    refine_time: bool = True,           # time step in proportion to the spacing
    height: float = 0.2,                # a / d
    theory: str = "exact",
    length: float = 56.0,               # of the tank / d
    start: float = 11.0,                # crest at t = 0 / d
    jitter: float = 0.0,
    seed: int = 0,
) -> Case:
    g = 9.81                            # [m/s2]
    d = 0.25                            # depth [m]
    step = time_step * sqrt(d / g) * (spacing / 0.05 if refine_time else 1.0)
    wave = SolitaryWave(height=height * d, depth=d, theory=theory, at=start * d)
    truth = WaveTruth(wave.model_copy(update={"theory": "exact"}), level=d)
    return Case(
        title=f"Solitary wave, a/d = {height:g}",
        fluid=Fluid(Box(width=length * d, height=d), density=1000.0, wave=wave),
        walls=Tank(width=length * d, height=2.0 * d),
        gravity=(0.0, -g),
        numerics=Numerics(method=method, preset=preset, spacing=spacing * d, jitter=jitter, seed=seed, time_step=step),
        output=Output(every=1.0, checkpoint_every=2.5),
        probes=[
            *(SurfaceGauge(f"x{k}d", at=k * d, truth=truth) for k in (17, 24, 34, 44) if k <= length - 12.0),
            RunUp("wall", side="right"),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )
