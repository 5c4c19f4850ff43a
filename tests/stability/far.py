"""Rows 15 and 25: scenes far from 0, and fast arithmetic. Whole pictures."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from pictures import everything

import feeler

from .cost import PictureCost
from .faces import MESH_RAYS, count_faces
from .study import DOUBLE, NAIVE, OTHER, ROBUST, Curve, Panel, Study, kernel_options

# ---- row 15

OFFSETS = [1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7]


def place_scene(offset: float, centred: bool) -> dict[str, Any]:
    """A sphere, a box and a triangle before a disc, so far from 0. A speck at the opposite place keeps the origin where it is."""
    x = float(offset)

    def at(*p: float) -> list[float]:
        return [x + p[0], x + p[1], x + p[2]]

    speck = {"sphere": {"centre": [-x, -x, -x], "radius": 1e-3}}
    return {
        "camera": {"eye": at(1, 2, 6), "look_at": at(0, 0.3, 0), "fov": 40},
        "image": {"size": [64, 48]},
        "background": 0.3,
        "lights": [{"point": at(3, 5, 4)}],
        "objects": [
            {"disc": {"centre": at(0, -0.5, 0), "normal": [0, 1, 0], "radius": 6}, "material": {"diffuse": 0.8}},
            {"sphere": {"centre": at(-0.8, 0.25, 0), "radius": 0.75}, "material": {"diffuse": [0.9, 0.4, 0.3]}},
            {"box": {"low": at(0.3, -0.5, -0.3), "high": at(1.2, 0.6, 0.6)}, "material": {"diffuse": [0.4, 0.5, 0.9]}},
            {"triangle": {"corners": [at(-2, -0.5, -1), at(2, -0.5, -1.5), at(0, 2, -1.2)]}, "material": {"diffuse": 0.6}},
            *([] if centred else [speck]),
        ],
    }  # fmt: skip


@functools.cache
def true_picture() -> Any:
    return feeler.Scene(place_scene(0, True)).render(level="reference").pixels


def wrong_pixels(offset: float, centred: bool, level: str) -> float:
    """The share of pixels that are off the double picture at 0 by more than 1/255."""
    pixels = feeler.Scene(place_scene(offset, centred)).render(level=level).pixels
    return float(np.mean((abs(pixels - true_picture()) > 1 / 255).any(-1)))


def far_away() -> list[Panel]:
    one = 1 / (64 * 48)
    worse = {
        "figures": [*[None] * 4, 0.01, 0.09, 2 / 3],
        "bound": [*[3 * one] * 3, 9 * one, 1, 1, 1],
        "fails": [*[None] * 3, one, *[None] * 3],
    }
    methods = [("as given, float", NAIVE, False, "standard", worse),
               ("as given, double", DOUBLE, False, "reference", {"bound": 3 * one}),
               ("moved at packing, float", ROBUST, True, "standard", {"bound": 3 * one})]  # fmt: skip
    return [
        Panel("a scene of size 4, far from 0", "distance from 0", OFFSETS, "pixels off by more than 1/255",
              [Curve(name, kind, [wrong_pixels(x, centred, level) for x in OFFSETS], **claim)
               for name, kind, centred, level, claim in methods], 64 * 48),
    ]  # fmt: skip


# ---- row 25

FLAGS = ["", "-cl-mad-enable", "-cl-no-signed-zeros", "-cl-unsafe-math-optimizations", "-cl-finite-math-only",
         "-cl-fast-relaxed-math"]  # fmt: skip


def render_fast(flags: str, **settings: Any) -> feeler.Image:
    with kernel_options(flags):
        return feeler.Scene(everything()).render(**settings)


def fast_picture(flags: str, level: str) -> Any:
    return render_fast(flags, level=level, lanes=1).pixels


def fast_math() -> list[Panel]:
    exact = {level: fast_picture("", level) for level in ("standard", "reference")}
    fast = {level: [fast_picture(f, level) for f in FLAGS] for level in exact}

    def differing(level: str) -> list[float]:
        return [float(np.mean((p != exact[level]).any(-1))) for p in fast[level]]

    def visible(level: str) -> list[float]:
        with np.errstate(invalid="ignore"):
            return [float(np.mean((~(abs(p - exact[level]) <= 1 / 255)).any(-1))) for p in fast[level]]

    def no_number(level: str) -> list[float]:
        return [float(np.mean(~np.isfinite(p).all(-1))) for p in fast[level]]

    def holes(level: str) -> list[float]:
        return [float(np.mean(count_faces(1, "edge", level, f) == 0)) for f in FLAGS]

    names = ["none", "mad", "signed zeros", "unsafe math", "finite math", "fast-relaxed"]
    tries = 48 * 36
    # What the other options do is the compiler's affair: of PoCL's it is said what was seen.
    pocl = any(d["default"] and d["platform"] == "Portable Computing Language" for d in feeler.devices())
    claimed: dict[str, Any] = {"bound": [0, 0, *[None] * 4]}
    nothing: dict[str, Any] = {"bound": 0} if pocl else claimed

    def other_bits(share: float) -> dict[str, Any]:
        return {"figures": [0, 0, None, share, None, share]} if pocl else claimed

    return [
        Panel("every primitive and term", "build option", names, "pixels", [
            Curve("other bits, float", NAIVE, differing("standard"), fails=0.01, **other_bits(0.48)),
            Curve("off by more than 1/255, float", OTHER, visible("standard"), **nothing),
            Curve("other bits, double", DOUBLE, differing("reference"), **other_bits(0.03)),
            Curve("NaN or infinite, float", OTHER, no_number("standard"), **nothing),
        ], tries, x_log=False),
        Panel("rays through points of a closed mesh's edges", "build option", names, "rays that leave without a hit", [
            Curve("edges by exact signs, float", ROBUST, holes("standard"), **nothing),
            Curve("edges by exact signs, double", DOUBLE, holes("reference"), **nothing),
        ], MESH_RAYS, x_log=False),
    ]  # fmt: skip


STUDIES = [
    Study(15, "far from 0", "the double picture at 0", far_away,
          PictureCost("a picture of a scene at 10⁶, against that at 0",
                      lambda: feeler.Scene(place_scene(1e6, True)).render(size=(512, 384), samples=4),
                      lambda: feeler.Scene(place_scene(0, True)).render(size=(512, 384), samples=4)), slow=True),
    Study(25, "fast-relaxed-math", "the same kernels without it", fast_math,
          PictureCost("a picture of every primitive", lambda: render_fast("", size=(240, 180)),
                      lambda: render_fast("-cl-fast-relaxed-math", size=(240, 180))), slow=True),
]  # fmt: skip
