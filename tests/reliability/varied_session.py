# SPDX-License-Identifier: GPL-3.0-or-later
"""A session in which a client of Python's says a bit of everything, and what it heard: equal however often its line
broke meanwhile, or it was not brought back as it was."""
import own_server
from own_server import mote, new
from mote.messages import to_message

DATASET = "data/beam"
WAYS = 4
"""In so many ways the same is said: other views, selections and numbers."""
_TRIES = 4


def _camera(way):
    return {"eye": [2.0 + 0.3 * way, 1.5 - 0.4 * way, 1.2], "target": [0, 0, 0], "up": [0, 0, 1]}


def halo(way):
    return {"density": {"max": 0.25 + 0.1 * way}}


def views(way):
    """Three views that follow each other: two layers, a selection that is made, the selection changed."""
    core, changed = {"density": {"min": 0.4}}, {"density": {"min": 0.3}, "ranges": [{"column": "x", "min": 0.0}]}
    base = {"width": 48 + 8 * way, "height": 40, "camera": _camera(way)}
    layer = {"dataset": DATASET, "step": way % 2, "particles": {}}
    marked = {**layer, "highlight": {"selection": {"named": "mine"}, "color": [1, 0, 0]}}
    beside = {**layer, "step": 1, "opacity": 0.5, "transform": [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
    return [{**base, "layers": [layer, beside]},
            {**base, "layers": [marked, beside], "selections": [{"name": "mine", "selection": core}]},
            {**base, "layers": [beside, marked], "selections": [{"name": "mine", "selection": changed}]}]


class VariedSession:
    """``heard`` holds what was answered, by name; ``shown`` the view that the session has at last."""

    def __init__(self, session, way, title):
        self._session, self._way, self.title = session, way, title
        self.heard, self.shown = {}, None

    def run(self):
        """The id of its job. Raises mote.Error where a question stays without an answer though the line came back."""
        heard, way, (first, marked, changed) = self.heard, self._way, views(self._way)
        beam = self._session[DATASET]
        heard["datasets"] = [name for name in self._session.datasets if name == DATASET]
        heard["first view"] = self._look(first)
        heard["statistics"] = list(beam.statistics(step=1, select=halo(way), names=["mean_x", "sigma_x"]).values())
        heard["marked view"] = self._look(marked)
        job = self._submit()
        heard["upload"] = self._upload([b"a" * 700, b"b" * 300])
        heard["histogram"] = [counts.tolist() for counts in beam.histogram("x", bins=16, step=None)[:1]]
        heard["column"] = beam.get("px", step=0, select=halo(way)).tobytes()
        heard["film"] = self._film(beam)
        heard["changed view"] = self._look(changed)
        heard["pick"] = str(beam.pick(self._session.view(first), 24.0, 20.0, 30.0))
        self._cancel(job)
        self._session.ping()
        return job.id

    def _look(self, fields):
        """As at a window: the view stays the session's own. Its exact picture."""
        message = new("ClientMessage")
        message.set_view.view.CopyFrom(to_message("View", fields))
        message.set_view.final_only = True
        self.shown = message.set_view.view
        return bytes(self._session.connection.ask(message, "frame").payload)

    def _film(self, beam):
        """Several pictures ahead, as a script asks for them."""
        view = beam.view(size=(32, 24), camera=_camera(self._way))
        asked = [view.replace(background=[0.1 * number, 0, 0]) for number in range(4)]
        requests = [(frame, frame.submit()) for frame in asked]
        return [frame.collect(request).array.tobytes() for frame, request in requests]

    def _submit(self):
        """Once, though its answer may be lost: then the list of jobs tells."""
        request = {"title": self.title, "export": {"dataset": f"{DATASET}.mote", "steps": "0:0:1",
                                                    "select": halo(self._way), "columns": ["x"]}}
        for _ in range(_TRIES):
            try:
                return self._session.submit(request, again=True)
            except mote.Error as error:
                if error.code != "internal" or self._session.connection.lost:
                    raise
            known = [job for job in self._session.jobs if job.status.request.title == self.title]
            if known:
                return known[0]
        raise RuntimeError("the job could not be submitted")

    def _cancel(self, job):
        """It has ended, this way or by itself, and the client is told so."""
        try:
            job.cancel()
        except mote.Error:
            if self._session.connection.lost:
                raise
        self._session.connection.wait_for(lambda: job.finished, 60)
        self.heard["job is over"] = job.finished

    def _upload(self, pieces):
        """An upload ends with its connection: it is begun anew."""
        for attempt in range(_TRIES):
            begin = 0
            try:
                for piece in pieces:
                    message = new("ClientMessage")
                    upload = message.upload
                    upload.name, upload.begin, upload.data = f"part-{attempt}", begin, piece
                    upload.size = 0 if begin else sum(map(len, pieces))
                    begin = self._session.connection.ask(message, "uploaded").message.uploaded.size
                return begin
            except mote.Error:
                if self._session.connection.lost:
                    raise
        raise RuntimeError("the upload came to no end")


def make_data(build, folder):
    own_server.make_beam(build, folder / "data", 2000, 2)
