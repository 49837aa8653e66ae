"""Tables of a report: the scene and its numbers, the parameters, the files and versions."""

from collections.abc import Iterator
from typing import Any

from pydantic import TypeAdapter, ValidationError

from parisph.base.errors import CaseError
from parisph.base.json_digest import MADE
from parisph.case.wave_sizes import size_of
from parisph.case.waves import AnyWave
from parisph.report.account import CASE, SUMMARY, Content, named_rows
from parisph.report.entries import Cell, CellTable, number

# Numbers of waves and motions in the table, with their units.
TOLD = {"height": "m", "amplitude": "m", "period": "s", "length": "m", "depth": "m", "frequency": "rad/s",
        "angle": "rad", "ramp": "s", "gamma": "", "seed": ""}
PARTICLES = (("particles", ["particles"]), ("of these, fluid", ["fluid_particles"]),
             ("of these, on walls", ["wall_particles"]))
# Lengths of walls, and of shapes of fluid, in the table: {entry: name}.
LENGTHS = {"width": "width", "height": "height"}
OF_FLUID = {"width": "width", "height": "depth", "radius": "radius", "level": "level"}
LIMITED = 20    # bodies in the table
Rows = Iterator[tuple[str, Cell]]
Place = list[Any]


def conditions(case: Content, summary: Content) -> CellTable:
    """Return scene, resolution, duration and method."""
    origin = [("scene of", number(case, CASE, ["source"]))] if case.get("source") else []
    jitter = [("jitter of the particles at the start", number(case, CASE, ["numerics", "jitter"], ".3g", "spacings")),
              ("seed of the jitter", number(case, CASE, ["numerics", "seed"], "d"))]
    return named_rows([
        ("status", number(summary, SUMMARY, ["status"])), *origin, *_scene(case),
        ("spacing", number(case, CASE, ["numerics", "spacing"], ".6g", "m")),
        *((name, number(summary, SUMMARY, path, "d")) for name, path in PARTICLES if path[0] in summary),
        *(jitter if case["numerics"].get("jitter") else []),
        ("duration", number(case, CASE, ["end_time"], ".6g", "s")),
        ("time reached", number(summary, SUMMARY, ["time"], ".6g", "s")),
        ("steps", number(summary, SUMMARY, ["steps"], "d")),
        ("time step", Cell("adaptive") if case["numerics"].get("time_step") is None
         else number(case, CASE, ["numerics", "time_step"], ".6g", "s")),
        ("method", number(case, CASE, ["numerics", "method"])), ("preset", number(case, CASE, ["numerics", "preset"]))])


def parameters(case: Content) -> CellTable:
    """Return the parameters of the case file; no rows if they are not known."""
    values, given = _made(case).get("parameters"), _made(case).get("given")
    given = given if isinstance(given, list) else []
    return CellTable(("parameter", "value", ""), tuple(
        (Cell(name), number(case, CASE, [MADE, "parameters", name], ".6g") if value is not None else Cell("none"),
         Cell("given" if name in given else "default")) for name, value in
        (values.items() if isinstance(values, dict) else ())))


def making(case: Content, summary: Content) -> CellTable:
    """Return case file, date, machine, command, options and versions of a run."""
    made = _made(case)
    names = (("case file", "case_file"), ("digest of its text", "case_digest"), ("date", "date"), ("machine", "host"),
             ("its cores", "cores"), ("command", "command"))
    rows = [(name, number(case, CASE, [MADE, key], "d")) for name, key in names if made.get(key) is not None]
    restarts = made.get("restarts")
    rows += [("continued", number(case, CASE, [MADE, "restarts", k, "date"]))
             for k in range(len(restarts) if isinstance(restarts, list) else 0)]
    rows += [("ranks", number(summary, SUMMARY, ["ranks"], "d")),
             ("parisph", number(summary, SUMMARY, ["parisph_version"])),
             ("PETSc options", number(summary, SUMMARY, ["petsc_options"]))]
    versions = summary.get("versions")
    rows += [(name, number(summary, SUMMARY, ["versions", name])) for name in
             (versions if isinstance(versions, dict) else ())]
    return named_rows(rows)


def _made(case: Content) -> dict[str, Any]:
    made = case.get(MADE)
    return made if isinstance(made, dict) else {}


def _scene(case: Content) -> Rows:
    """Yield (name, Cell) of tank, fluid, waves, motions, friction and zones."""
    for body, place in _placed(case, "walls"):
        name = body.get("name") or body.get("kind", "tank")
        yield from _lengths(case, place, name, LENGTHS)
        if body.get("lid"):
            yield f"{name}, lid", Cell("yes")
    for fluid, place in _placed(case, "fluid"):
        name = "fluid" if isinstance(case["fluid"], dict) else f"fluid {place[-1] + 1}"
        lengths = list(_lengths(case, [*place, "shape"], name, OF_FLUID))
        yield from lengths or [(f"{name}, shape", number(case, CASE, [*place, "shape", "kind"]))]
        yield f"{name}, density", number(case, CASE, [*place, "density"], ".6g", "kg/m³")
        if fluid.get("viscosity"):
            yield f"{name}, viscosity", number(case, CASE, [*place, "viscosity"], ".4g", "m²/s")
        yield from _moves(case, [*place, "wave"], fluid.get("wave"), f"wave at the start in {name}")
    yield from _moves(case, ["frame"], case.get("frame"), "motion of the tank, in whose frame the flow is")
    for body, place in _placed(case, "walls"):
        name = body.get("name") or body.get("kind", "wall")
        for what in ("motion", "wave"):    # a wavemaker has one of them
            yield from _moves(case, [*place, what], body.get(what), f"{what} of {name}")
    if case.get("friction"):
        yield "friction on walls, viscosity", number(case, CASE, ["friction", "viscosity"], ".3g", "m²/s")
        yield "friction on walls, roughness", number(case, CASE, ["friction", "roughness"], ".3g", "m")
    for k, zone in enumerate(case.get("absorb") or ()):
        yield f"{zone['kind']} from x", number(case, CASE, ["absorb", k, "start"], ".4g", "m")
        yield f"{zone['kind']}, length", number(case, CASE, ["absorb", k, "length"], ".4g", "m")
        yield from _moves(case, ["absorb", k, "wave"], zone.get("wave"), f"wave of {zone['kind']}")


def _placed(case: Content, field: str) -> Iterator[tuple[Any, Place]]:
    """Yield each body of a field of a case (none, one or a list) with its place in case.json."""
    found = case.get(field)
    if isinstance(found, list):
        yield from ((item, [field, k]) for k, item in enumerate(found[:LIMITED]))
    elif found:
        yield found, [field]


def _lengths(case: Content, place: Place, name: str, told: dict[str, str]) -> Rows:
    """Yield the lengths [m] of a body. told : {entry: name}"""
    for key, called in told.items():
        cell = number(case, CASE, [*place, key], ".6g", "m")
        if cell.text != "-":
            yield f"{name}, {called}", cell


def _moves(case: Content, place: Place, what: Any, name: str) -> Rows:
    """Yield kind and numbers of a wave or a motion (dict); nothing without one."""
    if not isinstance(what, dict) or what.get("kind", "at_rest") == "at_rest":
        return
    yield name, number(case, CASE, [*place, "kind"])
    given = {key: unit for key, unit in TOLD.items() if isinstance(what.get(key), (int, float))}
    if "amplitude" in given and "centre" in what:    # of a turn about it
        given["amplitude"] = "rad"
    for key, unit in given.items():
        yield f"{name}, {key}", number(case, CASE, [*place, key], ".6g", unit)
    for k, part in enumerate(what.get("parts") or ()):    # of several motions
        yield from _moves(case, [*place, "parts", k], part, f"{name}, part {k + 1}")
    if isinstance(what.get("wave"), dict):    # of a stroke
        yield from _moves(case, [*place, "wave"], what["wave"], f"wave of the {name}")
    length = _length(what)
    if length is not None and "length" not in given:
        yield f"{name}, length", Cell(f"{length:.4g} m", f"{CASE}: {'/'.join(map(str, [*place, 'period']))}")


def _length(wave: dict[str, Any]) -> float | None:
    """Return the length [m] of a wave (dict) with a period, at the peak if it is irregular; None for others."""
    if not {"period", "depth", "height"} <= wave.keys():
        return None
    try:
        return float(size_of("wave", TypeAdapter(AnyWave).validate_python(wave), 0.0).length)
    except (CaseError, ValidationError, ValueError, TypeError, ZeroDivisionError):
        return None
