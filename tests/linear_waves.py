"""Small motions of a still tank, as matrices: what one step of the method does to them.

On the lattice at rest every stencil is exact for the hydrostatic pressure, wherever its
particles have moved to. What remains to first order in the displacement is a wave problem on
the fixed lattice: the pressure beside the hydrostatic one is rho g eta at a surface particle
that has risen by eta, obeys the pressure rows, and accelerates the fluid by its gradient.
"""

from pathlib import Path

import numpy as np
from mpi4py import MPI

from parisph.base.fields import FLUID, INNER, SURFACE, WET, FieldSet
from parisph.base.log import Timers
from parisph.case.load import load
from parisph.case.waves import angular_frequency
from parisph.driver import solid_walls
from parisph.geometry import build as geometry
from parisph.kernels import gradient as gradients
from parisph.methods import lengths, potential, surfaces
from parisph.methods.boundary import Boundary
from parisph.methods.catalogue import Parts
from parisph.methods.flow import Flow
from parisph.methods.projection import Projection
from parisph.methods.stepping import share
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles

GRAVITY, DEPTH, LENGTH = 9.81, 0.5, 1.0
UNIT = np.sqrt(DEPTH / GRAVITY)  # [s]


def exact_frequency(mode):
    """Return omega_n of a standing wave in the tank [rad/s]."""
    return angular_frequency(mode * np.pi / LENGTH, DEPTH, GRAVITY)


class StillTank:
    """The tank of cases/small_sloshing.py at rest, with `across` spacings over its length.

    overrides : fields of Numerics that differ from the case's preset, beside a volume_time of 0

    inner, wet, surface, fluid : numbers of those particles; x : (n, 2) positions [m]
    """

    def __init__(self, across, **overrides):
        case = load(str(Path(__file__).parents[1] / "cases" / "small_sloshing.py"), {"spacing": 2.0 / across})
        self.numerics = case.numerics.model_copy(update={"volume_time": 0.0, **overrides}).resolved()
        parts = Parts.of(self.numerics)
        self.particles = p = Particles(MPI.COMM_SELF, 2, FieldSet((*parts.fields, *Boundary.fields)))
        p.assign({name: values for name, values in geometry.build(case).items() if name in p.fields})
        reach = parts.reach * self.numerics.spacing
        self.domain = Domain(p, *geometry.domain(case), reach, 0.1 * self.numerics.spacing,
                             elements=solid_walls.elements_of(case, p))
        self.domain.refresh()
        self.flow = Flow(self.numerics.model_copy(update={"rtol": 1e-13}), 1.0, self._force, p, self.domain,
                         Boundary(self.domain.elements, self.numerics.spacing), Timers(),
                         wave_time=np.sqrt(self.numerics.spacing / GRAVITY))
        solid_walls.fill(case, self.flow)
        self.method = Projection(self.flow, parts)
        flow = self.flow
        flow.step.force = self._force(p.x_all, 0.0)
        surfaces.classify(flow, parts.surface, 0.0)    # which walls are wet, or apart from the water
        self.n = p.n_owned
        self.x, self._ids = p.x.copy(), p.id.copy()
        self.inner, self.wet, self.surface = (np.flatnonzero(p.role == r) for r in (INNER, WET, SURFACE))
        self.fluid = np.flatnonzero(p.kind == FLUID)
        self._fill()

    @staticmethod
    def _force(x, t):
        return np.tile([0.0, -GRAVITY], (len(x), 1))

    # -- the operators of the method as matrices ------------------------------------------------

    def _fill(self):
        """Make the matrices; pressures are in the order inner, wet, surface, velocities (particle, axis) in rows."""
        p, rows = self.particles, self.method.rows
        rows.fill(np.zeros((self.n, 2)), self.flow.cloud, self.flow.walls.cells(self.flow))
        self.pressures = np.concatenate([self.inner, self.wet, self.surface])
        # slopes across walls and the Laplacian belong to the pressure at rest, or are of second order
        self.gradient = np.stack([self.method.pressure_gradient(e)[self.fluid].ravel()
                                  for e in self._units(self.pressures)], axis=1)
        self.rows = self._pressure_rows()
        self.measure = rows.rows.measure[self.inner].copy()
        div, divergence, beyond = np.empty(self.n), [], []
        for e in self._velocity_units():
            p.u[:] = self._with_walls(e)
            rows.divergence(div, p.u)
            divergence.append(div[self.inner])
            beyond.append(potential.find(self.flow).beyond[self.fluid].ravel())
        self.divergence, self.beyond = (np.stack(columns, axis=1) for columns in (divergence, beyond))

    def _units(self, numbers):
        for i in numbers:
            e = np.zeros(self.n)
            e[i] = 1.0
            yield e

    def _velocity_units(self):
        for e in self._units(self.fluid):
            yield e[:, None] * [1.0, 0.0]
            yield e[:, None] * [0.0, 1.0]

    def _with_walls(self, u):
        """Return u with the velocity that wall particles take from it."""
        u, rest = u.copy(), np.zeros((self.n, 2))
        gradients.wall_velocity(u, self.flow.cloud, rest, rest, lengths.WALL * self.numerics.spacing)
        return u

    def _pressure_rows(self):
        """Rows of inner and wet particles, columns of all pressures."""
        rows, unknowns = self.method.rows, np.concatenate([self.inner, self.wet])
        place = np.full(self.n, -1)
        place[self.pressures] = np.arange(len(self.pressures))
        matrix = np.eye(len(unknowns), len(self.pressures))
        for k, i in enumerate(unknowns):
            own = slice(rows.cloud.indptr[i], rows.cloud.indptr[i] + rows.rows.count[i])
            used = rows.rows.values[own] != 0.0
            matrix[k, place[rows.rows.columns[own][used]]] -= rows.rows.values[own][used]
        return matrix

    # -- what follows from them -----------------------------------------------------------------

    def _response(self, equations, source):
        """Return all pressures due to the surface's, and due to a unit source of each equation."""
        m = len(self.inner) + len(self.wet)
        inverse = np.linalg.inv(equations[:, :m])
        surface = np.vstack([-inverse @ equations[:, m:], np.eye(len(self.surface))])
        unit = np.vstack([inverse[:, : len(source)] * source, np.zeros((len(self.surface), len(source)))])
        return surface, unit

    @property
    def rise(self):
        """Which velocities are the vertical ones of surface particles."""
        return 2 * np.searchsorted(self.fluid, self.surface) + 1

    def waves(self):
        """Return omega^2 (complex) and shapes of the standing waves into which the steps settle.

        Over many small steps u stays free of divergence: div grad p = 0 with the method's own
        divergence and gradient, wall rows as they are. d^2 eta/dt^2 = -grad p at the surface.
        """
        equations = np.vstack([self.divergence @ self.gradient, self.rows[len(self.inner):]])
        surface, _ = self._response(equations, np.ones(len(self.inner)))
        return np.linalg.eig(GRAVITY * self.gradient[self.rise] @ surface)

    def step_matrix(self, dt):
        """Return the matrix of one step on the state (eta of surface particles, u of the fluid, the vertical
        acceleration of surface particles in the last step and in the one before)."""
        surface, unit = self._response(self.rows, -self.measure)
        m, n = len(self.surface), 2 * len(self.fluid)
        eta, u, last, before = np.split(np.eye(n + 3 * m), [m, m + n, 2 * m + n])
        middle = eta + 0.5 * dt * u[self.rise]
        if self.method.stepping.corrected:
            middle = middle + share(dt, self.flow.wave_time) * dt**2 * (2.0 * last - before)
        pressure = surface @ (GRAVITY * middle) + unit @ (self.divergence @ u / dt)
        acceleration = -self.gradient @ pressure
        filtered = min(1.0, self.numerics.filter * dt / self.flow.wave_time)
        after = u + dt * acceleration - filtered * self.beyond @ u
        return np.vstack([eta + 0.5 * dt * (u + after)[self.rise], after, acceleration[self.rise], last])

    def step(self, eta, u, last, before, dt):
        """Take one real step from a small displacement eta (m,), velocity u (n, 2) and accelerations (m,).

        Returns them after it, in the order of the state.
        """
        p, earlier = self.particles, self.method.earlier_accelerations
        p.x[:], p.u[:], p.p[:] = self.x, 0.0, 0.0
        p.x[self.surface, 1] += eta
        p.u[self.fluid] = u
        p.acceleration[:] = p.acceleration_before[:] = 0.0
        p.acceleration[self.surface, 1], p.acceleration_before[self.surface, 1] = last, before
        earlier.times = [-0.5 * dt, -1.5 * dt]
        self.method.step(0.0, dt)
        assert np.array_equal(p.id, self._ids), "the step has sorted the particles anew"
        return np.concatenate([p.x[self.surface, 1] - self.x[self.surface, 1], p.u[self.fluid].ravel(),
                               p.acceleration[self.surface, 1], p.acceleration_before[self.surface, 1]])

    def mode(self, number, values, shapes):
        """Return the index of the eigenvalue whose surface has the shape of a standing wave."""
        wave = np.cos(number * np.pi * self.x[self.surface, 0] / LENGTH)
        eta = shapes[: len(wave)]
        size = np.maximum(np.linalg.norm(eta, axis=0), 1e-12 * np.abs(shapes).max())
        likeness = np.abs(wave @ eta) / np.linalg.norm(wave) / size
        return int(np.argmax(likeness)), float(likeness.max())
