# SPDX-License-Identifier: GPL-3.0-or-later
"""Mote as an entry of jupyter-server-proxy: a tile of JupyterLab's launcher that opens the page below /mote/.

MOTE_CONNECTION names the connection file of a server that runs; without it one is started, of the folder MOTE_DATA or
else the home folder. The proxy asks who people are, and talks to a Unix socket that is its own.
"""
from __future__ import annotations

import os
from typing import Any, Dict

from .live import find_program

_READY = 60  # seconds


def setup() -> Dict[str, Any]:
    """What jupyter-server-proxy asks for (entry point ``jupyter_serverproxy_servers``)."""
    connection = os.environ.get("MOTE_CONNECTION")
    data = os.environ.get("MOTE_DATA") or os.path.expanduser("~")
    server = ["--connect", connection] if connection else ["--spawn", f"data={data}"]
    return {"command": [find_program(), *server, "--listen", "unix:{unix_socket}", "--no-token"], "unix_socket": True,
            "timeout": _READY, "launcher_entry": {"title": "Mote"}}
