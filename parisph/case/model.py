"""The base class of every part of a case: frozen, validated, with clear errors."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError
from typing_extensions import Self

from parisph.base.errors import CaseError
from parisph.base.text import shown
from parisph.case import values
from parisph.case.described import Described, given
from parisph.case.faults import explain

_T = TypeVar("_T")
if TYPE_CHECKING:
    Several = Sequence[_T]    # a list may be given
else:
    Several = tuple[_T, ...]


class Model(BaseModel, metaclass=Described):
    """A frozen, validated record.

    Fields may be given by position, in the order in which the class lists them, or by name.

    Raises CaseError: one line for each problem, with field, value, limit and remedy.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True,
                              defer_build=True)    # a run uses few of all records

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        names = list(given(type(self)))
        if len(args) > len(names):
            raise CaseError(
                f"{type(self).__name__} takes at most {len(names)} values by position ({', '.join(names)}), "
                f"got {len(args)}"
            )
        for name, value in zip(names, args):
            if name in kwargs:
                raise CaseError(f"{type(self).__name__}.{name} is given twice, by position and by name")
            kwargs[name] = value
        try:
            super().__init__(**kwargs)
        except ValidationError as error:
            raise CaseError(explain(error, type(self))) from None

    # Without this mark pydantic calls __init__ for nested records, and loses the place of an error in a stored case.
    setattr(__init__, "__pydantic_base_init__", True)

    @model_validator(mode="before")
    @classmethod
    def _values_of_their_kind(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        # as text: pydantic cannot pass on an integer of thousands of digits
        found = [(name, place, shown(value), limit)
                 for name, place, value, limit in values.faults(cls.model_fields, data)]
        if found:
            raise PydanticCustomError("values", "wrong values", {"owner": cls, "found": found})
        return data

    @classmethod
    def model_validate(cls, *args: Any, **kwargs: Any) -> Self:
        """Build from a dictionary. Raises CaseError."""
        try:
            return super().model_validate(*args, **kwargs)
        except ValidationError as error:
            raise CaseError(explain(error, cls)) from None

    @classmethod
    def model_validate_json(cls, *args: Any, **kwargs: Any) -> Self:
        """Build from JSON text. Raises CaseError."""
        try:
            return super().model_validate_json(*args, **kwargs)
        except ValidationError as error:
            raise CaseError(explain(error, cls)) from None
