"""What checkers, editors, inspect.signature and help() see of records: their fields, not pydantic's names."""

import inspect
import types
import typing
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, Field, PrivateAttr
from pydantic.fields import FieldInfo
from typing_extensions import dataclass_transform

if TYPE_CHECKING:    # a private name of pydantic
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)


def given(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields that a user may give, by name: all but `kind`."""
    return {name: field for name, field in model.model_fields.items() if name != "kind"}


# PEP 681: checkers and editors read the arguments of a record from its fields. A default must be written default=...; a
# field without a default after one with a default needs kw_only=True; a field that users cannot give needs init=False.
@dataclass_transform(frozen_default=True, field_specifiers=(Field, PrivateAttr))
class Described(ModelMetaclass):
    """The metaclass of all records. A record has the signature of its fields; help() omits what pydantic adds."""

    @property
    def __signature__(cls) -> inspect.Signature:
        """Fields in their order, with types and defaults; those with kw_only=True come last."""
        found = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY if field.kw_only
                                   else inspect.Parameter.POSITIONAL_OR_KEYWORD,
                                   default=inspect.Parameter.empty if field.is_required()
                                   else field.get_default(call_default_factory=True),
                                   annotation=_bare(field.annotation))
                 for name, field in given(typing.cast(type[BaseModel], cls)).items()]
        return inspect.Signature(sorted(found, key=lambda parameter: parameter.kind))

    @__signature__.setter
    def __signature__(cls, _: Any) -> None:
        """Ignore the signature that pydantic sets."""

    def __dir__(cls) -> list[str]:
        """Return the names that records define themselves; the others work too."""
        own = {name for base in cls.__mro__ if base not in BaseModel.__mro__ for name in vars(base)}
        return sorted(name for name in own if not name.startswith(("_", "model_")))


def _bare(annotation: Any) -> Any:
    """Return a type without the limits and descriptions that pydantic reads from it."""
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return _bare(parts[0])
    if origin in (typing.Union, types.UnionType):
        return typing.Union[tuple(_bare(part) for part in parts)]
    if origin is tuple:
        return tuple[tuple(_bare(part) for part in parts)]    # type: ignore[misc]    # made at run time
    return annotation
