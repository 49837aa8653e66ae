"""How records look to inspect.signature, help() and completion: by their fields and their own words, not pydantic's."""

import inspect
import types
import typing
from collections.abc import Iterable
from typing import Any

from pydantic import BaseModel

_Meta: Any = type(BaseModel)    # whose module is private to pydantic


class Described(_Meta):    # type: ignore[misc]
    """The type of all records. A record has the signature of its fields; help() leaves out what pydantic adds."""

    @property
    def __signature__(cls) -> inspect.Signature:
        """Fields in their order, with types and defaults. From the first that is needed after others on, by name."""
        found: list[inspect.Parameter] = []
        kind: Any = inspect.Parameter.POSITIONAL_OR_KEYWORD
        none = inspect.Parameter.empty
        for name, field in cls.model_fields.items():
            if name != "kind":
                default = none if field.is_required() else field.get_default(call_default_factory=True)
                if default is none and found and found[-1].default is not none:
                    kind = inspect.Parameter.KEYWORD_ONLY
                found.append(inspect.Parameter(name, kind, default=default, annotation=_bare(field.annotation)))
        return inspect.Signature(found)

    @__signature__.setter
    def __signature__(cls, _: Any) -> None:
        """Pydantic sets one of its own."""

    def __dir__(cls) -> Iterable[str]:
        """Names that records define themselves; the others work too."""
        own = {name for base in cls.__mro__ if base not in BaseModel.__mro__ for name in vars(base)}
        return sorted(name for name in own if not name.startswith(("_", "model_")))


def _bare(annotation: Any) -> Any:
    """Return a type without the limits and words that pydantic reads from it."""
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return _bare(parts[0])
    if origin in (typing.Union, types.UnionType):
        return typing.Union[tuple(_bare(part) for part in parts)]
    if origin is tuple:
        return tuple[tuple(_bare(part) for part in parts)]    # type: ignore[misc]
    return annotation
