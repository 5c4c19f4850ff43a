"""The ray tree of one pixel."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ._library import Error, call, lib, take_text
from ._replacement import write_text


class Pixel:
    """All that the rays of one pixel do, as `Scene.pixel` finds it. `print` it; in a notebook it is a drawing.

    Attributes:
        tree: a dict, as `feeler pixel --json` writes it (docs/command-line.md): `trees` has each sample's eye ray with
            what it meets, the terms of the light there and the rays that it sends on; `made_of` what the colour is of.
        colour: red, green and blue as in a picture.
        words: why the pixel has its colour, in lines.
    """

    def __init__(self, text: str) -> None:
        self._json = text.encode()
        self.tree: dict[str, Any] = json.loads(text)

    @property
    def colour(self) -> tuple[float, float, float]:
        red, green, blue = self.tree["colour"]
        return red, green, blue

    @property
    def words(self) -> list[str]:
        return list(self.tree["words"])

    @property
    def svg(self) -> str:
        """A drawing: a box for each ray, from the eye on the left, with a mark for each light."""
        return take_text(call(lib.feeler_pixel_svg, self._json))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the drawing as an SVG file."""
        if Path(path).suffix.lower() != ".svg":
            raise Error(f"the drawing of a pixel is an .svg file, not {os.fspath(path)!r}")
        try:
            write_text(path, self.svg)
        except OSError as error:
            raise Error(f"cannot be written: {error.strerror}", source=os.fspath(path)) from None

    def _repr_svg_(self) -> str:
        return self.svg

    def __str__(self) -> str:
        return take_text(call(lib.feeler_pixel_text, self._json))

    def __repr__(self) -> str:
        x, y = self.tree["pixel"]
        return f"<feeler.Pixel {x},{y} of {self.tree['scene'] or 'a scene'}: {self.tree['colour']}>"
