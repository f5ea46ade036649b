#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A session that goes on: by its secret, through servers that have no place, through silence."""
import itertools
import unittest

from support import Case, mote  # isort: skip
from fake_server import FakeServer
from mote import messages
from mote.silence import ASK, FINE, GONE, Silence


def tell_names(peer, message):
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
            tell_names(peer, message)

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
            tell_names(peer, message)

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
            tell_names(peer, message)

        with FakeServer(answer, minor=3) as server:
            self.assertEqual(self.connect(server).datasets, [])

    def test_a_silent_server_is_asked_and_its_line_opened_again(self):
        def answer(peer, message):
            if server.connections > 1:
                tell_names(peer, message)

        with FakeServer(answer, minor=3, more=lambda hello: {"silence_ms": 200}) as server:
            self.assertEqual(self.connect(server).datasets, [])
            self.assertEqual(server.bodies(), ["list_datasets", "ping", "list_datasets"])

    def test_who_was_too_silent_comes_back(self):
        def answer(peer, message):
            if server.connections == 1:
                peer.fail(message, "cancelled", "silence", "nothing was heard of the client", fatal=True)
                peer.hang_up()
            tell_names(peer, message)

        with FakeServer(answer, minor=3) as server:
            self.assertEqual(self.connect(server).datasets, [])
            self.assertEqual(server.connections, 2)


if __name__ == "__main__":
    unittest.main()
