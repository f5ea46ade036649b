# SPDX-License-Identifier: GPL-3.0-or-later
"""Script: views, one frame each."""
from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Deque, Dict, List, Tuple

from .arguments import told
from .errors import invalid

if TYPE_CHECKING:
    from .image import Image
    from .view import View

_UNDER_WAY = 4  # views that are asked for ahead: one is drawn while others are encoded, sent and looked at


class Script:
    """Views of one session, one frame each. ``to_dict`` is what mote-frames takes."""

    def __init__(self, views: Iterable[View]) -> None:
        from .view import View

        self.views: List[View] = list(views)
        for index, view in enumerate(self.views):
            if not isinstance(view, View):
                raise invalid(f"views[{index}]", f"is a mote.View, not the {told(view)}")

    @classmethod
    def steps(cls, view: View, steps: Iterable[int]) -> Script:
        """The same view of several steps, from one camera; if the view has none, from one that sees all of them.

        Axes stand around the whole plot, unless the view says around what.
        """
        chosen = list(steps)
        still = view if len(chosen) < 2 else view.with_still_axes()
        if len(chosen) > 1 and not view.message.HasField("camera"):
            still = still.fit(chosen)
        return cls(still.replace(step=step) for step in chosen)

    def to_dict(self) -> Dict[str, Any]:
        """The script as its JSON."""
        return {"views": [view.to_dict() for view in self.views]}

    def frames(self, linear: bool = False) -> Iterator[Image]:
        """The exact pictures one after the other; the next ones are drawn meanwhile."""
        under_way: Deque[Tuple[View, int]] = deque()
        try:
            for view in self.views:
                under_way.append((view, view.submit(linear)))
                if len(under_way) == _UNDER_WAY:
                    first, request = under_way.popleft()
                    yield first.collect(request)
            while under_way:
                first, request = under_way.popleft()
                yield first.collect(request)
        finally:
            for view, request in under_way:
                view.forget(request)

    def save(self, folder: Any, pattern: str = "frame-{:06d}.png") -> List[str]:
        """Writes each frame into a folder and returns the names of the files."""
        os.makedirs(folder, exist_ok=True)
        names = []
        for index, image in enumerate(self.frames()):
            name = os.path.join(os.fspath(folder), pattern.format(index))
            if name in names:
                raise invalid("pattern", f"{pattern!r} gives all frames one name")
            image.save(name)
            names.append(name)
        return names

    def __len__(self) -> int:
        return len(self.views)

    def __iter__(self) -> Iterator[Image]:
        return self.frames()
