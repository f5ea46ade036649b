# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/beam.ipynb: its cells run, one after the other, and the outputs in it are of these cells."""
import copy
import json
import os
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


if __name__ == "__main__":
    unittest.main()
