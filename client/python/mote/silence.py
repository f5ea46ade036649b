# SPDX-License-Identifier: GPL-3.0-or-later
"""Silence: when the other side of a line is asked whether it is still there, and when it counts as gone.

It is looked at now and then, with the time and with what has passed the line so far: bytes, as a long message on a slow
line is none for a while. One thread.
"""
from __future__ import annotations

from typing import Optional

FINE, ASK, GONE = "fine", "ask", "gone"


class Silence:
    """``limit``: seconds; 0: the other side may be silent for ever."""

    def __init__(self, limit: float, now: float) -> None:
        self.limit = limit
        self._since = self._looked = now
        self._progress = 0
        self._asked = False

    @property
    def interval(self) -> Optional[float]:
        """How often to look, seconds; None where nothing is looked for."""
        return self.limit / 8 if self.limit else None

    def at(self, now: float, progress: int) -> str:
        """Asks once in a silence, when half of it is over."""
        if not self.limit:
            return FINE
        # Who was stopped for a while has heard nothing for reasons of their own.
        absent = now - self._looked > self.limit / 2
        self._looked = now
        if absent or progress != self._progress:
            self._since, self._progress, self._asked = now, progress, False
        if now - self._since >= self.limit:
            return GONE
        if self._asked or now - self._since < self.limit / 2:
            return FINE
        self._asked = True
        return ASK
