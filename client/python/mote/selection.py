# SPDX-License-Identifier: GPL-3.0-or-later
"""Selections: which particles of a run, as the dicts of the interface or written with operators.

>>> (column("x") > 1e-3) & ~density(max=0.4)
Selection({'all': [{'ranges': [{'column': 'x', 'min': 0.0010000000000000002}]}, {'not': {'density': {'max': 0.4}}}]})
"""
from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence, Set
from typing import Any, Dict, Optional, Tuple, Union

from . import arguments
from .errors import invalid

Selectable = Union["Selection", Mapping[str, Any]]
"""What takes a selection takes one of these: a Selection, or a dict of the interface's form."""


def _parts(value: Selectable) -> Dict[str, Any]:
    if isinstance(value, Selection):
        return value.to_dict()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"a selection is a mote.Selection or a dict, not {type(value).__name__}")


class Selection(Mapping[str, Any]):
    """A selection that can be combined: ``&``, ``|``, ``~``. It is a mapping of the interface's form.

    An empty one selects all particles; a list in it that is present but empty selects none.
    """

    # What numpy is on the left of an operator leaves it to us.
    __array_ufunc__ = None

    def __init__(self, parts: Optional[Mapping[str, Any]] = None, **more: Any) -> None:
        self._parts: Dict[str, Any] = {**(parts or {}), **more}

    def to_dict(self) -> Dict[str, Any]:
        """The selection as a plain dict."""
        return dict(self._parts)

    def at(self, step: int) -> Selection:
        """The same, made in this step: in other steps it holds the same ids."""
        return Selection(self._parts, step=step)

    def __getitem__(self, name: str) -> Any:
        return self._parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def __and__(self, other: Selectable) -> Selection:
        return Selection({"all": [*_flat("all", self), *_flat("all", other)]})

    def __rand__(self, other: Selectable) -> Selection:
        return Selection(_parts(other)) & self

    def __or__(self, other: Selectable) -> Selection:
        return Selection({"any": [*_flat("any", self), *_flat("any", other)]})

    def __ror__(self, other: Selectable) -> Selection:
        return Selection(_parts(other)) | self

    def __invert__(self) -> Selection:
        return Selection({"not": self.to_dict()})

    def __bool__(self) -> bool:
        raise TypeError("a selection is neither true nor false: combine selections with &, | and ~, and write "
                        "column('x').between(low, high) for both bounds")

    def __repr__(self) -> str:
        return f"Selection({self._parts!r})"


def _flat(name: str, value: Selectable) -> Sequence[Dict[str, Any]]:
    """The members of an ``all`` or ``any`` that is nothing else, so that chains do not grow deep. One without members
    selects nothing, and stays."""
    parts = _parts(value)
    members = parts.get(name)
    return list(members) if set(parts) == {name} and isinstance(members, (list, tuple)) and members else [parts]


class Column:
    """A column or derived quantity; comparing it with a number makes a selection."""

    # A number of numpy's on the left of a comparison leaves it to us.
    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, name: str) -> None:
        if not isinstance(name, str) or not name:
            raise invalid("column", f"has a name, not the {arguments.told(name)}")
        self.name = str(name)

    def _bound(self, which: str, value: Any) -> float:
        number = arguments.number(value, f"{self.name}.{which}")
        if isinstance(value, int) and number != value:
            raise invalid(f"{self.name}.{which}", f"is {number!r} as the columns' numbers are, and not {value!r}")
        return number

    def _range(self, **bounds: Any) -> Selection:
        checked = {which: self._bound(which, value) for which, value in bounds.items()}
        return Selection({"ranges": [{"column": self.name, **checked}]})

    def __ge__(self, value: float) -> Selection:
        return self._range(min=value)

    def __le__(self, value: float) -> Selection:
        return self._range(max=value)

    # A bound belongs to its range: without it the range begins with the next number.
    def __gt__(self, value: float) -> Selection:
        return self._range(min=math.nextafter(self._bound("min", value), math.inf))

    def __lt__(self, value: float) -> Selection:
        return self._range(max=math.nextafter(self._bound("max", value), -math.inf))

    def __eq__(self, value: object) -> Selection:  # type: ignore[override]
        return self._range(min=value, max=value)

    def __ne__(self, value: object) -> Selection:  # type: ignore[override]
        return ~(self == value)

    def between(self, low: float, high: float) -> Selection:
        """From low to high, both included."""
        return self._range(min=low, max=high)

    def __repr__(self) -> str:
        return f"column({self.name!r})"


def column(name: str) -> Column:
    """A column or derived quantity to be compared: ``column("x") > 1e-3``. Units: m, eV/c, s, rad, eV."""
    return Column(name)


def density(min: Optional[float] = None, max: Optional[float] = None) -> Selection:
    """By the scaled log density of a particle's leaf, 0 to 1; the halo is what lies below some bound."""
    bounds = {"min": min, "max": max}
    return Selection({"density": {name: value for name, value in bounds.items() if value is not None}})


def polygon(columns: Tuple[str, str], points: Any) -> Selection:
    """What lies inside a polygon in the plane of two columns; at least three points (N x 2), even-odd rule."""
    return Selection({"polygon": {"columns": arguments.items(columns, "columns"), "points": arguments.items(points, "points")}})


def outermost(plane: str, share: float) -> Selection:
    """The particles of greatest single-particle emittance in a plane, "x", "y" or "z", that hold this share of the weight."""
    return Selection({"outermost": {"plane": plane, "share": share}})


def ids(values: Any) -> Selection:
    """Particles by their ids in the source; an empty list selects none."""
    return Selection({"ids": sorted(values) if isinstance(values, Set) else arguments.items(values, "ids")})


def lasso(camera: Mapping[str, Any], aspect: float, points: Any, transform: Optional[Sequence[float]] = None, *,
          plot: Optional[Mapping[str, Sequence[float]]] = None) -> Selection:
    """What a closed line on a picture surrounds, at any depth; points (N x 2) are fractions of its width and height.

    Args:
        transform: of the layer, 4 x 4, row by row, layer to world.
        plot: the plot in which it was drawn: {"x": (min, max), "px": (min, max), "y": (min, max)}, so that it holds the same
            particles in all plots of the run; default: that of the dataset it is used with.
    """
    parts = {"camera": dict(camera), "aspect": aspect, "points": arguments.items(points, "points")}
    if transform is not None:
        parts["transform"] = arguments.matrix(transform, "transform")
    if plot is not None:
        if not isinstance(plot, Mapping):
            raise invalid("plot", f"is a dict of (min, max) by the names of three axes, not the {arguments.told(plot)}")
        parts["axes"], parts["bounds"] = list(plot), [arguments.items(ends, "plot", "(min, max)") for ends in plot.values()]
    return Selection({"lasso": parts})
