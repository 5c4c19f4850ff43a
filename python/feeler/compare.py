"""How far two pictures are apart."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ._library import Error, call, ffi, lib, to_bytes
from .image import Image

Picture = Image | npt.ArrayLike | str | os.PathLike[str]


@dataclass(frozen=True)
class Difference:
    """The figures of two pictures' difference, of linear values clamped to 0 … 1.

    A pixel's difference is the greatest of its channels'; 1 where a value is not finite. Pixels that differ by more
    than 1/255 are flips, decisions that went the other way; the values of the others are measured apart from them.

    Attributes:
        max, p999: greatest difference of a pixel, and the 99.9th percentile (as numpy.percentile's).
        rmse: root of the mean square, over pixels and channels.
        flip: mean of LDR-FLIP at 67 pixels per degree.
        share: of the pixels that are flips.
        flips, nonfinite, pixels: how many pixels are flips, are not finite, are there.
        value_max, value_p999, value_rmse: of the pixels that are not flips.
    """

    max: float
    p999: float
    rmse: float
    flip: float
    share: float
    flips: int
    value_max: float
    value_p999: float
    value_rmse: float
    nonfinite: int
    pixels: int
    _images: Any = field(repr=False, compare=False)

    @property
    def difference(self) -> Image:
        """A picture of the difference of each channel."""
        return self._map(lib.FEELER_MAP_ABSOLUTE)

    @property
    def flip_map(self) -> Image:
        """A grey picture of each pixel's FLIP."""
        return self._map(lib.FEELER_MAP_FLIP)

    def _map(self, kind: int) -> Image:
        factor = ffi.new("double *", 1.0)
        return Image(call(lib.feeler_difference_image, *self._images, kind, factor), interrupted=False, alpha=False)


def compare(picture: Picture, reference: Picture) -> Difference:
    """Measures how far a picture is from another, as `feeler compare`.

    Args:
        picture: an image, a file's name, or an array of linear values, (height, width) or (height, width, 3 or 4).
        reference: likewise; of the same size.
    """
    return difference_of(_pointer(picture), _pointer(reference))


def difference_of(picture: Any, reference: Any) -> Difference:
    """Of two of the library's images, which are kept alive."""
    found = ffi.new("feeler_difference *")
    call(lib.feeler_compare, picture, reference, found)
    figures = {name: getattr(found, name) for name, _ in ffi.typeof("feeler_difference").fields}
    return Difference(**figures, _images=(picture, reference))


def _pointer(picture: Picture) -> Any:
    if isinstance(picture, Image):
        return picture._pointer
    if isinstance(picture, (str, os.PathLike)):
        return _own(call(lib.feeler_image_load, to_bytes(picture)))
    array = np.ascontiguousarray(picture, np.float64)
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or 0 in array.shape:
        raise Error(f"a picture is (height, width) or (height, width, channels), not {array.shape}")
    height, width, channels = array.shape
    values = ffi.from_buffer("double[]", array)
    return _own(call(lib.feeler_image_from_pixels, values, width, height, channels))


def _own(pointer: Any) -> Any:
    return ffi.gc(pointer, lib.feeler_image_free)
