"""Pressure rows of a method on particles at made-up places."""

import numpy as np

from parisph.case.methods import METHODS
from parisph.case.numerics import Numerics
from parisph.kernels.jit import axes_of
from parisph.methods import lengths
from parisph.methods.catalogue import Parts
from parisph.pressure.rows import Cloud, PressureRows

PROJECTIONS = [name for name, method in METHODS.items() if method.step == "projection"]


def parts_of(method="ISPH_R", **numerics):
    """Return the Parts of a method with the gentle preset."""
    return Parts.of(Numerics(**{"spacing": 1.0, "preset": "gentle", "method": method, **numerics}).resolved())


def rows_of_method(method, dim, wall_rows="sfdi", offset=0.0):
    """Return empty PressureRows."""
    parts = parts_of(method, wall_rows=wall_rows)
    return PressureRows(dim, parts.laplacian, parts.divergence, parts.wall_rows, offset, lengths.MLS)


def cloud_of(x, role, spacing, indptr, indices, kind=None, cells=None, normal=None):
    """Return a Cloud of fluid; what is not given is zero."""
    n, dim = x.shape
    none = np.zeros(n, np.int8)
    return Cloud(x, none if kind is None else kind, role, np.zeros(n) if cells is None else cells,
                 np.zeros_like(x) if normal is None else normal, none, indptr, indices, spacing, axes_of(dim))
