# SPDX-License-Identifier: GPL-3.0-or-later
"""Image: a picture as an array, which shows itself in notebooks and stays in them."""
from __future__ import annotations

import io
import os
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple

from .errors import Error

if TYPE_CHECKING:
    import numpy as np
    import PIL.Image
    from numpy.typing import NDArray

PNG_LEVEL = 4  # of zlib; 6 takes 1.3 to 2.2 times as long for 8% fewer bytes at most


def encode_srgb(linear: NDArray[Any]) -> NDArray[np.uint8]:
    """Linear light (RGBA, floats) as sRGB bytes; alpha stays linear."""
    import numpy as np

    values = np.clip(np.nan_to_num(linear.astype(np.float32)), 0.0, 1.0)
    colors = values[..., :3]
    values[..., :3] = np.where(colors <= 0.0031308, 12.92 * colors, 1.055 * colors ** (1 / 2.4) - 0.055)
    encoded: NDArray[np.uint8] = np.rint(values * 255.0).astype(np.uint8)
    return encoded


class Image:
    """What View.render() gives.

    Attributes:
        linear: float16 (height, width, 4), linear light, if the picture was asked for with ``linear``; otherwise None.
        points_drawn: how many points were drawn.
        device: what drew it.
        milliseconds: how long the server took, from the arrival of the view.
    """

    def __init__(self, pixels: NDArray[Any], points_drawn: int = 0, device: str = "", milliseconds: float = 0.0) -> None:
        linear = pixels.dtype.kind == "f"
        self.linear: Optional[NDArray[np.float16]] = pixels if linear else None
        self._array: Optional[NDArray[np.uint8]] = None if linear else pixels
        self.points_drawn = points_drawn
        self.device = device
        self.milliseconds = milliseconds

    @property
    def array(self) -> NDArray[np.uint8]:
        """uint8 (height, width, 4): red, green, blue, sRGB-encoded, and alpha; the top row first."""
        if self._array is None:
            assert self.linear is not None
            self._array = encode_srgb(self.linear)
        return self._array

    @property
    def size(self) -> Tuple[int, int]:
        """Width and height in pixels."""
        return self.array.shape[1], self.array.shape[0]

    def to_pil(self) -> PIL.Image.Image:
        """A Pillow image, RGB: alpha is 1 everywhere."""
        from PIL import Image as pil

        return pil.fromarray(self.array[..., :3])

    def save(self, path: Any, **options: Any) -> None:
        """Writes a file in the format of its name (.png, .jpg, .tif, .webp, ...); options are Pillow's.

        Documents (.svg, .pdf, .eps) are made by the view: View.save().
        """
        if os.fspath(path).lower().endswith((".svg", ".pdf", ".eps")):
            raise Error("unsupported", os.fspath(path), "pixels make no document; use View.save()")
        try:
            self.to_pil().save(path, **options)
        except ValueError as failure:
            raise Error("unsupported", os.fspath(path), f"{failure}") from None

    def png(self) -> bytes:
        """The picture as a PNG file."""
        file = io.BytesIO()
        self.to_pil().save(file, "PNG", compress_level=PNG_LEVEL)
        return file.getvalue()

    def _repr_png_(self) -> bytes:
        return self.png()

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Tuple[Dict[str, Any], Dict[str, Any]]:
        """For notebooks: the PNG goes into the notebook's file."""
        width, height = self.size
        bundle = {"image/png": self.png(), "text/plain": repr(self)}
        return bundle, {"image/png": {"width": width, "height": height}}

    def __array__(self, dtype: Any = None) -> NDArray[Any]:
        return self.array if dtype is None else self.array.astype(dtype)

    def __repr__(self) -> str:
        width, height = self.size
        return f"<mote.Image {width} x {height}, {self.points_drawn} points, {self.milliseconds:.0f} ms, {self.device}>"
