# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/beam.ipynb: its cells run, one after the other, and the outputs in it are of these cells."""
import copy
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from support import BIN, ROOT, Case, needs_server  # isort: skip
import notebook


def kinds(cell):
    """What the outputs of a cell are."""
    return [sorted(output.get("data", {"text/plain": 0})) for output in cell["outputs"]]


@needs_server
class Beam(Case):
    def test_runs_and_shows_what_is_in_it(self):
        os.environ["MOTE_SERVER"] = str(BIN / "mote-server")
        written = json.loads((ROOT / "docs" / "beam.ipynb").read_text())
        now = copy.deepcopy(written)
        notebook.execute(now)
        for before, after in zip(written["cells"], now["cells"]):
            if before["cell_type"] == "code":
                with self.subTest(source="".join(before["source"])):
                    self.assertEqual(kinds(before), kinds(after))
                    self.assertIsNotNone(before["execution_count"])

    @unittest.skipUnless(importlib.util.find_spec("nbconvert"), "nbconvert is not at hand")
    def test_nbconvert_keeps_one_copy_of_each_picture(self):
        written = json.loads((ROOT / "docs" / "beam.ipynb").read_text())
        pictures = [output["data"]["image/png"] for cell in written["cells"] for output in cell.get("outputs", ())
                    if "image/png" in output.get("data", {})]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-m", "nbconvert", "--to", "html", "--output-dir", folder, ROOT / "docs" / "beam.ipynb"],
                                  capture_output=True, text=True, check=False, env={**os.environ, "HOME": folder})
            self.assertEqual(done.returncode, 0, done.stderr)
            text = (pathlib.Path(folder) / "beam.html").read_text()
        self.assertGreater(len(pictures), 2)
        for picture in pictures:
            self.assertEqual(text.count("".join(picture).replace("\n", "")), 1)
        self.assertNotIn("<?xml", text)


if __name__ == "__main__":
    unittest.main()
