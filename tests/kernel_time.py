"""Processor time that a rank spends in kernels, measured from outside: every call is timed where the step makes it."""

import sys
from time import thread_time
from types import ModuleType

KERNELS = "parisph.kernels"


class KernelTime:
    """Times the kernels of a step from now on, in this process; `seconds` so far.

    All modules of parisph outside the kernels that are loaded by now time what they import from these.
    """

    def __init__(self):
        self.seconds = 0.0
        for name, module in list(sys.modules.items()):
            if name.startswith("parisph.") and not name.startswith(KERNELS):
                for key, found in list(vars(module).items()):
                    if isinstance(found, ModuleType):
                        if found.__name__.startswith(KERNELS + "."):
                            setattr(module, key, _Timed(found, self._timed))
                    elif _is_kernel(found):
                        setattr(module, key, self._timed(found))

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
        return self._wrap(found) if _is_kernel(found) else found


def _is_kernel(found):
    own = str(getattr(found, "__module__", "")).startswith(KERNELS)
    return own and callable(found) and not isinstance(found, type)
