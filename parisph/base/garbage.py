"""When Python looks for garbage: seldom during the start of a run, as usual in its steps.

A start makes some 150,000 objects that stay, in libraries, models and kernels. Python would go through all of them
again and again, which costs as much as to load a library.
"""

import gc

SELDOM = 500_000    # new objects between two searches: more than a start makes, but compiling kernels is not without

_usual: list[tuple[int, int, int]] = []    # thresholds before `put_off`


def put_off() -> None:
    """Search seldom until `as_usual` is called. For a process of parisph's own. Not collective."""
    if not _usual:
        _usual.append(gc.get_threshold())
        gc.set_threshold(SELDOM, *_usual[0][1:])


def as_usual() -> None:
    """Search as often as before `put_off`, in what is made from now on; do nothing without it. Not collective."""
    if _usual:
        gc.freeze()
        gc.set_threshold(*_usual.pop())
