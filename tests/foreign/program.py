# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the programs that are tested lie."""
import os
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("MOTE_BIN", ROOT / "build" / "release" / "bin"))
