# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames become arrays (docs/PROTOCOL.md, "Pixels"). Pure functions; sizes are checked before memory is taken."""
from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from . import wire
from .errors import Error
from .messages import Message

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

JPEG, ZSTD, DOCUMENT = 1, 2, 4  # Frame.Encoding
SRGB8, LINEAR_HALF = 1, 2  # PixelFormat


def _corrupt(message: str) -> Error:
    return Error("corrupt", "frame", message)


def _unpack(payload: bytearray, size: int) -> bytes:
    """A zstd frame of a size that is known."""
    import zstandard

    try:
        stated = zstandard.get_frame_parameters(payload).content_size
        if stated not in (size, zstandard.CONTENTSIZE_UNKNOWN):
            raise _corrupt(f"the picture holds {stated} bytes where its size asks for {size}")
        data = zstandard.ZstdDecompressor().decompress(payload, max_output_size=size)
    except zstandard.ZstdError as failure:
        raise _corrupt(f"the picture is damaged: {failure}") from None
    if len(data) != size:
        raise _corrupt(f"the picture holds {len(data)} bytes where its size asks for {size}")
    return data


def _decode_srgb(data: bytes, width: int, height: int) -> NDArray[np.uint8]:
    import numpy as np

    rows = np.frombuffer(data, np.uint8).reshape(height, width, 3)
    pixels = np.empty((height, width, 4), np.uint8)
    np.cumsum(rows, axis=1, dtype=np.uint8, out=pixels[..., :3])
    pixels[..., 3] = 255
    return pixels


def _decode_halves(data: bytes, width: int, height: int) -> NDArray[np.float16]:
    import numpy as np

    planes = np.frombuffer(data, np.uint8).reshape(height, 2, width, 3)
    differences = planes[:, 0].astype(np.uint16) | (planes[:, 1].astype(np.uint16) << 8)
    pixels = np.empty((height, width, 4), np.float16)
    np.cumsum(differences, axis=1, dtype=np.uint16, out=pixels.view(np.uint16)[..., :3])
    pixels[..., 3] = 1
    return pixels


def _decode_jpeg(payload: bytearray, width: int, height: int) -> NDArray[np.uint8]:
    import numpy as np
    from PIL import Image

    try:
        image = Image.open(io.BytesIO(payload), formats=["JPEG"])
        if image.size != (width, height):
            raise _corrupt(f"the JPEG picture is {image.size[0]} x {image.size[1]}, its message says {width} x {height}")
        return np.array(image.convert("RGBA"))
    except (OSError, SyntaxError, ValueError) as failure:
        raise _corrupt(f"the picture is damaged: {failure}") from None


def decode_frame(frame: Message, payload: bytearray) -> NDArray[Any]:
    """RGBA, top row first: uint8, sRGB-encoded, or float16, linear. Raises Error (corrupt, unsupported)."""
    width, height = frame.width, frame.height
    if not (1 <= width <= wire.MAX_SIDE and 1 <= height <= wire.MAX_SIDE and width * height <= wire.MAX_PIXELS):
        raise _corrupt(f"the server sent a picture of {width} x {height} pixels")
    if frame.payload_begin or frame.payload_size not in (0, len(payload)):
        raise _corrupt("a piece of it is missing")
    if frame.encoding == ZSTD and frame.format in (0, SRGB8):
        return _decode_srgb(_unpack(payload, width * height * 3), width, height)
    if frame.encoding == ZSTD and frame.format == LINEAR_HALF:
        return _decode_halves(_unpack(payload, width * height * 6), width, height)
    if frame.encoding == JPEG and frame.format in (0, SRGB8):
        return _decode_jpeg(payload, width, height)
    raise Error("unsupported", "frame", "the server sent an encoding or pixel format that is not known here")
