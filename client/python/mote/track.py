# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways of particles through the steps, by id."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, List, Sequence, Tuple

from . import queries
from .connection import Connection
from .errors import Error
from .question import Answer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


def _piece(answers: List[Answer], names: Sequence[str]) -> Tuple[NDArray[np.uint64], NDArray[np.float64]]:
    """ids, and values[step, particle, column]: all steps tell of the same ids."""
    import numpy as np

    ids, values = None, []
    for answer in answers:
        first, *others = queries.columns_of(answer, ["id", *names])
        if ids is not None and not np.array_equal(ids, first):
            raise Error("corrupt", "answer.columns", "the server's steps tell of different particles")
        ids = first
        values.append(np.stack(others, axis=1) if others else np.empty((len(first), 0)))
    assert ids is not None
    return ids, np.stack(values)


def track(connection: Connection, dataset: str, asked: queries.Asked, select: Any,
          names: Sequence[str]) -> Tuple[NDArray[np.uint64], NDArray[np.float64]]:
    """Piece by piece, each of all steps."""
    import numpy as np

    pieces = []
    begin = 0
    while True:
        columns = {"names": ["id", *names], "begin": begin, "byId": True}
        answers = queries.query(connection, dataset, asked, select, columns=columns)
        pieces.append(_piece(answers, names))
        ends = {(answer.message.answer.columns.end, answer.message.answer.columns.next) for answer in answers}
        if all(end for end, _ in ends):
            break
        if len(ends) > 1 or max(ends)[1] <= begin:
            raise Error("corrupt", "answer.columns.next", "the server's pieces do not go on")
        begin = max(ends)[1]
    return np.concatenate([ids for ids, _ in pieces]), np.concatenate([path for _, path in pieces], axis=1)
