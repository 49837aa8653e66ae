"""Pressure rows of a method on particles at made-up places."""

from parisph.case.methods import METHODS
from parisph.case.numerics import Numerics
from parisph.methods import lengths
from parisph.methods.catalogue import Parts
from parisph.pressure.rows import PressureRows

PROJECTIONS = [name for name, method in METHODS.items() if method.step == "projection"]


def parts_of(method="ISPH_R", **numerics):
    """Return the Parts of a method with the gentle preset."""
    return Parts.of(Numerics(**{"spacing": 1.0, "preset": "gentle", "method": method, **numerics}).resolved())


def rows_of_method(method, dim, wall_rows="sfdi", offset=0.0):
    """Return empty PressureRows."""
    parts = parts_of(method, wall_rows=wall_rows)
    return PressureRows(dim, parts.laplacian, parts.divergence, parts.wall_rows, offset, lengths.MLS)
