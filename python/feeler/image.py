"""Rendered pictures."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._library import Error, call, ffi, lib, to_bytes, to_string


class _Memory:
    """An image's pixels for numpy, which keeps this and so the image alive."""

    def __init__(self, pointer: Any) -> None:
        self.owner = pointer
        double = lib.feeler_image_is_double(pointer)
        self.__array_interface__ = {
            "version": 3,
            "shape": (lib.feeler_image_height(pointer), lib.feeler_image_width(pointer), 4),
            "typestr": np.dtype(np.float64 if double else np.float32).str,
            "data": (int(ffi.cast("uintptr_t", lib.feeler_image_pixels(pointer))), True),
        }


class Image:
    """A rendered picture, or the region of one that was asked for.

    An image shows itself in a notebook, and `numpy.asarray(image)` is its pixels.

    Attributes:
        interrupted: True if the render was stopped; pixels that were not done are transparent black.
    """

    def __init__(self, pointer: Any, *, interrupted: bool, alpha: bool) -> None:
        self._pointer = ffi.gc(pointer, lib.feeler_image_free)
        self._alpha = alpha
        self._pixels: npt.NDArray[Any] | None = None
        self.interrupted = interrupted

    @property
    def width(self) -> int:
        """In pixels."""
        return int(lib.feeler_image_width(self._pointer))

    @property
    def height(self) -> int:
        """In pixels."""
        return int(lib.feeler_image_height(self._pointer))

    @property
    def pixels(self) -> npt.NDArray[Any]:
        """Linear RGBA, shape (height, width, 4), row 0 at the top; float32, or float64 at level "reference".

        The alpha is associated: the share of the pixel's samples that hit something. The background is in the colour
        unless the render was asked for alpha. The array shares the image's memory, keeps it alive and cannot be
        written; copy it to change it.
        """
        if self._pixels is None:
            self._pixels = np.asarray(_Memory(self._pointer))
        return self._pixels

    @property
    def stats(self) -> dict[str, Any]:
        """What the render did: rays by kind, seconds by stage, discarded weight, device, as the CLI's --stats."""
        stats: dict[str, Any] = json.loads(to_string(call(lib.feeler_image_stats_json, self._pointer)))
        return stats

    def save(self, path: str | os.PathLike[str], *, alpha: bool | None = None, bits: int | None = None) -> None:
        """Writes a file whose format the name's ending tells; it appears under its name only when whole.

        Args:
            path: .exr and .hdr hold linear float, .png and .tif sRGB with 8 or 16 bits, .jpg sRGB with 8 bits.
            alpha: whether to write the alpha (not for .jpg and .hdr); by default as the render was asked.
            bits: 8 (the default) or 16, for .png and .tif.
        """
        if bits not in (None, 8, 16):
            raise Error(f"bits is 8 or 16, not {bits!r}")
        options = ffi.new("feeler_save_options *")
        options.alpha = self._alpha if alpha is None else bool(alpha)
        options.sixteen_bit = bits == 16
        options.partial = self.interrupted
        call(lib.feeler_image_save, self._pointer, to_bytes(path), options)

    def _repr_png_(self) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "image.png"
            self.save(path)
            return path.read_bytes()

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        if dtype is None or np.dtype(dtype) == self.pixels.dtype:
            return self.pixels.copy() if copy else self.pixels
        if copy is False:
            raise ValueError(f"the pixels are {self.pixels.dtype}: another type needs a copy")
        return self.pixels.astype(dtype)

    def __repr__(self) -> str:
        state = ", interrupted" * self.interrupted
        return f"<feeler.Image {self.width}x{self.height}, {self.pixels.dtype}{state}>"
