"""The particles of one rank: a struct of arrays, [owned | ghost]."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from parisph.base.arrays import Array, Ints
from parisph.base.communicator import Communicator
from parisph.base.errors import CaseError, agree
from parisph.base.fields import EVERY, FieldSet
from parisph.kernels.jit import axes_of
from parisph.kernels.records import Cloud

GROWTH = 1.2  # spare room of arrays, so changes in the number of ghosts do not reallocate


class Particles:
    """One array per field of the scene, the owned particles first, then the ghosts.

    For each name in `fields`, for example u: `p.u` is the view of the owned particles, (n_owned,) or (n_owned, dim),
    and `p.u_all` that of owned and ghost particles, (n_all, ...), in the units of the registry. Ghosts are copies of
    other ranks' particles; only the halo writes them. `p.u = values` copies into the view. Views are stale after
    `assign` and after a redistribution.

    Attributes
    ----------
    comm, dim, fields
    n_owned, n_ghost, n_all : int, on this rank
    offset : int, global row of the first owned particle; the rows of a rank are contiguous
    offsets : (ranks + 1,) int64, offsets of all ranks, and the total
    n_global : int, over all ranks
    n_assigned : int, number of calls of `assign`
    """

    comm: Any    # mpi4py's, or a stand-in of a test
    dim: int
    fields: FieldSet
    n_owned: int
    n_ghost: int
    n_assigned: int
    offsets: Ints
    _store: dict[str, Array]

    def __init__(self, comm: Communicator, dim: int, fields: FieldSet = EVERY) -> None:
        if dim not in (2, 3):
            raise CaseError(f"dimension {dim}: particles live in 2 or 3 dimensions")
        vars(self).update(comm=comm, dim=dim, fields=fields, n_owned=0, n_ghost=0, n_assigned=0,
                          offsets=np.zeros(comm.size + 1, np.int64), _store={})
        self._reserve(0)
        self._expose()

    @property
    def n_all(self) -> int:
        return self.n_owned + self.n_ghost

    @property
    def offset(self) -> int:
        return int(self.offsets[self.comm.rank])

    @property
    def n_global(self) -> int:
        return int(self.offsets[-1])

    def __setattr__(self, name: str, values: Any) -> None:
        view = vars(self).get(name)
        if name not in self.fields and name.removesuffix("_all") not in self.fields:
            object.__setattr__(self, name, values)
        elif view is not None and values is not view:  # `p.u += a` has already changed it in place
            view[...] = values

    def __getattr__(self, name: str) -> Array:
        # called only for missing names
        raise AttributeError(f"these particles have no {name!r}: no part of the scene's method declares such a field")

    # -- contents --------------------------------------------------------------------------

    def assign(self, arrays: Mapping[str, Array]) -> None:
        """Replace all particles; missing fields get their default, ghosts are dropped. Collective.

        Parameters
        ----------
        arrays : dict of field name -> (n,) or (n, dim), this rank's particles; must contain x

        Raises
        ------
        CaseError on every rank: an unknown name, x missing, or a wrong shape on some rank.
        """
        error = self._fault(arrays)
        agree(self.comm, None if error is None else CaseError(error))
        self.resize(0, 0)
        self.resize(len(arrays["x"]), 0)
        for name, field in self.fields.items():
            getattr(self, name)[...] = arrays.get(name, field.default)
        self.n_assigned += 1
        self.renumber()

    def _fault(self, arrays: Mapping[str, Array]) -> str | None:
        unknown = sorted(set(arrays) - set(self.fields))
        if unknown:
            return f"no such particle field: {', '.join(unknown)} (this scene has {', '.join(self.fields)})"
        if "x" not in arrays:
            return "particles need positions: x is missing"
        for name, values in arrays.items():
            due = self.fields[name].empty(0, self.dim).shape[1:]
            if np.shape(values) != (len(arrays["x"]), *due):
                return f"field {name} has shape {np.shape(values)}, not {(len(arrays['x']), *due)}"
        return None

    def renumber(self) -> None:
        """Update the global rows after the number of owned particles has changed. Collective."""
        counts = np.array([self.n_owned])
        if self.comm.size > 1:    # numbers, as thousands of ranks would take milliseconds to read objects
            counts = np.empty(self.comm.size, np.int64)
            self.comm.Allgather(np.array([self.n_owned], np.int64), counts)
        self.offsets[1:] = np.cumsum(counts)

    def resize(self, n_owned: int, n_ghost: int) -> None:
        """Set the numbers of particles of this rank. Owned ones are kept, up to the new number.

        Added particles and all ghosts are undefined. Not collective: call `renumber` after a change of n_owned.
        """
        self._reserve(n_owned + n_ghost)
        self.n_owned, self.n_ghost = n_owned, n_ghost
        self._expose()

    def reorder(self, order: Ints) -> None:
        """Keep the owned particles `order` (n,), int, in that order; drop ghosts. Not collective."""
        for array in self._store.values():
            array[:len(order)] = array[:self.n_owned][order]
        self.resize(len(order), 0)

    def cloud(self, indptr: Array, indices: Array, spacing: float) -> Cloud:
        """Return the record for kernels, with these CSR lists of neighbours."""
        return Cloud(self.x_all, self.kind_all, self.role_all, self.normal_all, self.corner_all, self.volume_all,
                     indptr, indices, spacing, axes_of(self.dim))

    # -- storage ---------------------------------------------------------------------------

    def _reserve(self, n: int) -> None:
        for name, field in self.fields.items():
            old = self._store.get(name)
            if old is None or len(old) < n:
                new = field.empty(int(GROWTH * n), self.dim)
                if old is not None:
                    new[:self.n_owned] = old[:self.n_owned]
                self._store[name] = new

    def _expose(self) -> None:
        """Set the views as plain attributes, which are fast to read."""
        for name, array in self._store.items():
            vars(self)[name] = array[:self.n_owned]
            vars(self)[f"{name}_all"] = array[:self.n_all]
