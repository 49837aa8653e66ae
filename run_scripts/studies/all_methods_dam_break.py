"""The dam break by every method, with 800 and 3200 particles: which ones complete, with what impact, at what cost.

    parisph study run_scripts/studies/all_methods_dam_break.py

About twenty minutes of CPU time, to t sqrt(g/H) = 4. A method that blows up is a result too.
"""

from dam_break_measures import IMPACT

from parisph.case.methods import METHODS
from parisph.study import Study, Variant

STEPS = {0.025: 0.004, 0.0125: 0.002}     # spacing over H: dt sqrt(g/H); at the finer one half of the case's

study = Study(
    title="The dam break by every method",
    case="../../cases/dam_break.py",
    variants=[Variant(methods=list(METHODS), spacings=[spacing], time_steps=[step])
              for spacing, step in STEPS.items()],
    parameters={"end_time": 4.0, "jitter": 0.2},
    errors=IMPACT,
    histories=["P2", "energy"],
    time_limit=900.0,
)
