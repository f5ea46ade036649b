# SPDX-License-Identifier: GPL-3.0-or-later
"""What a server tells of itself while it works: a log of JSON lines, metrics for Prometheus, its health; no secrets."""
import collections
import http.client
import json
import math
import re
import signal
import socket
import subprocess
import unittest

from support import BIN, FolderCase, make_beam, mote, needs_server

NAME = re.compile(r"[a-zA-Z_:][a-zA-Z0-9_:]*")
SAMPLE = re.compile(rf'({NAME.pattern})(?:\{{((?:{NAME.pattern}="(?:[^"\\\n]|\\["\\n])*",?)*)\}})? (\S+)')


def read_metrics(text):
    """Samples as {(name, labels): value}. Raises where Prometheus would complain: as promtool checks."""
    types, samples = {}, {}
    assert text.endswith("\n"), "the last line ends"
    for line in text.splitlines():
        if line.startswith("# TYPE "):
            _, _, name, kind = line.split(" ")
            assert name not in types, f"{name} twice"
            types[name] = kind
            continue
        if line.startswith("# HELP "):
            continue
        found = SAMPLE.fullmatch(line)
        assert found, line
        name, labels, value = found[1], found[2] or "", float(found[3])
        base = re.sub(r"_(bucket|sum|count)$", "", name) if name not in types else name
        assert base in types, f"{name} has no type"
        assert types[base] != "counter" or name.endswith("_total"), name
        assert (name, labels) not in samples, f"{name} {labels} twice"
        samples[name, labels] = value
    check_histograms(samples)
    return samples


def check_histograms(samples):
    """Buckets grow, and the last one has no bound and all of them."""
    series = collections.defaultdict(list)
    for (name, labels), value in samples.items():
        bound = re.search(r'(.*?),?le="([^"]*)"', labels)
        if name.endswith("_bucket"):
            series[name.removesuffix("_bucket"), bound[1]].append((float(bound[2]), value))
    for (name, labels), buckets in series.items():
        assert buckets == sorted(buckets), name
        assert math.isinf(buckets[-1][0]), name
        assert buckets[-1][1] == samples[name + "_count", labels], name


class UnixConnection(http.client.HTTPConnection):
    def __init__(self, path):
        super().__init__("localhost")
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.connect(str(self.path))


@needs_server
class Operation(FolderCase):
    def setUp(self):
        super().setUp()
        (self.folder / "data").mkdir()
        make_beam(self.folder / "data", particles=1000, steps=1)
        self.configure()
        self.server = subprocess.Popen([BIN / "mote-server", "--config", self.folder / "server.toml"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.stop)
        self.assertTrue(self.server.stdout.readline().startswith("ready "))
        self.token = json.loads((self.folder / "connection.json").read_text(encoding="utf-8"))["token"]

    def configure(self):
        lines = [f'root = ["data={self.folder}/data"]', 'device = "cpu"', 'log-format = "json"', "threads = 1"]
        for key, name in (("state", "state"), ("connection", "connection.json"), ("log", "server.log")):
            lines.append(f'{key} = "{self.folder}/{name}"')
        lines.append(f'metrics = "unix:{self.folder}/metrics.sock"')
        (self.folder / "server.toml").write_text("\n".join(lines), encoding="utf-8")

    def stop(self):
        if self.server.poll() is None:
            self.server.send_signal(signal.SIGTERM)
        said = self.server.communicate(timeout=60)
        return self.server.returncode, said

    def get(self, path):
        connection = UnixConnection(self.folder / "metrics.sock")
        connection.request("GET", path)
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        return answer.status, text

    def wrong_token(self):
        file = self.folder / "wrong.json"
        content = json.loads((self.folder / "connection.json").read_text(encoding="utf-8"))
        file.write_text(json.dumps({**content, "token": "0" * len(self.token)}), encoding="utf-8")
        file.chmod(0o600)
        with self.assertRaises(mote.Error):
            mote.connect(file).close()

    def use(self):
        with mote.connect(self.folder / "connection.json") as session:
            mote.View(session["data/beam"], size=(64, 64)).render()
            with self.assertRaises(mote.Error):
                session["data/none"]
            session.prepare("data/run.h5", axes=["x", "px", "y"], output="data/again.mote").wait()
        self.wrong_token()

    def test_what_is_counted_and_what_is_logged(self):
        self.assertEqual(self.get("/healthz"), (200, "well\n"))
        before = read_metrics(self.get("/metrics")[1])
        self.use()
        status, text = self.get("/metrics")
        self.assertEqual(status, 200)
        after = read_metrics(text)
        grown = {key: after[key] - before.get(key, 0) for key in after}
        self.assertEqual(grown["mote_sessions_total", ""], 1)
        self.assertEqual(grown["mote_refused_total", 'reason="token"'], 1)
        self.assertEqual(grown["mote_frames_total", 'final="true"'], 1)
        self.assertEqual(grown["mote_frame_seconds_count", 'part="render"'], 1)
        self.assertEqual(grown["mote_jobs", 'state="succeeded"'], 1)
        self.assertGreaterEqual(grown["mote_errors_total", 'code="not_found"'], 1)
        self.assertGreater(grown["mote_sent_bytes_total", ""], 100)
        self.assertEqual(after["mote_datasets", ""], 2)
        code, said = self.stop()
        self.assertEqual(code, 0)
        log = (self.folder / "server.log").read_text(encoding="utf-8")
        self.check_log(log)
        secrets = [self.token, self.token.encode().hex(), "0" * len(self.token)]
        for place in (log, text, *said):
            for secret in secrets:
                self.assertNotIn(secret, place)

    def check_log(self, log):
        lines = [json.loads(line) for line in log.splitlines()]
        for line in lines:
            self.assertRegex(line["time"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z$")
            self.assertIn(line["level"], ("info", "warning", "error"))
            self.assertLessEqual(set(line), {"time", "level", "session", "job", "kind", "text"})
        kinds = {line["kind"] for line in lines}
        for kind in ("state in {}: {}", "root {}: {}{}", "{} run {}", "metrics at {}"):
            self.assertIn(kind, kinds, "what the server found when it began")
        self.assertTrue(any("kernel" in kind for kind in kinds))
        sessions = [line for line in lines if "session" in line]
        self.assertTrue(any("connected" in line["text"] for line in sessions))
        self.assertTrue(any("token" in line["text"] for line in lines if "session" not in line), "of a stranger")
        self.assertTrue(any(re.fullmatch(r"[0-9a-f]{16}", line.get("job", "")) for line in lines), "of the job")


if __name__ == "__main__":
    unittest.main()
