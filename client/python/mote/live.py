# SPDX-License-Identifier: GPL-3.0-or-later
"""Live: a view in a notebook's cell, which a hand turns there and Python changes from here. mote-web, which this starts,
serves the page to the cell's frame; both put the view into a room of it (docs/WEB.md, "In a notebook")."""
from __future__ import annotations

import html
import http.client
import importlib.util
import json
import os
import secrets
import select
import shutil
import subprocess
import weakref
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple

from .errors import Error
from .messages import Message, new, to_dict

if TYPE_CHECKING:
    from .session import Session
    from .view import View

_READY = 30.0  # seconds
_ANSWER = 30.0


def find_program(program: Optional[str] = None) -> str:
    """The program: the one that is asked for, else MOTE_WEB, the one in PATH or beside MOTE_SERVER, or the source tree's."""
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), *[os.pardir] * 3, "build/release/bin/mote-web")
    server = os.environ.get("MOTE_SERVER")
    of_server = os.path.join(os.path.dirname(server), "mote-web") if server else ""
    for found in (program, os.environ.get("MOTE_WEB"), of_server, shutil.which("mote-web"), os.path.normpath(beside)):
        if found and os.access(found, os.X_OK) and not os.path.isdir(found):
            return os.path.abspath(found)
        if found and found in (program, os.environ.get("MOTE_WEB")):
            break
    raise Error("not_found", program or "mote-web", "there is no such program to show a view with; say where it is: program=")


def jupyter_base() -> Optional[str]:
    """The path below which the Jupyter server of this kernel shows ports; None where it does not."""
    if importlib.util.find_spec("jupyter_server_proxy") is None or importlib.util.find_spec("jupyter_server") is None:
        return None
    from jupyter_server.serverapp import list_running_servers

    parent = os.environ.get("JPY_PARENT_PID", "")
    for server in list_running_servers():
        if str(server.get("pid")) == parent:
            return str(server["base_url"])
    return os.environ.get("JUPYTERHUB_SERVICE_PREFIX")


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()


class Web:
    """A mote-web of a session's own; it ends with it."""

    def __init__(self, connection_file: str, program: Optional[str], host: str) -> None:
        self.base = jupyter_base()
        # Whose page frames ours: JupyterLab's, of a port that we do not know. Behind its proxy it is one of the same host.
        words = ["--any-host"] if self.base else ["--frame-ancestor", f"http://{host}:*"]
        try:
            self._process = subprocess.Popen([find_program(program), "--connect", connection_file, *words],
                                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                             start_new_session=True, bufsize=0)
        except OSError as failure:
            raise Error("internal", "mote-web", f"cannot be started: {failure}") from None
        self.close = weakref.finalize(self, _end, self._process)
        link = self._line("ready ")
        self.port = int(link.split("/")[2].rpartition(":")[2])
        self.host = host
        # The first link is ours: with its cookie we speak in rooms.
        answer, _ = self._ask("GET", "/?token=" + link.rpartition("token=")[2])
        self._cookie = (answer.getheader("Set-Cookie") or "").partition(";")[0]

    def _line(self, begin: str) -> str:
        assert self._process.stdout is not None and self._process.stderr is not None
        poll = select.poll()
        poll.register(self._process.stdout, select.POLLIN)
        text = self._process.stdout.readline().decode() if poll.poll(_READY * 1000) else ""
        if not text.startswith(begin):
            self.close()
            raise Error("internal", "mote-web", "did not say that it is ready")
        return text[len(begin):].strip()

    def _ask(self, method: str, path: str, body: bytes = b"") -> Tuple[http.client.HTTPResponse, bytes]:
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=_ANSWER)
        headers = {"Origin": f"http://127.0.0.1:{self.port}", "Cookie": getattr(self, "_cookie", "")}
        try:
            line.request(method, path, body if method == "POST" else None, headers)
            answer = line.getresponse()
            data = answer.read()
        except (OSError, http.client.HTTPException) as failure:
            raise Error("internal", "mote-web", f"does not answer: {failure}") from None
        finally:
            line.close()
        if answer.status >= 400:
            raise Error("internal", "mote-web", data.decode("utf-8", "replace").strip())
        return answer, data

    @property
    def alive(self) -> bool:
        return self.close.alive and self._process.poll() is None

    def token(self) -> str:
        """For one more browser."""
        return str(json.loads(self._ask("POST", "/link", b"owner")[1])["token"])

    def put(self, room: str, view: Message) -> None:
        self._ask("POST", f"/room/{room}", view.SerializeToString())

    def get(self, room: str) -> Message:
        view: Message = new("View")
        view.ParseFromString(self._ask("GET", f"/room/{room}")[1])
        return view

    def address(self, room: str) -> str:
        """Of the page with a room, for one browser."""
        begin = f"{self.base}proxy/{self.port}/" if self.base else f"http://{self.host}:{self.port}/"
        return f"{begin}?token={self.token()}#room={room}"


class Live:
    """The result of View.show(): the view in a cell of a notebook, or in any browser at ``url``.

    Attributes:
        url: a link for one browser: its token works once.
    """

    def __init__(self, view: View, web: Web) -> None:
        self._session, self._web = view._session, web
        self._room = secrets.token_hex(16)
        web.put(self._room, view.message)
        self.url = web.address(self._room)

    @property
    def view(self) -> View:
        """The view as it is seen now, including what was changed by hand."""
        from .view import View

        return View.from_dict(self._session, to_dict(self._web.get(self._room)))

    @property
    def camera(self) -> Optional[Dict[str, Any]]:
        """The current camera; None if the view has none and has not been drawn yet."""
        camera: Optional[Dict[str, Any]] = to_dict(self._web.get(self._room)).get("camera")
        return camera

    def update(self, view: View) -> None:
        """Shows another view in its place, from the same camera unless it has one."""
        message: Message = new("View")
        message.CopyFrom(view.message)
        if not message.HasField("camera"):
            now = self._web.get(self._room)
            if now.HasField("camera"):
                message.camera.CopyFrom(now.camera)
        self._web.put(self._room, message)

    def __repr__(self) -> str:
        return f"<mote.Live {self.url.partition('?')[0]}>"


def _display(outputs: List[Any]) -> None:
    """Where this is a notebook."""
    try:
        from IPython import get_ipython
        from IPython.display import display
    except ImportError:
        return
    if get_ipython() is None:
        return
    for output in outputs:
        display(output)


class _Frame:
    """The cell's frame, by itself. It has no height until its page says that it is there: a saved notebook shows no hole."""

    def __init__(self, url: str, height: int) -> None:
        self._url, self._height = url, height

    def _repr_html_(self) -> str:
        name = f"mote-{self._url.rpartition('=')[2]}"
        return (f'<iframe id="{name}" src="{html.escape(self._url)}" title="Mote" allow="clipboard-write; fullscreen" '
                'style="display:block;width:100%;height:0;border:0;border-radius:8px"></iframe>'
                '<script>addEventListener("message", ({source, data}) => {'
                f'const frame = document.getElementById("{name}");'
                'if (frame && source === frame.contentWindow && data === "mote-room") '
                f'frame.style.height = "{self._height}px";}});</script>')

    def __repr__(self) -> str:
        return f"<mote.Live frame of {self._url.partition('?')[0]}>"


_webs: weakref.WeakKeyDictionary[Session, Web] = weakref.WeakKeyDictionary()


def show(view: View, height: int, program: Optional[str], host: str) -> Live:
    session = view._session
    web = _webs.get(session)
    if web is None or not web.alive:
        web = _webs[session] = Web(session.connection.file, program, host)
        session.connection.at_close.append(web.close)
    live = Live(view, web)
    # The picture stays in the saved notebook when the frame has nothing to show any more.
    _display([_Frame(live.url, height), view.render()])
    return live
