"""Studies: many runs of one case, by method, spacing, time step, seed and ranks, with a table of errors and costs."""

from parisph.study.definition import OtherCodes, Required, Study, Variant
from parisph.study.measures import FinestError, Function, Quantity, SeriesError, TruthError

__all__ = [
    "FinestError", "Function", "OtherCodes", "Quantity", "Required", "SeriesError", "Study", "TruthError", "Variant",
]
