"""When Python looks for garbage: seldom during the start of a run, as usual in its steps.

A start makes some 150,000 objects that stay, in libraries, models and kernels. Python would go through all of them
again and again, which costs as much as to load a library.
"""

import gc

SELDOM = 500_000    # new objects between two searches: more than a start makes
USUAL = gc.get_threshold()


def put_off() -> None:
    """Search seldom until `as_usual` is called. For a process of parisph's own. Not collective."""
    gc.set_threshold(SELDOM, *USUAL[1:])


def as_usual() -> None:
    """Search as often as before `put_off`, in what is made from now on; do nothing without it. Not collective."""
    if gc.get_threshold()[0] == SELDOM:
        gc.freeze()
        gc.set_threshold(*USUAL)
