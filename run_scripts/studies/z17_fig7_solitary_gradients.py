"""Errors of a solitary wave by a piston with the four gradients of Zheng et al. 2017 (Figs 6 and 7).

    parisph study run_scripts/studies/z17_fig7_solitary_gradients.py -j 2

About two and a half hours of CPU time, all but a quarter of an hour for the records of Z17 at the paper's time step of
0.001 s; --only ISPH_R leaves these out. ISPH_R runs as it is, and with the gradients of Z17 Eqs 27, 28 and 29 in place
of its own, so that nothing else differs. The records have their own source, and no regularisation; their surface is
found by gaps, not by the rule of the papers. Err of Eq 35 is against Boussinesq's wave as in Z17, the profile against
the exact one, at 5 s and with crests aligned; the gauges are aligned by nothing.
"""

from solitary_measures import GAUGES, height, printed, profile

from parisph.study import Study, TruthError, Variant

METHODS = ["ISPH_R", "Z17_ISPH", "Z17_CISPH1", "Z17_CISPH2", "Z17_CISPH3"]
GRADIENTS = {"CISPH1": "corrected", "CISPH2": "spline", "CISPH3": "sfdi"}
SPACINGS = [1 / 10, 1 / 15, 1 / 20, 1 / 30]    # over d; Z17 Fig 6 has the last one

study = Study(
    title="Solitary wave by a piston, Z17 Fig 7",
    case="../../cases/solitary_piston.py",
    spacings=SPACINGS,
    variants=[
        Variant(methods=METHODS[:1], label="ISPH_R"),
        *(Variant(methods=METHODS[:1], label=f"ISPH_R with the gradient of {name}",
                  parameters={"numerics.gradient": word, "numerics.surface_gradient": "same"})
          for name, word in GRADIENTS.items()),
        *(Variant(methods=[method], label=method, time_steps=[0.001], parameters={"numerics.surface_rule": "gap"})
          for method in METHODS[1:]),
    ],
    errors=[printed(5.0), profile(5.0), height(5.0), *(TruthError(gauge) for gauge in GAUGES)],
    histories=GAUGES,
)
