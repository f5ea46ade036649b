#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is installed beneath a DESTDIR is whole and works, and is taken away again, and nothing besides.

    install_test.py BUILD
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(sys.argv.pop(1))
PREFIX = "/usr/local"
PROGRAMS = ("mote", "mote-prep", "mote-server", "mote-supervise", "mote-frames", "mote-stats", "mote-view", "mote-web")


# What the viewer's program names: it runs where little else is (docs/VIEWER.md). H.264 it loads where it is there.
VIEWER_NEEDS = {"libc", "libcrypto", "libdeflate", "libepoxy", "libfmt", "libgcc_s", "libglfw", "libm", "libprotobuf", "libsleef",
                "libssl", "libstb", "libstdc++", "libturbojpeg", "libzstd"}


class Install(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = pathlib.Path(self.folder.name) / "root"
        self.keep_manifest()
        self.run_cmake("--install", str(BUILD), "--prefix", PREFIX)

    def keep_manifest(self):
        """What was really installed from this build can still be uninstalled afterwards."""
        manifest, kept = BUILD / "install_manifest.txt", pathlib.Path(self.folder.name) / "kept"
        if not manifest.exists():
            self.addCleanup(lambda: manifest.unlink(missing_ok=True))
            return
        shutil.copy2(manifest, kept)
        self.addCleanup(lambda: shutil.copy2(kept, manifest))

    def run_cmake(self, *arguments):
        subprocess.run(["cmake", *arguments], check=True, capture_output=True,
                       env={**os.environ, "DESTDIR": str(self.root)})

    def uninstall(self):
        self.run_cmake("--build", str(BUILD), "--target", "uninstall")

    def at(self, place):
        return self.root / PREFIX[1:] / place

    def test_what_is_installed_is_whole(self):
        for name in PROGRAMS:
            said = subprocess.run([self.at("bin") / name, "--help"], check=True, capture_output=True, text=True)
            self.assertIn(name, said.stdout)
            self.assertTrue(self.at(f"share/man/man1/{name}.1").is_file(), name)
            self.assertTrue(self.at(f"share/bash-completion/completions/{name}").is_file(), name)
        for name in ("share/man/man1/mote-prep-volume.1", "share/doc/mote/README.md", "share/doc/mote/LICENSE",
                     "share/man/man1/mote-connect.1", "lib/python3/dist-packages/mote/mote.desc",
                     "share/doc/mote/docs/FORMAT.md", "share/doc/mote/examples/mote-server.toml"):
            self.assertTrue(self.at(name).is_file(), name)

    def test_the_viewer_is_light(self):
        said = subprocess.run(["readelf", "--dynamic", self.at("bin/mote-view")], check=True, capture_output=True, text=True)
        needed = set(re.findall(r"\(NEEDED\).*\[(.*?)\.so", said.stdout))
        if any(name.startswith(("libasan", "libtsan", "libubsan")) for name in needed):
            self.skipTest("it was built with a sanitizer")
        self.assertIn("libglfw", needed)
        self.assertLessEqual({name for name in needed if not name.startswith("ld-linux")}, VIEWER_NEEDS)

    def test_what_reads_pictures_is_loaded_for_them_alone(self):
        prep, made = self.at("bin/mote-prep"), self.root / "a.mote"
        said = subprocess.run(["readelf", "--dynamic", prep], check=True, capture_output=True, text=True)
        self.assertNotIn("OpenImageIO", said.stdout)
        picture = self.root / "a.png"
        shutil.copy2(min(self.at("share/doc/mote/docs").rglob("*.png")), picture)
        subprocess.run([prep, "image", picture, "--out", made, "--quiet"], check=True)
        self.assertTrue((made / "manifest.json").is_file())
        self.at("lib/mote/mote-pictures.so").unlink()
        alone = subprocess.run([prep, "image", picture, "--out", self.root / "b.mote"], check=False, capture_output=True, text=True)
        self.assertEqual(alone.returncode, 1)
        self.assertIn("a.png: cannot be read: mote-pictures.so is not with mote-prep", alone.stderr)
        self.assertFalse((self.root / "b.mote").exists())

    def test_the_unit_starts_the_installed_server(self):
        unit = self.at("share/systemd/user/mote-server.service").read_text(encoding="utf-8")
        self.assertIn(f"\nExecStart={PREFIX}/bin/mote-server --config %h/", unit)
        self.assertNotIn("%h/.local/bin", unit)

    def test_uninstalled_leaves_nothing(self):
        self.uninstall()
        self.assertEqual([str(path) for path in self.root.rglob("*")], [])

    def test_uninstalled_leaves_what_is_not_ours(self):
        others = self.at("bin/others")
        others.write_text("theirs", encoding="utf-8")
        self.uninstall()
        self.assertEqual([path for path in self.root.rglob("*") if not path.is_dir()], [others])


if __name__ == "__main__":
    unittest.main()
