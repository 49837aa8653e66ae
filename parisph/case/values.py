"""Rules for every value of a case, checked before pydantic converts values.

pydantic alone accepts True for 1.0 and '0.1' for 0.1, numbers whose squares are infinite, and titles
with line breaks, which would add lines to a log.
"""

import typing
from collections.abc import Iterator, Mapping
from numbers import Number
from typing import Any

import numpy as np
from pydantic.fields import FieldInfo

from parisph.base.text import is_plain

LARGEST = 1e30            # in SI units: products of several quantities stay finite
SMALLEST = 1e-30          # of values that must be positive
MOST_VALUES = 10**6       # in one field
MOST_CHARACTERS = 10_000  # of one text
FEW = 100                 # values: fewer are checked one by one
_SCALARS = {bool, int, float, str}


def faults(fields: Mapping[str, FieldInfo], data: Mapping[str, Any]) -> Iterator[tuple[str, str, Any, str]]:
    """Yield (field, place in it, value, limit) for each value that is not allowed.

    fields : {name: pydantic FieldInfo}; data : {name: value} before validation. The place is '' or as '[1]'.
    """
    for name, value in data.items():
        kinds = _kinds(fields[name].annotation) if name in fields else None
        if kinds and not _are_sound(value, kinds):
            positive = any(getattr(item, "gt", None) == 0 for item in fields[name].metadata)
            for count, (place, item) in enumerate(_items(value)):
                limit = (_fault(item, kinds, positive) if count < MOST_VALUES
                         else f"one of at most {MOST_VALUES:,} values")
                if limit:
                    yield name, "".join(f"[{number}]" for number in place), item, limit
                    break


def _are_sound(value: Any, kinds: set[type]) -> bool:
    """Return whether a value is a long tuple of allowed floats, which is quicker than a check one by one."""
    if type(value) is not tuple or not FEW < len(value) <= MOST_VALUES or float not in kinds:
        return False
    if set(map(type, value)) != {float}:
        return False
    size = np.abs(np.array(value))
    return bool(np.all((size <= LARGEST) & ((size >= SMALLEST) | (size == 0.0))))


def _fault(item: Any, kinds: set[type], positive: bool) -> str | None:
    flag = isinstance(item, (bool, np.bool_))
    if kinds == {bool}:
        # pydantic knows whether the field may be a record
        return None if flag or hasattr(type(item), "model_fields") else "True or False"
    if flag and bool not in kinds:
        return "a text" if kinds == {str} else "a number"
    if isinstance(item, (str, bytes)):
        return _fault_of_text(item, kinds)
    if isinstance(item, Number) and not flag and kinds & {int, float}:
        return _fault_of_size(item, positive)
    return None


def _fault_of_text(text: str | bytes, kinds: set[type]) -> str | None:
    if str not in kinds:
        return "a number"
    if isinstance(text, bytes):
        return "a text"
    if len(text) > MOST_CHARACTERS:
        return f"a text of at most {MOST_CHARACTERS:,} characters"
    return None if is_plain(text) else "one line of text, without control characters"


def _fault_of_size(number: Any, positive: bool) -> str | None:
    try:
        size = abs(float(number))
    except OverflowError:       # an integer of hundreds of digits
        size = 2.0 * LARGEST
    except (TypeError, ValueError):
        return None             # such as complex: pydantic reports it
    if LARGEST < size < np.inf:
        return f"at most {LARGEST:g} in size"
    return f"at least {SMALLEST:g}" if positive and 0.0 < size < SMALLEST else None


def _items(value: Any, place: tuple[int, ...] = (), depth: int = 3) -> Iterator[tuple[tuple[int, ...], Any]]:
    """Yield (indices, value) of nested lists and tuples; records (dict or object) are checked separately."""
    if isinstance(value, (list, tuple)) and depth:
        for number, item in enumerate(value):
            yield from _items(item, (*place, number), depth - 1)
    elif not isinstance(value, dict) and value is not None:
        yield place, value


def _kinds(annotation: Any) -> set[type]:
    """Return the types among bool, int, float and str in an annotation; a Literal of texts counts as str."""
    if typing.get_origin(annotation) is typing.Literal:
        return {type(value) for value in typing.get_args(annotation)} & _SCALARS
    found = {annotation} & _SCALARS if isinstance(annotation, type) else set()
    return found.union(*map(_kinds, typing.get_args(annotation)))
