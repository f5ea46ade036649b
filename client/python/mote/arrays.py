# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns straight from numpy: checked, packed as a file for each step, uploaded for a job to read."""
from __future__ import annotations

import re
import tempfile
import warnings
from collections import deque
from collections.abc import Mapping, Sequence
from typing import IO, TYPE_CHECKING, Any, Deque, Dict, List, Optional

from . import arguments
from .errors import Error, invalid
from .messages import new

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .session import Session

# What the job's reader of .npz knows, in any case; all others are records under their own names.
_COLUMNS = ("x", "y", "z", "t", "px", "py", "pz", "weight", "charge", "id", "status", "lost", "alive")
_SAME = {"w": "weight", "weighting": "weight", "q": "charge", "particleid": "id", "particle_id": "id",
         "particlestatus": "status", "particle_status": "status",
         **{f"position_{axis}": axis for axis in "xyz"},
         **{f"{word}_{axis}": f"p{axis}" for axis in "xyz" for word in ("p", "momentum")}}
# Names that a record cannot have: what is derived from columns (docs/NUMBERS.md), and what numpy.savez takes.
_DERIVED = ("r", "theta", "xp", "yp", "pr", "p", "delta", "gamma", "energy", "zeta", "tau", "x_c", "y_c", "px_c",
            "py_c", "pz_c")
_ARGUMENTS = ("time", "iteration", "mass")
_RECORD = re.compile(r"([A-Za-z_][A-Za-z0-9_]{0,63})( ?\[[^\[\]]{1,32}\])?")
_PIECE = (1 << 20) - 1024  # bytes of a file in a message
_UNDER_WAY = 8  # pieces that are sent ahead of their answers


def _meaning(name: Any, where: str) -> str:
    """Which of _COLUMNS a name stands for, or the record of this name: without its unit."""
    if isinstance(name, str):
        lower = name.lower()
        meaning = _SAME.get(lower, lower)
        if meaning in _COLUMNS:
            return meaning
        record = _RECORD.fullmatch(name)
        if record and record[1] not in (*_DERIVED, *_ARGUMENTS, "file") and not record[1].startswith("arr_"):
            return record[1]
    why = ("it is an argument of its own" if name in _ARGUMENTS else
           "it is derived from other columns" if name in _DERIVED else
           "a record has a name of letters, digits and \"_\", and may have its unit behind it: \"spin [hbar]\"")
    raise invalid(where, f"{name!r} is no name of a column that can be prepared: {why}; there are {', '.join(_COLUMNS)}")


def _array(values: Any, place: str) -> NDArray[Any]:
    import numpy as np

    try:
        array: NDArray[Any] = values if isinstance(values, np.ma.MaskedArray) else np.asarray(values)
    except ValueError:
        raise invalid(place, "is numbers in a row; its parts differ in length") from None
    if array.ndim > 1:
        raise invalid(place, f"is numbers in a row, not of the shape {array.shape}")
    return array


def _is_masked(array: Any) -> bool:
    """Whether some of it is."""
    return bool(getattr(array, "mask", None) is not None and array.mask.any())


def _column(name: Any, values: Any, where: str) -> NDArray[Any]:
    """One column as float64, NaN where it is masked, or uint64 where it is of ids."""
    import numpy as np

    meaning = _meaning(name, where)
    place = f"{where}[{name!r}]"
    array = _array(values, place)
    masked = _is_masked(array)
    if meaning == "id":
        if array.dtype.kind not in "iu" or (array.size and int(array.min()) < 0):
            raise invalid(place, f"ids are whole numbers from 0 on, not {array.dtype}")
        if masked or array.ndim == 0:
            raise invalid(place, "each particle has an id of its own; none can be masked" if masked else
                          "each particle has an id of its own: one number is none for all of them")
        return np.asarray(array).astype(np.uint64)
    if array.dtype.kind not in "fiub":
        raise invalid(place, f"is of real numbers, not of {array.dtype}")
    if masked and meaning in ("status", "lost", "alive"):
        raise invalid(place, "is masked, and whether a particle is lost cannot be left open")
    floats: Any = array.astype(np.float64, copy=False)
    return np.asarray(floats.filled(np.nan) if masked else floats)


def _tell_not_finite(columns: Mapping[str, NDArray[Any]], where: str) -> None:
    import numpy as np

    bad = {name: int(np.count_nonzero(~np.isfinite(column))) for name, column in columns.items()}
    told = ", ".join(f"{count} of {name}" for name, count in bad.items() if count)
    if told:
        warnings.warn(f"{where}: values that are not finite: {told}; particles that miss a coordinate or their weight are "
                      "left out of the plot", stacklevel=5)


def check_step(arrays: Any, where: str) -> Dict[str, NDArray[Any]]:
    """The columns of one step, all of one length. Raises Error (invalid_argument)."""
    import numpy as np

    if not isinstance(arrays, Mapping) or not arrays:
        raise invalid(where, "is a dict of columns by name")
    columns = {name: _column(name, values, where) for name, values in arrays.items()}
    meanings = [_meaning(name, where) for name in columns]
    for index, meaning in enumerate(meanings):
        if meaning in meanings[:index]:
            raise invalid(where, f"{list(columns)[index]!r} is a column {meaning!r}, and there is another one")
    lengths = {name: len(column) for name, column in columns.items() if column.ndim == 1}
    if not lengths:
        raise invalid(where, "holds single numbers alone; at least one column must be an array")
    if len(set(lengths.values())) > 1:
        raise invalid(where, "its columns differ in length: " + ", ".join(f"{n} {c}" for n, c in lengths.items()))
    count = next(iter(lengths.values()))
    whole = {name: np.broadcast_to(column, (count,)) for name, column in columns.items()}
    _tell_not_finite(whole, where)
    return whole


def kept_columns(arrays: Any) -> List[str]:
    """The columns of arrays that were checked, where records are among them, which are kept when they are named."""
    steps = [arrays] if isinstance(arrays, Mapping) else list(arrays)
    found = [[_meaning(name, "arrays") for name in step] for step in steps]
    common = [name for name in found[0] if all(name in names for names in found)]
    if all(name in _COLUMNS for name in common):
        return []
    names = ["weight" if name == "charge" else name for name in common]
    return [name for name in names if name not in ("status", "lost", "alive")]


def _numbers(values: Any, count: int, where: str) -> List[Any]:
    """One for each step."""
    import numpy as np

    if values is None:
        return [None] * count
    array = np.atleast_1d(_array(values, where))
    if (array.shape != (count,) or array.dtype.kind not in "fiu" or _is_masked(array) or not np.isfinite(array).all()):
        raise invalid(where, f"is one number for each of {count} steps")
    return list(array.tolist())


def _iterations(values: Any, count: int) -> List[Any]:
    """Whole numbers that a float holds, as the reader wants them."""
    found = _numbers(values, count, "iteration")
    for number in found:
        if number is not None and (number != int(number) or abs(number) > 2**53):
            raise invalid("iteration", f"is a whole number for each of {count} steps, within 2^53, not {number!r}")
    return [None if number is None else int(number) for number in found]


def checked_mass(mass: Any) -> Optional[float]:
    """Raises Error (invalid_argument) where it is none."""
    if mass is None:
        return None
    real = arguments.number(mass, "mass")
    if not 0.0 < real < float("inf"):
        raise invalid("mass", f"is over 0, eV/c^2, not {mass!r}")
    return real


def _write(file: IO[bytes], columns: Mapping[str, NDArray[Any]], about: Mapping[str, Any]) -> None:
    """As NPZ, members stored as they are."""
    import numpy as np

    # Any: numpy 2 has an argument of its own among the names.
    members: Dict[str, Any] = {name: np.array(value) for name, value in about.items() if value is not None}
    np.savez(file, **{**columns, **members})


def _send(session: Session, name: str, file: IO[bytes]) -> None:
    """Piece by piece, some of them ahead of the server's answers."""
    size = file.seek(0, 2)
    file.seek(0)
    under_way: Deque[int] = deque()
    begin = 0
    try:
        while begin < size or (begin == 0 and not under_way):
            message = new("ClientMessage")
            upload = message.upload
            upload.name, upload.begin, upload.data = name, begin, file.read(_PIECE)
            if begin == 0:
                upload.size = size
            begin += len(upload.data)
            under_way.append(session.connection.submit(message, "uploaded"))
            while len(under_way) > _UNDER_WAY or (begin >= size and under_way):
                answer = session.connection.collect(under_way.popleft())[-1]
        if answer.message.uploaded.size != size:
            raise Error("internal", name, f"the server has {answer.message.uploaded.size} of {size} bytes")
    finally:
        for request in under_way:
            session.connection.forget(request)


def upload_steps(session: Session, number: int, arrays: Any, mass: Optional[float], time: Any,
                 iteration: Any) -> List[str]:
    """Uploads a file a step; the inputs of the job that reads them. All is checked before anything is sent."""
    several = isinstance(arrays, Sequence)
    if several and not arrays:
        raise invalid("arrays", "holds no step")
    steps = []
    for index, step in enumerate(arrays if several else [arrays]):
        steps.append(check_step(step, f"arrays[{index}]" if several else "arrays"))
    if any(set(step) != set(steps[0]) for step in steps):
        raise invalid("arrays", "its steps differ in their columns")
    times, numbers = _numbers(time, len(steps), "time"), _iterations(iteration, len(steps))
    names = []
    for index, columns in enumerate(steps):
        names.append(f"arrays-{number}-{index:06d}.npz")
        about = {"time": times[index], "iteration": index if iteration is None else numbers[index], "mass": mass}
        with tempfile.TemporaryFile(prefix="mote-") as file:
            _write(file, columns, about)
            _send(session, names[-1], file)
    return [f"uploads/{name}" for name in names]
