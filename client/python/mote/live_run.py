# SPDX-License-Identifier: GPL-3.0-or-later
"""LiveRun: a simulation's own script sends its steps, one after another, to a dataset that others look at meanwhile."""
from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Deque, Dict, Optional, Type

from .arrays import checked_mass, kept_columns, upload_steps
from .errors import Error, invalid
from .jobs import Job, axis_names, request_of
from .messages import to_message

if TYPE_CHECKING:
    from .dataset import Dataset
    from .session import Session

_SUFFIX = ".mote"
_UNDER_WAY = 4  # steps whose jobs are not waited for


class LiveRun:
    """The result of ``session.live``. Steps are processed in the order in which they were sent, each by a job of its own.

    As a context manager it is closed at the end, unless an exception ends it: then it stays live, and ``session.live``
    goes on with it.
    """

    def __init__(self, session: Session, output: str, axes: Sequence[str], mass: Optional[float], title: str,
                 options: Mapping[str, Any], numbers: itertools.count[int]) -> None:
        self._session, self._output, self._title, self._numbers = session, output, title, numbers
        self._axes, self._mass, self._options = axis_names(axes), checked_mass(mass), dict(options)
        for name in ("append", "closes", "follow", "steps"):
            if name in self._options:
                raise invalid(name, "is no option: it is what a live run does")
        if self._mass is not None:
            self._options["mass"] = self._mass
        to_message("JobRequest", self._request(["uploads/none"]))
        self._under_way: Deque[Job] = deque()
        self._closed = False
        self._next = self._look()

    def _request(self, names: Sequence[str], **more: Any) -> Dict[str, Any]:
        request = request_of("particles", "uploads/none", self._output, self._axes, self._title,
                             {**self._options, **more, "append": True})
        request["particles"]["inputs"] = list(names)
        return request

    def _look(self) -> int:
        """The next iteration. Raises Error (already_exists) where there is a dataset that is not live."""
        name = self._output[:-len(_SUFFIX)] if self._output.endswith(_SUFFIX) else self._output
        if name not in self._session:
            return 0
        dataset = self._session[name]
        if not dataset.live:
            raise Error("already_exists", "output", f"{self._output} exists already and is not live")
        if "columns" not in self._options and dataset.manifest["request"]["particles"].get("columns"):
            self._options["columns"] = list(dataset.manifest["request"]["particles"]["columns"])
        return int(dataset.iterations[-1]) + 1

    @property
    def dataset(self) -> Dataset:
        """The dataset, as far as it has come. Raises Error (not_found) before the first step is processed."""
        return self._session[self._output[:-len(_SUFFIX)]]

    def step(self, arrays: Mapping[str, Any], *, time: Optional[float] = None, iteration: Optional[int] = None) -> Job:
        """Sends the next step. Gives its job, which need not be waited for. Raises Error, also where an earlier step
        could not be taken.

        Args:
            arrays: columns by name, as for ``session.prepare_arrays``; the same ones in every step.
            time: s.
            iteration: its number, above that of the step before; default: one more than that.
        """
        if self._closed:
            raise invalid("step", "the live run is closed")
        self._settle(_UNDER_WAY - 1)
        if not isinstance(arrays, Mapping):
            raise invalid("arrays", "is a dict of columns by name: of one step")
        number = self._next if iteration is None else iteration
        names = upload_steps(self._session, next(self._numbers), arrays, self._mass, time, number)
        if int(number) < self._next:
            raise invalid("iteration", f"is {self._next} or more: the run has come to {self._next - 1}")
        if "columns" not in self._options and kept_columns(arrays):
            self._options["columns"] = kept_columns(arrays)
        job = self._session.submit(self._request(names), again=True)
        self._under_way.append(job)
        self._next = int(number) + 1
        return job

    def _settle(self, most: int) -> None:
        """Waits until so many are under way. Raises Error where one of the others failed."""
        while self._under_way and (len(self._under_way) > most or self._under_way[0].finished):
            self._under_way.popleft().wait(progress=False)

    def close(self) -> None:
        """No more steps come: waits for those under way and ends the dataset's being live. Again: nothing. Raises Error
        where a step could not be taken; the dataset is live still, and ``close()`` ends it without that step."""
        if self._closed:
            return
        self._settle(0)
        if self._next > 0:
            self._session.submit(self._request([], closes=True), again=True).wait(progress=False)
        self._closed = True

    def __enter__(self) -> LiveRun:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        if kind is None:
            self.close()

    def __repr__(self) -> str:
        return f"<mote.LiveRun {self._output} {'closed' if self._closed else 'live'}>"
