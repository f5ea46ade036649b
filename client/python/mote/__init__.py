# SPDX-License-Identifier: GPL-3.0-or-later
"""Mote in Python: large particle runs, as pictures and as numbers.

>>> import mote                                                                  # doctest: +SKIP
>>> s = mote.connect("connection.json")          # or mote.spawn(data="plots")   # doctest: +SKIP
>>> ds = s["data/beam"]                                                          # doctest: +SKIP
>>> mote.View(ds, step=3).render()               # shows itself in a notebook    # doctest: +SKIP
>>> ds.statistics()["norm_emit_x"]               # of all steps                  # doctest: +SKIP

All calls are synchronous; positions are in m, momenta in eV/c, times in s. Whatever goes wrong raises a mote.Error.
Everything is described in docs/PYTHON.md.
"""
from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, List

from .errors import CoarseNumbers, Error

if TYPE_CHECKING:
    from .dataset import Dataset
    from .figure import Figure
    from .image import Image
    from .jobs import Job
    from .live import Live
    from .live_run import LiveRun
    from .script import Script
    from .selection import Selection, column, density, ids, lasso, outermost, polygon
    from .session import Session, connect, spawn
    from .view import Layer, View

__version__ = "0.1.0"

# What is imported when it is first used: a picture needs little of all this.
_PLACES = {
    "Dataset": "dataset", "Figure": "figure", "Image": "image", "Job": "jobs", "Layer": "view", "Live": "live",
    "LiveRun": "live_run", "Script": "script", "Selection": "selection", "Session": "session", "View": "view", "column": "selection", "connect": "session",
    "density": "selection", "ids": "selection", "lasso": "selection", "outermost": "selection", "polygon": "selection",
    "spawn": "session"}

__all__ = ["CoarseNumbers", "Dataset", "Error", "Figure", "Image", "Job", "Layer", "Live", "LiveRun", "Script", "Selection",
           "Session", "View", "column", "connect", "density", "ids", "lasso", "outermost", "polygon", "spawn"]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'mote' has no attribute {name!r}")
    value = getattr(importlib.import_module("." + _PLACES[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> List[str]:
    return sorted([*globals(), *__all__])
