# SPDX-License-Identifier: GPL-3.0-or-later
"""A run that a fake server answers for: columns by step from a seed, and its answers to queries by plain numpy."""
import io
import zipfile

import numpy as np

from mote import messages

COLUMNS = ("x", "px", "y")


class FakeRun:
    """``answer`` is what a FakeServer takes. Pieces have at most ``piece`` rows; uploads are kept."""

    def __init__(self, seed=1, steps=3, particles=500, piece=70):
        numbers = np.random.default_rng(seed)
        self.piece = piece
        self.ids = [np.sort(numbers.choice(4 * particles, particles, replace=False)).astype(np.uint64) for _ in range(steps)]
        self.values = [numbers.normal(size=(particles, 3)) for _ in range(steps)]
        self.weights = [numbers.random(particles) for _ in range(steps)]
        self.queries = []
        self.files = {}
        self.jobs = []
        self.lie = lambda message, payload: (message, payload)

    def answer(self, peer, asked):
        body = asked.WhichOneof("body")
        if body == "describe":
            self.describe(peer, asked)
        elif body == "query":
            self.queries.append(asked.query)
            self.query(peer, asked)
        elif body == "upload":
            part = asked.upload
            self.files[part.name] = (b"" if part.begin == 0 else self.files[part.name]) + part.data
            peer.reply(asked, "uploaded", name=part.name, size=len(self.files[part.name]))
        elif body in ("watch_jobs", "list_jobs"):
            self.list(peer, asked)
        elif body == "submit_job":
            self.job(peer, asked)

    def arrays(self, name):
        """The members of an uploaded NPZ, read by zipfile and numpy."""
        with zipfile.ZipFile(io.BytesIO(self.files[name])) as archive:
            return {member[:-4]: np.load(io.BytesIO(archive.read(member))) for member in archive.namelist()}

    def describe(self, peer, asked):
        message = messages.new("ServerMessage")
        message.reply_to = asked.request
        message.description.dataset = asked.describe.dataset
        message.description.manifest.CopyFrom(messages.to_message("Manifest", self.manifest()))
        peer.send(message)

    def manifest(self):
        steps = [{"iteration": 10 * i, "time": 0.5 * i, "particles": len(ids), "statistics": [float(len(ids)), 0.25 * i]}
                 for i, ids in enumerate(self.ids)]
        axes = [{"name": name, "unit": "m", "min": -4, "max": 4} for name in COLUMNS]
        return {"kind": "particles", "title": "<b>fake</b>", "particles": {
            "axes": axes, "columns": [{"name": name, "unit": "m"} for name in COLUMNS], "ids": True, "mass": 5.11e5,
            "steps": steps, "statisticNames": ["n_particle", "sigma_x"]}}

    def job(self, peer, asked):
        for state, progress in (("QUEUED", 0.0), ("RUNNING", 0.5), ("SUCCEEDED", 1.0)):
            message = messages.new("ServerMessage")
            message.reply_to = asked.request if state == "QUEUED" else 0
            message.job.CopyFrom(messages.to_message("JobStatus", {
                "id": "7", "state": state, "progress": progress, "phase": "sorting", "log": ["a line"]}))
            message.job.request.CopyFrom(asked.submit_job.job)
            peer.send(message)
        self.jobs = [message.job]

    def list(self, peer, asked):
        """All on one page."""
        message = messages.new("ServerMessage")
        message.reply_to = asked.request
        message.jobs.total = len(self.jobs)
        message.jobs.jobs.extend(self.jobs[asked.list_jobs.first:])
        peer.send(message)

    def chosen(self, query, step):
        """Of a selection's ranges and ids alone, and of nothing."""
        keep = np.full(len(self.ids[step]), not query.select.nothing)
        for bounds in query.select.ranges:
            column = self.values[step][:, COLUMNS.index(bounds.column)]
            keep &= column >= (bounds.min if bounds.HasField("min") else -np.inf)
            keep &= column <= (bounds.max if bounds.HasField("max") else np.inf)
        if query.select.ids:
            keep &= np.isin(self.ids[step], np.array(query.select.ids, np.uint64))
        return keep

    def steps(self, query):
        if not query.steps:
            return range(len(self.ids))
        first, last, stride = map(int, query.steps.split(":"))
        return range(first, last + 1, stride)

    def query(self, peer, asked):
        query = asked.query
        what = query.WhichOneof("what")
        for step in self.steps(query):
            message = messages.new("ServerMessage")
            message.reply_to = asked.request
            message.answer.step, message.answer.time = step, 0.5 * step
            message.answer.last = step == self.steps(query)[-1]
            payload = getattr(self, what)(query, step, message.answer)
            peer.send(*self.lie(message, payload))

    def column(self, name, step):
        return self.ids[step].view(np.float64) if name == "id" else self.values[step][:, COLUMNS.index(name)]

    def columns(self, query, step, answer):
        asked, said = query.columns, answer.columns
        if asked.by_id:
            return self.by_id(query, step, said)
        rows = np.flatnonzero(self.chosen(query, step)[asked.begin : asked.begin + self.piece]) + asked.begin
        said.names.extend(asked.names)
        said.count, said.next = len(rows), asked.begin + self.piece
        said.end = said.next >= len(self.ids[step])
        return b"".join(self.column(name, step)[rows].tobytes() for name in asked.names)

    def by_id(self, query, step, said):
        at = query.select.step if query.select.HasField("step") else step
        listed = query.select.ids and not query.select.ranges
        wanted = np.unique(np.array(query.select.ids, np.uint64)) if listed else self.ids[at][self.chosen(query, at)]
        part = wanted[query.columns.begin : query.columns.begin + self.piece]
        said.names.extend(query.columns.names)
        said.count, said.next, said.total = len(part), query.columns.begin + len(part), len(wanted)
        said.end = said.next >= len(wanted)
        place = {identity: row for row, identity in enumerate(self.ids[step].tolist())}
        rows = [place.get(identity) for identity in part.tolist()]
        parts = []
        for name in query.columns.names:
            values = [np.nan if row is None else self.column(name, step)[row] for row in rows]
            parts.append(part.tobytes() if name == "id" else np.array(values, np.float64).tobytes())
        return b"".join(parts)

    def histogram(self, query, step, answer):
        keep = self.chosen(query, step)
        data = [self.column(axis.column, step)[keep] for axis in query.histogram.axes]
        ranges = [tuple(axis.range) or (-4.0, 4.0) for axis in query.histogram.axes]
        weights = None if query.histogram.unweighted else self.weights[step][keep]
        counts, edges = np.histogramdd(np.stack(data, 1), [axis.bins for axis in query.histogram.axes], ranges, weights=weights)
        for axis in edges:
            answer.histogram.axes.add().values.extend(axis.tolist())
        answer.histogram.particles = int(keep.sum())
        return counts.tobytes()

    def statistics(self, query, step, answer):
        keep = self.chosen(query, step)
        x = self.values[step][keep, 0]
        answer.statistics.names.extend(["n_particle", "sigma_x"])
        answer.statistics.values.extend([float(keep.sum()), float(x.std()) if len(x) else np.nan])
        if query.statistics.slices:
            count = query.statistics.slice_count or 50
            answer.statistics.slice_edges.extend(np.linspace(-4, 4, count + 1).tolist())
            for i in range(count):
                answer.statistics.slices.add().values.extend([i, step])
        return b""
