"""Tables of a report: the volume and the energy of a run, from summary.json."""

from parisph.case.expressions import uniform_field
from parisph.case.schema import Case
from parisph.report.account import SUMMARY, Content
from parisph.report.entries import Cell, CellTable, number

MOTION_HEAD = ("", "at the start", "at the end", "change, of that at the start", "highest", "at")
VOLUME = (
    "The volume is the mean cell inside the fluid, relative to that at the start, once in several steps and at the end "
    "of the run. A probe of the volume has samples at other steps, and is relative to the square of the spacing: its "
    "extremes may differ a little."
)
WHOLE = (
    "The energy drift is relative to the whole energy, with potential energy above the lowest corner of the tank. For "
    "low waves, nearly all of it is that of still water."
)
MOVING = (
    "The energy in motion is that of waves and flow: the kinetic energy plus the potential energy above that of the "
    "fluid at rest. If it is a small part of the whole energy, it is a small difference of large numbers: a change of "
    "volume, or a start that is not a lattice, changes it more than the flow does. In 2D, if the water fills the width "
    "of a tank without other walls, it is computed from the elevation of the surface."
)
KINETIC = "No potential energy is computed for this body force: the energy is the kinetic energy alone."


def drift(case: Case, summary: Content) -> CellTable:
    """Return the changes of volume and energy since the start."""
    energy = "energy change (work is done on the fluid)" if summary.get("driven") else "energy drift"
    if not case.same_force_everywhere:
        energy = "change of the kinetic energy (work is done on the fluid)"
    extremes = (("low", "+.3%", ""), ("low_time", ".4g", "s"), ("high", "+.3%", ""), ("high_time", ".4g", "s"))
    rows = []
    for what, kind in (("volume drift", "volume"), (energy, "energy")):
        end = number(summary, SUMMARY, [f"{kind}_drift"], "+.3%")
        rows.append((Cell(what), end, *(number(summary, SUMMARY, [f"{kind}_range", name], form, unit)
                                        for name, form, unit in extremes)))
    return CellTable(("", "at the end", "lowest", "at", "highest", "at"), tuple(rows))


def motion(summary: Content) -> CellTable:
    """Return the energy in motion at the start, at the end and at its highest; no row if it is not defined."""
    found = summary.get("energy_in_motion") or {}
    unit = str(found.get("unit") or "")
    row = (Cell("energy in motion"), *(
        number(summary, SUMMARY, ["energy_in_motion", name], form, of)
        for name, form, of in (("start", ".4g", unit), ("end", ".4g", unit), ("drift", "+.2%", ""),
                               ("high", ".4g", unit), ("high_time", ".4g", "s"))))
    return CellTable(MOTION_HEAD, (row,) if found else ())


def lost(summary: Content) -> list[str]:
    """Return a sentence on water that has left over the rim of an open tank, [] without any."""
    left = summary.get("left") or {}
    count, volume = left.get("particles"), left.get("volume")
    if not count:
        return []
    many = "1 particle has" if count == 1 else f"{count} particles have"
    return [f"{many} left over the rim, with a volume of {volume:.3g} m³/m."]


def drift_notes(case: Case, summary: Content) -> list[str]:
    """Return the explanations of `drift` and `motion`."""
    pulled = uniform_field(case.gravity)
    energy = [] if pulled is None or case.turns else [WHOLE] * bool(pulled.any())
    energy += [] if case.same_force_everywhere else [KINETIC]
    return [VOLUME, *energy, *([MOVING] if motion(summary).rows else [])]
