# SPDX-License-Identifier: GPL-3.0-or-later
"""What is asked of a server and what comes of it: values that a Connection keeps under its lock."""
from __future__ import annotations

from typing import List, NamedTuple, Optional

from .errors import Error
from .messages import Message


class Farewell(Exception):
    """The server's last word: nothing is opened again."""

    def __init__(self, error: Error) -> None:
        super().__init__(error)
        self.error = error


class Answer(NamedTuple):
    """A server's message that answers a question, and its payload."""

    message: Message
    payload: bytearray


class Question:
    """What is asked, and what came of it so far. Guarded by its connection's lock."""

    def __init__(self, message: Message, expected: str) -> None:
        self.message = message
        self.expected = expected
        self.answers: List[Answer] = []
        self.error: Optional[Error] = None
        self.finished = False
        self.sent = False

    @property
    def is_view(self) -> bool:
        return self.expected == "frame"

    def answered(self, answer: Answer) -> None:
        body = answer.message.WhichOneof("body")
        if body != self.expected:
            self.fail(Error("internal", "", "the server answered something else"))
            return
        self.answers.append(answer)
        self.finished = body != "answer" or answer.message.answer.last

    def fail(self, error: Error) -> None:
        self.error, self.finished = error, True


def copy_of(error: Error) -> Error:
    """The same for each that it reaches, with a traceback of its own."""
    return Error(error.code, error.where, error.message)


def error_of(failure: Message) -> Error:
    """A server's Failure as an exception."""
    return Error(failure.code or "internal", failure.where, failure.message or "the server failed and gave no reason")
