# SPDX-License-Identifier: GPL-3.0-or-later
"""What callers give, made into what is meant, or refused: nothing is dropped, cut into letters or taken for something
else. Pure functions; all raise Error (invalid_argument) with the argument's name."""
from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Iterator, Mapping, Set
from typing import Any, List, Optional, Tuple

from .errors import invalid


def told(value: Any) -> str:
    """What was given, short enough for a sentence."""
    return f"{type(value).__name__} {value!r}"[:80].replace("\n", " ")


def flag(value: Any, where: str) -> bool:
    """True or False, numpy's too; nothing else that Python takes for one of them."""
    if isinstance(value, bool) or type(value).__name__ in ("bool_", "bool"):
        return bool(value)
    raise invalid(where, f"is True or False, not the {told(value)}")


def number(value: Any, where: str) -> float:
    """A real number, numpy's too; not NaN."""
    dtype = getattr(value, "dtype", None)  # numpy makes a float of nearly everything
    if isinstance(value, (bool, str, bytes, bytearray)) or (dtype is not None and (value.shape or dtype.kind not in "fiu")):
        raise invalid(where, f"is a number, not the {told(value)}")
    try:
        real = float(value)
    except (TypeError, ValueError, OverflowError):
        raise invalid(where, f"is a number, not the {told(value)}") from None
    if math.isnan(real):
        raise invalid(where, "is not a number (NaN)")
    return real


def whole(value: Any, where: str) -> int:
    """A whole number, numpy's too; neither True nor 1.0."""
    try:
        index = operator.index(value)
    except TypeError:
        index = None
    if index is None or isinstance(value, bool) or getattr(value, "dtype", None) == bool:
        raise invalid(where, f"is a whole number, not the {told(value)}")
    return index


def items(value: Any, where: str, what: str = "a list") -> List[Any]:
    """The items of a list, a tuple, an array or whatever else gives them in an order that was meant. A text is none, and
    neither is a set nor a dict; what gives its items but once is taken whole here."""
    if hasattr(value, "tolist") and not isinstance(value, (str, bytes)):
        value = value.tolist()
    if isinstance(value, (str, bytes, bytearray, Mapping, Set)) or not isinstance(value, Iterable):
        raise invalid(where, f"is {what}, not the {told(value)}")
    return list(value)


def names(value: Any, where: str, what: str = "column", none: bool = False) -> List[str]:
    """One name, or several. ``none``: there may be none of them; else that is an error, never all."""
    found = [value] if isinstance(value, str) else items(value, where, f"the name of a {what}, or a list of names")
    for name in found:
        if not isinstance(name, str) or not name:
            raise invalid(where, f"holds the {told(name)} where the name of a {what} belongs")
    if not found and not none:
        raise invalid(where, f"is empty: it names no {what}; leave it out where all are meant")
    return [str(name) for name in found]


def one_step(step: Any, count: int, where: str = "step") -> int:
    """A step as Python counts: negative from the end."""
    given = whole(step, where)
    index = given + count if given < 0 else given
    if not 0 <= index < max(count, 1):
        raise invalid(where, f"there is no step {given}; the dataset has {count}")
    return index


def _listed(steps: Any, count: int) -> List[int]:
    if isinstance(steps, slice):
        try:
            return list(range(count)[steps])
        except TypeError:
            raise invalid("steps", f"{steps} is no slice of whole numbers") from None
    if isinstance(steps, range):
        return list(steps)
    return [one_step(step, count) for step in items(steps, "step", "a step, a slice, a range or a list of steps")]


def even_steps(steps: Any, count: int) -> List[int]:
    """Several steps, ascending and evenly apart, as queries can name them."""
    chosen = _listed(steps, count)
    strides = {b - a for a, b in zip(chosen, chosen[1:])} or {1}
    if not chosen or chosen[0] < 0 or chosen[-1] >= count or len(strides) > 1 or min(strides) < 1:
        raise invalid("steps", f"{steps} are no steps in ascending order, evenly apart; the dataset has {count}"[:200])
    return chosen


def is_single(steps: Any) -> bool:
    """Whether one step is meant, and not several."""
    return not isinstance(steps, (slice, range, Iterator)) and (getattr(steps, "ndim", None) == 0 or
                                                               not isinstance(steps, Iterable))


def bins_of(bins: Any, columns: int) -> List[Any]:
    """How many bins each column has: one number for all of them, or one each."""
    single = isinstance(bins, (str, bytes)) or getattr(bins, "ndim", None) == 0 or not isinstance(bins, Iterable)
    counts = [bins] * columns if single else items(bins, "bins", "a number, or one for each column")
    if len(counts) != columns:
        raise invalid("bins", f"says one for each of {columns} columns, how many and not where they end")
    return [None if count is None else whole(count, "bins") for count in counts]


def _limits(limits: Any) -> Optional[Tuple[float, float]]:
    if limits is None:
        return None
    ends = items(limits, "range", "(low, high)")
    try:
        low, high = (float(end) for end in ends if not isinstance(end, (str, bytes, bool)))
    except (TypeError, ValueError):
        low, high = 0.0, 0.0
    if len(ends) != 2 or not float("-inf") < low < high < float("inf"):
        raise invalid("range", f"is (low, high), two finite numbers that ascend, not the {told(limits)}")
    return low, high


def ranges_of(limits: Any, columns: int) -> List[Optional[Tuple[float, float]]]:
    """Where the bins of each column begin and end; None: the column's own range."""
    if limits is None:
        return [None] * columns
    each = [limits] if columns == 1 else items(limits, "range", "one (low, high) for each column")
    if len(each) != columns:
        raise invalid("range", f"says one for each of {columns} columns")
    return [_limits(one) for one in each]


def slices_of(slices: Any) -> Tuple[str, Optional[int], str]:
    """A column, (column, count) or (column, count, "even" or "charge"): the column, the count where it is said, and of what
    slices are equal where that is said."""
    name, count, of = slices, None, ""
    if not isinstance(slices, str):
        parts = items(slices, "slices", "a column, or (column, count)")
        if not 1 <= len(parts) <= 3:
            raise invalid("slices", f"is a column, (column, count) or (column, count, \"charge\"), not {len(parts)} things")
        name, count, of = (*parts, None, None)[:3]
        of = of or ""
    if of not in ("", "even", "charge"):
        raise invalid("slices", f"are \"even\" or of equal \"charge\", not {of!r}")
    if not isinstance(name, str) or not name:
        raise invalid("slices", f"names a column, not the {told(name)}")
    return name, None if count is None else whole(count, "slices"), of


def matrix(value: Any, where: str) -> Any:
    """16 numbers, row by row, from them or from 4 x 4."""
    if value is None:
        return None
    rows = items(value, where, "4 x 4 numbers, row by row")
    if len(rows) == 4 and not any(isinstance(row, (int, float)) for row in rows):
        rows = [value for row in rows for value in items(row, where, "4 x 4 numbers, row by row")]
    if len(rows) != 16:
        raise invalid(where, f"is 4 x 4 numbers, row by row, not {len(rows)}")
    return rows
