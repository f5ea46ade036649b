# SPDX-License-Identifier: GPL-3.0-or-later
"""Questions for numbers: what is sent, and how answers become arrays. Sizes are checked; nothing is believed."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Dict, List, NamedTuple, Optional, Tuple, Union

from . import arguments
from .connection import Connection
from .errors import Error, invalid, warn_of
from .messages import Message, new, to_message
from .question import Answer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Steps = Union[None, int, slice, range]
"""One step, some, or all of them (None); negative ones count from the end."""


class Asked(NamedTuple):
    """Steps as a query has them, and whether one was meant."""

    text: str
    indices: List[int]
    single: bool


def steps_of(steps: Any, count: int) -> Asked:
    """Raises Error where there is no such step."""
    if steps is None:
        return Asked("", list(range(count)), False)
    if arguments.is_single(steps):
        return one_step(steps, count)
    chosen = arguments.even_steps(steps, count)
    stride = chosen[1] - chosen[0] if len(chosen) > 1 else 1
    return Asked(f"{chosen[0]}:{chosen[-1]}:{stride}", chosen, False)


def one_step(step: Any, count: int) -> Asked:
    """Raises Error where there is no such step, and where several are meant."""
    if step is None or not arguments.is_single(step):
        raise invalid("step", f"is one step, not the {arguments.told(step)}")
    index = arguments.one_step(step, count)
    return Asked(f"{index}:{index}:1", [index], True)


def query(connection: Connection, dataset: str, asked: Asked, select: Optional[Any], **what: Any) -> List[Answer]:
    """The answers to a query, one a step, in the order of the steps that were asked for."""
    message = new("ClientMessage")
    message.query.CopyFrom(to_message("Query", {"dataset": dataset, "steps": asked.text, "select": select, **what}))
    answers = connection.ask_all(message, "answer")
    got = [answer.message.answer.step for answer in answers]
    if got != asked.indices:
        raise Error("corrupt", "answer", f"the server answered for the steps {got} where {asked.indices} were asked for")
    warn_of(notes_of(answers))
    return answers


def notes_of(answers: List[Answer]) -> List[str]:
    """What limits the numbers, a sentence each, each once."""
    return list(dict.fromkeys(note for answer in answers for note in answer.message.answer.notes))


def query_one(connection: Connection, fields: Dict[str, Any]) -> Answer:
    """The one answer to a query that is of no steps."""
    message = new("ClientMessage")
    message.query.CopyFrom(to_message("Query", fields))
    answer = connection.ask_all(message, "answer")[-1]
    warn_of(notes_of([answer]))
    return answer


def floats(payload: bytearray, count: int, where: str) -> NDArray[np.float64]:
    """So many f64 of a payload, all of it."""
    import numpy as np

    if len(payload) != 8 * count:
        raise Error("corrupt", where, f"the server sent {len(payload)} bytes where {8 * count} belong")
    return np.frombuffer(payload, "<f8").astype(np.float64, copy=False)


# ------------------------------------------------------------------------------------------ statistics

def _typed(name: str, values: NDArray[np.float64]) -> NDArray[Any]:
    import numpy as np

    whole = name.startswith("n_") and bool(np.isfinite(values).all())
    return values.astype(np.int64) if whole else values


def table(names: Sequence[str], rows: Sequence[Sequence[float]], single: bool) -> Dict[str, Any]:
    """Statistics by name: numbers of one step, or arrays over steps."""
    import numpy as np

    values = np.array(rows, np.float64).reshape(len(rows), len(names))
    columns = {name: _typed(name, values[:, index]) for index, name in enumerate(names)}
    return {name: column[0].item() for name, column in columns.items()} if single else columns


def _slices(answers: List[Answer], names: Sequence[str], single: bool) -> Dict[str, Any]:
    import numpy as np

    edges, parts = [], []
    for answer in answers:
        statistics = answer.message.answer.statistics
        count = len(statistics.slices)
        values = [value for part in statistics.slices for value in part.values]
        if len(statistics.slice_edges) != count + 1 or len(values) != count * len(names):
            raise Error("corrupt", "answer.slices", "the server's slices do not belong together")
        edges.append(list(statistics.slice_edges))
        parts.append(np.array(values, np.float64).reshape(count, len(names)))
    if len({part.shape for part in parts}) > 1:
        raise Error("corrupt", "answer.slices", "the server's slices do not belong together")
    stacked = np.stack(parts)
    columns = {name: stacked[0, :, i] if single else stacked[:, :, i] for i, name in enumerate(names)}
    return {"slice_edges": np.array(edges[0] if single else edges, np.float64), "slices": columns}


def statistics_of(answers: List[Answer], single: bool, sliced: bool) -> Dict[str, Any]:
    """Answers to a StatisticsQuery."""
    names: List[str] = []
    rows = []
    for answer in answers:
        statistics = answer.message.answer.statistics
        names = names or list(statistics.names)
        if list(statistics.names) != names or len(statistics.values) != len(names):
            raise Error("corrupt", "answer.statistics", "the server's numbers do not belong to their names")
        rows.append(list(statistics.values))
    columns = table(names, rows, single)
    return {**columns, **_slices(answers, names, single)} if sliced else columns


# ------------------------------------------------------------------------------------------ histograms

def histogram_query(columns: Sequence[str], bins: Any, range: Any, weighted: bool) -> Dict[str, Any]:
    """A HistogramQuery of one or two columns, from what numpy.histogram2d takes."""
    if not 1 <= len(columns) <= 2:
        raise invalid("columns", f"a histogram is of one column or two, not {len(columns)}")
    for name in columns:
        if not isinstance(name, str) or not name:
            raise invalid("columns", f"is the name of a column, not the {arguments.told(name)}")
    counts, ranges = arguments.bins_of(bins, len(columns)), arguments.ranges_of(range, len(columns))
    axes = [{"column": name, "bins": count, "range": limits} for name, count, limits in zip(columns, counts, ranges)]
    return {"axes": axes, "unweighted": not arguments.flag(weighted, "weighted")}


class Histogram(Tuple[Any, Any]):
    """(H, edges), as numpy gives them; and what they rest on.

    Attributes:
        particles: how many, those beyond the ranges left out; of several steps an array.
        outside: the weight of those left out.
        notes: what limits it, a sentence each.
    """

    particles: Any
    outside: Any
    notes: List[str]

    @classmethod
    def of(cls, counts: Any, edges: Any, particles: Any, outside: Any, notes: List[str]) -> Histogram:
        made = cls((counts, edges))
        made.particles, made.outside, made.notes = particles, outside, notes
        return made


def _edges(answer: Answer) -> List[NDArray[np.float64]]:
    import numpy as np

    edges = [np.array(axis.values, np.float64) for axis in answer.message.answer.histogram.axes]
    if not edges or any(len(axis) < 2 for axis in edges):
        raise Error("corrupt", "answer.histogram", "the server sent a histogram without bins")
    return edges


def histogram_of(answers: List[Answer], single: bool) -> Histogram:
    """Answers to a HistogramQuery: counts[bin], counts[first, second], and with several steps counts[step, ...]."""
    import numpy as np

    edges = _edges(answers[0])
    shape = [len(axis) - 1 for axis in edges]
    parts = []
    for answer in answers:
        if [len(axis) - 1 for axis in _edges(answer)] != shape:
            raise Error("corrupt", "answer.histogram", "the server's bins differ from step to step")
        parts.append(floats(answer.payload, int(np.prod(shape)), "answer.histogram").reshape(shape))
    particles = [answer.message.answer.histogram.particles for answer in answers]
    outside = [answer.message.answer.histogram.outside for answer in answers]
    axes = edges[0] if len(edges) == 1 else tuple(edges)
    if single:
        return Histogram.of(parts[0], axes, particles[0], outside[0], notes_of(answers))
    return Histogram.of(np.stack(parts), axes, np.array(particles), np.array(outside), notes_of(answers))


# --------------------------------------------------------------------------------------------- columns

def columns_of(answer: Answer, names: Sequence[str]) -> List[NDArray[Any]]:
    """The columns of one piece; of "id" u64, all others f64."""
    import numpy as np

    said = answer.message.answer.columns
    if list(said.names) != list(names):
        raise Error("corrupt", "answer.columns", f"the server sent the columns {list(said.names)}")
    values = floats(answer.payload, said.count * len(names), "answer.columns").reshape(len(names), said.count)
    return [column.view(np.uint64) if name == "id" else column for name, column in zip(names, values)]


def all_pieces(connection: Connection, dataset: str, index: int, select: Any, names: Sequence[str],
               by_id: bool = False) -> List[NDArray[Any]]:
    """Columns of one step, piece by piece."""
    import numpy as np

    asked = Asked(f"{index}:{index}:1", [index], True)
    pieces: List[List[NDArray[Any]]] = []
    begin = 0
    while True:
        columns = {"names": list(names), "begin": begin, "byId": by_id}
        answer = query(connection, dataset, asked, select, columns=columns)[0]
        pieces.append(columns_of(answer, names))
        said: Message = answer.message.answer.columns
        if said.end:
            return [np.concatenate(column) if len(column) > 1 else column[0] for column in zip(*pieces)]
        if said.next <= begin:
            raise Error("corrupt", "answer.columns.next", "the server's pieces do not go on")
        begin = said.next


def made_in_a_step(select: Any) -> bool:
    """Whether a selection holds the same particles in all steps."""
    if not isinstance(select, Mapping):
        raise invalid("select", f"is a selection, not the {arguments.told(select)}")
    parts = {name: value for name, value in select.items() if value is not None}
    return "step" in parts or set(parts) in ({"ids"}, {"nothing"})
