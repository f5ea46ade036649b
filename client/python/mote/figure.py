# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure: numbers drawn with axes by the server, fit for a paper; it shows itself in notebooks."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Dict

from . import queries
from .errors import Error

if TYPE_CHECKING:
    from .session import Session

_FORMATS = {".png": "PNG", ".svg": "SVG", ".pdf": "PDF"}


class Figure:
    """The result of Dataset.figure(). It is drawn when it is first looked at, and then kept."""

    def __init__(self, session: Session, query: Dict[str, Any], fields: Dict[str, Any]) -> None:
        self._session = session
        self._query = query
        self._fields = fields
        self._drawn: Dict[str, bytes] = {}

    def _draw(self, format: str) -> bytes:
        if format not in self._drawn:
            query = {**self._query, "figure": {**self._fields, "format": format}}
            answer = queries.query_one(self._session.connection, query)
            if answer.message.answer.WhichOneof is None or not answer.payload:
                raise Error("corrupt", "answer.figure", "the server sent no figure")
            self._drawn[format] = bytes(answer.payload)
        return self._drawn[format]

    @property
    def svg(self) -> str:
        """The figure as SVG."""
        return self._draw("SVG").decode("utf-8", "replace")

    @property
    def png(self) -> bytes:
        """The figure as a PNG file."""
        return self._draw("PNG")

    def save(self, path: Any) -> None:
        """Writes it in the format of the file's name: .svg, .pdf or .png."""
        format = _FORMATS.get(os.path.splitext(os.fspath(path))[1].lower())
        if format is None:
            raise Error("unsupported", os.fspath(path), f"figures are written as {', '.join(_FORMATS)}")
        data = self._draw(format)
        with open(path, "wb") as file:
            file.write(data)

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Dict[str, Any]:
        """For notebooks: one copy, which every converter takes."""
        return {"image/png": self.png, "text/plain": repr(self)}

    def __repr__(self) -> str:
        what = self._fields.get("statistics") or [axis["column"] for axis in self._fields["histogram"]["axes"]]
        return f"<mote.Figure of {', '.join(what)}, {self._query['dataset']}>"
