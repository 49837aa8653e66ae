"""The registry of particle fields: one place that says what each array is."""

from dataclasses import dataclass

import numpy as np

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

    Attributes
    ----------
    shape : "scalar" for (n,), "vector" for (n, dim), "tensor" for (n, dim, dim)
    unit, meaning : for people and for file attributes
    exchanged : part of the first message that fills a new ghost
    migrates : moves with its particle to another rank, and is in checkpoints
    written : may be asked for in snapshots
    """

    name: str
    shape: str
    dtype: type
    unit: str
    meaning: str
    exchanged: bool = True
    migrates: bool = True
    written: bool = True

    def empty(self, n, dim):
        """Return a zeroed array for n particles in dim dimensions."""
        return np.zeros((n, *(dim,) * ORDER[self.shape]), dtype=self.dtype)


FIELDS = {
    field.name: field
    for field in (
        Field("id", "scalar", np.int64, "", "number of the particle, the same for the whole run"),
        Field("kind", "scalar", np.int8, "", "0 fluid, 1 wall"),
        Field("corner", "scalar", np.int8, "", "1 for a wall particle in a corner", written=False),
        Field("x", "vector", np.float64, "m", "position"),
        Field("x0", "vector", np.float64, "m", "position at the start of the step", exchanged=False, written=False),
        Field("u", "vector", np.float64, "m/s", "velocity"),
        Field("volume", "scalar", np.float64, "m^dim", "volume of fluid that the particle stands for, always; 0 for walls"),
        Field("p", "scalar", np.float64, "Pa", "pressure"),
        Field("normal", "vector", np.float64, "", "unit normal of a wall particle, into the fluid"),
        Field("role", "scalar", np.int8, "", "0 inner, 1 surface, 2 wet wall, 3 dry wall, 4 contact line, 5 ballistic"),
        Field("start_role", "scalar", np.int8, "", "role at the start of the run, which a frozen surface gives back", exchanged=False,
              written=False),
        Field("phi", "scalar", np.float64, "m^2", "potential of the position projection", exchanged=False, written=False),
        Field("grad_alpha", "vector", np.float64, "1/m", "gradient of alpha", exchanged=False, migrates=False, written=False),
        Field("grad_u", "tensor", np.float64, "1/s", "velocity gradient, du_a/dx_b", exchanged=False, migrates=False, written=False),
        Field("strain_rate", "scalar", np.float64, "1/s", "rate of strain sqrt(2 S:S)", exchanged=False, migrates=False, written=False),
        Field("turn", "scalar", np.float64, "m", "displacement by which close pairs turn", exchanged=False, migrates=False, written=False),
        Field("pairs", "scalar", np.int32, "", "close pairs that share a correction", exchanged=False, migrates=False, written=False),
        Field("closing", "scalar", np.int8, "", "of a wall particle: 0 apart from fluid in front of it, 1 free, 2 closing fluid off (kernels.wetness)",
              exchanged=False, migrates=False, written=False),
        Field("share", "scalar", np.float64, "", "part of the half cell at a wall particle for which fluid stands (kernels.halves), 1 for fluid",
              exchanged=False, migrates=False, written=False),
        Field("alpha", "scalar", np.float64, "", "kernel-sum density over its lattice value"),
    )
}
