"""The base of every part of a case: frozen, validated, with errors in plain words."""

import difflib

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
    return "\n".join(dict.fromkeys(_line(item, model) for item in error.errors()))


def _positional(model):
    return [name for name in model.model_fields if name != "kind"]


def _line(item, model):
    loc, kind, given = item["loc"], item["type"], item.get("input")
    place = ".".join([model.__name__, *(str(part) for part in loc if not _is_schema_tag(part))])
    context = item.get("ctx", {})
    if kind == "value_error":
        return _with_place(place, str(context["error"]), loc)
    if kind == "extra_forbidden":
        return _unknown_field(model, loc)
    if kind in ("missing", "missing_argument"):
        return f"{place} is missing: give {_meaning(model, loc) or 'a value'}"
    message = item["msg"].removeprefix("Input should be ")
    meaning = _meaning(model, loc)
    remedy = f" ({meaning})" if meaning else ""
    return f"{place} = {given!r}: must be {message}{remedy}"


def _with_place(place, message, loc):
    """Put the place before each line of our own message, unless it starts with a place already."""
    lines = message.split("\n")
    return "\n".join(line if not loc else f"{place}: {line}" for line in lines)


def _is_schema_tag(part):
    """True for pydantic's names of union members, which say nothing to a user."""
    return isinstance(part, str) and (part in ("float", "str", "none") or "[" in part or part[:1].isupper())


def _unknown_field(model, loc):
    owner = _owner(model, loc[:-1]) or model
    names = list(owner.model_fields)
    close = difflib.get_close_matches(str(loc[-1]), names, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"{owner.__name__} has no field {loc[-1]!r}{hint} (its fields: {', '.join(names)})"


def _owner(model, loc):
    """Return the record class that the location leads to, or None where it cannot be told."""
    for part in loc:
        known = {cls.__name__: cls for cls in _all_models(Model)}
        if part in known:
            model = known[part]
        elif isinstance(part, str) and model is not None and part in model.model_fields:
            annotation = model.model_fields[part].annotation
            model = annotation if isinstance(annotation, type) and issubclass(annotation, Model) else None
    return model


def _all_models(cls):
    for child in cls.__subclasses__():
        yield child
        yield from _all_models(child)


def _meaning(model, loc):
    owner = _owner(model, loc[:-1])
    if owner is None or not loc or loc[-1] not in owner.model_fields:
        owner, loc = model, loc[:1]
    info = owner.model_fields.get(loc[-1]) if loc else None
    return info.description if info else None
