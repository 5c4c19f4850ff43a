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
    """A plane of an image for numpy, which keeps this and so the image alive."""

    def __init__(self, pointer: Any, values: Any, type_: Any, *components: int) -> None:
        self.owner = pointer
        self.__array_interface__ = {
            "version": 3,
            "shape": (lib.feeler_image_height(pointer), lib.feeler_image_width(pointer), *components),
            "typestr": np.dtype(type_).str,
            "data": (int(ffi.cast("uintptr_t", values)), True),
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
            type_ = np.float64 if lib.feeler_image_is_double(self._pointer) else np.float32
            self._pixels = np.asarray(_Memory(self._pointer, lib.feeler_image_pixels(self._pointer), type_, 4))
        return self._pixels

    @property
    def channels(self) -> dict[str, npt.NDArray[Any]]:
        """What `render` was asked for beside the picture, by name; shapes (height, width) or (height, width, 3).

        Of the ray through the pixel's centre, in the pixels' type: "depth", the distance along it, infinite where it
        hits nothing; "position" in the scene's coordinates and "normal", the one that shades, turned to the viewer,
        both 0 there. Likewise "object", a place in the scene's list of objects (an instance's own for what is in it),
        and "material", a place in `materials`: int32, -1 where nothing is hit.

        Of all of the pixel's samples: "rays" that were sent and the "deepest" level, int32; "discarded", the weight of
        rays that depth and cutoff did not let go, for red, green and blue; "margin", how far the least certain decision
        is from the other one, in bounds of its rounding error, 16 at most (docs/numerics.md). Where it is above 1,
        rounding has changed none.

        The arrays share the image's memory, as `pixels`.
        """
        found: dict[str, npt.NDArray[Any]] = {}
        channel = ffi.new("feeler_channel *")
        types = {lib.FEELER_FLOAT32: np.float32, lib.FEELER_FLOAT64: np.float64, lib.FEELER_INT32: np.int32}
        while lib.feeler_image_channel(self._pointer, len(found), channel) == 0:
            components = (channel.components,) if channel.components > 1 else ()
            plane = _Memory(self._pointer, channel.values, types[channel.type], *components)
            found[to_string(channel.name)] = np.asarray(plane)
        return found

    @property
    def materials(self) -> list[str]:
        """The names of the channel "material", "" for one that was written in place; empty without that channel."""
        names: list[str] = []
        while name := lib.feeler_image_material(self._pointer, len(names)):
            names.append(to_string(name))
        return names

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
