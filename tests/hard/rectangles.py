"""Rectangles of fluid without gravity that hit each other or a wall, against pressure-impulse theory."""

import numpy as np

from parisph.case.schema import Box, Case, Fluid, Numerics, Tank
from tests.hard.flow import Bench, History
from tests.hard.impulse import lost_energy
from tests.hard.scene import Scene
from tests.hard.table import Line

SPEED, SIDE, GAP = 1.0, 1.0, 4      # [m/s], [m], spacings between the bodies, or to the wall
TOUCHED = 0.02                      # of the theoretical loss: from then on there is contact
FIRST, LATER = 0.05, 0.3            # times side/speed after contact: the end of its first steps, and of the second look


def colliding(resolution: int) -> Case:
    """Return two squares that meet head on at x = 0. resolution : spacings a side"""
    s = SIDE / resolution
    fluids = [Fluid(Box(width=SIDE, height=SIDE, at=(at, 0.0)), density=1000.0, velocity=(speed, 0.0))
              for at, speed in ((-0.5 * GAP * s - SIDE, SPEED), (0.5 * GAP * s, -SPEED))]
    return Case(title="colliding squares", fluid=fluids, gravity=(0.0, 0.0), numerics=Numerics(spacing=s),
                end_time=(0.5 * GAP * s + 0.6 * SIDE) / SPEED)


def against_wall(resolution: int) -> Case:
    """Return a square that flies into the left wall of a wide tank. resolution : spacings a side"""
    s = SIDE / resolution
    fluid = Fluid(Box(width=SIDE, height=SIDE, at=(GAP * s, SIDE)), density=1000.0, velocity=(-SPEED, 0.0))
    return Case(title="square against a wall", fluid=fluid, walls=Tank(width=2.0 * SIDE, height=3.0 * SIDE, lid=True),
                gravity=(0.0, 0.0), numerics=Numerics(spacing=s), end_time=(GAP * s + 0.6 * SIDE) / SPEED)


def impact(bench: Bench, case: Case, coarser: float = 1.0) -> list[Line]:
    """The energy that is lost in the first steps of contact, and how it grows.

    coarser : times the errors that are allowed at 40 spacings a side
    """
    theory = lost_energy(SIDE, SIDE)
    found = History.of(bench, case)
    loss = (1.0 - found.kinetic / found.kinetic[0]) / theory
    touched = np.flatnonzero(loss > TOUCHED)
    if not len(touched):
        return [Line("contacts", 0, 1, least=True)]
    contact = found.time[touched[0]]
    first, later = (np.interp(contact + part * SIDE / SPEED, found.time, loss) for part in (FIRST, LATER))
    until = (found.time > contact + FIRST * SIDE / SPEED) & (found.time < contact + LATER * SIDE / SPEED)
    growth = max(later, loss[until].max(initial=0.0)) / first - 1.0
    return [Line(f"energy lost {FIRST:g} h/U after contact / theory ({theory:.4f} of all)", first),
            Line("its error", abs(first - 1.0), 0.05 * coarser),
            Line(f"growth of the loss until {LATER:g} h/U, of itself", growth, 0.1 * coarser),
            Line(f"decrease of the loss until {LATER:g} h/U, of itself", 1.0 - loss[until].min(initial=first) / first),
            Line("energy lost before contact / theory", loss[:touched[0]].max(initial=0.0)),
            Line("largest rise of the energy above its start", found.energy_rise())]


SCENES = {
    "rectangles-meet": Scene("two squares, 40 spacings a side, that meet", lambda bench: impact(bench, colliding(40))),
    "rectangles-wall": Scene("a square, 40 spacings a side, and a wall", lambda bench: impact(bench, against_wall(40))),
}
# so coarse that twice the error is allowed
QUICK = {"rectangles-meet": Scene("two squares, 16 spacings a side", lambda bench: impact(bench, colliding(16), 2.0))}
