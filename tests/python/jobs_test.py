# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-frames and the jobs of a server: listed to the last page, followed, cancelled, tried again; left with a time."""
import json
import pathlib
import subprocess
import tempfile
import unittest

from support import BIN, Case  # isort: skip
from fake_server import FakeServer  # isort: skip
from mote.messages import new  # isort: skip
from terminal_test import EVIL, OBEYED, SCRIPT  # isort: skip

QUEUED, RUNNING, SUCCEEDED, FAILED, CANCELLED = range(1, 6)


def job(number, state=SUCCEEDED, **more):
    made = new("JobStatus")
    made.id, made.state, made.request.title = f"{number:016x}", state, f"film {number}"
    for name, value in more.items():
        if name == "log":
            made.log.extend(value)
        else:
            setattr(made, name, value)
    return made


class Queue:
    """A server's jobs, the latest first, two a page. ``come``: what comes in after the first page was read."""

    def __init__(self, *jobs, come=()):
        self.jobs, self.come = list(jobs), list(come)

    def answer(self, peer, message):
        answer = getattr(self, message.WhichOneof("body"), None)
        if answer:
            answer(peer, message)

    def ping(self, peer, message):
        peer.reply(message, "pong")

    def tell(self, peer, jobs, asked=None):
        """All in one message, or, unasked, one of them."""
        told = new("ServerMessage")
        if asked:
            told.reply_to = asked.request
            told.jobs.total, told.jobs.first = len(self.jobs), asked.list_jobs.first
            told.jobs.jobs.extend(jobs)
        else:
            told.job.CopyFrom(jobs[0])
        peer.send(told)

    def watch_jobs(self, peer, message):
        self.tell(peer, self.jobs[:2], message)

    def list_jobs(self, peer, message):
        first = message.list_jobs.first
        self.tell(peer, self.jobs[first:first + 2], message)
        self.jobs, self.come = self.come + self.jobs, []

    def cancel_job(self, peer, message):
        peer.reply(message, "job", id=message.cancel_job.id, state=RUNNING)

    def retry_job(self, peer, message):
        peer.reply(message, "job", id="f" * 16, state=QUEUED)

    def submit_job(self, peer, message):
        peer.reply(message, "job", id="e" * 16, state=QUEUED)


class Followed(Queue):
    """One job that changes while its page is on its way: told before the page, or after it."""

    def __init__(self, then, before):
        super().__init__(job(3), job(2), job(1, RUNNING, progress=0.25, phase="frame 1 of 4"))
        self.then, self.before = then, before

    def list_jobs(self, peer, message):
        last = message.list_jobs.first == 2
        if last and self.before:
            self.tell(peer, [self.then])
        super().list_jobs(peer, message)
        if last and not self.before:
            self.tell(peer, [self.then])


class Dropping(Followed):
    """It hangs up once the job is being waited for, and the job ends unseen."""

    def list_jobs(self, peer, message):
        Queue.list_jobs(self, peer, message)
        if message.list_jobs.first == 2 and self.jobs[2] != self.then:
            self.jobs[2] = self.then
            peer.hang_up()


@unittest.skipUnless((BIN / "mote-frames").exists(), "there is no mote-frames")
class Jobs(Case):
    def asked(self, queue, *words, code=0):
        """What mote-frames prints, and what it said to the server."""
        with FakeServer(queue.answer) as server:
            done = subprocess.run([BIN / "mote-frames", *words, "--connect", server.file], capture_output=True, timeout=60)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout.decode(), done.stderr.decode(), server.said

    def test_a_list_is_read_to_its_end(self):
        jobs = [job(5, QUEUED), job(4, RUNNING, progress=0.42, phase="frame 3 of 7"), job(3), job(2, CANCELLED),
                job(1, FAILED, error="the disk is full")]
        said, _, _ = self.asked(Queue(*jobs, come=[job(6)]), "--list-jobs")
        lines = said.splitlines()
        self.assertEqual([line.split()[0] for line in lines], [each.id for each in jobs], "each once, whatever comes in")
        self.assertEqual(lines[1].split(maxsplit=3)[1:], ["running", "42%", "film 4: frame 3 of 7"])
        self.assertEqual(lines[4].split(maxsplit=3)[1:], ["failed", "0%", "film 1: the disk is full"])

    def test_a_list_is_json(self):
        said, _, _ = self.asked(Queue(job(2, RUNNING, progress=0.5), job(1, log=["a", "b"])), "--list-jobs", "--json")
        first, second = map(json.loads, said.splitlines())
        self.assertEqual((first["id"], first["state"], first["progress"]), (f"{2:016x}", "RUNNING", 0.5))
        self.assertEqual((second["log"], second["error"]), (["a", "b"], ""))

    def test_no_jobs_are_no_lines(self):
        self.assertEqual(self.asked(Queue(), "--list-jobs")[:2], ("", ""))

    def test_who_follows_ends_as_the_job_does(self):
        for before in (True, False):
            for state, code in ((SUCCEEDED, 0), (FAILED, 1), (CANCELLED, 1)):
                with self.subTest(before=before, state=state):
                    then = job(1, state, log=["it was so"], error="a fault" if state == FAILED else "")
                    said, errors, _ = self.asked(Followed(then, before), "--follow", then.id, code=code)
                    self.assertEqual(said, "")
                    why = {FAILED: "a fault", CANCELLED: "the job was cancelled"}.get(state)
                    self.assertEqual(errors, why and f"mote-frames: it was so\nmote-frames: {then.id}: {why}\n" or "")

    def test_changes_are_lines_of_json(self):
        said, _, _ = self.asked(Followed(job(1), False), "--follow", f"{1:016x}", "--json")
        states = [json.loads(line)["state"] for line in said.splitlines()]
        self.assertIn(states, (["RUNNING", "SUCCEEDED"], ["SUCCEEDED"]), "the second comes right after the first")

    def test_who_follows_comes_back(self):
        self.asked(Dropping(job(1), False), "--follow", f"{1:016x}")

    def test_a_job_that_there_is_not(self):
        for option in ("--follow", "--fetch"):
            with self.subTest(option=option):
                _, errors, _ = self.asked(Queue(job(1)), option, "0" * 16, *["--out", "x"] * (option == "--fetch"), code=1)
                self.assertIn(f'no job "{"0" * 16}"', errors)

    def test_cancel_and_retry(self):
        printed, _, said = self.asked(Queue(), "--cancel", "a" * 16)
        self.assertEqual(printed, "")
        self.assertEqual([message.cancel_job.id for message in said if message.HasField("cancel_job")], ["a" * 16])
        printed, _, said = self.asked(Queue(), "--retry", "a" * 16)
        self.assertEqual(printed, "f" * 16 + "\n")
        self.assertEqual([message.retry_job.id for message in said if message.HasField("retry_job")], ["a" * 16])

    def test_a_film_is_left_with_a_time_and_a_name(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "script.json"
            script.write_text(json.dumps(SCRIPT), encoding="utf-8")
            printed, _, said = self.asked(Queue(), script, "--detach", "--again", "--job-time", "90", "--video", "mp4")
        self.assertEqual(printed, "e" * 16 + "\n")
        (submitted,) = [message.submit_job for message in said if message.HasField("submit_job")]
        self.assertEqual((submitted.time_limit_s, submitted.again), (90, True))
        self.assertEqual(submitted.job.title, "mp4 of data/a, 1 frames")

    def test_wrong_usage(self):
        for words in (["--follow", "a", "--cancel", "b"], ["--list-jobs", "--detach", "s.json"], ["--list-jobs", "s.json"],
                      ["--list-jobs", "--out", "x"], ["--retry", "a", "--video", "x.mp4"], ["s.json", "--job-time", "9"],
                      ["s.json", "--detach", "--job-time", "0"], ["--follow"]):
            with self.subTest(words=words):
                self.asked(Queue(), *words, code=2)

    def test_the_terminal_obeys_no_job(self):
        evil = job(1, FAILED, phase=EVIL, error=EVIL, log=[EVIL], runner=EVIL, waits_for=EVIL)
        evil.request.title = evil.id = EVIL
        for words, code in ((["--list-jobs"], 0), (["--list-jobs", "--json"], 0), (["--follow", EVIL], 1)):
            with self.subTest(words=words):
                said, errors, _ = self.asked(Queue(evil), *words, code=code)
                self.assertIn("52;c;cm0gLXJm", said + errors)
                self.assertIsNone(OBEYED.search(said + errors), repr(said + errors))


if __name__ == "__main__":
    unittest.main()
