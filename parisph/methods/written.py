"""Fields that no step needs: they are computed when they are written, for scenes that ask for them."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from parisph.base.errors import CaseError
from parisph.kernels import strain
from parisph.methods import lengths, straining
from parisph.methods.sliding import write_wall_velocity

if TYPE_CHECKING:
    from parisph.methods.flow import Flow


def compute(flow: "Flow", names: Iterable[str], time: float) -> None:
    """Write those of the fields `names` that this module computes, of owned particles at a time [s]. Collective."""
    for name in names:
        if name in WRITTEN:
            WRITTEN[name](flow, time)


def check(names: Iterable[str], dim: int) -> None:
    """Raise CaseError for a field that does not exist in this number of dimensions."""
    if dim != 2 and "vorticity" in names:
        raise CaseError(f"output.fields: 'vorticity' exists in 2D only, and this scene has {dim} dimensions")


def _vorticity(flow: "Flow", time: float) -> None:
    """Write the vorticity by a least-squares gradient (kernels.strain), exact for a linear velocity."""
    p = flow.particles
    gradient, rate = np.empty((p.n_owned, p.dim, p.dim)), np.empty(p.n_owned)
    with _walls_along(flow, time):
        strain.velocity_gradient(gradient, rate, np.empty((0, p.dim)), flow.cloud, p.u_all, lengths.MLS * flow.spacing,
                                 straining.FLOOR)
    p.vorticity[:] = gradient[:, 1, 0] - gradient[:, 0, 1]


@contextmanager
def _walls_along(flow: "Flow", time: float) -> Iterator[None]:
    """Give walls the velocity of the flow along them at a time [s], within this context. Collective.

    With their velocity at the start of the step, an irrotational wave had a vorticity beside walls of the acceleration
    times the step over the spacing. The velocity of the run is restored.
    """
    p, d = flow.particles, flow.domain
    d.update("x", "u", "role")
    velocity = p.u.copy()
    write_wall_velocity(flow, flow.wall_shear(time))
    d.update("u")
    try:
        yield
    finally:
        p.u[:] = velocity
        d.update("u")


WRITTEN: MappingProxyType[str, Callable[["Flow", float], None]] = MappingProxyType({"vorticity": _vorticity})
