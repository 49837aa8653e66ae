"""Profiles of a solitary wave by a piston against the spacing (Zheng et al. 2017, Fig 8).

    parisph study run_scripts/studies/z17_fig8_solitary_spacing.py

About four minutes of CPU time, two thirds of it for the finest. Z17 draws profiles at several times for several numbers
of particles in the depth beside Boussinesq's wave, and says that they approach it; here their errors at 3, 4 and 5 s
are those against the exact wave, crests aligned, and those of the gauges against the wave that the piston is to make,
which nothing aligns. `parisph plot RUN --time T --surface` draws a profile.
"""

from solitary_measures import GAUGES, height, profile

from parisph.study import Study, TruthError

METHODS = ["ISPH_R"]
SPACINGS = [1 / 8, 1 / 12, 1 / 16, 1 / 20, 1 / 30]    # over d

study = Study(
    title="Solitary wave by a piston, Z17 Fig 8",
    case="../../cases/solitary_piston.py",
    methods=METHODS, spacings=SPACINGS,
    errors=[*(measure(time) for measure in (profile, height) for time in (3.0, 4.0, 5.0)),
            *(TruthError(gauge) for gauge in GAUGES)],
    histories=GAUGES,
)
