"""What a report says of the volume and the energy of a run, from summary.json."""

from collections.abc import Mapping
from typing import Any

from parisph.case.expressions import uniform_field
from parisph.pictures.style import has_potential
from parisph.report.entries import Cell, CellTable, number

SUMMARY = "summary.json"
MOTION_HEAD = ("", "at the start", "at the end", "change, of that at the start", "highest", "at")
VOLUME = (
    "The volume is the mean cell inside the fluid, relative to that at the start. It is looked at once in several "
    "steps and at the end of the run. A probe of the volume has samples at other steps, and is relative to the square "
    "of the spacing: its extremes may differ a little."
)
WHOLE = (
    "The energy drift is relative to the whole energy, whose potential part is counted from the lowest corner of the "
    "tank. Where waves are low, nearly all of it is that of still water."
)
MOVING = (
    "The energy in motion is the kinetic energy plus the potential energy above that of the fluid at rest: the energy "
    "of the waves and of the flow. Where it is a small part of the whole energy, it is a small difference of large "
    "numbers: a little more or less volume, or a start that is no lattice, changes it more than the flow does. In "
    "2D, where the water fills the width of a tank that is all its walls, it is found from the elevation of the "
    "surface instead."
)
KINETIC = "No potential energy is computed for this body force: the energy is the kinetic energy alone."
Content = Mapping[str, Any]    # of a JSON file


def drift(case: Content, summary: Content) -> CellTable:
    """Return how volume and energy have changed since the start."""
    energy = "energy change (work is done on the fluid)" if summary.get("driven") else "energy drift"
    if not has_potential(case):
        energy = "change of the kinetic energy (work is done on the fluid)"
    extremes = (("low", "+.3%", ""), ("low_time", ".4g", "s"), ("high", "+.3%", ""), ("high_time", ".4g", "s"))
    rows = []
    for what, kind in (("volume drift", "volume"), (energy, "energy")):
        end = number(summary, SUMMARY, [f"{kind}_drift"], "+.3%")
        rows.append((Cell(what), end, *(number(summary, SUMMARY, [f"{kind}_range", name], form, unit)
                                        for name, form, unit in extremes)))
    return CellTable(("", "at the end", "lowest", "at", "highest", "at"), tuple(rows))


def motion(summary: Content) -> CellTable:
    """Return the energy in motion at the start, at the end and at its highest; no row where it is not defined."""
    found = summary.get("energy_in_motion") or {}
    unit = str(found.get("unit") or "")
    row = (Cell("energy in motion"), *(
        number(summary, SUMMARY, ["energy_in_motion", name], form, of)
        for name, form, of in (("start", ".4g", unit), ("end", ".4g", unit), ("drift", "+.2%", ""),
                               ("high", ".4g", unit), ("high_time", ".4g", "s"))))
    return CellTable(MOTION_HEAD, (row,) if found else ())


def lost(summary: Content) -> list[str]:
    """Return what has left the scene over the rim of an open tank, in words; nothing if nothing has."""
    left = summary.get("left") or {}
    count, volume = left.get("particles"), left.get("volume")
    if not count:
        return []
    many = "1 particle has" if count == 1 else f"{count} particles have"
    return [f"{many} left over the rim, with a volume of {volume:.3g} m³/m."]


def drift_notes(case: Content, summary: Content) -> list[str]:
    """Return what the numbers of `drift` and `motion` are relative to, in words."""
    pulled = uniform_field(case["gravity"])
    energy = [WHOLE] if has_potential(case) and pulled is not None and pulled.any() else []
    energy += [] if has_potential(case) else [KINETIC]
    return [VOLUME, *energy, *([MOVING] if motion(summary).rows else [])]
