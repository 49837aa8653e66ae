"""What is wrong with a case, in plain words: one line for each problem that pydantic finds."""

import difflib
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from parisph.base.text import shown

MOST_LINES = 10     # of problems in one message
PLAIN = {           # pydantic's words for what a value must be are those of programmers
    "string_type": "a text", "tuple_type": "several values, as in (1, 2)", "bool_type": "True or False",
    "float_type": "a number", "int_type": "a whole number", "int_from_float": "a whole number",
}


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """Return one line for each problem of a pydantic ValidationError raised by `model`."""
    lines: dict[tuple[str, bool], str] = {}
    for item in error.errors(include_url=False):
        # A value that may be of several types fails once for each of them; the first says enough.
        place = _follow(model, item["loc"])[0]
        lines.setdefault((place, item["type"] == "value_error"), _line(item, model))
    return first_lines(list(lines.values()))


def first_lines(problems: Sequence[str]) -> str:
    """Return problems as text, one line each; of many, the first ones and how many there are."""
    left = len(problems) - MOST_LINES
    return "\n".join([*problems[:MOST_LINES], *([f"and {left:,} more problems like these"] if left > 0 else [])])


def _line(item: Mapping[str, Any], model: type[BaseModel]) -> str:
    """Return one problem in plain words: field, value, limit and remedy."""
    kind, given, context = item["type"], item.get("input"), item.get("ctx", {})
    place, owner, name = _follow(model, item["loc"])
    if kind == "value_error":  # our own message, which may have several lines
        return "\n".join(f"{place}: {line}" if item["loc"] else line for line in str(context["error"]).split("\n"))
    if kind == "values":
        return "\n".join(f"{place}.{name}{inside} = {value}: must be {limit}{_meaning(context['owner'], name)}"
                         for name, inside, value, limit in context["found"])
    if kind == "extra_forbidden":
        return _unknown_field(owner, item["loc"][-1])
    if kind == "missing":
        meaning = owner.model_fields[name].description if name in owner.model_fields else None
        return f"{place} is missing: give {meaning or 'a value'}"
    if kind == "json_invalid":
        return f"{place} cannot be read: {item['msg']}"
    return f"{place} = {shown(given)}: must be {_limit(item, context)}{_meaning(owner, name)}"


def _meaning(owner: type[BaseModel], name: Any) -> str:
    """Return what a field means, in brackets, or nothing."""
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


def _unknown_field(owner: type[BaseModel], name: Any) -> str:
    names = list(owner.model_fields)
    close = difflib.get_close_matches(str(name), names, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"{owner.__name__} has no field {shown(name)}{hint} (its fields: {', '.join(names)})"


def _follow(model: type[BaseModel], loc: Sequence[str | int]) -> tuple[str, type[BaseModel], Any]:
    """Follow a pydantic location through the records.

    Returns the place as text, such as Case.probes[0].at; the record class that owns the last field;
    and the name of that field. Pydantic's names of union members are left out: they do not help users.
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
    for part in typing.get_args(annotation):
        yield from _models_in(part)
