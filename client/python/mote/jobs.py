# SPDX-License-Identifier: GPL-3.0-or-later
"""Job: a dataset that is being prepared, a film or an export that is being made, by the server."""
from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping, Sequence
from typing import IO, TYPE_CHECKING, Any, Dict, List, Optional, Union

from . import arguments
from .errors import Error, invalid
from .messages import Message, new

if TYPE_CHECKING:
    from .session import Session

_STATES = ("unknown", "queued", "running", "succeeded", "failed", "cancelled")
_INPUTS = {"particles": "inputs", "volume": "inputs", "mesh": "input", "image": "input", "stipple": "mesh"}
_BAR = 30  # characters


def axis_names(axes: Any) -> List[str]:
    """Several names; one text is not taken for its letters."""
    if isinstance(axes, str):
        raise invalid("axes", f"is a list of names, not the {arguments.told(axes)}")
    return arguments.names(axes, "axes", "axis")


def _fields(kind: str, options: Mapping[str, Any]) -> Dict[str, Any]:
    """Of a job of a kind. Raises Error where one has an argument of its own."""
    if kind not in _INPUTS:
        raise invalid("kind", f"is one of {', '.join(_INPUTS)}, not {kind!r}")
    for name in options:
        if name in ("input", _INPUTS[kind]):
            raise invalid(name, "is no option: the files are the first argument")
    return dict(options)


def request_of(kind: str, input: Union[str, Sequence[str]], output: str, axes: Optional[Sequence[str]], title: str,
               options: Mapping[str, Any]) -> Dict[str, Any]:
    """A JobRequest as plain values."""
    fields = _fields(kind, options)
    if axes is not None:
        fields["axes"] = axis_names(axes)
    names = arguments.names(input, "input", "file")
    if _INPUTS[kind] == "inputs":
        fields["inputs"] = names
    elif len(names) == 1:
        fields[_INPUTS[kind]] = names[0]
    else:
        raise invalid("input", f"a job of kind {kind!r} reads one file, not {len(names)}")
    return {"title": title, "output": output, kind: fields}


class _Bar:
    """A line of text that is written over; on a terminal or in a notebook."""

    def __init__(self, wanted: Optional[bool], stream: Optional[IO[str]] = None) -> None:
        notebook = "ipykernel" in sys.modules
        self._stream = stream or (sys.stdout if notebook else sys.stderr)  # notebooks show stderr on red
        self._shown = wanted if wanted is not None else notebook or self._stream.isatty()
        self._length = 0

    def show(self, progress: float, phase: str) -> None:
        if not self._shown:
            return
        done = int(round(_BAR * min(max(progress, 0.0), 1.0)))
        line = f"[{'#' * done}{'.' * (_BAR - done)}] {100 * progress:3.0f}% {phase}"[:100]
        self._stream.write("\r" + line.ljust(self._length))
        self._stream.flush()
        self._length = len(line)

    def end(self) -> None:
        if self._length:
            self._stream.write("\n")
            self._stream.flush()


class Job:
    """A job of the server. It goes on whether anybody watches it or not."""

    def __init__(self, session: Session, identity: str) -> None:
        self._session = session
        self.id = identity

    @property
    def status(self) -> Message:
        """Everything that the server says about it, a JobStatus."""
        return self._session.connection.jobs[self.id]

    @property
    def state(self) -> str:
        """ "queued", "running", "succeeded", "failed" or "cancelled"."""
        number = self.status.state
        return _STATES[number] if 0 <= number < len(_STATES) else _STATES[0]

    @property
    def finished(self) -> bool:
        return self.state in ("succeeded", "failed", "cancelled")

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return float(self.status.progress)

    @property
    def phase(self) -> str:
        """What it does now."""
        return str(self.status.phase)

    @property
    def waits_for(self) -> str:
        """One sentence: what keeps it waiting, such as a full disk; "" if nothing does."""
        return str(self.status.waits_for)

    @property
    def interrupted(self) -> int:
        """How often it was queued again because it had been interrupted."""
        return int(self.status.interrupted)

    @property
    def log(self) -> List[str]:
        """The last lines that it wrote."""
        return list(self.status.log)

    @property
    def error(self) -> str:
        """One sentence, if it failed."""
        return str(self.status.error)

    @property
    def output(self) -> str:
        """The dataset that it makes, "ROOT/NAME.mote"; empty for films and exports."""
        return str(self.status.request.output)

    def wait(self, timeout: Optional[float] = None, progress: Optional[bool] = None) -> Job:
        """Waits for its end and returns the job. Raises Error if it failed, was cancelled or takes longer.

        An interrupt ends the waiting, not the job. ``progress`` says whether a bar is shown; by default it is on
        terminals and in notebooks.
        """
        end = None if timeout is None else time.monotonic() + timeout
        bar = _Bar(progress)
        connection = self._session.connection
        try:
            while not self.finished:
                status = self.status
                bar.show(status.progress, status.phase)
                left = None if end is None else end - time.monotonic()
                if left is not None and left <= 0:
                    raise Error("cancelled", self.id, f"the job is at {100 * self.progress:.0f}% and is not waited for longer")
                connection.wait_for(lambda: self.status is not status, left)
            bar.show(self.progress, self.state)
        finally:
            bar.end()
        if self.state != "succeeded":
            code = "cancelled" if self.state == "cancelled" else "internal"
            raise Error(code, self.output or self.id, self.error or f"the job was {self.state}")
        return self

    def cancel(self) -> Job:
        """Cancels it. Raises Error if the server knows no such job."""
        message = new("ClientMessage")
        message.cancel_job.id = self.id
        self._session.connection.ask(message, "job")
        return self

    def retry(self) -> Job:
        """Starts it anew after it failed or was cancelled, and returns the new job. Raises Error if it did neither."""
        message = new("ClientMessage")
        message.retry_job.id = self.id
        return Job(self._session, self._session.connection.ask(message, "job").message.job.id)

    def save(self, path: Any, frame: Optional[int] = None) -> None:
        """Fetches the result of a film or an export, or one picture of a film, into a file."""
        if frame is not None and not 0 <= arguments.whole(frame, "frame") < 2**32:
            raise invalid("frame", f"is one of the film's, from 0 on, not {frame}")
        answer, payload = self._fetch(0, frame)  # what is not there takes no file's place
        with open(os.fspath(path), "wb") as file:
            file.write(payload)
            while payload and file.tell() < answer.film_piece.size:
                answer, payload = self._fetch(file.tell(), frame)
                file.write(payload)

    def _fetch(self, begin: int, frame: Optional[int]) -> Any:
        message = new("ClientMessage")
        message.fetch_film.id = self.id
        message.fetch_film.begin = begin
        if frame is not None:
            message.fetch_film.frame = arguments.whole(frame, "frame")
        return self._session.connection.ask(message, "film_piece")

    def __repr__(self) -> str:
        status = self.status
        return f"<mote.Job {self.id} {self.state} {100 * status.progress:.0f}% {status.phase}>"

    def _repr_html_(self) -> str:
        import html

        status = self.status
        words = html.escape(f"{self.output or self.id}: {self.state} {status.phase} {status.error}".strip())
        return f'<progress value="{status.progress:.3f}"></progress> {words}'
