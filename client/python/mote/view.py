# SPDX-License-Identifier: GPL-3.0-or-later
"""View: what a picture shows, as a value; render() asks the server for its exact picture."""
from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence, Set
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple, Union

from . import arguments, wire
from .errors import Error, invalid
from .messages import Message, new, to_dict, to_message
from .pixels import DOCUMENT, LINEAR_HALF, SRGB8, decode_frame

if TYPE_CHECKING:
    from .dataset import Dataset
    from .image import Image
    from .live import Live
    from .selection import Selectable
    from .session import Session

_STYLES = {"particles": "particles", "hybrid": "hybrid", "stipple": "stipple", "mesh": "mesh", "image": "image"}
_KINDS = ("particles", "hybrid", "stipple", "ink", "mesh", "image")
_DOCUMENTS = {".svg": 1, ".eps": 2, ".pdf": 3}  # Page.Format
MAX_LAYERS = 8  # of a view
_ALL_ANNOTATIONS = {"axes": True, "colorBar": True, "scaleBar": True, "labels": True}


def _color_by(value: Any) -> Any:
    """A column's name, (name, (low, high)), or all that the interface has."""
    if isinstance(value, str):
        return {"column": value}
    if isinstance(value, Sequence) and len(value) == 2:
        if value[1] is not None and not len(arguments.items(value[1], "color_by", "(name, (low, high))")):
            raise invalid("color_by", "has a range without numbers; leave it out for the column's own")
        return {"column": value[0], "range": value[1]}
    return value


def _highlight(value: Any) -> Any:
    """A selection, or one with a colour: {"selection": ..., "color": ...}."""
    plain = dict(value) if isinstance(value, Mapping) else value
    return plain if isinstance(plain, Mapping) and "selection" in plain else {"selection": plain}


def _paths(value: Any) -> Any:
    if value is None or isinstance(value, Mapping):
        return value
    return {"ids": sorted(value) if isinstance(value, Set) else arguments.items(value, "paths", "a list of ids")}


def _towards(value: Any, count: int) -> Any:
    if value is None or isinstance(value, Mapping):
        return value
    pair = arguments.items(value, "towards", "a step and a share")
    if len(pair) != 2:
        raise invalid("towards", f"is a step and how far on the way there the layer is, not {len(pair)} values")
    return {"step": arguments.one_step(pair[0], count, "towards.step"), "share": pair[1]}


def _annotations(value: Any) -> Any:
    if value is True:
        return _ALL_ANNOTATIONS
    if isinstance(value, str):
        return {**_ALL_ANNOTATIONS, "title": value}
    return None if value is False else value


def _named(value: Any) -> Any:
    """Selections by name, as a view holds them."""
    if not isinstance(value, Mapping):
        raise invalid("selections", f"is a dict of selections by name, not the {arguments.told(value)}")
    return [{"name": name, "selection": selection} for name, selection in value.items()]


class Layer:
    """One layer of a view: a dataset at a step, and how it looks.

    Args:
        dataset: what is shown.
        step: index into the dataset's steps; negative ones count from the end.
        style: the fields of the dataset's kind in a script: {"volume": {...}, "points": {...}} of particles.
        kind: a style other than the dataset's own: "ink".
        color_by: a column's name, (name, (low, high)), or a dict with "column", "range", "colorMap", "ofPixel".
        select: only these particles.
        highlight: a selection that is drawn over the others, or a dict with "selection", "color", "sizePixels".
        towards: (step, share): the layer is this share of the way to another step.
        paths: ids whose paths through all steps are drawn, or a dict with "ids", "color", "width".
        opacity: of the whole layer, 0 to 1.
        transform: 4 x 4, row by row, layer to world.
        name: what people call it.
        hidden: it stays in the view, but is not drawn.
    """

    def __init__(self, dataset: Dataset, step: int = 0, *, style: Optional[Mapping[str, Any]] = None,
                 kind: Optional[str] = None, color_by: Any = None, select: Optional[Selectable] = None,
                 highlight: Any = None, paths: Any = None, opacity: Optional[float] = None,
                 transform: Any = None, towards: Any = None, name: Optional[str] = None, hidden: bool = False) -> None:
        from .dataset import Dataset

        if not isinstance(dataset, Dataset):
            raise TypeError(f"a layer is of a dataset, session[\"ROOT/NAME\"], not of the {arguments.told(dataset)}")
        if kind is not None and kind not in _KINDS:
            raise invalid("kind", f"is one of {', '.join(_KINDS)}, not {kind!r}")
        style_name = kind or _STYLES.get(dataset.kind)
        if style_name is None:
            raise Error("unsupported", dataset.name, f"a dataset of kind {dataset.kind!r} makes no layer by itself")
        self.session = dataset.session
        self.fields: Dict[str, Any] = {
            "dataset": dataset.name, "step": arguments.one_step(step, len(dataset)), style_name: {} if style is None else style,
            "opacity": opacity, "transform": arguments.matrix(transform, "transform"), "colorBy": _color_by(color_by), "select": select,
            "highlight": None if highlight is None else _highlight(highlight), "paths": _paths(paths),
            "towards": _towards(towards, len(dataset)), "name": name, "hidden": arguments.flag(hidden, "hidden")}


class View:
    """What a picture shows. A value: ``replace`` gives a changed one.

    Args:
        dataset: a Dataset, a Layer or a list of layers.
        step: of a Dataset; negative ones count from the end.
        size: width and height in pixels.
        camera: {"eye": ..., "target": ..., "up": ..., "fovYDegrees": ...}; default: fits the layers.
        background: three numbers, sRGB, 0 to 1; default black, or white if all layers are ink or stipples.
        annotations: True (all), a title, or a dict with "axes", "colorBar", "scaleBar", "labels", "title", ...
        selections: {name: selection} that layers may name.
        space: "metres": each layer lies where it is: a plot along x, y and z by its axes, volumes and meshes by their unit.
        stretch: with space, factors for the places along x, y and z.
        depth_contrast: 0 to 1, how much clearer the picture makes which of two layers is in front.
        layer: further options of the Layer of a Dataset: style, color_by, select, highlight, ...

    >>> mote.View(ds, step=-1, size=(1280, 720), color_by="energy", annotations=True).render()   # doctest: +SKIP
    """

    def __init__(self, dataset: Union[Dataset, Layer, Sequence[Layer]], step: int = 0,
                 size: Tuple[int, int] = (1280, 720), *, camera: Optional[Mapping[str, Any]] = None, background: Any = None,
                 annotations: Any = None, selections: Optional[Mapping[str, Selectable]] = None,
                 space: Optional[str] = None, stretch: Optional[Sequence[float]] = None,
                 depth_contrast: Optional[float] = None, **layer: Any) -> None:
        layers = _layers(dataset, step, layer)
        named = [] if selections is None else _named(selections)
        width, height = _size(size)
        fields = {"width": width, "height": height, "background": background, "camera": camera,
                  "layers": [item.fields for item in layers], "annotations": _annotations(annotations),
                  "selections": named, "space": space,
                  "stretch": None if stretch is None else arguments.items(stretch, "stretch", "three numbers"),
                  "depthContrast": depth_contrast}
        self._session = layers[0].session
        self._message = to_message("View", fields)

    @classmethod
    def from_dict(cls, session: Session, fields: Mapping[str, Any]) -> View:
        """A view written as in a script or a file of mote-view. Raises Error with the path of what is wrong."""
        view = cls.__new__(cls)
        view._session = session
        view._message = to_message("View", fields)
        return view

    def to_dict(self) -> Dict[str, Any]:
        """The view as in a script, with JSON's names."""
        return to_dict(self._message)

    def replace(self, **fields: Any) -> View:
        """The same view with other fields of its own, or with another ``step`` of all its layers."""
        plain = self.to_dict()
        step = fields.pop("step", None)
        if "size" in fields:
            plain["width"], plain["height"] = _size(fields.pop("size"))
        if isinstance(fields.get("selections"), Mapping):
            fields["selections"] = _named(fields["selections"])
        if isinstance(fields.get("layers"), Sequence):
            fields["layers"] = [layer.fields if isinstance(layer, Layer) else layer for layer in fields["layers"]]
        if "annotations" in fields:
            fields["annotations"] = _annotations(fields["annotations"])
        if step is not None:
            layers = [{**layer, "step": step} for layer in plain.get("layers", [])]
            plain["layers"] = [{field: layer[field] for field in layer if field != "towards"} for layer in layers]
        return View.from_dict(self._session, {**plain, **fields})

    def fit(self, steps: Iterable[int] = ()) -> View:
        """The same view with the camera that it would get without one: it sees all that the layers show, in these steps too.

        Of many steps, as many as a view has layers for are looked at, evenly among them. Axes of a film that plays them
        stand around the whole plot: it sees these too.
        """
        chosen = list(steps)
        message: Message = new("View")
        message.CopyFrom((self.with_still_axes() if chosen else self).message)
        message.ClearField("camera")
        counts = {name: len(self._session[name]) for name in {layer.dataset for layer in message.layers}}
        moving = [layer for layer in self._message.layers if counts[layer.dataset] > 1]
        places = (MAX_LAYERS - len(message.layers)) // max(len(moving), 1)
        for layer in moving:
            for step in _evenly(sorted({arguments.one_step(step, counts[layer.dataset]) for step in chosen}), places):
                more = message.layers.add()
                more.CopyFrom(layer)
                more.step = step
                more.ClearField("towards")
        fitted = View.from_dict(self._session, to_dict(message))
        answer, _ = self._session.connection.collect(fitted.submit())[-1]
        return self.replace(camera=to_dict(answer.frame.camera)) if answer.frame.HasField("camera") else self

    def with_still_axes(self) -> View:
        """The view, whose axes stand around the whole plot if it does not say around what: in no step elsewhere."""
        annotations = self._message.annotations
        if not annotations.axes or annotations.axes_around:
            return self
        return self.replace(annotations={**to_dict(annotations), "axesAround": "plot"})

    @property
    def message(self) -> Message:
        """The view as a message of the schema."""
        return self._message

    @property
    def layers(self) -> Tuple[Message, ...]:
        """Its layers as messages of the schema, which are copies: ``view.layers[0].name``."""
        copies = []
        for layer in self._message.layers:
            copy = new("Layer")
            copy.CopyFrom(layer)
            copies.append(copy)
        return tuple(copies)

    def submit(self, linear: bool = False, page: Optional[Message] = None) -> int:
        """Asks for the exact picture without waiting; ``collect`` takes it."""
        connection = self._session.connection
        linear = arguments.flag(linear, "linear")
        queued = connection.welcome.minor >= 2 if connection.welcome else False
        most = wire.MAX_QUEUED_VIEWS if queued else 1
        message = new("ClientMessage")
        asked = message.set_view
        asked.view.CopyFrom(self._message)
        if connection.welcome and connection.welcome.minor < 4:  # it would draw what is hidden
            for layer in asked.view.layers:
                if layer.hidden:
                    layer.opacity = 0.0
        asked.final_only, asked.queued = True, queued
        asked.format = LINEAR_HALF if linear else SRGB8
        if page is not None:
            asked.page.CopyFrom(page)
        return connection.submit(message, "frame", most)

    def collect(self, request: int) -> Image:
        """The picture that was asked for."""
        from .image import Image

        message, payload = self._session.connection.collect(request)[-1]
        frame = message.frame
        return Image(decode_frame(frame, payload), frame.points_drawn, frame.device, frame.total_ms)

    def show(self, height: int = 540, *, program: Optional[str] = None, host: str = "localhost") -> Live:
        """Shows it live, in a notebook's cell, where it can be turned with the mouse, with the still picture beneath it.

        Args:
            height: of the cell's frame, pixels.
            program: mote-web; default: MOTE_WEB, the one in PATH, or the source tree's.
            host: the name by which browsers reach this machine: the one in the notebook's own address.

        >>> live = mote.View(ds).show(); live.camera; live.update(mote.View(ds, step=5))   # doctest: +SKIP
        """
        from .live import show

        return show(self, height, program, host)

    def forget(self, request: int) -> None:
        """Says that the picture that was asked for is no longer wanted."""
        self._session.connection.forget(request)

    def render(self, linear: bool = False) -> Image:
        """The exact picture. With ``linear`` also as linear light in half floats: image.linear."""
        return self.collect(self.submit(linear))

    def save(self, path: Any, *, width: float = 0.0, height: float = 0.0, margin: float = 0.0, dot: float = 0.0,
             **options: Any) -> None:
        """Writes a file in the format of its name: .svg, .pdf and .eps are documents, all others pixels.

        Args:
            path: the file.
            width, height: of a document's sheet, mm; 0: as wide as annotations.printWidth, or else 96 pixels an inch.
            margin: of a document's sheet on each side, mm.
            dot: diameter of the largest dots, mm; 0: as the picture has them.
            options: of Pillow's save(), of pixels.
        """
        format = _DOCUMENTS.get(os.path.splitext(os.fspath(path))[1].lower())
        page = {"width": width, "height": height, "margin": margin, "dot": dot}
        if format is None:
            sheet = [name for name, value in page.items() if arguments.number(value, name) != 0.0]
            if sheet:
                raise invalid(sheet[0], "is of documents (.svg, .pdf, .eps); pixels have the view's own size")
            self.render().save(path, **options)
            return
        if options:
            raise invalid(next(iter(options)), "is an option of pixels; a document has width, height, margin and dot")
        data = self._document(format, page)
        with open(path, "wb") as file:
            file.write(data)

    def _document(self, format: int, page: Dict[str, Any]) -> bytearray:
        message = to_message("Page", page, "page")
        message.format = format
        answer, payload = self._session.connection.collect(self.submit(page=message))[-1]
        if answer.frame.encoding != DOCUMENT:
            raise Error("unsupported", "page", "this server makes no documents")
        return payload

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Any:
        return self.render()._repr_mimebundle_()

    def __repr__(self) -> str:
        names = ", ".join(f"{layer.dataset}[{layer.step}]" for layer in self._message.layers)
        return f"<mote.View {self._message.width} x {self._message.height} of {names}>"


def _evenly(values: List[int], most: int) -> List[int]:
    """The last of them, and others evenly before it."""
    if len(values) <= most:
        return values
    return [values[-1 - (i * (len(values) - 1)) // max(most - 1, 1)] for i in range(most)]


def _layers(dataset: Union[Dataset, Layer, Sequence[Layer]], step: int, options: Dict[str, Any]) -> List[Layer]:
    if isinstance(dataset, Layer):
        dataset = [dataset]
    if not isinstance(dataset, Sequence):
        return [Layer(dataset, step, **options)]
    layers = list(dataset)
    if not layers or any(not isinstance(layer, Layer) for layer in layers):
        raise TypeError("a view is of a dataset, a mote.Layer or a list of layers")
    if options or step:
        raise TypeError("step and style of a list of layers are given to each of them")
    if any(layer.session is not layers[0].session for layer in layers):
        raise invalid("layers", "are of several sessions; one server draws a view")
    return layers


def _size(size: Any) -> Tuple[Any, Any]:
    found = arguments.items(size, "size", "(width, height)")
    if len(found) != 2:
        raise invalid("size", f"is (width, height), not {len(found)} numbers")
    return found[0], found[1]
