"""The registry of particle fields, and the set of them that a scene has."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from parisph.base.arrays import Array

# Values of the field `kind`.
FLUID, WALL = 0, 1
ABSENT = 2     # marks particles that a kernel must ignore; never in the field itself

# Values of the field `role`: the part a particle plays in the pressure equation.
INNER = 0      # fluid, an equation of its own
SURFACE = 1    # fluid on the free surface, p = 0
WET = 2        # wall in contact with fluid, a Neumann row
DRY = 3        # wall without fluid, in no stencil
CONTACT = 4    # wall node at the contact line, in no stencil either
BALLISTIC = 5  # fluid with too few neighbours for any stencil, p = 0 and free flight

ORDER = {"scalar": 0, "vector": 1, "tensor": 2}    # indices of a value


@dataclass(frozen=True)
class Field:
    """One particle field.

    shape : "scalar" for (n,), "vector" for (n, dim), "tensor" for (n, dim, dim)
    unit, meaning : for people and for attributes of files
    exchanged : whether the first message to a new ghost contains it
    migrates : whether it moves with its particle to another rank, and is in checkpoints
    written : whether snapshots may contain it
    default : value without data, as after a restart from an older file
    """

    name: str
    shape: str
    dtype: type
    unit: str
    meaning: str
    exchanged: bool = True
    migrates: bool = True
    written: bool = True
    default: float = 0

    def empty(self, n: int, dim: int) -> Array:
        """Return an array of the default value for n particles in dim dimensions."""
        return np.full((n, *(dim,) * ORDER[self.shape]), self.default, dtype=self.dtype)


class FieldSet(Mapping[str, Field]):
    """The fields of a scene: CORE, and those that its parts declare. Particles have arrays for these only.

    names : of fields in the registry, in any order, also repeated

    Raises KeyError: a name that is not in the registry
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        wanted = {*CORE, *names}
        unknown = sorted(wanted - set(FIELDS))
        if unknown:
            raise KeyError(f"no such particle field: {', '.join(unknown)} (there are {', '.join(FIELDS)})")
        self._fields = {name: field for name, field in FIELDS.items() if name in wanted}
        self.exchanged = tuple(name for name, field in self._fields.items() if field.exchanged)
        self.migrating = tuple(name for name, field in self._fields.items() if field.migrates)

    def __getitem__(self, name: str) -> Field:
        return self._fields[name]

    def __contains__(self, name: object) -> bool:    # faster than Mapping's, which raises and catches a KeyError
        return name in self._fields

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)


def register(field: Field) -> None:
    """Add a field to the registry, on every rank and before a case runs. Not collective.

    Raises ValueError if another field has this name.
    """
    if FIELDS.setdefault(field.name, field) != field:
        raise ValueError(f"there is another particle field {field.name!r}: {FIELDS[field.name].meaning}")


# Flags of fields that new ghosts get no copy of: KEPT if a restart needs them, OWN if each step computes them.
KEPT: dict[str, Any] = {"exchanged": False, "written": False}
OWN: dict[str, Any] = {**KEPT, "migrates": False}

FIELDS = {
    field.name: field
    for field in (
        Field("id", "scalar", np.int64, "", "number of the particle, the same for the whole run"),
        Field("kind", "scalar", np.int8, "", "0 fluid, 1 wall"),
        Field("corner", "scalar", np.int8, "", "1 for a wall particle in a corner", written=False),
        Field("x", "vector", np.float64, "m", "position"),
        Field("x0", "vector", np.float64, "m", "position at the start of the step", **KEPT),
        Field("u", "vector", np.float64, "m/s", "velocity"),
        Field("volume", "scalar", np.float64, "m^dim",
              "volume of fluid that the particle represents; 0 for walls"),
        Field("p", "scalar", np.float64, "Pa", "pressure"),
        Field("laplacian", "scalar", np.float64, "Pa/m^2",
              "Laplacian of the pressure in the last step, without the part due to the body force", written=False),
        Field("p_before", "scalar", np.float64, "Pa", "pressure one step before", **KEPT),
        Field("p_earlier", "scalar", np.float64, "Pa", "pressure two steps before", **KEPT),
        Field("p_earliest", "scalar", np.float64, "Pa", "pressure three steps before", **KEPT),
        Field("normal", "vector", np.float64, "", "unit normal of a wall particle, into the fluid"),
        Field("role", "scalar", np.int8, "", "0 inner, 1 surface, 2 wet wall, 3 dry wall, 4 contact line, 5 ballistic"),
        Field("start_role", "scalar", np.int8, "", "role at the start, which a frozen surface keeps", **KEPT),
        Field("phi", "scalar", np.float64, "m^2", "potential of the position projection", **KEPT),
        Field("lack", "scalar", np.float64, "", "density error whose mean over neighbours shows voids", **OWN),
        Field("hollow", "scalar", np.float64, "",
              "density error of the void around the particle at the start, which is subtracted; nan until it is known",
              **KEPT, default=np.nan),
        Field("grad_alpha", "vector", np.float64, "1/m", "gradient of alpha", **OWN),
        Field("grad_u", "tensor", np.float64, "1/s", "velocity gradient, du_a/dx_b", **OWN),
        Field("vorticity", "scalar", np.float64, "1/s", "dv/dx - du/dy of fluid, 0 for walls; computed for snapshots",
              exchanged=False, migrates=False),
        Field("swirl", "scalar", np.float64, "1/s",
              "vorticity in the inertial frame, which inviscid fluid carries from the start; of a wall, that of the "
              "fluid beside it", written=False),
        Field("strain_rate", "scalar", np.float64, "1/s", "rate of strain sqrt(2 S:S)", **OWN),
        Field("turn", "scalar", np.float64, "m", "displacement by which close pairs rotate", **OWN),
        Field("pairs", "scalar", np.int32, "", "close pairs that share a correction", **OWN),
        Field("closing", "scalar", np.int8, "",
              "of a wall particle: 0 without fluid in front of it, 1 free, 2 closing fluid off (kernels.wetness)",
              **OWN),
        Field("share", "scalar", np.float64, "",
              "part of the half cell at a wall particle that fluid represents; of fluid, the part of those around it "
              "that it represents (kernels.halves)", **OWN),
        Field("spare", "scalar", np.float64, "", "half cells of walls that fluid carries away, over s^dim", **OWN),
        Field("beside", "scalar", np.float64, "",
              "half cells of walls that fluid represented at the start, over s^dim", **KEPT),
        Field("weight", "scalar", np.float64, "",
              "cell of the particle over s^dim: of a wall particle, the part inside the fluid (kernels.density); of "
              "inner fluid, that of the stretched lattice at the start", written=False, default=1.0),
        Field("area", "vector", np.float64, "", "area vector of a wall particle over s^(dim-1), 0 for fluid",
              written=False),
        Field("edge", "scalar", np.int8, "",
              "of a wall particle: 0 on a face, 1 on a concave edge, 2 on a convex edge, where it is in no stencil",
              written=False),
        Field("body", "scalar", np.int16, "", "number of the body of a wall particle, -1 for fluid"),
        Field("half", "scalar", np.int8, "",
              "1 for fluid on the surface beside walls at the start: half a cell, whatever its volume", written=False),
        Field("covered", "scalar", np.float64, "",
              "part of a wall particle with fluid in front of it (kernels.wetness), 1 for fluid",
              **OWN, default=1.0),
        Field("rho", "scalar", np.float64, "kg/m^dim", "density of weakly compressible fluid"),
        Field("pull", "vector", np.float64, "m/s^2", "acceleration of weakly compressible fluid", **KEPT),
        Field("no_slip", "scalar", np.int8, "", "1 for a wall particle to which viscous fluid sticks", written=False),
        Field("wall_u", "vector", np.float64, "m/s", "velocity of the wall itself, 0 for fluid", written=False),
        Field("touched", "scalar", np.int8, "",
              "1 for fluid, and for a wall particle whose friction fluid feels (kernels.wetness)", **OWN),
        Field("nu", "scalar", np.float64, "m^2/s", "kinematic viscosity, that of eddies included",
              exchanged=False, migrates=False),
        Field("viscous", "vector", np.float64, "m/s^2", "acceleration by viscosity", exchanged=False, migrates=False),
        Field("friction", "vector", np.float64, "m/s^2", "acceleration by the friction of walls",
              exchanged=False, migrates=False),
        Field("surface_pressure", "scalar", np.float64, "Pa",
              "pressure that balances the viscous stress normal to a free surface", exchanged=False, migrates=False),
        Field("acceleration", "vector", np.float64, "m/s^2", "of fluid in the last step", **KEPT),
        Field("acceleration_before", "vector", np.float64, "m/s^2", "of fluid one step before", **KEPT),
        Field("expansion", "scalar", np.float64, "", "relative volume that residual divergence has made",
              exchanged=False),
        Field("left", "scalar", np.float64, "1/s", "residual divergence of the last step, by its operators", **KEPT),
        Field("halfway", "vector", np.float64, "m/s", "velocity predicted for the middle of the step",
              migrates=False, written=False),
        Field("alpha", "scalar", np.float64, "", "kernel-sum density over its lattice value", default=1.0),
    )
}

# Every scene has these.
CORE = ("id", "kind", "corner", "x", "x0", "u", "volume", "p", "normal", "role")

EVERY = FieldSet(FIELDS)
