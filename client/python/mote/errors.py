# SPDX-License-Identifier: GPL-3.0-or-later
"""Error: all that can go wrong between Python and a server, as one sentence with a code and a place; CoarseNumbers: what
limits numbers that are right."""
from __future__ import annotations

import os
import sys
import warnings
from typing import Iterable, List

_PACKAGE = os.path.dirname(os.path.abspath(__file__))

# What a terminal obeys and does not show: C0, DEL and C1. Texts of a server or dataset may hold any of them.
_SHOWN = {code: f"\\x{code:02x}" for code in [*range(0x20), *range(0x7F, 0xA0)]}


class Error(Exception):
    """What went wrong, from the server or from this package.

    Attributes:
        code: ``"invalid_argument"``, ``"not_found"``, ``"already_exists"``, ``"permission_denied"``, ``"corrupt"``,
            ``"unsupported"``, ``"resource_exhausted"``, ``"cancelled"`` or ``"internal"``.
        where: a field's path, a file or a position; may be empty.
        message: one sentence.

    ``str(error)`` is fit for a terminal: control characters are shown as ``\\xNN``.
    """

    def __init__(self, code: str, where: str, message: str) -> None:
        super().__init__(code, where, message)
        self.code = code
        self.where = where
        self.message = message

    def __str__(self) -> str:
        text = f"{self.where}: {self.message}" if self.where else self.message
        return text.translate(_SHOWN)

    def within(self, place: str) -> Error:
        """The same error with a place put before its own: "views[0]" and "camera" give "views[0].camera"."""
        joint = "" if not self.where or self.where.startswith("[") else "."
        return Error(self.code, place + joint + self.where, self.message)


def invalid(where: str, message: str) -> Error:
    """An argument is wrong."""
    return Error("invalid_argument", where, message)


class CoarseNumbers(UserWarning):
    """A warning: the numbers are of so few or so close particles that the precision of a column shows in them."""


def warn_of(notes: Iterable[str]) -> List[str]:
    """Warns of each sentence once, where the package was called from; gives the sentences."""
    said = list(dict.fromkeys(str(note).translate(_SHOWN) for note in notes))
    if said:
        level, frame = 1, sys._getframe()
        while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
            level, frame = level + 1, frame.f_back
        for note in said:
            warnings.warn(note, CoarseNumbers, stacklevel=level)
    return said
