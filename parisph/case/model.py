"""The base of every part of a case: frozen, validated, with errors in plain words."""

import difflib
import typing

from pydantic import BaseModel, ConfigDict, ValidationError

from parisph.base.errors import CaseError


class Model(BaseModel):
    """A frozen, validated record.

    Fields may be given by position, in the order in which the class lists them, or by name.

    Raises
    ------
    CaseError : one line for each problem, with field, value, limit and remedy.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True)

    def __init__(self, *args, **kwargs):
        names = _positional(type(self))
        if len(args) > len(names):
            raise CaseError(
                f"{type(self).__name__} takes at most {len(names)} values by position ({', '.join(names)}), got {len(args)}"
            )
        for name, value in zip(names, args):
            if name in kwargs:
                raise CaseError(f"{type(self).__name__}.{name} is given twice, by position and by name")
            kwargs[name] = value
        try:
            super().__init__(**kwargs)
        except ValidationError as error:
            raise CaseError(explain(error, type(self))) from None

    # Without this mark pydantic would call __init__ for nested records too, and the
    # place of an error inside a stored case would be lost.
    __init__.__pydantic_base_init__ = True

    @classmethod
    def model_validate(cls, *args, **kwargs):
        """Build from a dictionary. Raises CaseError."""
        try:
            return super().model_validate(*args, **kwargs)
        except ValidationError as error:
            raise CaseError(explain(error, cls)) from None

    @classmethod
    def model_validate_json(cls, *args, **kwargs):
        """Build from JSON text. Raises CaseError."""
        try:
            return super().model_validate_json(*args, **kwargs)
        except ValidationError as error:
            raise CaseError(explain(error, cls)) from None


def explain(error, model):
    """Return one line for each problem of a pydantic ValidationError raised by `model`."""
    lines = {}
    for item in error.errors():
        # A value that may be of several types fails once for each of them; the first says enough.
        place = _follow(model, item["loc"])[0]
        lines.setdefault((place, item["type"] == "value_error"), _line(item, model))
    return "\n".join(lines.values())


def _positional(model):
    return [name for name in model.model_fields if name != "kind"]


def _line(item, model):
    """Return one problem in plain words: field, value, limit and remedy."""
    kind, given, context = item["type"], item.get("input"), item.get("ctx", {})
    place, owner, name = _follow(model, item["loc"])
    if kind == "value_error":  # our own message, which may have several lines
        return "\n".join(f"{place}: {line}" if item["loc"] else line for line in str(context["error"]).split("\n"))
    if kind == "extra_forbidden":
        return _unknown_field(owner, item["loc"][-1])
    meaning = owner.model_fields[name].description if name in owner.model_fields else None
    if kind == "missing":
        return f"{place} is missing: give {meaning or 'a value'}"
    if kind == "json_invalid":
        return f"{place} cannot be read: {item['msg']}"
    return f"{place} = {given!r}: must be {_limit(item, context)}{f' ({meaning})' if meaning else ''}"


def _limit(item, context):
    kind = item["type"]
    if kind == "too_short":
        return f"at least {context['min_length']} values, not {context['actual_length']}"
    if kind == "too_long":
        return f"at most {context['max_length']} values"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return f"of a known kind: {context.get('expected_tags', 'give one by its class')}"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return "an object of the right class"
    return item["msg"].removeprefix("Input should be ")


def _unknown_field(owner, name):
    names = list(owner.model_fields)
    close = difflib.get_close_matches(str(name), names, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"{owner.__name__} has no field {name!r}{hint} (its fields: {', '.join(names)})"


def _follow(model, loc):
    """Follow a pydantic location through the records.

    Returns the place in words, such as Case.probes[0].at; the record class that owns the last field;
    and the name of that field. Pydantic's names of union members are left out: they say nothing to a
    user.
    """
    place, owner, name, inside = model.__name__, model, None, [model]
    for part in loc:
        with_field = [cls for cls in inside if part in cls.model_fields]
        if with_field:
            owner, name = with_field[0], part
            place += f".{part}"
            inside = list(_models_in(owner.model_fields[part].annotation))
        elif isinstance(part, int):
            place += f"[{part}]"
        else:
            inside = [cls for cls in inside if part in (cls.__name__, _tag(cls))] or inside
            owner = inside[0] if inside else owner
    return place, owner, name


def _tag(cls):
    return cls.model_fields["kind"].default if "kind" in cls.model_fields else None


def _models_in(annotation):
    """Yield the record classes that an annotation mentions."""
    if isinstance(annotation, type) and issubclass(annotation, Model):
        yield annotation
    for part in typing.get_args(annotation):
        yield from _models_in(part)
