"""Messages about a case: one line in plain words for each problem that pydantic finds."""

import difflib
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from parisph.base.text import shown
from parisph.case.described import given

MOST_LINES = 10     # problems in one message
PLAIN = {           # replaces pydantic's programmers' terms
    "string_type": "a text", "tuple_type": "several values, as in (1, 2)", "bool_type": "True or False",
    "float_type": "a number", "int_type": "a whole number", "int_from_float": "a whole number",
}
SHAPES = ("Box", "Disc", "Polygon", "Tank")
OSCILLATIONS = ("Sway", "Heave", "Roll", "Pitch", "Yaw", "Turn")
BODIES = ("Obstacle", "Plate", "Profile", "Tank", "Piston", "Flap")
# Field names of other codes: (classes, names, what parisph has instead)
MEANT = (
    ((*SHAPES, *BODIES, "Case", "Fluid"), ("depth", "breadth", "thickness", "dim", "z"),
     "a Tank(..., breadth=) or Profile(..., breadth=) makes a scene 3D, with z up, and other bodies have ends "
     "across=(ya, yb); without one it is 2D, y is up, and forces are per metre of breadth"),
    (BODIES, ("density", "mass", "inertia", "moment_of_inertia", "floating", "free", "mooring", "spring"),
     "bodies move only as given, by motion=, and none floats"),
    (BODIES, ("velocity", "speed", "acceleration", "displacement"),
     "bodies move by motion=, such as Sway(...), Heave(...), Roll(...) or Moved(Series(...))"),
    (("Roll",), ("axis", "yaw", "pitch"),
     "a Roll turns the section, in 3D about y; Pitch turns about x, Yaw about z, Turn about any axis"),
    (("Pitch", "Yaw"), ("axis", "direction"), "Pitch turns about x, Yaw about z, and Turn about any axis"),
    (OSCILLATIONS, ("omega", "w"), "give frequency [rad/s] or period [s]"),
    (OSCILLATIONS, ("stroke",), "give amplitude, half of the stroke"),
    (("Case",), ("spacing", "preset", "method"), "that is one of numerics=Numerics(...)"),
    (("Fluid",), ("width", "height", "radius", "level", "at"), "that is one of its shape, such as Box(...)"),
)


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """Return one line for each problem of a pydantic ValidationError raised by `model`."""
    lines: dict[tuple[str, bool], str] = {}
    unknown: dict[type[BaseModel], list[str]] = {}
    for item in error.errors(include_url=False):
        # A value of a union fails once for each member; the first message is enough.
        place, owner, _ = _follow(model, item["loc"])
        if item["type"] == "extra_forbidden":
            unknown.setdefault(owner, []).append(str(item["loc"][-1]))
        else:
            lines.setdefault((place, item["type"] == "value_error"), _line(item, model))
    return first_lines([*(_unknown_fields(owner, names) for owner, names in unknown.items()), *lines.values()])


def first_lines(problems: Sequence[str]) -> str:
    """Return problems as text, one line each; of many, the first ones and the number of the others."""
    left = len(problems) - MOST_LINES
    return "\n".join([*problems[:MOST_LINES], *([f"and {left:,} more problems like these"] if left > 0 else [])])


def _line(item: Mapping[str, Any], model: type[BaseModel]) -> str:
    """Return one problem in plain words: field, value, limit and remedy."""
    kind, given, context = item["type"], item.get("input"), item.get("ctx", {})
    place, owner, name = _follow(model, item["loc"])
    if kind == "value_error":  # a message of parisph, possibly of several lines
        return "\n".join(f"{place}: {line}" if item["loc"] else line for line in str(context["error"]).split("\n"))
    if kind == "values":
        return "\n".join(f"{place}.{name}{inside} = {value}: must be {limit}{_meaning(context['owner'], name)}"
                         for name, inside, value, limit in context["found"])
    if kind == "missing":
        meaning = owner.model_fields[name].description if name in owner.model_fields else None
        return f"{place} is missing: give {meaning or 'a value'}"
    if kind == "json_invalid":
        return f"{place} cannot be read: {item['msg']}"
    return f"{place} = {shown(given)}: must be {_limit(item, context)}{_meaning(owner, name)}"


def _meaning(owner: type[BaseModel], name: Any) -> str:
    """Return the description of a field in brackets, or ""."""
    meaning = owner.model_fields[name].description if name in owner.model_fields else None
    return f" ({meaning})" if meaning else ""


def _limit(item: Mapping[str, Any], context: Mapping[str, Any]) -> str:
    kind = item["type"]
    if kind == "too_short":
        return f"at least {context['min_length']} values, not {context['actual_length']}"
    if kind in ("string_too_short", "string_too_long"):
        return f"a text of {'at least' if 'short' in kind else 'at most'} {next(iter(context.values()))} characters"
    if kind == "too_long":
        return f"at most {context['max_length']} values"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return f"of a known kind: {context.get('expected_tags', 'give one by its class')}"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return "an object of the right class"
    if kind in PLAIN:
        return PLAIN[kind]
    return str(item["msg"]).removeprefix("Input should be ")


def _unknown_fields(owner: type[BaseModel], names: Sequence[str]) -> str:
    """Return the message about names that are not fields of a record, with what it has instead."""
    known = list(given(owner))
    wrong, meant, hints = list(dict.fromkeys(names)), [], []
    for name in wrong:
        hint = next((text for classes, words, text in MEANT if owner.__name__ in classes and name in words), None)
        if hint is None:
            meant += difflib.get_close_matches(name, known, n=1)
        elif hint not in hints:
            hints.append(hint)
    parts = [f"{owner.__name__} has no field{'s' if len(wrong) > 1 else ''} {', '.join(map(shown, wrong))}", *hints]
    if meant:
        parts.append(f"did you mean {', '.join(map(repr, dict.fromkeys(meant)))}?")
    return f"{'; '.join(parts)} (its fields: {', '.join(known) or 'none'})"


def _follow(model: type[BaseModel], loc: Sequence[str | int]) -> tuple[str, type[BaseModel], Any]:
    """Follow a pydantic location through the records.

    Return the place as text, such as Case.probes[0].at, the record class that owns the last field, and the name of that
    field. Pydantic's names of union members are left out: they do not help users.
    """
    place, owner, name, inside = model.__name__, model, None, [model]
    for part in loc:
        with_field = [cls for cls in inside if part in cls.model_fields]
        if with_field:
            owner, name = with_field[0], part
            place += f".{part}"
            inside = list(_models_in(owner.model_fields[str(part)].annotation))
        elif isinstance(part, int):
            place += f"[{part}]"
        else:
            inside = [cls for cls in inside if part in (cls.__name__, _tag(cls))] or inside
            owner = inside[0] if inside else owner
    return place, owner, name


def _tag(cls: type[BaseModel]) -> str | None:
    return cls.model_fields["kind"].default if "kind" in cls.model_fields else None


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the record classes that an annotation mentions."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
        for derived in annotation.__subclasses__():    # as of Probe
            yield from _models_in(derived)
    for part in typing.get_args(annotation):
        yield from _models_in(part)
