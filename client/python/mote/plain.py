# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages from plain Python values, and back.

Fields may be named as in JSON (``colorMap``) or as in the schema (``color_map``); numpy's arrays and numbers are
lists and numbers; ``None`` is as good as absent, an empty list of a selection is not. An unknown field or a bad value is an Error that names its path.
Any thread.
"""
from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Iterator, Mapping, Set
from typing import Any, Callable, Dict, List

from . import arguments
from .errors import Error, invalid
from .messages import Message

_LIST = "google.protobuf.ListValue"
_SELECTION = "mote.proto.Selection"

# Numbers of protobuf's CppType, which is the same in all of its versions.
_INT32, _INT64, _UINT32, _UINT64, _DOUBLE, _FLOAT, _BOOL, _ENUM, _STRING, _MESSAGE = range(1, 11)
_RANGES = {_INT32: (-(2**31), 2**31 - 1), _INT64: (-(2**63), 2**63 - 1), _UINT32: (0, 2**32 - 1),
           _UINT64: (0, 2**64 - 1)}
_REPEATED, _BYTES = 3, 12


_of_kind = arguments.told


def _integer(field: Any, value: Any, where: str) -> int:
    # Beyond 2^53 a float is not the number that somebody wrote.
    if isinstance(value, float) and value.is_integer() and abs(value) < 2**53:
        value = int(value)
    try:
        number = operator.index(value)
    except TypeError:
        raise invalid(where, f"is a whole number, not the {_of_kind(value)}") from None
    low, high = _RANGES[field.cpp_type]
    if isinstance(value, bool) or not low <= number <= high:
        raise invalid(where, f"is a whole number from {low} to {high}, not {value!r}")
    return number


def _real(field: Any, value: Any, where: str) -> float:
    return arguments.number(value, where)


def _boolean(field: Any, value: Any, where: str) -> bool:
    return arguments.flag(value, where)


def _text(field: Any, value: Any, where: str) -> Any:
    if field.type == _BYTES and isinstance(value, (bytes, bytearray)):
        return bytes(value)
    if isinstance(value, str):
        return str(value)
    raise invalid(where, f"is a text, not the {_of_kind(value)}")


def _enumerator(field: Any, value: Any, where: str) -> int:
    names = field.enum_type.values_by_name
    if isinstance(value, str) and value.upper() in names:
        return int(names[value.upper()].number)
    raise invalid(where, f"is one of {', '.join(names)}, not the {_of_kind(value)}")


_SCALARS: Dict[int, Callable[[Any, Any, str], Any]] = {
    _INT32: _integer, _INT64: _integer, _UINT32: _integer, _UINT64: _integer,
    _DOUBLE: _real, _FLOAT: _real, _BOOL: _boolean, _STRING: _text, _ENUM: _enumerator}


def _items(value: Any, where: str, any_order: bool = False) -> List[Any]:
    if isinstance(value, Iterator):
        raise invalid(where, f"is a list, not the {type(value).__name__}, which gives its items but once")
    if any_order and isinstance(value, Set):
        return list(value)
    return arguments.items(value, where)


def _fill_list(message: Message, value: Any, where: str) -> None:
    """google.protobuf.ListValue: numbers, as all lists of lists of the schema."""
    for index, item in enumerate(_items(value, where)):
        message.values.add().number_value = _real(None, item, f"{where}[{index}]")


def _put(message: Message, value: Any, where: str) -> None:
    """Into one message, whatever it is."""
    if message.DESCRIPTOR.full_name == _LIST:
        _fill_list(message, value, where)
    else:
        fill(message, value, where)


def _fill_repeated(message: Message, field: Any, value: Any, where: str) -> None:
    target = getattr(message, field.name)
    items = _items(value, where, field.name == "ids")
    if field.cpp_type == _MESSAGE:
        for index, item in enumerate(items):
            _put(target.add(), item, f"{where}[{index}]")
        return
    scalar = _SCALARS[field.cpp_type]
    target.extend([scalar(field, item, f"{where}[{index}]") for index, item in enumerate(items)])


def _fill_field(message: Message, field: Any, value: Any, where: str) -> None:
    if field.label == _REPEATED:
        _fill_repeated(message, field, value, where)
    elif field.cpp_type == _MESSAGE:
        target = getattr(message, field.name)
        target.SetInParent()
        _put(target, value, where)
    else:
        setattr(message, field.name, _SCALARS[field.cpp_type](field, value, where))


def _field(descriptor: Any, name: Any, where: str) -> Any:
    found = isinstance(name, str) and descriptor.fields_by_camelcase_name.get(name) or descriptor.fields_by_name.get(name)
    for field in descriptor.fields:
        if field.json_name == name:
            found = field
    if not found:
        names = ", ".join(field.json_name for field in descriptor.fields)
        raise invalid(where, f"there is no field {name!r}; there are {names}")
    return found


def _is_empty_list(message: Message, field: Any) -> bool:
    return field.label == _REPEATED and message.DESCRIPTOR.full_name == _SELECTION and not getattr(message, field.name)


def fill(message: Message, value: Any, where: str = "") -> None:
    """Fills an empty message. A list of a selection that is there and empty selects nothing. Raises Error
    (invalid_argument)."""
    if hasattr(value, "to_dict"):
        value = value.to_dict()
    if not isinstance(value, Mapping):
        raise invalid(where or message.DESCRIPTOR.name, f"is a mapping of fields, not the {_of_kind(value)}")
    given, nothing = set(), False
    for name, item in value.items():
        if item is None:
            continue
        field = _field(message.DESCRIPTOR, name, where)
        place = f"{where}.{name}" if where else str(name)
        oneof = field.containing_oneof
        taken = message.WhichOneof(oneof.name) if oneof else None
        if taken is not None and taken != field.name:
            raise invalid(where, f"holds both {taken!r} and {field.name!r} where only one may be")
        if field.name in given:
            raise invalid(place, "is given twice, under both of its names")
        given.add(field.name)
        _fill_field(message, field, item, place)
        nothing = nothing or _is_empty_list(message, field)
    if nothing:  # whatever it says of that itself
        message.nothing = True


def _value(field: Any, value: Any) -> Any:
    if field.cpp_type == _MESSAGE:
        return from_message(value)
    if field.cpp_type == _ENUM:
        found = field.enum_type.values_by_number.get(value)
        return found.name if found else value
    return value


def from_message(message: Message) -> Any:
    """Plain values of what is set in a message."""
    if message.DESCRIPTOR.full_name == _LIST:
        return [item.number_value for item in message.values]
    plain: Dict[str, Any] = {}
    for field, value in message.ListFields():
        if field.label == _REPEATED:
            plain[field.json_name] = [_value(field, item) for item in value]
        else:
            plain[field.json_name] = _value(field, value)
    return plain


def check_finite(values: Iterable[float], where: str) -> None:
    """Raises Error where one of them is infinite."""
    for value in values:
        if not math.isfinite(value):
            raise Error("invalid_argument", where, f"{value} is not finite")
