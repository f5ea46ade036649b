# SPDX-License-Identifier: GPL-3.0-or-later
"""Files beneath a server's roots: what lies in a folder, and what a file holds before anything is made of it."""
from __future__ import annotations

import math
from typing import Any, Dict, List, NamedTuple

from .connection import Connection
from .errors import Error, invalid
from .messages import Message, new

_KINDS = ("unknown", "file", "folder", "dataset")
_FROM_MINOR = 5


class File(NamedTuple):
    """Something in a folder."""

    path: str
    """As jobs and other calls take it: "ROOT/PATH"."""
    name: str
    kind: str
    """ "file", "folder" or "dataset"."""
    size: int
    """Bytes, of a file."""
    changed: float
    """Unix time, s; NaN: not known."""


class Files(List[File]):
    """What a folder holds: folders first, then by name."""

    notes: List[str]
    """What is left out, a sentence each."""


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise invalid(where, f"is a text, not the {type(value).__name__}")
    return value


def _check_version(connection: Connection) -> None:
    welcome = connection.welcome
    if welcome is not None and welcome.minor < _FROM_MINOR:
        raise Error("unsupported", "server", f"{welcome.server} is older than this package and tells nothing of its files")


def list_folder(connection: Connection, folder: str) -> Files:
    """As Session.files."""
    _check_version(connection)
    files = Files()
    files.notes = []
    while True:
        message = new("ClientMessage")
        message.list_folder.folder = _text(folder, "folder")
        message.list_folder.first = len(files)
        page = connection.ask(message, "folder").message.folder
        files.extend(_file_of(folder, entry) for entry in page.entries)
        files.notes = list(page.notes)
        if not page.entries or len(files) >= page.total:
            return files


def _file_of(folder: str, entry: Message) -> File:
    kind = _KINDS[entry.kind] if 0 <= entry.kind < len(_KINDS) else _KINDS[0]
    changed = entry.changed_ms / 1000 if entry.changed_ms else math.nan
    return File(f"{folder}/{entry.name}" if folder else entry.name, entry.name, kind, entry.bytes, changed)


def look(connection: Connection, path: str, format: str, map: str) -> Dict[str, Any]:
    """As Session.look."""
    _check_version(connection)
    message = new("ClientMessage")
    message.look_at_file.input = _text(path, "path")
    message.look_at_file.format = _text(format, "format")
    message.look_at_file.map = _text(map, "map")
    told = connection.ask(message, "look").message.look
    return {"input": told.input, "found": [_found(each) for each in told.found], "refused": list(told.refused)}


def _found(found: Message) -> Dict[str, Any]:
    columns = [{"name": column.name, "unit": column.unit, "min": column.min if column.HasField("min") else math.nan,
                "max": column.max if column.HasField("max") else math.nan, "invalid": column.invalid}
               for column in found.columns]
    name = {"name": found.name} if found.name else {}
    return {"kind": found.kind, "format": found.format, "toldBy": found.told_by, **name,
            **{name: _plain(value) for name, value in found.facts.fields.items()},
            "lines": [{"label": line.label, "text": line.text} for line in found.lines], "columns": columns,
            "notes": list(found.notes), "refused": list(found.refused)}


def _plain(value: Message) -> Any:
    """What JSON has; whole numbers are such."""
    kind = value.WhichOneof("kind")
    if kind == "list_value":
        return [_plain(each) for each in value.list_value.values]
    if kind == "struct_value":
        return {name: _plain(each) for name, each in value.struct_value.fields.items()}
    if kind == "number_value":
        number = float(value.number_value)
        return int(number) if number.is_integer() and abs(number) < 2**53 else number
    if kind in (None, "null_value"):
        return math.nan
    return getattr(value, kind)
