# SPDX-License-Identifier: GPL-3.0-or-later
"""The package as such: it installs without network, its types hold, nothing heavy is imported before it is used."""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from support import PACKAGE, mote  # isort: skip


def run(*words, **more):
    return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, check=False, **more)


def have(name):
    return unittest.skipUnless(importlib.util.find_spec(name), f"{name} is not at hand")


class Package(unittest.TestCase):
    def test_what_is_promised_is_there(self):
        for name in mote.__all__:
            self.assertTrue(getattr(mote, name).__doc__, f"{name} says what it is")
            self.assertIn(name, dir(mote))
        with self.assertRaises(AttributeError):
            mote.nothing

    def test_an_import_alone_is_light(self):
        text = "import sys, mote; print([m for m in ('numpy', 'google.protobuf', 'zstandard', 'PIL') if m in sys.modules])"
        self.assertEqual(run("-c", text, env={**os.environ, "PYTHONPATH": str(PACKAGE)}).stdout, "[]\n")

    @have("mypy")
    def test_types_hold(self):
        with tempfile.TemporaryDirectory() as cache:
            done = run("-m", "mypy", "--strict", "--cache-dir", cache, cwd=PACKAGE)
        self.assertEqual(done.returncode, 0, done.stdout)

    @have("pyflakes")
    def test_nothing_is_left_over(self):
        done = run("-m", "pyflakes", PACKAGE / "mote")
        self.assertEqual(done.stdout, "")

    @have("pip")
    @have("venv")
    def test_pip_installs_it_without_network(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            python = folder / "there" / "bin" / "python"
            made = run("-m", "venv", "--without-pip", "--system-site-packages", folder / "there")
            self.assertEqual(made.returncode, 0, made.stderr)
            before = sorted(path for path in PACKAGE.rglob("*") if "__pycache__" not in path.parts)
            for options in ((), ("--editable",)):
                done = subprocess.run([python, "-m", "pip", "install", "--no-index", *options, PACKAGE], capture_output=True,
                                      text=True, check=False, env={**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1"})
                self.assertEqual(done.returncode, 0, done.stderr)
                text = "import mote, mote.messages as m; print(mote.__file__); m.new('View')"
                said = subprocess.run([python, "-c", text], cwd=folder, capture_output=True, text=True, check=False)
                self.assertEqual(said.stderr, "")
                self.assertEqual(str(PACKAGE) in said.stdout, "--editable" in options, said.stdout)
            after = sorted(path for path in PACKAGE.rglob("*") if "__pycache__" not in path.parts)
            self.assertEqual(before, after, "it leaves nothing beside the sources")

    def test_a_source_archive_is_as_good_as_the_tree(self):
        with tempfile.TemporaryDirectory() as name:
            text = "import sys; sys.path.insert(0, 'build_backend'); import mote_backend as b; print(b.{}({!r}))"
            archive = run("-c", text.format("build_sdist", name), cwd=PACKAGE).stdout.strip()
            shutil.unpack_archive(pathlib.Path(name) / archive, name)
            source = pathlib.Path(name) / archive.replace(".tar.gz", "")
            one = run("-c", text.format("build_wheel", name), cwd=source).stdout.strip()
            first = (pathlib.Path(name) / one).read_bytes()
            run("-c", text.format("build_wheel", name), cwd=PACKAGE)
            self.assertEqual((pathlib.Path(name) / one).read_bytes(), first)

    def test_without_its_messages_it_says_what_to_build(self):
        with tempfile.TemporaryDirectory() as name:
            shutil.copytree(PACKAGE / "mote", pathlib.Path(name) / "mote", ignore=shutil.ignore_patterns("*.desc"))
            text = "import mote.messages as m\ntry:\n  m.new('View')\nexcept m.Error as e:\n  print(e.code, e)"
            said = run("-c", text, env={**os.environ, "PYTHONPATH": name})
        self.assertIn("not_found", said.stdout, said.stderr)
        self.assertIn("cmake --build", said.stdout)


if __name__ == "__main__":
    unittest.main()
