"""Small sloshing by every method, with 800 and 3200 particles: which ones complete, with what error, at what cost.

    parisph study run_scripts/studies/all_methods_sloshing.py

About ten minutes of CPU time, to t sqrt(g/d) = 20. A method that blows up is a result too.
"""

from parisph.case.methods import METHODS
from parisph.study import Study, TruthError

study = Study(
    title="Small sloshing by every method",
    case="../../cases/small_sloshing.py",
    methods=list(METHODS),
    spacings=[0.05, 0.025],             # over d
    time_steps=[0.064],                 # dt sqrt(g/d) at spacing = 0.05, the same for all
    parameters={"end_time": 20.0, "refine_time": True},
    errors=[TruthError("left", name="wave part")],
    histories=["left", "energy"],
    time_limit=900.0,
)
