"""The dam break by every method, with 800 and 3200 particles: which ones complete, with what impact, at what cost.

    parisph study run_scripts/studies/all_methods_dam_break.py

About twenty minutes of CPU time, to t sqrt(g/H) = 4. A method that blows up is a result too.
"""

from dam_break_measures import IMPACT

from parisph.case.methods import METHODS
from parisph.study import Study

study = Study(
    title="The dam break by every method",
    case="../../cases/dam_break.py",
    methods=list(METHODS),
    spacings=[0.025, 0.0125],           # over H
    parameters={"end_time": 4.0, "jitter": 0.2},
    errors=IMPACT,
    histories=["P2", "energy"],
    time_limit=900.0,
)
