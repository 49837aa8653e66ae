"""Processor time that a rank spends in kernels, measured from outside: every call is timed where the step makes it."""

from time import thread_time

from parisph.methods import boundary, operators, positions, projection, straining, surfaces, velocities
from parisph.parallel import domain
from parisph.pressure import rows

_CALLED_FROM = {
    projection: ("gradients",), surfaces: ("surface",), velocities: ("collisions", "films"), straining: ("strain",),
    positions: ("pairs", "shifting"), boundary: ("density", "nearest_walls"),
    operators: ("gradient", "laplacian", "rankine", "walls"), rows: ("rankine", "surface_rows", "compress"),
    domain: ("neighbour_lists",),
}


class KernelTime:
    """Times the kernels of a step from now on, in this process; `seconds` so far."""

    def __init__(self):
        self.seconds = 0.0
        for module, names in _CALLED_FROM.items():
            for name in names:
                found = getattr(module, name)
                setattr(module, name, self._timed(found) if callable(found) else _Timed(found, self._timed))

    def _timed(self, function):
        def call(*args, **options):
            start = thread_time()
            try:
                return function(*args, **options)
            finally:
                self.seconds += thread_time() - start
        return call


class _Timed:
    """A module of kernels, each of which is timed when it is called."""

    def __init__(self, module, timed):
        self._module, self._wrap = module, timed

    def __getattr__(self, name):
        found = getattr(self._module, name)
        return self._wrap(found) if callable(found) else found
