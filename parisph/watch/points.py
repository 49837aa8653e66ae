"""Velocity and pressure at points inside the fluid, by least squares."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.fields import INNER, SURFACE, WET
from parisph.case.probes import Probe
from parisph.watch.sampling import ProbeScene, View

REACH = 2.6    # radius of the neighbours of a point, in spacings


class AtPoints(Probe):
    """Velocity and pressure at points, by least squares of a quadratic polynomial.

    The weight is (1 - r^2/radius^2)^2 within REACH spacings. Wet wall particles count with their own velocity. If the
    neighbours do not determine the polynomial, the value is nan.
    """

    columns = {"u": "m/s", "v": "m/s", "p": "Pa"}

    @property
    def places(self) -> Floats:
        """The points (points, dim) [m]."""
        raise NotImplementedError

    def columns_in(self, scene: ProbeScene) -> dict[str, str]:
        endings = [""] if len(self.places) == 1 else [f"_{k}" for k in range(len(self.places))]
        return {f"{name}{ending}": "Pa" if name == "p" else "m/s"
                for ending in endings for name in (*"uvw"[:scene.dim], "p")}

    def sums(self, view: View) -> Floats:
        p, radius = view.particles, REACH * view.scene.spacing
        use = np.isin(p.role, (INNER, SURFACE, WET))
        x, values = p.x[use], np.column_stack([p.u[use], p.p[use]])
        found = []
        for place in self.places:
            d = (x - place) / radius
            weight = np.clip(1.0 - (d**2).sum(axis=1), 0.0, None) ** 2
            near = weight > 0.0
            basis = _quadratic(d[near])
            weighted = basis * weight[near, None]
            found += [(weighted.T @ basis).ravel(), (weighted.T @ values[near]).ravel()]
        return np.concatenate(found)

    def values(self, sums: Floats, rows: Floats, view: View) -> list[float]:
        dim = view.scene.dim
        n = _quadratic(np.zeros((1, dim))).shape[1]
        table = np.reshape(sums, (-1, n * (n + dim + 1)))
        return [value for line in table
                for value in _at_centre(line[:n * n].reshape(n, n), line[n * n:].reshape(n, dim + 1))]


def _quadratic(d: Floats) -> Floats:
    """Return the polynomials up to degree 2 at d (n, dim): (n, 6), in 3D (n, 10); the first is 1."""
    dim = d.shape[1]
    return np.column_stack([np.ones(len(d)), d, *(d[:, a] * d[:, b] for a in range(dim) for b in range(a, dim))])


def _at_centre(moments: Floats, right: Floats) -> Floats:
    """Return the fitted values at the centre, nan if the moments do not determine them."""
    if not np.isfinite(moments).all() or np.linalg.matrix_rank(moments) < len(moments):
        return np.full(right.shape[1], np.nan)
    found: Floats = np.linalg.solve(moments, right)[0]
    return found
