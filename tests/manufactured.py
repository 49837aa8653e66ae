"""A manufactured Poisson problem on lattice or jittered particles, with known values around it."""

import numpy as np

from parisph.patch import arrangement
from parisph.patch.analytic import FIELD_OF
from parisph.patch.derivatives import discrete
from parisph.patch.solution import solution
from tests.made_rows import parts_of

wave, smooth = FIELD_OF["wave"], FIELD_OF["smooth"]    # that of the paper, and one that the particles resolve well


def poisson_error(method, spacing, jitter, field=wave, seed=1, dim=2):
    """Solve lap p = lap f in the unit square or cube, p = f on the particles around it.

    Returns the relative error |p - f| / |f| inside, and the error of the discrete
    Laplacian of f itself, relative to that of the largest Laplacian (both rms).
    """
    parts = parts_of(method)
    layers = int(np.ceil(parts.reach)) + 1
    cloud = arrangement.block(round(1.0 / spacing), jitter, seed, dim, layers, centred=False)
    system = discrete(cloud, parts.laplacian.name)
    f, laplacian, inside = field.values(cloud.x), field.laplacians(cloud.x), cloud.inside
    p = solution(system, f, laplacian)
    found = system.derivative(f)[inside]
    truncation = np.sqrt(np.mean((found - laplacian[inside]) ** 2)) / np.abs(laplacian).max()
    return np.linalg.norm((p - f)[inside]) / np.linalg.norm(f[inside]), truncation


def orders(spacings, errors):
    """Return the observed orders between successive spacings."""
    spacings, errors = np.log(spacings), np.log(errors)
    return np.diff(errors) / np.diff(spacings)
