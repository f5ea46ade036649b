# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-stats, the program: what it asks, what it tells in each form (numpy is the judge), what it leaves behind, and
what it says of wrong input and of servers that lie."""
import csv
import json
import os
import signal
import subprocess
import threading
import time
import unittest

import numpy as np

from support import BIN, BeamCase, FolderCase, needs_server  # isort: skip
from fake_run import COLUMNS, FakeRun
from fake_server import FakeServer
from mote import messages

PROGRAM = BIN / "mote-stats"
PATIENCE = 60  # s


def run(*words, **options):
    return subprocess.run([str(PROGRAM), *map(str, words)], capture_output=True, text=True, timeout=PATIENCE, check=False, **options)


@unittest.skipUnless(PROGRAM.exists(), f"there is no {PROGRAM}")
class WithRun(FolderCase):
    def setUp(self):
        super().setUp()
        self.fake = FakeRun(steps=4, particles=300)
        self.server = self.serve(self.fake.answer)

    def serve(self, answer):
        server = FakeServer(answer)
        self.enterContext(server)
        return server

    def stats(self, *words, server=None):
        return run("data/beam", "--connect", (server or self.server).file, *words)

    def numbers(self, *words):
        """What it tells in JSON, by step."""
        done = self.stats("--json", *words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return [json.loads(line) for line in done.stdout.splitlines()]

    def write(self, content, name="selection.json"):
        (self.folder / name).write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
        return self.folder / name

    def refused(self, words, *said, status=1, server=None):
        done = self.stats(*words, server=server)
        self.assertEqual(done.returncode, status, done.stderr)
        for part in said:
            self.assertIn(part, done.stderr)
        self.assertEqual(done.stdout, "")
        if status == 1:
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertTrue(done.stderr.startswith("mote-stats: "), done.stderr)

    def left(self):
        """Everything in the folder, hidden files too."""
        return sorted(os.listdir(self.folder))


class Statistics(WithRun):
    def test_whole_steps_need_no_query(self):
        lines = self.numbers()
        self.assertEqual([line["step"] for line in lines], [0, 1, 2, 3])
        self.assertEqual([line["iteration"] for line in lines], [0, 10, 20, 30])
        self.assertEqual([line["sigma_x"] for line in lines], [0, 0.25, 0.5, 0.75])
        self.assertNotIn("query", self.server.bodies())
        self.assertEqual([line["step"] for line in self.numbers("--steps", "1:3:2")], [1, 3])
        self.assertEqual([line["step"] for line in self.numbers("--steps", "2")], [2])
        self.assertEqual(list(self.numbers("--columns", "x")[0]), ["step", "iteration", "time", "n_particle", "sigma_x"])

    def test_selections_are_asked_for(self):
        selection = self.write({"ranges": [{"column": "x", "min": 0.5}]})
        lines = self.numbers("--select", selection, "--steps", "0:2:2")
        self.assertEqual(self.fake.queries[-1].steps, "0:2:2")
        for line in lines:
            x = self.fake.values[line["step"]][:, 0]
            self.assertEqual(line["n_particle"], np.sum(x >= 0.5))
            self.assertEqual(line["sigma_x"], x[x >= 0.5].std())
        empty = self.numbers("--select", self.write({"ranges": [{"column": "x", "min": 50}]}))
        self.assertEqual([(line["n_particle"], line["sigma_x"]) for line in empty], 4 * [(0, None)])

    def test_what_limits_them_is_said(self):
        def limited(message, payload):
            message.answer.notes.append(f"x is held in steps of {message.answer.step} m here")
            return message, payload
        self.fake.lie = limited
        selection = self.write({"ranges": [{"column": "x", "min": 0.5}]})
        for words in (("--select", selection), ("--histogram", "x", "--bins", "9")):
            done = self.stats(*words, "--json", "--steps", "0:1")
            self.assertEqual(done.returncode, 0, done.stderr)
            lines = [json.loads(line) for line in done.stdout.splitlines()]
            self.assertEqual([line["notes"] for line in lines], [[f"x is held in steps of {i} m here"] for i in (0, 1)])
            self.assertEqual(done.stderr, "".join(f"mote-stats: step {i}: x is held in steps of {i} m here\n" for i in (0, 1)))
        self.assertEqual(self.stats("--select", selection, "--quiet").stderr, "")
        self.assertNotIn("notes", self.numbers()[0])

    def test_files_hold_the_same(self):
        selection = self.write({"ranges": [{"column": "px", "max": -2.9}]})
        lines = self.numbers("--select", selection)
        for ending in ("csv", "npy"):
            done = self.stats("--select", selection, f"--{ending}", self.folder / f"out.{ending}")
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        array = np.load(self.folder / "out.npy")
        self.assertEqual(array.dtype.names, ("step", "iteration", "time", "n_particle", "sigma_x"))
        with open(self.folder / "out.csv", encoding="utf-8", newline="") as file:
            table = list(csv.DictReader(file))
        self.assertEqual(len(table), len(lines))
        for line, row, text in zip(lines, array, table):
            for name, value in line.items():
                expected = np.nan if value is None else value
                np.testing.assert_equal(float(row[name]), expected)
                heading = {"time": "time [s]", "sigma_x": "sigma_x [m]"}.get(name, name)
                np.testing.assert_equal(float(text[heading] or "nan"), expected)
        np.testing.assert_array_equal(array["sigma_x [m]"], array["sigma_x"])
        self.assertEqual(self.left(), ["out.csv", "out.npy", "selection.json"])

    def test_tables_are_for_people(self):
        many, one = self.stats().stdout, self.stats("--steps", "3").stdout
        self.assertEqual(len(many.splitlines()), 2 + 4)
        self.assertIn("n_particle", many)
        self.assertIn("750 mm", " ".join(one.split()))
        self.assertIn("step 3, iteration 30, time 1.5000 s", one)


class Histograms(WithRun):
    def test_are_numpy_s(self):
        x, px, _ = self.fake.values[1].T
        (line,) = self.numbers("--histogram", "x,px", "--bins", "7,9", "--range", "x=-1:2", "--steps", "1")
        counts, one, two = np.histogram2d(x, px, (7, 9), [(-1, 2), (-4, 4)], weights=self.fake.weights[1])
        np.testing.assert_array_equal(line["counts"], counts)
        np.testing.assert_array_equal(line["edges"][0], one)
        np.testing.assert_array_equal(line["edges"][1], two)
        (line,) = self.numbers("--histogram", "x", "--bins", "20", "--unweighted", "--steps", "1")
        counts, edges = np.histogram(x, 20, (-4, 4))
        np.testing.assert_array_equal(line["counts"], counts)
        np.testing.assert_array_equal(line["edges"], [edges])

    def test_files_hold_the_same(self):
        lines = self.numbers("--histogram", "x,y", "--bins", "5,6")
        counts = np.array([line["counts"] for line in lines])
        words = ("--histogram", "x,y", "--bins", "5,6")
        self.assertEqual(self.stats(*words, "--npy", self.folder / "all.npy").returncode, 0)
        self.assertEqual(self.stats(*words, "--npy", self.folder / "one.npy", "--steps", "2").returncode, 0)
        self.assertEqual(self.stats(*words, "--csv", self.folder / "all.csv").returncode, 0)
        np.testing.assert_array_equal(np.load(self.folder / "all.npy"), counts)
        np.testing.assert_array_equal(np.load(self.folder / "one.npy"), counts[2])
        table = np.genfromtxt(self.folder / "all.csv", delimiter=",", names=True)
        np.testing.assert_array_equal(table["count"], counts.ravel())
        np.testing.assert_array_equal(np.unique(table["x_from_m"]), lines[0]["edges"][0][:-1])

    def test_are_seen_on_a_terminal(self):
        self.assertIn("#", self.stats("--histogram", "x", "--bins", "30", "--steps", "0").stdout)
        self.assertIn("along x", self.stats("--histogram", "x,px", "--bins", "30", "--steps", "0").stdout)


class Exports(WithRun):
    def test_rows_come_whole_however_they_are_cut(self):
        selection = self.write({"ranges": [{"column": "x", "min": -1, "max": 1}]})
        for ending in ("npy", "csv"):
            done = self.stats("--select", selection, "--export", self.folder / f"rows.{ending}", "--steps", "0:2:2")
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        array = np.load(self.folder / "rows.npy")
        self.assertEqual(array.dtype.names, ("step", "id", *COLUMNS))
        table = np.genfromtxt(self.folder / "rows.csv", delimiter=",", names=True)
        for step in (0, 2):
            keep = np.abs(self.fake.values[step][:, 0]) <= 1
            rows = array[array["step"] == step]
            np.testing.assert_array_equal(rows["id"], self.fake.ids[step][keep])
            for i, name in enumerate(COLUMNS):
                np.testing.assert_array_equal(rows[name], self.fake.values[step][keep, i])
                np.testing.assert_array_equal(rows[f"{name} [m]"], rows[name])
                np.testing.assert_array_equal(table[table["step"] == step][name + "_m"], rows[name])

    def test_columns_are_chosen(self):
        self.assertEqual(self.stats("--export", self.folder / "rows.npy", "--columns", "px,id", "--steps", "1").returncode, 0)
        array = np.load(self.folder / "rows.npy")
        self.assertEqual(array.dtype, [(("px [m]", "px"), "<f8"), ("id", "<u8")])
        np.testing.assert_array_equal(array["px"], self.fake.values[1][:, 1])

    def test_a_job_s_file_is_fetched(self):
        content = os.urandom(3 << 20)
        seen = []

        def answer(peer, asked):
            body = asked.WhichOneof("body")
            if body == "submit_job":
                seen.append(asked.submit_job.job.export)
            if body == "fetch_film":
                begin = asked.fetch_film.begin
                peer.reply(asked, "film_piece", content[begin : begin + (1 << 20)], size=len(content), begin=begin)
            else:
                self.fake.answer(peer, asked)

        selection = self.write({"ids": [3, 4]})
        done = self.stats("--select", selection, "--steps", "1:2", "--columns", "x,px", "--export", self.folder / "halo.h5",
                          server=self.serve(answer))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual((self.folder / "halo.h5").read_bytes(), content)
        self.assertEqual((seen[0].dataset, seen[0].steps, list(seen[0].columns), list(seen[0].select.ids)),
                         ("data/beam.mote", "1:2:1", ["x", "px"], [3, 4]))


class WrongInput(WithRun):
    def test_is_one_sentence(self):
        self.refused(["--select", self.folder / "none.json"], "none.json")
        self.refused(["--select", self.write("{")], "selection.json")
        self.refused(["--select", self.write({"rangs": []})], "selection.json", "rangs")
        points = {"polygon": {"columns": ["x", "px"], "points": [[0, 0], [1, 1]]}}
        self.refused(["--select", self.write(points)], "polygon.points")
        self.refused(["--select", self.write({"named": "halo"})], "named", "halo")
        self.refused(["--steps", "2:9"], "--steps", "4 steps")
        self.refused(["--columns", "x,wind"], "--columns", "wind")
        self.refused(["--csv", self.folder / "no" / "where.csv"], "where.csv")
        self.refused(["--npy", self.folder], "folder")
        self.refused(["--histogram", "x", "--bins", "0"], "--bins", status=2)
        self.assertEqual(self.left(), ["selection.json"])

    def test_other_datasets_are_told_apart(self):
        def answer(kind, **particles):
            def reply(peer, asked):
                if asked.WhichOneof("body") != "describe":
                    return
                manifest = self.fake.manifest()
                manifest.update(kind=kind)
                manifest["particles"].update(particles)
                message = messages.new("ServerMessage")
                message.reply_to = asked.request
                message.description.manifest.CopyFrom(messages.to_message("Manifest", manifest))
                peer.send(message)
            return self.serve(reply)

        self.refused([], "holds no particles", "mesh", server=answer("mesh"))
        self.refused([], "made before statistics", "mote-prep", server=answer("particles", statisticNames=[], columns=[], ids=False))
        self.refused(["--export", self.folder / "a.npy"], "made without columns", "mote-prep",
                     server=answer("particles", columns=[], ids=False))
        self.refused([], "no steps", server=answer("particles", steps=[]))

    def test_what_a_server_says_reaches_no_terminal_raw(self):
        def answer(peer, asked):
            if asked.WhichOneof("body") == "describe":
                peer.fail(asked, "not_found", "data\x1b[2J", "gone\x07 \u009b31m\nmore")

        done = self.stats(server=self.serve(answer))
        self.assertEqual(done.returncode, 1)
        for letter in "\x1b\x07\u009b":
            self.assertNotIn(letter, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        lying = FakeRun()
        manifest = lying.manifest()
        manifest["particles"]["statisticNames"] = ["n_\x1b[2J\u009b\"", "sigma_x"]
        lying.manifest = lambda: manifest
        for words in ([], ["--json"], ["--steps", "0"]):
            done = self.stats(*words, server=self.serve(lying.answer))
            self.assertEqual(done.returncode, 0, done.stderr)
            for letter in "\x1b\u009b":
                self.assertNotIn(letter, done.stdout)

    def test_answers_that_cannot_be_true_are_refused(self):
        def more(message, payload):
            return message, payload + b"12345678"

        def elsewhere(message, payload):
            message.answer.step += 1
            return message, payload

        def endless(message, payload):
            message.answer.last = True
            return message, payload

        selection = self.write({"ranges": [{"column": "x"}]})
        for lie in (more, elsewhere, endless):
            self.fake.lie = lie
            for words in (["--histogram", "x", "--bins", "5", "--npy", self.folder / "a.npy"], ["--select", selection, "--csv", self.folder / "a.csv"],
                          ["--export", self.folder / "rows.csv"]):
                if lie is more and "--select" in words:
                    continue  # statistics have no payload
                if lie is endless and "--export" in words:
                    continue  # each of its queries is of one step
                self.refused(words, "server")
        self.assertEqual(self.left(), ["selection.json"])


class Interrupted(WithRun):
    def test_cancels_its_query_and_leaves_nothing(self):
        asked_for = threading.Event()

        def answer(peer, asked):
            if asked.WhichOneof("body") == "query":
                asked_for.set()
            elif asked.WhichOneof("body") == "ping":
                peer.reply(asked, "pong")
            else:
                self.fake.answer(peer, asked)

        for words in (["--histogram", "x", "--npy", "h.npy"], ["--export", "rows.csv"]):
            asked_for.clear()
            server = self.serve(answer)
            with subprocess.Popen([str(PROGRAM), "data/beam", "--connect", server.file, *words], cwd=self.folder,
                                  stderr=subprocess.PIPE, text=True) as process:
                self.assertTrue(asked_for.wait(PATIENCE))
                begin = time.monotonic()
                process.send_signal(signal.SIGINT)
                said = process.communicate(timeout=PATIENCE)[1]
                self.assertEqual(process.returncode, 128 + signal.SIGINT)
            self.assertLess(time.monotonic() - begin, 5)
            self.assertIn("interrupted", said)
            query = next(message.request for message in server.said if message.WhichOneof("body") == "query")
            cancels = [message.cancel_query.request for message in server.said if message.WhichOneof("body") == "cancel_query"]
            self.assertEqual(cancels, [query])
            self.assertEqual(self.left(), [])


@needs_server
class RealServer(BeamCase):
    """The server's answers, by the program, held to numpy on the columns that the package gets."""

    def told(self, *words):
        done = run("data/beam", "--spawn", f"data={self.plots}", "--json", *words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return [json.loads(line) for line in done.stdout.splitlines()]

    def test_numbers_are_numpy_s(self):
        selection = self.plots / "selection.json"
        selection.write_text('{"ranges": [{"column": "x", "min": 5e-4}], "step": 2}', encoding="utf-8")
        ids = self.ds.get("id", 2, {"ranges": [{"column": "x", "min": 5e-4}]})
        lines = self.told("--select", selection)
        self.assertEqual([line["step"] for line in lines], list(range(len(self.ds))))
        for line in lines:
            x, px, own = self.ds.get(["x", "px", "id"], line["step"])
            keep = np.isin(own, ids)
            self.assertEqual(line["n_particle"], keep.sum())
            for name, value in (("mean_x", x[keep].mean()), ("sigma_x", x[keep].std()), ("min_px", px[keep].min()),
                                ("max_px", px[keep].max()), ("cov_x__px", np.cov(x[keep], px[keep], bias=True)[0, 1])):
                np.testing.assert_allclose(line[name], value, rtol=1e-6, err_msg=name)

    def test_histograms_are_numpy_s(self):
        x, px, weight = self.ds.get(["x", "px", "weight"], 1)
        (line,) = self.told("--histogram", "x,px", "--bins", "8,9", "--range", "x=-2e-3:2e-3", "--range", "px=-1e5:1e5",
                            "--steps", "1")
        counts, one, two = np.histogram2d(x, px, (8, 9), [(-2e-3, 2e-3), (-1e5, 1e5)], weights=weight)
        np.testing.assert_allclose(line["counts"], counts, rtol=1e-12)
        np.testing.assert_allclose(line["edges"][0], one, rtol=1e-12)
        np.testing.assert_allclose(line["edges"][1], two, rtol=1e-12)

    def test_exported_rows_are_the_columns(self):
        out = self.plots / "rows.npy"
        done = run("data/beam", "--spawn", f"data={self.plots}", "--export", out, "--steps", "1")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        rows = np.load(out)
        for name in rows.dtype.names:
            np.testing.assert_array_equal(rows[name], self.ds.get(name, 1))

    def test_what_is_not_there_is_said(self):
        done = run("data/beam", "--spawn", f"data={self.plots}", "--histogram", "wind")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("wind", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
