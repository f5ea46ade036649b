# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a server's roots: folders are listed, files are looked at, and whatever is wrong is one sentence."""
import json
import math
import os
import pathlib
import socket
import subprocess
import tempfile
import threading
import time
import unittest

from support import BIN, Case  # isort: skip
from fake_server import FakeServer  # isort: skip
from real_server import RealServer  # isort: skip
import mote  # isort: skip

PREP, SERVER = BIN / "mote-prep", BIN / "mote-server"


def children(process):
    """Processes that came from it, and from these."""
    found = []
    for task in pathlib.Path(f"/proc/{process}/task").iterdir():
        for child in map(int, (task / "children").read_text(encoding="ascii").split()):
            found += [child, *children(child)]
    return found


def name_of(process):
    try:
        return pathlib.Path(f"/proc/{process}/comm").read_text(encoding="utf-8").strip()
    except OSError:
        return ""


@unittest.skipUnless(PREP.exists() and SERVER.exists(), "mote-prep and mote-server are needed")
class FilesTest(Case):

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="mote-files-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.root = pathlib.Path(cls.folder.name) / "data"
        cls.root.mkdir()
        prep = lambda *words: subprocess.run([PREP, *map(str, words)], check=True, stdout=subprocess.DEVNULL,
                                             stderr=subprocess.DEVNULL)
        prep("synth", "beam", "--particles", 1000, "--steps", 3, "--seed", 1, "--out", cls.root / "run.h5")
        prep("particles", cls.root / "run.h5", "--axes", "x,px,y", "--out", cls.root / "beam.mote")
        cls.server = RealServer(SERVER, cls.folder.name)
        cls.addClassCleanup(cls.server.close)

    def setUp(self):
        self.session = mote.connect(self.server.file)
        self.addCleanup(self.session.close)

    def fails(self, code, call, *words):
        """One sentence, which has these words."""
        with self.assertRaises(mote.Error) as caught:
            call()
        self.assertEqual(caught.exception.code, code, caught.exception)
        for word in words:
            self.assertIn(word, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))
        self.assertNotIn(self.folder.name, str(caught.exception))  # nobody is told where the root lies

    def test_a_folder_is_listed_in_order(self):
        self.assertEqual([(file.path, file.kind) for file in self.session.files()], [("data", "folder")])
        place = self.root / "order"
        (place / "Zeta").mkdir(parents=True)
        (place / "alpha").mkdir()
        for name in ("run_10.h5", "run_9.h5", "Run_8.h5", ".hidden", "x.mote.partial-1234"):
            (place / name).write_bytes(b"12345")
        os.utime(place / "run_9.h5", (1e9, 1e9))
        files = self.session.files("data/order")
        self.assertEqual([file.name for file in files], ["alpha", "Zeta", "Run_8.h5", "run_9.h5", "run_10.h5"])
        self.assertEqual(files[3], ("data/order/run_9.h5", "run_9.h5", "file", 5, 1e9))
        self.assertEqual(files.notes, [])
        kinds = {file.name: file.kind for file in self.session.files("data")}
        self.assertEqual(kinds["beam.mote"], "dataset")
        self.assertEqual(kinds["run.h5"], "file")

    def test_what_is_no_file_of_the_root_is_left_out_and_said(self):
        place = self.root / "odd"
        place.mkdir()
        os.mkfifo(place / "pipe")
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(place / "socket"))
        (place / "away").symlink_to("/etc/passwd")
        (place / "nowhere").symlink_to("not there")
        (place / "inside").symlink_to("../run.h5")
        (place / "up").symlink_to("..")
        with open(os.fsencode(place) + b"/\xff.h5", "wb"):
            pass
        files = self.session.files("data/odd")
        self.assertEqual({(file.name, file.kind, file.size > 0) for file in files},
                         {("inside", "file", True), ("up", "folder", False)})
        self.assertEqual(files.notes, ["a name that is not UTF-8 is left out",
                                       "2 links that lead out of the root, or nowhere, are left out",
                                       "2 things that are neither files nor folders are left out"])
        self.assertEqual(len(self.session.look("data/odd/inside")["found"]), 1)
        self.fails("invalid_argument", lambda: self.session.look("data/odd/pipe"), "neither a file nor a folder")
        self.fails("invalid_argument", lambda: self.session.look("data/odd/socket"), "neither a file nor a folder")
        self.fails("invalid_argument", lambda: self.session.look("data/odd/away"), "out of its root")
        self.fails("invalid_argument", lambda: self.session.files("data/odd/away"), "out of its root")

    def test_wrong_names_are_sentences(self):
        for call in (self.session.files, self.session.look):
            for name in ("data/../data", "data/", "data//x", "/etc", "data/x\0y", "data/./x", "..", "data/" + "x/" * 3000 + "x"):
                with self.subTest(name=name[:20], call=call.__name__):
                    self.fails("invalid_argument", lambda name=name, call=call: call(name))
            self.fails("not_found", lambda call=call: call("data/none.h5"), "data/none.h5")
            self.fails("not_found", lambda call=call: call("nothing/run.h5"), "no root of that name")
            self.fails("not_found", lambda call=call: call("uploads"), "no root of that name")
        self.fails("invalid_argument", lambda: self.session.files("data/run.h5"), "not a folder")
        self.fails("invalid_argument", lambda: self.session.look(""))
        self.fails("invalid_argument", lambda: self.session.files(3))

    @unittest.skipIf(os.geteuid() == 0, "a superuser may read everything")
    def test_what_may_not_be_read_is_said(self):
        (self.root / "shut").mkdir(mode=0)
        self.addCleanup((self.root / "shut").chmod, 0o700)
        self.fails("permission_denied", lambda: self.session.files("data/shut"))

    def test_a_huge_folder_comes_in_pages(self):
        place = self.root / "huge"
        place.mkdir()
        for number in range(10_050):
            (place / f"run_{number}.h5").touch()
        files = self.session.files("data/huge")
        self.assertEqual([file.name for file in files], [f"run_{number}.h5" for number in range(10_050)])

    def test_a_file_is_told_as_mote_prep_tells_it(self):
        told = self.session.look("data/run.h5")
        said = json.loads(subprocess.run([PREP, "look", "--json", self.root / "run.h5"], check=True, capture_output=True).stdout)
        self.assertEqual(told["input"], "data/run.h5")
        said["input"] = told["input"]
        self.assertEqual(told, said)
        self.assertEqual(told["found"][0]["axes"], "x,px,y")
        self.assertEqual(told["found"][0]["steps"], 3)

    def test_what_cannot_be_read_is_refused_in_sentences(self):
        (self.root / "noise.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(range(256)) * 8)
        (self.root / "words.txt").write_text("nothing that anybody reads", encoding="ascii")
        (self.root / "empty.csv").touch()
        for name in ("noise.h5", "words.txt", "empty.csv"):
            told = self.session.look(f"data/{name}")
            self.assertEqual(told["found"], [], name)
            self.assertTrue(told["refused"], name)
            for sentence in told["refused"]:
                self.assertNotIn(self.folder.name, sentence)
        self.assertIn("is a dataset", self.session.look("data/beam.mote")["refused"][0])

    def test_a_table_is_read_by_its_map(self):
        (self.root / "table.csv").write_text("a,b,c\n1,2,3\n4,5,6\n", encoding="ascii")
        told = self.session.look("data/table.csv", map="x=a [mm],px=b [MeV/c],y=c [mm]")["found"][0]
        self.assertEqual([(column["name"], column["min"], column["max"]) for column in told["columns"][:2]],
                         [("x", 1e-3, 4e-3), ("y", 3e-3, 6e-3)])
        # No word of a client's is an option of the program.
        self.assertTrue(self.session.look("data/table.csv", format="--help")["refused"])
        self.fails("invalid_argument", lambda: self.session.look("data/table.csv", map="x" * 5000), "map")

    def test_a_value_that_is_not_finite_is_said(self):
        (self.root / "holes.csv").write_text("x,px,y\n1,nan,3\n4,nan,6\n", encoding="ascii")
        column = self.session.look("data/holes.csv")["found"][0]["columns"][2]
        self.assertEqual((column["name"], column["invalid"]), ("px", 2))
        self.assertTrue(math.isnan(column["min"]) and math.isnan(column["max"]))

    def reader(self):
        """The process that looks, once it does."""
        end = time.monotonic() + 60
        while time.monotonic() < end:
            for child in children(self.server.serving):
                if name_of(child) == "mote-prep":
                    return child
        raise AssertionError("nobody looks")

    def slow(self, name):
        """A table that takes minutes to be read."""
        path = self.root / name
        if not path.exists():
            line = "1e-3 2e-3 3e-3 4e-3 5e-3 6e-3\n"
            path.write_text("# x px y py z pz\n" + line * 3_000_000, encoding="ascii")
        return f"data/{name}"

    def test_another_look_ends_the_one_before(self):
        slow = self.slow("slow.txt")
        errors = []

        def look():
            try:
                self.session.look(slow)
            except mote.Error as error:
                errors.append(error)
        first = threading.Thread(target=look)
        first.start()
        reader = self.reader()
        self.assertEqual(len(self.session.look("data/run.h5")["found"]), 1)
        first.join(60)
        self.assertEqual([error.code for error in errors], ["cancelled"])
        self.gone(reader)

    def test_a_client_that_leaves_ends_its_look(self):
        slow = self.slow("slow.txt")
        session = mote.connect(self.server.file)
        thread = threading.Thread(target=lambda: self.assertRaises(mote.Error, session.look, slow))
        thread.start()
        reader = self.reader()
        session.close()
        thread.join(60)
        self.gone(reader)

    def gone(self, process):
        end = time.monotonic() + 60
        while time.monotonic() < end and name_of(process) == "mote-prep":
            time.sleep(0.01)
        self.assertNotEqual(name_of(process), "mote-prep")
        looks = pathlib.Path(self.folder.name) / "state" / "looks"
        while time.monotonic() < end and list(looks.iterdir()):
            time.sleep(0.01)
        self.assertEqual(list(looks.iterdir()), [])


class OlderServerTest(Case):

    def test_an_older_server_is_a_sentence(self):
        with FakeServer(lambda peer, message: None, minor=4) as server:
            session = mote.connect(server.file)
            self.addCleanup(session.close)
            for call in (session.files, lambda: session.look("data/run.h5")):
                with self.assertRaises(mote.Error) as caught:
                    call()
                self.assertEqual(caught.exception.code, "unsupported")
                self.assertIn("older", str(caught.exception))


if __name__ == "__main__":
    unittest.main()
