"""Dam break on a wet bed: SPHERIC test 5 (Janosi et al. 2004, Exp. Fluids 37, 219-229).

A reservoir of 0.38 m x 0.15 m opens into a layer of 38 mm in a flume of 9.55 m. Surface profiles were photographed from
0.156 s to 0.593 s after the gate began to rise. It rises with 1.5 m/s, and holds back so much water that the wave is
0.1 m behind one without a gate, and of another shape. Until then the wave goes no farther than 2 m. The foremost place
where the surface is above 55 mm, of gauges 20 mm apart, is 23 to 60 mm ahead of the photographs (at .219 and .406 s).

parisph run cases/wet_bed.py        # 45 s on one core
"""

from parisph import (
    Box,
    Case,
    Energy,
    Fluid,
    Numerics,
    Output,
    Plate,
    ProbeArray,
    Profiles,
    StillWater,
    SurfaceGauge,
    Tabulated,
    Tank,
    Volume,
)
from parisph.case.measured_data import measured

FILE = "02i_spheric5_wetbed_d38_profiles.csv"
NOTE = (
    "The still layer ahead of the wave, 38 mm deep, is between 34 and 46 mm in the digitised photographs. So a part of "
    "each rms, of about 5 mm, is scatter of the photographs; what is more than that is a difference of the run."
)


def case(
    spacing: float = 0.15 / 32.0,       # [m]; fits the depth of the reservoir, and nearly that of the layer
    method: str = "ISPH_R",
    preset: str = "violent",
    end_time: float = 0.6,              # [s]
    time_step: float | None = None,     # [s]; none to adapt it
    layer: float = 0.038,               # depth of the wet bed [m]; also measured with 0.018
    length: float = 2.0,                # of the flume [m]; 9.55 in the experiment
    rising: float = 1.5,                # speed of the gate [m/s]; 0 for none
    jitter: float = 0.0,
    seed: int = 0,
    data: str = "",                     # folder of the measured data, "" for ../shared/reference/measured
) -> Case:
    dam, depth = 0.38, 0.15             # [m]
    times = (0.156, 0.219, 0.281, 0.343, 0.406, 0.468, 0.531, 0.593)    # of the photographs [s]
    return Case(
        title=f"Dam break on a wet bed of {1e3 * layer:g} mm (SPHERIC 5)",
        source="SPHERIC test 5, Janosi et al. (2004)",
        fluid=(
            Fluid(Box(width=dam, height=depth), density=1000.0),
            Fluid(StillWater(level=layer), density=1000.0),
        ),
        walls=(Tank(width=length, height=2.0 * depth), *([_gate(dam, depth, rising)] if rising > 0.0 else [])),
        gravity=(0.0, -9.81),
        numerics=Numerics(
            method=method, preset=preset, spacing=spacing, time_step=time_step, jitter=jitter, seed=seed,
        ),
        output=Output(times=tuple(t for t in times if t <= end_time), checkpoint_every=0.1),
        probes=[
            *(SurfaceGauge(f"x{100.0 * x:.0f}cm", at=x) for x in (0.2, 0.5, 0.75, 1.0)),
            ProbeArray("profile", [SurfaceGauge(f"at{x}cm", at=0.01 * x) for x in range(39, 104, 2)],
                       truth=_profiles(layer, data)),
            Energy("energy"),
            Volume("volume", every=10),
        ],
        end_time=end_time,
    )


def _gate(at: float, depth: float, speed: float) -> Plate:
    """Return the gate, which takes 10 ms to its speed and, above the water, as long to rest."""
    ramp, above = 0.01, 1.4 * depth
    even = [ramp + k / 8.0 * (above / speed - ramp) for k in range(9)]
    times = [0.0, *even, even[-1] + ramp]
    heights = [0.0, *(speed * (time - 0.5 * ramp) for time in even), speed * even[-1]]
    return Plate([(at, 0.0), (at, 1.2 * depth)], name="gate", motion=Tabulated(times, heights, direction=(0.0, 1.0)))


def _profiles(layer: float, data: str) -> Profiles | None:
    """Return the photographed surfaces, of the layer of 38 mm."""
    file = measured(FILE, data) if layer == 0.038 else None
    return None if file is None else Profiles(
        file, time="t_s", x="x_cm", value="y_cm", scale=0.01, x_scale=0.01, name="experiment, photographs", note=NOTE)
