"""Asks for the ray trees of `feeler pixel`, and walks them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import feeler

Json = dict[str, Any]
NO_LIGHT = {"point": [0, 0, 99], "colour": 0}  # or there would be kernels without shadows
TOLERANCE = 2e-6  # of a float near 1, a few operations deep


def near(value: Any) -> Any:
    return pytest.approx(value, rel=TOLERANCE, abs=TOLERANCE)


def pixel(description: Json, eye: Any, look_at: Any, **settings: Any) -> Json:
    """The tree of the one pixel of a picture that looks along a line, by the kernel that serves all these scenes."""
    return look(description, eye, look_at, **settings).tree


def look(description: Json, eye: Any, look_at: Any, depth: int = 4, **settings: Any) -> feeler.Pixel:
    view = {"eye": list(eye), "look_at": list(look_at), "up": [1, 0, 0], "fov": 1}
    scene = feeler.Scene({"camera": view, "image": {"size": [1, 1]}, "lights": [NO_LIGHT], **description})
    return scene.pixel(0, 0, depth=depth, general=True, **settings)


def rays(tree: Json) -> Iterator[Json]:
    """A ray and all that follow from it."""
    yield tree
    for way in ("reflection", "transmission"):
        if tree.get(way, {}).get("sent"):
            yield from rays(tree[way]["ray"])


def all_rays(found: Json) -> list[Json]:
    return [ray for tree in found["trees"] for ray in rays(tree)]
