"""Particles as the store sees them: the rows of one rank, with every field of the registry filled."""

import numpy as np

from parisph.base.fields import EVERY, FIELDS


class OwnedRows:
    """Rows [offset, offset + n_owned) of `n_global` made-up particles, the same for any spread over ranks."""

    def __init__(self, counts, rank, dim=2, seed=1):
        self.fields, self.dim, self.n_owned, self.n_global = EVERY, dim, counts[rank], sum(counts)
        self.offset = sum(counts[:rank])
        for name, data in everything(self.n_global, dim, seed).items():
            setattr(self, name, data[self.offset:self.offset + self.n_owned])


def everything(n, dim=2, seed=1):
    """All rows of all fields, as a dict; ids are a permutation, as after a migration."""
    random = np.random.default_rng(seed)
    arrays = {}
    for name, field in FIELDS.items():
        shape = field.empty(n, dim).shape
        small = np.issubdtype(field.dtype, np.integer)
        arrays[name] = (random.integers(0, 2, shape) if small else random.normal(size=shape)).astype(field.dtype)
    arrays["id"] = random.permutation(n).astype(np.int64)
    return arrays
