# SPDX-License-Identifier: GPL-3.0-or-later
"""The line to a server that lies, stops in the midst of a word, dies and comes back; a session
that goes on by its secret, through servers that have no place, through silence."""
import gc
import itertools
import os
import signal
import struct
import subprocess
import sys
import threading
import unittest

from support import PACKAGE, Case, mote  # isort: skip
from fake_server import FakeServer
from mote import connection as connection_module
from mote import messages
from mote.silence import ASK, FINE, GONE, Silence


def catalogue(peer, message, *names):
    answer = messages.new("ServerMessage")
    answer.reply_to = message.request
    answer.catalogue.SetInParent()
    for name in names:
        answer.catalogue.datasets.add().name = name
    peer.send(answer)


def tell_names(peer, message):
    if message.WhichOneof("body") == "list_datasets":
        catalogue(peer, message, "data/a")


class Conversation(Case):
    def connect(self, server, **options):
        session = mote.connect(server.file, **options)
        self.addCleanup(session.close)
        return session

    def quick(self):
        """A broken line is given up soon."""
        before = connection_module.PATIENCE
        connection_module.PATIENCE = 0.2
        self.addCleanup(setattr, connection_module, "PATIENCE", before)

    def test_names_and_hello(self):
        with FakeServer(tell_names) as server:
            session = self.connect(server, background=True)
            self.assertEqual(session.datasets, ["data/a"])
            self.assertIn("data/a", session)
            self.assertNotIn("data/b", session)
            self.assertEqual((list(session), len(session), session.device), (["data/a"], 1, "paper"))
            self.assertTrue(server.hellos[0].hello.background)
            self.assertIn("data/a", session._repr_html_())

    def test_answers_may_come_in_any_order_and_to_many_threads(self):
        waiting = []

        def answer(peer, message):
            waiting.append(message)
            if len(waiting) == 8:
                for item in reversed(waiting):
                    peer.reply(item, "description", dataset=item.describe.dataset)

        with FakeServer(answer) as server:
            session, got = self.connect(server), {}
            threads = [threading.Thread(target=lambda n=n: got.update({n: session[f"data/{n}"].name})) for n in range(8)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(got, {n: f"data/{n}" for n in range(8)})

    def test_a_failure_is_one_sentence_and_not_the_end(self):
        def answer(peer, message):
            if message.WhichOneof("body") == "describe":
                peer.fail(message, "not_found", "dataset", "there is no dataset data/none")
            tell_names(peer, message)

        with FakeServer(answer) as server:
            session = self.connect(server)
            with self.fails("not_found", "dataset", "there is no dataset"):
                session["data/none"]
            self.assertEqual(session.datasets, ["data/a"])

    def test_a_server_that_says_something_else_is_not_believed(self):
        def answer(peer, message):
            peer.reply(message, "pong")

        with FakeServer(answer) as server:
            with self.fails("internal", words="answered something else"):
                self.connect(server).datasets

    def test_strangers_at_the_socket(self):
        for greeting, code in ((b"HTTP/1.1", "corrupt"), (struct.pack("<4sHH", b"MOTE", 9, 0), "unsupported")):
            with FakeServer(greeting=greeting) as server, self.fails(code, "greeting"):
                self.connect(server)
        for greeting in (b"", b"MOT", struct.pack("<4sHH", b"MOTE", 1, 2)):
            with FakeServer(greeting=greeting, welcome=False) as server, self.fails("internal", words="closed the connection"):
                self.connect(server)

    def test_frames_that_are_cut_or_too_long_or_no_messages(self):
        self.quick()
        for data, code in ((struct.pack("<II", 100, 0) + b"abc", "internal"), (struct.pack("<II", 2**31, 0), "resource_exhausted"),
                           (struct.pack("<II", 3, 0) + b"\xff\xff\xff", "corrupt"), (struct.pack("<I", 3), "internal")):
            def answer(peer, message, data=data):
                peer.send_bytes(data)
                peer.hang_up()

            with self.subTest(data), FakeServer(answer) as server, self.fails(code):
                self.connect(server).datasets

    def test_a_server_that_dies_is_found_again_and_asked_again(self):
        def answer(peer, message):
            if server.connections < 3:
                peer.hang_up()
            else:
                tell_names(peer, message)

        with FakeServer(answer) as server:
            self.assertEqual(self.connect(server).datasets, ["data/a"])
            self.assertEqual(server.connections, 3)
            self.assertEqual(server.bodies(), ["list_datasets"] * 3)

    def test_a_job_is_not_submitted_twice(self):
        def answer(peer, message):
            if message.WhichOneof("body") == "watch_jobs":
                peer.reply(message, "jobs")
            elif message.WhichOneof("body") == "submit_job":
                peer.hang_up()
            tell_names(peer, message)

        with FakeServer(answer) as server:
            session = self.connect(server)
            with self.fails("internal", words="nobody knows"):
                session.prepare("data/run.h5", output="data/x.mote", axes=["x", "y", "z"])
            self.assertEqual(session.datasets, ["data/a"])
            self.assertEqual(server.bodies().count("submit_job"), 1)
            self.assertEqual(server.bodies().count("watch_jobs"), 2, "a new line watches jobs again")

    def test_a_last_word_is_the_end(self):
        def answer(peer, message):
            peer.fail(message, "cancelled", "server", "the server ends", fatal=True)

        with FakeServer(answer) as server:
            session = self.connect(server)
            for _ in range(2):
                with self.fails("cancelled", "server", "the server ends"):
                    session.datasets
            self.assertEqual(server.connections, 1)

    def test_a_server_that_stays_away_is_given_up(self):
        self.quick()

        def answer(peer, message):
            os.unlink(server.socket_path)
            peer.hang_up()

        with FakeServer(answer) as server:
            session = self.connect(server)
            with self.fails("internal", words="closed the connection"):
                session.datasets

    def test_closed_is_closed(self):
        with FakeServer(tell_names) as server:
            session = self.connect(server)
            session.close()
            session.close()
            with self.fails("cancelled", words="closed"):
                session.datasets
            self.assertIn("closed", repr(session))

    def test_who_waits_when_it_is_closed_hears_of_it(self):
        heard = []
        asked = threading.Event()
        with FakeServer(lambda peer, message: asked.set()) as server:
            session = self.connect(server)

            def ask():
                try:
                    session.datasets
                except mote.Error as error:
                    heard.append(error.code)

            thread = threading.Thread(target=ask)
            thread.start()
            asked.wait()
            session.close()
            thread.join()
        self.assertEqual(heard, ["cancelled"])

    def test_nobody_s_session_ends_by_itself(self):
        left = threading.Event()
        with FakeServer(tell_names) as server:
            session = mote.connect(server.file)
            session.datasets
            thread = session.connection._thread
            del session
            gc.collect()
            thread.join(10)
            self.assertFalse(thread.is_alive())
            left.set()

    def test_an_interrupt_leaves_the_line_usable(self):
        def answer(peer, message):
            body = message.WhichOneof("body")
            if body == "describe":
                os.kill(os.getpid(), signal.SIGINT)  # while the main thread waits for an answer that never comes
            tell_names(peer, message)

        with FakeServer(answer) as server:
            session = self.connect(server)
            for _ in range(3):
                with self.assertRaises(KeyboardInterrupt):
                    session["data/a"]
                self.assertEqual(session.datasets, ["data/a"])
            self.assertEqual(session.connection._questions, {})

    def test_a_query_that_is_interrupted_is_cancelled(self):
        def answer(peer, message):
            body = message.WhichOneof("body")
            if body == "query":
                os.kill(os.getpid(), signal.SIGINT)
            tell_names(peer, message)

        with FakeServer(answer) as server:
            session = self.connect(server)
            message = messages.new("ClientMessage")
            message.query.dataset = "data/a"
            with self.assertRaises(KeyboardInterrupt):
                session.connection.ask_all(message, "answer")
            self.assertEqual(session.datasets, ["data/a"])
            cancelled = [m.cancel_query.request for m in server.said if m.WhichOneof("body") == "cancel_query"]
            self.assertEqual(cancelled, [message.request])

    def test_a_forked_process_is_told_to_connect_anew(self):
        with FakeServer(tell_names) as server:
            session = self.connect(server)
            child = os.fork()
            if child == 0:
                code = 1
                try:
                    session.datasets
                except mote.Error as error:
                    code = 0 if error.code == "unsupported" else 2
                finally:
                    session.close()  # the parent's line stays
                    os._exit(code)
            self.assertEqual(os.waitpid(child, 0)[1], 0)
            self.assertEqual(session.datasets, ["data/a"])


class Exit(unittest.TestCase):
    def test_python_ends_cleanly_with_a_session_open(self):
        with FakeServer(tell_names) as server:
            text = f"import mote; s = mote.connect({server.file!r}); print(s.datasets)"
            done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=60,
                                  env={**os.environ, "PYTHONPATH": str(PACKAGE)}, check=True)
            self.assertEqual((done.stdout, done.stderr), ("['data/a']\n", ""))


def tell_no_names(peer, message):
    if message.WhichOneof("body") == "list_datasets":
        peer.reply(message, "catalogue")


class SilenceRule(unittest.TestCase):
    def test_is_asked_once_and_then_over(self):
        silence = Silence(8.0, 100.0)
        self.assertEqual(silence.interval, 1.0)
        verdicts = [silence.at(100.0 + second, 0) for second in range(1, 9)]
        self.assertEqual(verdicts, [FINE] * 3 + [ASK] + [FINE] * 3 + [GONE])

    def test_any_byte_ends_it(self):
        silence = Silence(8.0, 100.0)
        for second in range(1, 100):
            self.assertNotEqual(silence.at(100.0 + second, second // 7), GONE)

    def test_our_own_absence_is_not_theirs(self):
        silence = Silence(8.0, 100.0)
        self.assertEqual(silence.at(4000.0, 0), FINE)
        self.assertEqual([silence.at(4000.0 + second, 0) for second in (3, 4, 7, 8)], [FINE, ASK, FINE, GONE])

    def test_without_a_limit_it_lasts_for_ever(self):
        self.assertIsNone(Silence(0.0, 0.0).interval)
        self.assertEqual(Silence(0.0, 0.0).at(1e9, 0), FINE)


class Resume(Case):
    def connect(self, server):
        session = mote.connect(server.file)
        self.addCleanup(session.close)
        return session

    def test_each_line_is_opened_with_the_latest_secret(self):
        secrets = map(str, itertools.count(1))

        def answer(peer, message):
            if server.connections < 3:
                peer.hang_up()
            tell_no_names(peer, message)

        with FakeServer(answer, minor=3, more=lambda hello: {"resume": next(secrets)}) as server:
            self.assertEqual(self.connect(server).datasets, [])
            self.assertEqual([hello.hello.resume for hello in server.hellos], ["", "1", "2"])

    def test_a_server_without_a_place_is_asked_again(self):
        refused = []

        def more(hello):
            if len(refused) in (0, 2):  # who comes, and who comes back
                refused.append(hello)
                return "resource_exhausted", "server", "it has as many clients as it takes"
            refused.append(hello)
            return {}

        def answer(peer, message):
            if len(refused) == 2:
                peer.hang_up()
            tell_no_names(peer, message)

        with FakeServer(answer, more=more) as server:
            self.assertEqual(self.connect(server).datasets, [])
            self.assertEqual(len(refused), 4)

    def test_an_upload_goes_on_with_its_session(self):
        for resumed in (False, True):
            parts = []

            def answer(peer, message, parts=parts):
                parts.append(message.upload.begin)
                if len(parts) == 1:
                    peer.hang_up()
                peer.reply(message, "uploaded", name="a", size=9)

            with FakeServer(answer, minor=3, more=lambda hello, on=resumed: {"resumed": on}) as server:
                part = messages.new("ClientMessage")
                part.upload.name, part.upload.begin, part.upload.data = "a", 3, b"abcdef"
                connection = self.connect(server).connection
                request = connection.submit(part, "uploaded")
                if resumed:
                    self.assertEqual(connection.collect(request)[-1].message.uploaded.size, 9)
                else:
                    with self.assertRaises(mote.Error):
                        connection.collect(request)
            self.assertEqual(parts, [3, 3] if resumed else [3])

    def test_pings_of_the_server_are_answered(self):
        def answer(peer, message):
            if message.WhichOneof("body") == "list_datasets":
                ping = messages.new("ServerMessage")
                ping.ping.SetInParent()
                peer.send(ping)
                self.assertEqual(peer.hear().WhichOneof("body"), "pong")
            tell_no_names(peer, message)

        with FakeServer(answer, minor=3) as server:
            self.assertEqual(self.connect(server).datasets, [])

    def test_a_silent_server_is_asked_and_its_line_opened_again(self):
        def answer(peer, message):
            if server.connections > 1:
                tell_no_names(peer, message)

        with FakeServer(answer, minor=3, more=lambda hello: {"silence_ms": 200}) as server:
            self.assertEqual(self.connect(server).datasets, [])
            self.assertEqual(server.bodies(), ["list_datasets", "ping", "list_datasets"])

    def test_who_was_too_silent_comes_back(self):
        def answer(peer, message):
            if server.connections == 1:
                peer.fail(message, "cancelled", "silence", "nothing was heard of the client", fatal=True)
                peer.hang_up()
            tell_no_names(peer, message)

        with FakeServer(answer, minor=3) as server:
            self.assertEqual(self.connect(server).datasets, [])
            self.assertEqual(server.connections, 2)


if __name__ == "__main__":
    unittest.main()
