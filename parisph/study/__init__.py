"""Studies: many runs of one case, by method, spacing, time step, seed and ranks, with their errors and costs.

Patch studies instead apply operators to fields with known derivatives.
"""

from parisph.patch.analytic import AnalyticField
from parisph.study.definition import OtherCodes, Required, Study, Variant
from parisph.study.measures import FinestError, Function, Quantity, SeriesError, TruthError
from parisph.study.patch_study import Histogram, PatchStudy, Sweep

__all__ = [
    "AnalyticField", "FinestError", "Function", "Histogram", "OtherCodes", "PatchStudy", "Quantity", "Required",
    "SeriesError", "Study", "Sweep", "TruthError", "Variant",
]
