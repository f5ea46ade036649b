# SPDX-License-Identifier: GPL-3.0-or-later
"""What passed the lines of one client, looked at: whether each new line took up the session of the one before it, as it
was, and how long that took."""
from typing import NamedTuple, Optional

from cutting_proxy import CLIENT
from own_server import parse


class Return(NamedTuple):
    """Seconds from a cut."""

    session: float
    """To the welcome."""
    state: Optional[float]
    """To the first word after it: a picture, the jobs, an answer; none where nothing was to be said."""


class _Heard(NamedTuple):
    time: float
    client: bool
    body: str
    message: object


def _of(line):
    """Greetings left out."""
    for time, whose, data in list(line.passed):
        if data:
            message = parse("ClientMessage" if whose == CLIENT else "ServerMessage", data)
            yield _Heard(time, whose == CLIENT, message.WhichOneof("body"), message)


def tells_jobs_unasked(line):
    """As a server does that knows they are watched."""
    return any(heard.body == "jobs" and heard.message.reply_to == 0 for heard in _of(line))


class Judge:
    """Looks at lines in their order. ``wrongs``: sentences."""

    def __init__(self):
        self.returns, self.wrongs = [], []
        self._secrets = [""]  # as they came to the client
        self._asked = {}  # views by id
        self._seen = 0  # the newest whose picture came
        self._cut_at = None

    @property
    def has_session(self):
        return len(self._secrets) > 1

    def look(self, lines):
        for line in lines:
            self._look_at(line)
            self._cut_at = line.cut_at
        return self

    def _look_at(self, line):
        welcomed = state = None
        for heard in _of(line):
            if heard.body == "hello" and heard.message.hello.resume != self._secrets[-1]:
                self.wrongs.append("a hello does not name the latest secret")
            elif heard.client:
                self._note_asked(heard)
            elif heard.body == "welcome":
                welcomed = heard.time
                self._welcome(heard.message.welcome)
            else:
                self._note_seen(heard)
                state = state or (heard.time if heard.body != "ping" else None)
        if welcomed and self._cut_at is not None:
            self.returns.append(Return(welcomed - self._cut_at, state and state - self._cut_at))

    def _welcome(self, welcome):
        if self.has_session and not welcome.resumed:
            self.wrongs.append("the session did not go on")
        if not welcome.resume or welcome.resume in self._secrets:
            self.wrongs.append("the secret is an old one")
        self._secrets.append(welcome.resume)
        if self._seen > welcome.view.view_id:
            self.wrongs.append(f"the server has view {welcome.view.view_id}, but {self._seen} was drawn")
        if welcome.view.view_id and welcome.view != self._asked.get(welcome.view.view_id):
            self.wrongs.append("the server has another view than was asked for")

    def _note_asked(self, heard):
        view = heard.message.set_view
        if heard.body == "set_view" and not view.queued:
            self._asked[view.view_id] = view

    def _note_seen(self, heard):
        if heard.body == "frame" and heard.message.frame.view_id in self._asked:
            self._seen = max(self._seen, heard.message.frame.view_id)
