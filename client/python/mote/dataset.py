# SPDX-License-Identifier: GPL-3.0-or-later
"""Dataset: what a server tells of one, and the numbers behind its pictures."""
from __future__ import annotations

import html
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple, Union

from . import arguments, queries
from .errors import Error, invalid
from .messages import Message, to_dict

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .figure import Figure
    from .jobs import Job
    from .queries import Histogram, Steps
    from .selection import Selectable
    from .session import Session
    from .view import View

# Statistics of any quantity, which the server finds from the columns.
_FURTHER = re.compile(r"(mean|sigma|min|max)_.|cov_.+__.")


class Dataset:
    """A dataset of a session, session["ROOT/NAME"], as it was when it was asked for; a live one as it is now.

    Attributes:
        session: the session it belongs to.
        name: "ROOT/NAME".
        kind: "particles", "hybrid", "mesh", "stipple" or "image".
        title: a name for people.
    """

    _BINS = 100

    def __init__(self, session: Session, description: Message) -> None:
        self.session = session
        self.name = str(description.dataset)
        self._known = description.manifest
        self.kind = str(self._known.kind)
        self.title = str(self._known.title)

    # ------------------------------------------------------------------------------------ what it is

    @property
    def _manifest(self) -> Message:
        """Of a live dataset what the server knows now: its steps become more."""
        if self._known.particles.live:
            self._known = self.session.describe(self.name).manifest
        return self._known

    @property
    def live(self) -> bool:
        """Whether more steps may come."""
        return bool(self._manifest.particles.live)

    @property
    def _particles(self) -> Message:
        if self.kind != "particles":
            raise Error("unsupported", self.name, f"holds no particles; it is of kind {self.kind!r}")
        return self._manifest.particles

    @property
    def _steps(self) -> Any:
        return self._manifest.hybrid.steps if self.kind == "hybrid" else self._manifest.particles.steps

    def __len__(self) -> int:
        """How many steps it has; 1 of what has none."""
        return len(self._steps) if self.kind in ("particles", "hybrid") else 1

    def __bool__(self) -> bool:
        return True

    @property
    def manifest(self) -> Dict[str, Any]:
        """Everything that the server says about it, with JSON's names (docs/FORMAT.md)."""
        return to_dict(self._manifest)

    @property
    def axes(self) -> Tuple[str, ...]:
        """The three axes of a particle plot."""
        return tuple(axis.name for axis in self._manifest.particles.axes[:3])

    @property
    def columns(self) -> Tuple[str, ...]:
        """The columns kept beside a particle plot; none if it was made without columns."""
        particles = self._manifest.particles
        names = tuple(column.name for column in particles.columns)
        return (*names, "id") if particles.ids and "id" not in names else names

    @property
    def units(self) -> Dict[str, str]:
        """The units of axes and columns: "m", "eV/c", "s", "rad", "eV" or "1"."""
        particles = self._manifest.particles
        return {item.name: item.unit for items in (particles.axes, particles.columns) for item in items}

    @property
    def iterations(self) -> NDArray[np.int64]:
        """The source's own numbers of the steps."""
        import numpy as np

        return np.array([step.iteration for step in self._manifest.particles.steps], np.int64)

    @property
    def t(self) -> NDArray[np.float64]:
        """The times of the steps, s."""
        import numpy as np

        return np.array([step.time for step in self._steps], np.float64)

    @property
    def particles(self) -> NDArray[np.int64]:
        """How many particles each step's plot holds."""
        import numpy as np

        return np.array([step.particles for step in self._manifest.particles.steps], np.int64)

    @property
    def bounds(self) -> Dict[str, Tuple[float, float]]:
        """What the axes of a particle plot span over all steps together, in their units; see ``bounds_of``."""
        return self._bounds_in(self._manifest.particles.axes[:3])

    def bounds_of(self, step: int) -> Dict[str, Tuple[float, float]]:
        """The same in one step, which has bounds of its own if the plot was made with ``bounds_of="step"``."""
        at, plot = arguments.one_step(step, len(self)), self._manifest.particles
        behind = plot.axes[3 * (1 + at):3 * (2 + at)]  # where they stood before a step had its own
        return self._bounds_in(plot.steps[at].axes or behind or plot.axes)

    @staticmethod
    def _bounds_in(axes: Any) -> Dict[str, Tuple[float, float]]:
        return {axis.name: (axis.min, axis.max) for axis in axes}

    @property
    def mass(self) -> float:
        """The mass of one particle, eV/c^2; 0 if it is not known."""
        return float(self._manifest.particles.mass)

    # ------------------------------------------------------------------------------------ numbers

    def get(self, columns: Union[str, Sequence[str]], step: int = 0, select: Optional[Selectable] = None) -> Any:
        """Columns or derived quantities of the particles of one step, in the dataset's order.

        Args:
            columns: a name gives an array, several names a tuple of arrays: float64 in m, eV/c, s; "id" is uint64.
            step: one step; negative ones count from the end.
            select: these particles alone.
        """
        self._particles
        names = arguments.names(columns, "columns")
        index = queries.one_step(step, len(self)).indices[0]
        values = queries.all_pieces(self.session.connection, self.name, index, select, names)
        return values[0] if isinstance(columns, str) else tuple(values)

    def statistics(self, step: Steps = None, select: Optional[Selectable] = None, names: Union[None, str, Sequence[str]] = None,
                   slices: Union[None, str, Tuple[str, int], Tuple[str, int, str]] = None) -> Dict[str, Any]:
        """Statistics by name (docs/NUMBERS.md): numbers for one step, arrays for several or all (None).

        Without selection and slices they are those of preparation, from the source's own values in f64; with a
        selection they are computed from the columns. A number that is not defined is NaN. "step", "iteration" and "time" are
        included.

        Args:
            step: one; a slice, range or list of them, ascending and evenly apart; or None: all.
            select: only of these particles.
            names: only these, one or several; default all.
            slices: a column, or (column, count): also the statistics of even slices along it; (column, count,
                "charge"): of slices that hold the same charge. "slices" is then a dict of the same names, whose arrays
                have one more dimension for the slices, and "slice_edges" says where these are.
        """
        particles = self._particles
        asked = queries.steps_of(step, len(self))
        own = list(particles.statistic_names)
        wanted = [] if names is None else arguments.names(names, "names", "statistic")
        further = any(_FURTHER.match(name) and name not in own for name in wanted)
        if select is None and slices is None and own and not further:
            rows = [list(particles.steps[index].statistics) for index in asked.indices]
            if any(len(row) != len(own) for row in rows):
                raise Error("corrupt", self.name, "its statistics do not belong to their names")
            found = _some(queries.table(own, rows, asked.single), wanted)
        else:
            fields: Dict[str, Any] = {"names": wanted}
            if slices is not None:
                fields["slices"], fields["sliceCount"], fields["slicesOf"] = arguments.slices_of(slices)
            answers = queries.query(self.session.connection, self.name, asked, select, statistics=fields)
            found = queries.statistics_of(answers, asked.single, slices is not None)
        return {**self._when(asked), **found}

    def _when(self, asked: queries.Asked) -> Dict[str, Any]:
        import numpy as np

        when = {"step": np.array(asked.indices, np.int64), "iteration": self.iterations[asked.indices],
                "time": self.t[asked.indices]}
        return {name: values[0].item() for name, values in when.items()} if asked.single else when

    def histogram(self, x: str, y: Optional[str] = None, *, bins: Any = 100, range: Any = None, step: Steps = None,
                  select: Optional[Selectable] = None, weighted: bool = True) -> Histogram:
        """A histogram of all data: (H, edges). As in numpy, H[i] or H[i, j] and the edges of the bins, a tuple of both
        for two columns; with several steps, or all of them (None), H[step, ...]: a waterfall.

        Args:
            x, y: columns or derived quantities.
            bins: how many, or one number for each column; 1 to 4096.
            range: (low, high), or one for each column; or what the bins cover: the values of all steps ("run",
                the default), of one step ("step"), or of the selection in it ("selection").
            step: as for ``statistics``.
            select: only of these particles.
            weighted: by the particles' weight; otherwise each particle counts 1.
        """
        self._particles
        columns = [x] if y is None else [x, y]
        asked = queries.steps_of(step, len(self))
        fields = queries.histogram_query(columns, bins, self._ranges(columns, range, asked, select), weighted)
        answers = queries.query(self.session.connection, self.name, asked, select, histogram=fields)
        return queries.histogram_of(answers, asked.single)

    def _ranges(self, columns: Sequence[str], range: Any, asked: queries.Asked, select: Optional[Selectable]) -> Any:
        """Numbers for "step" and "selection": of values as the dataset has them, "'x'", not as the source had them."""
        if not isinstance(range, str):
            return range
        if range not in ("run", "step", "selection"):
            raise invalid("range", f"is numbers, or 'run', 'step' or 'selection', not {range!r}")
        if range == "run":
            return None
        if not asked.single:
            raise invalid("range", f"{range!r} is of one step")
        columns = [f"'{name}'" if name in self.columns or name.isidentifier() else name for name in columns]
        found = self.statistics(asked.indices[0], select=select if range == "selection" and select is not None else {},
                                names=[f"{kind}_{quoted}" for quoted in columns for kind in ("min", "max")])
        ranges = []
        for quoted in columns:
            low, high = found[f"min_{quoted}"], found[f"max_{quoted}"]
            half = 0.0 if low < high else max(0.5, 1e-9 * abs(low))
            ranges.append((low - half, high + half) if low <= high else (0.0, 1.0))
        return ranges if len(ranges) > 1 else ranges[0]

    def track(self, select: Selectable, columns: Union[str, Sequence[str]],
              step: Steps = None) -> Tuple[NDArray[np.uint64], NDArray[np.float64]]:
        """The paths of particles through the steps: ids, ascending, and path[step, particle, column].

        If a step lacks a particle, its numbers are NaN there. The selection says in which step it was made
        ({"density": {"max": 0.3}, "step": 59}), or consists of ids.
        """
        from .track import track

        self._particles
        if not queries.made_in_a_step(select):
            raise invalid("select.step", "what is followed through the steps must say in which it was selected")
        names = arguments.names(columns, "columns", none=True)
        if "id" in names:
            raise invalid("columns", "holds \"id\", which is no number of a path: the ids are given beside it")
        return track(self.session.connection, self.name, queries.steps_of(step, len(self)), select, names)

    def pick(self, view: View, x: float, y: float, radius: Optional[float] = None) -> Optional[Dict[str, Any]]:
        """The drawn point that appears nearest to a pixel of a view, with all its columns; None if there is none.

        Args:
            view: with a camera.
            x, y: pixels from the picture's left and upper edge.
            radius: pixels; default 8.
        """
        from .messages import to_dict as plain
        from .view import View

        if not isinstance(view, View):
            raise invalid("view", f"is a mote.View, not the {arguments.told(view)}")
        fields = {"view": view.to_dict(), "x": x, "y": y, "radius": radius}
        query = {"dataset": self.name, "pick": fields}
        picked = queries.query_one(self.session.connection, query).message.answer.picked
        if not picked.found:
            return None
        found = plain(picked)
        found["values"] = dict(zip(picked.names, picked.values))
        found["units"] = dict(zip(picked.names, picked.units))
        found.pop("names", None)
        return {"layer": picked.layer, "point": picked.point, "row": picked.row, **found}

    def figure(self, x: Optional[str] = None, y: Optional[str] = None, *,
               statistics: Union[None, str, Sequence[str]] = None,
               step: Steps = None, select: Optional[Selectable] = None, bins: Any = _BINS, range: Any = None,
               weighted: bool = True, **options: Any) -> Figure:
        """A histogram, a waterfall (one column, several steps) or statistics over time, drawn with axes.

        Args:
            x, y: columns or derived quantities, for a histogram.
            statistics: one or several names of statistics instead.
            step, select: as for ``histogram``; also bins, range and weighted, for a histogram.
            options: width, height (mm), font_points, dots_per_inch, dark, log_scale, marginals, ellipse, color_map,
                title.
        """
        from .figure import Figure

        self._particles
        if (x is None) == (statistics is None):
            raise invalid("figure", "is of columns, or of statistics")
        for name in options:
            if name in ("format", "histogram"):
                raise invalid(name, "is no option of a figure: its format is that of the file's name in save(), its "
                              "histogram that of x and y")
        fields = dict(options)
        if x is not None:
            columns = [x] if y is None else [x, y]
            ranges = self._ranges(columns, range, queries.steps_of(step, len(self)), select)
            fields["histogram"] = queries.histogram_query(columns, bins, ranges, weighted)
        elif y is None and range is None and weighted is True and bins is self._BINS:
            fields["statistics"] = arguments.names(statistics, "statistics", "statistic")
        else:
            raise invalid("figure", "is of statistics, which have no y, bins, range and weighted")
        steps = queries.steps_of(step, len(self)).text
        return Figure(self.session, {"dataset": self.name, "steps": steps, "select": select}, fields)

    def export(self, step: Steps = None, select: Optional[Selectable] = None,
               columns: Union[None, str, Sequence[str]] = None) -> Job:
        """A job that writes particles as openPMD-beamphysics HDF5: ``ds.export(step=3).wait().save("halo.h5")``.

        Args:
            step: as for ``statistics``.
            select: only these particles.
            columns: one or several, besides those that the format requires; default all.
        """
        self._particles
        if columns is not None:
            columns = arguments.names(columns, "columns")
        fields = {"dataset": f"{self.name}.mote", "steps": queries.steps_of(step, len(self)).text, "select": select,
                  "columns": columns}
        return self.session.submit({"export": fields})

    def view(self, step: int = 0, **options: Any) -> View:
        """``mote.View(ds, step, ...)``."""
        from .view import View

        return View(self, step, **options)

    # ------------------------------------------------------------------------------------ itself

    def __repr__(self) -> str:
        axes = f" ({', '.join(self.axes)})" if self.axes else ""
        return f"<mote.Dataset {self.name}: {self.kind}{axes}, {len(self)} steps>"

    def _rows(self) -> List[Tuple[str, str]]:
        rows = [("kind", self.kind), ("steps", str(len(self)))]
        if self.title:
            rows.insert(0, ("title", self.title))
        if self.kind == "particles":
            rows += [(f"axis {axis.name}", f"{axis.min:.4g} to {axis.max:.4g} {axis.unit}")
                     for axis in self._manifest.particles.axes[:3]]
            rows += [("columns", ", ".join(self.columns) or "none: prepare it again to have them"),
                     ("particles", f"{int(self.particles.max(initial=0)):,}")]
        return rows

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in self._rows())
        return f"<table><caption>{html.escape(self.name)}</caption><tbody>{rows}</tbody></table>"


def _some(found: Dict[str, Any], wanted: Sequence[str]) -> Dict[str, Any]:
    """Those that are wanted; all where none is named. Raises Error where one is not there."""
    for name in wanted:
        if name not in found:
            raise invalid("names", f"there is no statistic {name!r}")
    return {name: found[name] for name in wanted} if wanted else found


Numbers = Mapping[str, Any]
"""What statistics() gives."""
