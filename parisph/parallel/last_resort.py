"""Let a second signal end this rank even if Python cannot run.

PETSc and HDF5 hold Python's global lock while they wait for other ranks. If they hang, the thread that
reads signals (base.signals) cannot run. A compiled function in another thread does not need the lock,
and checks whether signals stay unread.
"""

import socket
import threading

import numpy as np

from parisph.base.signals import CODE, NUMBERS, Signals
from parisph.kernels.jit import unlocked
from parisph.kernels.processor import numba

PATIENCE = 6.0    # [s] that a second signal may stay unread: more than base.signals.PATIENCE
SLICE = 0.1       # [s] between two looks

types = numba.types

_recv = types.ExternalFunction("recv", types.intp(types.int32, types.intp, types.uintp, types.int32))
_write = types.ExternalFunction("write", types.intp(types.int32, types.intp, types.uintp))
_usleep = types.ExternalFunction("usleep", types.int32(types.uint32))
_exit = types.ExternalFunction("_exit", types.void(types.int32))


def arm(signals: Signals) -> None:
    """Start the thread for Signals that end several ranks; it ends with them. Not collective."""
    if signals.abort is None or signals.socket is None or signals.helper is not None:
        return
    signals.taken = np.array(signals.taken, np.int64)
    text = np.frombuffer(b"parisph: stopped at once by a second signal, while this rank waited for another\n",
                         np.uint8).copy()
    values = (signals.socket.fileno(), socket.MSG_PEEK, socket.MSG_PEEK | socket.MSG_DONTWAIT, signals.taken,
              np.array(NUMBERS, np.uint8), int(PATIENCE / SLICE), int(1e6 * SLICE), text, CODE)
    signals.helper = threading.Thread(target=_watch, args=values, name="last resort", daemon=True)
    signals.helper.start()


@unlocked
def _watch(source, peek, peek_now, taken, numbers, patience, pause, text, code):
    """Return when the socket is shut down; end the process if a second signal is unread for `patience` pauses."""
    unread = np.empty(64, np.uint8)
    while _recv(source, unread.ctypes.data, 64, peek) > 0:
        for k in range(patience + 1):
            _usleep(pause)
            n = _recv(source, unread.ctypes.data, 64, peek_now)
            if n <= 0:
                break
            signals = taken[0]
            for i in range(n):
                for number in numbers:
                    signals += unread[i] == number
            if k == patience and signals >= 2:
                _write(2, text.ctypes.data, len(text))
                _exit(code)
