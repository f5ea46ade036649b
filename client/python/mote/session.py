# SPDX-License-Identifier: GPL-3.0-or-later
"""Session: a connection to a server, its datasets and its jobs; and how one is begun."""
from __future__ import annotations

import html
import importlib
import itertools
import os
import time
import weakref
from collections.abc import Iterator, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Type, Union

from . import arguments
from .connection import Connection
from .errors import Error, invalid
from .messages import Message, new, to_message
from .server import PrivateServer

if TYPE_CHECKING:
    from .dataset import Dataset
    from .files import Files
    from .jobs import Job
    from .live_run import LiveRun
    from .view import View

_CLIENT = "mote for Python"


def _end(connection: Connection, server: Optional[PrivateServer]) -> None:
    connection.close()
    if server is not None:
        server.stop()


class Session:
    """The result of ``connect`` and ``spawn``: a mapping of names to datasets, and the server's jobs.

    It ends with ``close()``, as a context manager, when nothing refers to it any more, or with Python; a server that
    it spawned ends with it.
    """

    def __init__(self, connection: Connection, server: Optional[PrivateServer] = None) -> None:
        self.connection = connection
        self._server = server
        self._uploads = itertools.count()
        self._end = weakref.finalize(self, _end, connection, server)

    # ------------------------------------------------------------------------------------------ datasets

    def catalogue(self) -> List[Message]:
        """What the server has, entry by entry: name, kind, title, steps, particles (of the largest step)."""
        message = new("ClientMessage")
        message.list_datasets.SetInParent()
        return list(self.connection.ask(message, "catalogue").message.catalogue.datasets)

    @property
    def datasets(self) -> List[str]:
        """The names of all datasets: "ROOT/NAME"."""
        return [entry.name for entry in self.catalogue()]

    def __getitem__(self, name: str) -> Dataset:
        """A dataset by its name. Raises Error (not_found)."""
        from .dataset import Dataset

        return Dataset(self, self.describe(name))

    def describe(self, name: str) -> Message:
        """What the server says about a dataset now, a Description. Raises Error (not_found)."""
        message = new("ClientMessage")
        message.describe.dataset = name
        return self.connection.ask(message, "description").message.description

    def __iter__(self) -> Iterator[str]:
        return iter(self.datasets)

    def __contains__(self, name: object) -> bool:
        return name in self.datasets

    def __len__(self) -> int:
        return len(self.datasets)

    # --------------------------------------------------------------------------------------------- files

    def files(self, folder: str = "") -> Files:
        """What lies in a folder beneath a root of the server, "ROOT/PATH"; by default the roots.

        Each has path, name, kind ("file", "folder", "dataset"), size (bytes) and changed (Unix time, s); ``.notes`` of the
        list says what is left out. Raises Error (not_found, permission_denied, invalid_argument, unsupported: an older server).
        """
        from .files import list_folder

        return list_folder(self.connection, folder)

    def look(self, path: str, *, format: str = "", map: str = "") -> Dict[str, Any]:
        """What a file beneath a root holds, or a folder as one run: what mote-prep look --json tells, as a dict.

        ``look("data/run.h5")["found"]`` has a dict for each thing that it can be read as: kind, format, columns with their
        ranges, steps, species, notes (what would be assumed) and refused (why it would not be prepared). It is read by a
        confined process of the server's, one at a time of a session; an interrupt ends it.

        Args:
            path: "ROOT/PATH".
            format: how it is read, as --format; default: told by its content.
            map: what a table's columns are, as --map: "x=X [mm],px=PX [MeV/c]".
        """
        from .files import look

        return look(self.connection, path, format, map)

    # ---------------------------------------------------------------------------------------------- jobs

    @property
    def jobs(self) -> List[Job]:
        """All jobs that the server remembers, the latest first."""
        from .jobs import Job

        self.connection.watch_jobs()
        identities: Dict[str, None] = {}
        while True:
            message = new("ClientMessage")
            message.list_jobs.first = len(identities)
            page = self.connection.ask(message, "jobs").message.jobs
            new_ones = [job.id for job in page.jobs if job.id not in identities]
            identities.update(dict.fromkeys(new_ones))
            if not new_ones or len(identities) >= page.total:
                return [Job(self, identity) for identity in identities]

    def job(self, identity: str) -> Job:
        """A job by its id. Raises Error (not_found)."""
        from .jobs import Job

        self.connection.watch_jobs()
        if identity not in self.connection.jobs and identity not in [job.id for job in self.jobs]:
            raise Error("not_found", "id", f"there is no job {identity}")
        return Job(self, identity)

    def submit(self, request: Mapping[str, Any], *, again: bool = False, time_limit: int = 0) -> Job:
        """Submits a job, written as in its JSON (docs/JOBS.md): {"output": ..., "particles": {...}}.

        Args:
            request: as plain values.
            again: do it even if the same request is waiting or running, or its output is there; otherwise that job is returned.
            time_limit: s; 0: the server's, which is never exceeded.
        """
        from .jobs import Job

        seconds = arguments.whole(time_limit, "time_limit")
        if not 0 <= seconds < 2**31:
            raise invalid("time_limit", f"is seconds, from 0 on, not {seconds}")
        self.connection.watch_jobs()
        message = new("ClientMessage")
        message.submit_job.job.CopyFrom(to_message("JobRequest", request))
        message.submit_job.again = arguments.flag(again, "again")
        message.submit_job.time_limit_s = seconds
        return Job(self, self.connection.ask(message, "job").message.job.id)

    def prepare(self, input: Union[str, Sequence[str]], *, output: str, axes: Optional[Sequence[str]] = None,
                kind: str = "particles", title: str = "", **options: Any) -> Job:
        """Has a dataset prepared from files beneath the server's roots.

        Args:
            input: "ROOT/PATH", or several of them.
            output: "ROOT/NAME.mote".
            axes: for particles: three quantities (docs/NUMBERS.md), or expressions over them.
            kind: "particles", "volume", "mesh", "image" or "stipple".
            title: of the dataset.
            options: those of the kind of job, as in docs/JOBS.md: species="electron", steps="0:360:10", columns=["x", "px"].
        """
        from .jobs import request_of

        return self.submit(request_of(kind, input, output, axes, title, options))

    def prepare_arrays(self, arrays: Union[Mapping[str, Any], Sequence[Mapping[str, Any]]], axes: Sequence[str],
                       output: str, *, mass: Optional[float] = None, time: Any = None, iteration: Any = None,
                       title: str = "", **options: Any) -> Job:
        """Has a dataset prepared from numpy arrays: of one step a dict of columns, of several steps a list of them.

        Args:
            arrays: columns by name (x y z t px py pz weight or charge, id, status or lost or alive; others, such as "spin" or
                "spin [hbar]", are kept beside them): one-dimensional, all of one length; a single number stands for all
                particles. m, eV/c, s. Particles with values that are masked or not finite are left out, with a warning.
            axes: three columns, derived quantities or expressions: "hypot(x, y)".
            output: "ROOT/NAME.mote".
            mass: of one particle, eV/c^2; energies need it, slopes do not.
            time: of each step, s.
            iteration: of each step; default 0, 1, 2, ...
            title: of the dataset.
            options: as for ``prepare``: volume_level, bounds, columns.
        """
        from .arrays import checked_mass, kept_columns, upload_steps
        from .jobs import axis_names, request_of

        if mass is not None:
            options["mass"] = mass = checked_mass(mass)
        axes = axis_names(axes)
        to_message("JobRequest", request_of("particles", "uploads/none", output, axes, title, options))
        names = upload_steps(self, next(self._uploads), arrays, mass, time, iteration)
        if "columns" not in options and kept_columns(arrays):
            options["columns"] = kept_columns(arrays)
        return self.submit(request_of("particles", names, output, axes, title, options))

    def live(self, output: str, axes: Sequence[str], *, mass: Optional[float] = None, title: str = "",
             **options: Any) -> LiveRun:
        """A dataset that gets its steps one by one while a simulation runs, and that anybody can look at meanwhile:
        run = s.live("data/live.mote", axes=["x", "px", "y"]); run.step({"x": x, "px": px, "y": y}); run.close().

        If the dataset is there and live, as it is after a script has ended early, the run continues it.

        Args:
            output: "ROOT/NAME.mote".
            axes: three of them, as for ``prepare_arrays``.
            mass: of one particle, eV/c^2.
            title: of the dataset.
            options: as for ``prepare``: bounds, bounds_of="step", volume_level, columns. Without bounds, those of the
                first step hold for all.
        """
        from .live_run import LiveRun

        return LiveRun(self, output, axes, mass, title, options, self._uploads)

    def film(self, script: Any, *, video: str = "mp4", title: str = "", **options: Any) -> Job:
        """Has the server make a film (docs/SCRIPTS.md); ``job.wait().save("film.mp4")`` fetches it.

        Args:
            script: a Script, or a script as in its JSON.
            video: "mp4", "webm" or "gif"; "": only its pictures.
            title: of the job.
            options: those of the job: quality, samples, shutter_degrees, subframes, format; chroma="full" keeps the colours
                of single points, but QuickTime and some browsers do not play it.
        """
        return self.submit({"title": title, "film": {"script": script, "video": video, **options}})

    def view(self, fields: Mapping[str, Any]) -> View:
        """A view as a script or a saved view has it."""
        from .view import View

        return View.from_dict(self, fields)

    # --------------------------------------------------------------------------------------------- itself

    @property
    def device(self) -> str:
        """What draws the server's pictures."""
        welcome = self.connection.welcome
        return str(welcome.device) if welcome is not None else ""

    def ping(self) -> float:
        """The round trip to the server, s."""
        import time

        begun = time.perf_counter()
        message = new("ClientMessage")
        message.ping.SetInParent()
        self.connection.ask(message, "pong")
        return time.perf_counter() - begun

    def close(self) -> None:
        """Ends the connection, and the server if it is our own. Again: nothing."""
        self._end()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if not self._end.alive else self.device
        return f"<mote.Session {state}>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{html.escape(entry.name)}</td><td>{html.escape(entry.kind)}</td><td>{entry.steps}</td>"
            f"<td>{entry.particles:,}</td><td>{_size(entry.bytes)}</td><td>{_date(entry.prepared_ms)}</td>"
            f"<td>{html.escape(entry.title)}</td></tr>" for entry in self.catalogue())
        names = ("dataset", "kind", "steps", "particles", "size", "prepared", "title")
        head = "".join(f"<th>{name}</th>" for name in names)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _size(size: int) -> str:
    """For people; nothing where a server does not tell it."""
    return f"{size / 1e6:,.1f} MB" if size else ""


def _date(unix_ms: int) -> str:
    """By this machine's clock; nothing where a server does not tell it."""
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(unix_ms / 1000)) if unix_ms > 0 else ""


def connect(file: Union[str, os.PathLike[str]], *, background: bool = False) -> Session:
    """A session with the server of a connection file. Raises Error.

    Args:
        file: the connection file that mote-server --connection wrote.
        background: pictures are made only while nobody else waits for one.
    """
    return Session(Connection(os.path.abspath(os.fspath(file)), _CLIENT, background))


def spawn(roots: Optional[Mapping[str, Any]] = None, *, program: Optional[Union[str, os.PathLike[str]]] = None,
          device: str = "auto", memory: Optional[str] = None, threads: Optional[int] = None, **more: Any) -> Session:
    """A session with a server of its own, which ends with it.

    Args:
        roots: names of folders with datasets, or as keywords: mote.spawn(data="plots").
        program: mote-server; default: MOTE_SERVER in the environment, or what is in PATH or in the source tree's build.
        device: "auto", "cpu" or "egl".
        memory: what the server may use, such as "8G".
        threads: for its jobs and the cpu device.
    """
    folders: Dict[str, str] = {name: os.fsdecode(folder) for name, folder in {**(roots or {}), **more}.items()}
    options = ["--device", device]
    if memory is not None:
        options += ["--memory", str(memory)]
    if threads is not None:
        options += ["--threads", str(threads)]
    server = PrivateServer(None if program is None else os.fspath(program), folders, options)
    try:
        _import_meanwhile()
        server.wait_until_ready()
        return Session(Connection(server.connection_file, _CLIENT, ended=server.ended), server)
    except BaseException:
        server.stop()
        raise


def _import_meanwhile() -> None:
    """What the first picture needs, while the server starts."""
    new("ClientMessage")
    new("ServerMessage")
    for name in ("zstandard", "numpy", "mote.dataset", "mote.image", "mote.view"):
        importlib.import_module(name)
