# SPDX-License-Identifier: GPL-3.0-or-later
"""Connection: a client's line to its server, by one thread that reads and writes.

Whoever asks waits for its answer; any thread may ask, and a KeyboardInterrupt of the one that waits leaves the line as
it was. A line that breaks without a word of the server's is opened again for a few seconds, the session goes on, and
what was not answered is asked again (docs/PROTOCOL.md, "When a line breaks").
"""
from __future__ import annotations

import os
import sys
import threading
import time
from collections import deque
from typing import Callable, Deque, Dict, List, Optional, Set

from . import wire
from .errors import Error
from .line import Line
from .messages import Message, new
from .question import Answer, Farewell, Question, copy_of, error_of
from .silence import ASK, GONE, Silence

PATIENCE = 5.0
"""Seconds for which a line that broke is opened again."""
ENTRY_PATIENCE = 2.0
"""Seconds for which a server that has no place is asked for one by who was not there before."""
CONNECT_TIMEOUT = 10.0
_HOLDS_AFTER = 1.0  # a line that broke sooner after its welcome counts as not opened
_PAUSE, _LONG_PAUSE, _PAUSE_SHARE = 0.02, 1.0, 0.05


def _no_place(failure: Error) -> bool:
    """The server takes nobody on at the moment."""
    return (failure.code, failure.where) == ("resource_exhausted", "server")


def _slept(failure: Error) -> bool:
    """The server has heard nothing of us: this machine slept, or the network."""
    return (failure.code, failure.where) == ("cancelled", "silence")


def _may_return(failure: Error, returning: bool) -> bool:
    """Whether a line that ended for this reason may be opened again."""
    if failure.code == "permission_denied":
        return returning  # a server that is started anew listens a moment before its file holds its token
    return failure.code in ("internal", "not_found") or _slept(failure) or _no_place(failure)


class Connection:
    """Connects to the server of a connection file. Raises Error where that does not work.

    ``ended`` tells, of a server that is our own, its last words once it is gone: then nothing is opened again.
    """

    def __init__(self, file: str, client: str, background: bool = False,
                 ended: Callable[[], Optional[str]] = lambda: None) -> None:
        self._file, self._client, self._background, self._ended = file, client, background, ended
        self._changed = threading.Condition()
        self._process = os.getpid()
        # Guarded by _changed.
        self._questions: Dict[int, Question] = {}
        self._outbox: Deque[int] = deque()
        self._credits = 0
        self._last_request = 0
        self._abandoned: Set[int] = set()  # views that nobody waits for any more and that are still to come
        self._lost: Optional[Error] = None
        self._closing = False
        self._watching = False
        self.jobs: Dict[str, Message] = {}
        self.welcome: Optional[Message] = None
        self.at_close: List[Callable[[], object]] = []  # what ends with the line
        # The thread's own.
        self._welcomed_at = 0.0
        self._resume = ""  # takes the session up again, once
        self._silence = Silence(0.0, 0.0)
        self._wake_reader, self._wake_writer = os.pipe()
        os.set_blocking(self._wake_writer, False)
        self._thread = threading.Thread(target=self._run, name="mote connection", daemon=True)
        self._thread.start()
        self._wait_for_welcome()

    def _wait_for_welcome(self) -> None:
        try:
            with self._changed:
                self._changed.wait_for(lambda: self.welcome is not None or self._lost is not None)
                if self._lost is not None:
                    raise copy_of(self._lost)
        except BaseException:
            self.close()
            raise

    # ---------------------------------------------------------------------------------------- any thread

    @property
    def file(self) -> str:
        """Of the server that it is a line to."""
        return self._file

    def ask(self, message: Message, expected: str) -> Answer:
        """Sends a ClientMessage and waits for its one answer. Raises Error."""
        return self.ask_all(message, expected)[-1]

    def ask_all(self, message: Message, expected: str) -> List[Answer]:
        """The same for a message with several answers: all of them."""
        try:
            return self.collect(self.submit(message, expected))
        finally:
            self.forget(message.request)  # whatever interrupted it

    def submit(self, message: Message, expected: str, most_views: Optional[int] = None) -> int:
        """Sends a message and does not wait for answers. Each is to be collected, or forgotten.

        ``most_views``: it waits until fewer views are under way.
        """
        most = sys.maxsize if most_views is None else most_views
        with self._changed:
            self.wait_for(lambda: self.views_under_way() < most)  # with the lock held until it is counted
            self._check_usable()
            self._last_request += 1
            request = message.request = self._last_request
            if expected == "frame":
                message.set_view.view_id = request
            wire.check_size(message.ByteSize())
            self._questions[request] = Question(message, expected)
            self._outbox.append(request)
        self._wake()
        return request

    def collect(self, request: int) -> List[Answer]:
        """Waits for the answers of a message that was submitted. Raises Error."""
        question = self._questions[request]
        try:
            with self._changed:
                self._changed.wait_for(lambda: question.finished)
        finally:
            self.forget(request)
        if question.error is not None:
            raise copy_of(question.error)
        return question.answers

    def forget(self, request: int) -> None:
        """Its answers are not wanted any more."""
        with self._changed:
            question = self._questions.pop(request, None)
            if question is None or question.finished or not question.sent:
                return
            if question.is_view:
                self._abandoned.add(request)
            elif question.expected in ("answer", "look"):
                cancel = new("ClientMessage")
                cancel.cancel_query.request = request
                self._last_request += 1
                cancel.request = self._last_request
                self._questions[cancel.request] = Question(cancel, "nothing")
                self._outbox.append(cancel.request)
        self._wake()

    def wait_for(self, condition: Callable[[], bool], timeout: Optional[float] = None) -> bool:
        """Waits until something that the server says makes a condition true, which is looked at with the lock held."""
        with self._changed:
            self._changed.wait_for(lambda: condition() or self._lost is not None, timeout)
            if not condition() and self._lost is not None:
                raise copy_of(self._lost)
            return condition()

    def views_under_way(self) -> int:
        """Views that the server has not answered yet."""
        with self._changed:
            return len(self._abandoned) + sum(q.is_view and not q.finished for q in self._questions.values())

    def watch_jobs(self) -> None:
        """From now on ``jobs`` follows what the server tells."""
        with self._changed:
            if self._watching:
                return
        message = new("ClientMessage")
        message.watch_jobs.SetInParent()
        self.ask(message, "jobs")
        with self._changed:
            self._watching = True

    @property
    def lost(self) -> Optional[Error]:
        """Why the connection is of no use any more; None while it is."""
        return self._lost

    def close(self) -> None:
        """Ends the line and its thread. What still waits gets an Error."""
        if os.getpid() != self._process:
            return
        while self.at_close:
            self.at_close.pop()()
        with self._changed:
            self._closing = True
        self._wake()
        if self._thread is not threading.current_thread():
            self._thread.join(5.0)
        with self._changed:
            if self._wake_writer >= 0 and not self._thread.is_alive():
                os.close(self._wake_reader)
                os.close(self._wake_writer)
                self._wake_reader = self._wake_writer = -1

    def _check_usable(self) -> None:
        if os.getpid() != self._process:
            raise Error("unsupported", "", "a connection does not follow into a forked process; connect anew there")
        if self._closing:
            raise Error("cancelled", "", "the connection was closed")
        if self._lost is not None:
            raise copy_of(self._lost)

    def _wake(self) -> None:
        try:
            os.write(self._wake_writer, b"\0")
        except OSError:
            pass  # closed, or it is awake already

    # ---------------------------------------------------------------------------------------- its thread

    def _run(self) -> None:
        try:
            error = self._keep_line()
        except Error as failure:
            error = failure
        except BaseException as failure:  # whoever waits must not wait for ever
            error = Error("internal", "", f"the connection failed: {failure!r}")
        with self._changed:
            self._lost = error
            for question in self._questions.values():
                if not question.finished:
                    question.fail(error)
            self._changed.notify_all()

    def _keep_line(self) -> Error:
        """Opens the line as often as it is worth it; why it is not any more."""
        broken: Optional[Error] = None
        since, patience = 0.0, PATIENCE
        while not self._closing:
            try:
                self._one_line()
            except Farewell as farewell:
                if not _slept(farewell.error):
                    return farewell.error
                failure = farewell.error
            except Error as error:
                failure = error
            else:
                break
            now = time.monotonic()
            held = self._welcomed_at and now - self._welcomed_at > _HOLDS_AFTER
            if held:
                broken = None
            if broken is None and (self._welcomed_at or _no_place(failure)):
                broken, since, patience = failure, now, PATIENCE if self._welcomed_at else min(ENTRY_PATIENCE, PATIENCE)
            self._welcomed_at = 0.0
            if broken is None or not _may_return(failure, broken is not failure):
                return failure
            if now - since > patience or self._gone():
                return self._gone() or broken
            self._pause(min(max((now - since) * _PAUSE_SHARE, _PAUSE), _LONG_PAUSE))
        return Error("cancelled", "", "the connection was closed")

    def _gone(self) -> Optional[Error]:
        words = self._ended()
        return Error("internal", "mote-server", words) if words is not None else None

    def _pause(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while not self._closing and time.monotonic() < end:
            time.sleep(_PAUSE)

    def _one_line(self) -> None:
        """From a socket to its end; returns when the connection is closed by us, raises Error where by others."""
        place = wire.read_connection_file(self._file)
        hello = new("ClientMessage")
        hello.request = 0
        hello.hello.token = place.token
        hello.hello.client = self._client
        hello.hello.minor = wire.MINOR
        hello.hello.background = self._background
        hello.hello.resume = self._resume
        with Line(place, self._wake_reader) as line:
            line.send(wire.encode(hello.SerializeToString()))
            welcomed = False
            deadline = time.monotonic() + CONNECT_TIMEOUT
            while not self._closing:
                if not welcomed and time.monotonic() > deadline:
                    raise Error("internal", place.address, "the server did not answer in time")
                for message, payload in line.turn(self._silence.interval if welcomed else deadline - time.monotonic()):
                    if not welcomed:
                        welcomed = self._greeted(message)
                    elif message.WhichOneof("body") == "ping":
                        self._send_own(line, "pong")
                    else:
                        self._received(message, payload)
                if welcomed:
                    self._send_what_is_due(line)
                    self._listen_for_life(line)

    def _listen_for_life(self, line: Line) -> None:
        """Raises Error where the server was silent for too long."""
        verdict = self._silence.at(time.monotonic(), line.progress)
        if verdict == GONE:
            raise Error("internal", "", f"nothing was heard of the server for {self._silence.limit:.3g} s")
        if verdict == ASK:
            self._send_own(line, "ping")

    def _send_own(self, line: Line, body: str) -> None:
        """A message that nobody asked us for."""
        message = new("ClientMessage")
        with self._changed:
            self._last_request += 1
            message.request = self._last_request
        getattr(message, body).SetInParent()
        line.send(wire.encode(message.SerializeToString()))

    def _greeted(self, message: Message) -> bool:
        body = message.WhichOneof("body")
        if body == "failure":
            raise error_of(message.failure)
        if body != "welcome":
            return False
        self._welcomed_at = time.monotonic()
        self._resume = message.welcome.resume
        self._silence = Silence(message.welcome.silence_ms / 1000, self._welcomed_at)
        with self._changed:
            self.welcome = message.welcome
            self._credits = 0
            self._abandoned.clear()
            self._ask_again(message.welcome.resumed)
            self._changed.notify_all()
        return True

    def _ask_again(self, resumed: bool) -> None:
        """After a line broke: all but jobs that may have been submitted, and half an upload that the server has not kept."""
        self._outbox.clear()
        for request in sorted(self._questions):
            question = self._questions[request]
            body = question.message.WhichOneof("body")
            if question.finished:
                continue
            if question.sent and (body in ("submit_job", "retry_job") or body == "upload" and not resumed):
                question.fail(Error("internal", "", "the line broke while the server was asked, and nobody knows what it did"))
                continue
            question.answers.clear()
            question.sent = False
            self._outbox.append(request)
        if self._watching:
            again = new("ClientMessage")
            again.watch_jobs.SetInParent()
            self._last_request += 1
            again.request = self._last_request
            self._questions[again.request] = Question(again, "nothing")
            self._outbox.appendleft(again.request)

    def _send_what_is_due(self, line: Line) -> None:
        with self._changed:
            if self._credits:
                credit = new("ClientMessage")
                self._last_request += 1
                credit.request = self._last_request
                credit.credit.frames, self._credits = self._credits, 0
                line.send(wire.encode(credit.SerializeToString()))
            while self._outbox and not line.full:
                request = self._outbox.popleft()
                question = self._questions.get(request)
                if question is None:
                    continue
                line.send(wire.encode(question.message.SerializeToString()))
                question.sent = True
                if question.expected == "nothing":
                    del self._questions[request]

    def _received(self, message: Message, payload: bytearray) -> None:
        body = message.WhichOneof("body")
        with self._changed:
            if body == "failure":
                self._failed(message)
            elif body == "frame":
                self._framed(message, payload)
            else:
                if body == "jobs":
                    self.jobs.update((job.id, job) for job in message.jobs.jobs)
                elif body == "job":
                    self.jobs[message.job.id] = message.job
                self._answered(message.reply_to, message, payload)
            self._changed.notify_all()

    def _failed(self, message: Message) -> None:
        error = error_of(message.failure)
        if message.failure.fatal:
            raise Farewell(error)
        self._abandoned.discard(message.reply_to)
        question = self._questions.get(message.reply_to)
        if question is not None and not question.finished:
            question.fail(error)

    def _framed(self, message: Message, payload: bytearray) -> None:
        self._credits += 1
        self._abandoned.discard(message.frame.view_id)
        self._answered(message.frame.view_id, message, payload)

    def _answered(self, request: int, message: Message, payload: bytearray) -> None:
        question = self._questions.get(request)
        if question is not None and question.sent and not question.finished:
            question.answered(Answer(message, payload))
