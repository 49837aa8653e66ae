"""Probes of velocity and pressure at points inside the fluid."""

from collections.abc import Sequence

import numpy as np

from parisph.base.fields import INNER, SURFACE, WET
from parisph.case import probes
from parisph.watch.sampling import Sampler, Scene, View

REACH = 2.6    # spacings within which neighbours serve a point


class _Points(Sampler):
    """Velocity and pressure at points, by least squares of a quadratic polynomial.

    The weight is (1 - r^2/radius^2)^2, the radius REACH spacings. Walls count with their own velocity, as far as they
    are wet. Where particles do not determine the polynomial, the value is nan.

    places : (points, dim) [m]; endings : of the names of the columns, one for each point
    """

    def __init__(self, probe: probes.Single, scene: Scene, places: np.ndarray, endings: Sequence[str]) -> None:
        super().__init__(probe, scene)
        self.places, self.radius = places, REACH * scene.spacing
        names = [*"uvw"[:scene.dim], "p"]
        self.columns = {f"{name}{ending}": "Pa" if name == "p" else "m/s" for ending in endings for name in names}

    def sums(self, view: View) -> np.ndarray:
        p = view.particles
        use = np.isin(p.role, (INNER, SURFACE, WET))
        x, values = p.x[use], np.column_stack([p.u[use], p.p[use]])
        found = []
        for place in self.places:
            d = (x - place) / self.radius
            weight = np.clip(1.0 - (d**2).sum(axis=1), 0.0, None) ** 2
            near = weight > 0.0
            basis = _quadratic(d[near])
            weighted = basis * weight[near, None]
            found += [(weighted.T @ basis).ravel(), (weighted.T @ values[near]).ravel()]
        return np.concatenate(found)

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        n, quantities = _quadratic(np.zeros((1, self.scene.dim))).shape[1], self.scene.dim + 1
        table = np.reshape(sums, (len(self.places), n * (n + quantities)))
        return tuple(value for line in table
                     for value in _at_centre(line[:n * n].reshape(n, n), line[n * n:].reshape(n, quantities)))


class VelocityProfile(_Points):
    """Velocity and pressure at points along a line, see _Points."""

    def __init__(self, probe: probes.VelocityProfile, scene: Scene) -> None:
        super().__init__(probe, scene, probe.places, [f"_{k}" for k in range(probe.points)])
        self.title = (f"Velocity and pressure at {len(self.places)} points from "
                      f"({', '.join(f'{a:g}' for a in probe.start)}) to ({', '.join(f'{a:g}' for a in probe.end)}) m")


class VelocityPoint(_Points):
    """Velocity and pressure at one point, see _Points."""

    def __init__(self, probe: probes.VelocityPoint, scene: Scene) -> None:
        super().__init__(probe, scene, np.array([probe.at]), [""])
        self.title = f"Velocity and pressure at ({', '.join(f'{a:g}' for a in probe.at)}) m"


def _quadratic(d):
    """Return the polynomials up to degree 2 at d (n, dim): (n, 6), in 3D (n, 10); the first is 1."""
    dim = d.shape[1]
    return np.column_stack([np.ones(len(d)), d, *(d[:, a] * d[:, b] for a in range(dim) for b in range(a, dim))])


def _at_centre(moments, right):
    """Return the fitted values at the centre, nan if the moments do not determine them."""
    if not np.isfinite(moments).all() or np.linalg.matrix_rank(moments) < len(moments):
        return np.full(right.shape[1], np.nan)
    return np.linalg.solve(moments, right)[0]
