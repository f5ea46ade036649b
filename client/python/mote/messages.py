# SPDX-License-Identifier: GPL-3.0-or-later
"""The messages of protocol/mote.proto, as classes made from the descriptor set that the build leaves beside this file.

``new("View")`` makes a message, ``to_message`` fills one from plain Python values as a script's JSON has them, and
``to_dict`` is the way back. Any thread.
"""
from __future__ import annotations

import os
import sys
import threading
from typing import Any, Dict, Iterator

from .errors import Error

Message = Any
"""A message of the schema: its classes are made while the program runs, so no checker knows them."""

_classes: Dict[str, Any] = {}
_lock = threading.Lock()
_factory: Any = None


def descriptor_file() -> str:
    """Where the schema lies."""
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "mote.desc")


def _files(data: bytes) -> Iterator[bytes]:
    """The files of a FileDescriptorSet, whose only field is 1, in the order in which they need each other."""
    at = 0
    while at < len(data):
        if data[at] != 0x0A:
            raise Error("corrupt", descriptor_file(), "is no descriptor set; build Mote again")
        at += 1
        size = shift = 0
        while True:
            byte = data[at]
            at += 1
            size |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                break
        yield data[at : at + size]
        at += size


def _read_descriptors() -> bytes:
    try:
        with open(descriptor_file(), "rb") as file:
            return file.read()
    except OSError:
        raise Error("not_found", descriptor_file(),
                    "the messages are made by Mote's build: cmake --build --preset release --target python") from None


class _Factory:
    """Makes classes; protobuf 3 and 4 have different functions for it."""

    def __init__(self) -> None:
        try:
            from google.protobuf import descriptor_pool, message_factory
        except ImportError as error:
            raise ImportError(f"mote needs the packages protobuf, numpy, zstandard and pillow, and {sys.executable} has no "
                              "protobuf; Debian's are python3-protobuf, python3-numpy, python3-zstandard and python3-pil, for "
                              "/usr/bin/python3", name=error.name) from None

        self.pool = descriptor_pool.DescriptorPool()
        for file in _files(_read_descriptors()):
            self.pool.AddSerializedFile(file)
        if hasattr(message_factory, "GetMessageClass"):
            self.make = message_factory.GetMessageClass
        else:
            self.make = message_factory.MessageFactory(self.pool).GetPrototype


def message_class(name: str) -> Any:
    """The class of a message, by its name in the schema: ``"View"``, ``"JobStatus"``."""
    global _factory
    found = _classes.get(name)
    if found is not None:
        return found
    with _lock:
        if _factory is None:
            _factory = _Factory()
        made = _factory.make(_factory.pool.FindMessageTypeByName("mote.proto." + name))
        _classes[name] = made
        return made


def new(name: str) -> Message:
    """An empty message."""
    return message_class(name)()


def parse(name: str, data: bytes) -> Message:
    """A message from its bytes. Raises Error (corrupt)."""
    message = new(name)
    try:
        message.ParseFromString(bytes(data))
    except Exception:
        raise Error("corrupt", "message", "the server sent bytes that are no message") from None
    return message


def to_dict(message: Message) -> Dict[str, Any]:
    """A message as its JSON would be: fields in lowerCamelCase, those of 64 bits as numbers, defaults left out."""
    from .plain import from_message

    fields: Dict[str, Any] = from_message(message)
    return fields


def to_message(name: str, value: Any, where: str = "") -> Message:
    """A message from plain values. Raises Error (invalid_argument) with the path of what is wrong."""
    from .plain import fill

    message = new(name)
    fill(message, value, where)
    return message
