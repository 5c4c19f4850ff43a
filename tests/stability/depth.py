"""Rows 18 and 19: how deep a ray's tree goes. Here double mends nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from shapes import UNIT

import feeler

from .cost import PictureCost
from .study import DOUBLE, NAIVE, OTHER, ROBUST, Curve, Panel, Study

SHARES = [0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99]
DEPTHS = [1, 2, 3, 4, 5, 6, 8, 10, 12, 14]
CUTOFF = 1 / 256


def see_mirrors(share: float, **settings: Any) -> feeler.Image:
    """The view square at one of two parallel mirrors that shine."""
    mirror = {"emission": 1, "reflection": share}
    return feeler.Scene({
        "camera": {"eye": [0, 0, 0.5], "look_at": [0, 0, 0]},
        "image": {"size": [1, 1]},
        "objects": [{"plane": {"point": [0, 0, z], "normal": [0, 0, 1 - 2 * z]}, "material": mirror} for z in (0, 1)],
    }).render(**settings)  # fmt: skip


def mirrors(share: float, **settings: Any) -> tuple[float, float]:
    """The relative error of what is seen there, against the geometric series; and the bound that the render itself states, by
    the same.
    """
    image = see_mirrors(share, **settings)
    exact = 1 / (1 - share)  # the sum's own rounding is beside the bound: u for each of up to 256 terms
    bound = image.stats["truncation_bound"]
    return float(abs(image.pixels[0, 0, 0] - exact) / exact), (float("inf") if bound is None else bound) / exact


def series() -> list[Panel]:
    five = [mirrors(s, depth=5)[0] for s in SHARES]
    double = [mirrors(s, depth=5, level="reference")[0] for s in SHARES]
    cut = [mirrors(s, depth=256, cutoff=0.01) for s in SHARES]
    expected = [s**5 for s in SHARES]
    under = {"bound": [*[0.01] * 7, None], "figures": [*[None] * 7, 0.076]}  # at 0.99 the depth ends it
    return [
        Panel("between two mirrors", "reflection ρ", SHARES, "relative error", [
            Curve("depth 5, float", NAIVE, five, [1.001 * e for e in expected], [0.999 * e - UNIT["standard"] for e in expected]),
            Curve("depth 5, double", DOUBLE, double, [1.000001 * e for e in expected], [0.999999 * e for e in expected]),
            Curve("weight at least 1/100, float", ROBUST, [e for e, _ in cut], [b + 256 * UNIT["standard"] for _, b in cut],
                  [b - 256 * UNIT["standard"] for _, b in cut]),
            Curve("the bound that this render states", OTHER, [b for _, b in cut], **under),
        ], x_log=False),
    ]  # fmt: skip


SHEETS, ABOVE = 40, 20  # the eye looks down at the sheet of this number


def see_sheets(share: float, depth: int, cutoff: float, level: str = "standard", **settings: Any) -> feeler.Image:
    """One eye ray on many parallel sheets that shine and send this share on and as much back."""
    sheet = {"emission": 0.1, "reflection": share, "transmission": share}
    return feeler.Scene({
        "camera": {"eye": [0, 0, ABOVE + 0.5], "look_at": [0, 0, 0]},
        "image": {"size": [1, 1]},
        "objects": [{"disc": {"centre": [0, 0, z], "normal": [0, 0, 1], "radius": 100}, "material": sheet} for z in range(SHEETS)],
    }).render(depth=depth, cutoff=cutoff, level=level, **settings)  # fmt: skip


def count_rays(*settings: Any) -> int:
    rays = see_sheets(0.5, *settings).stats["rays"]
    return int(1 + rays["reflection"] + rays["transmission"])


def lack(share: float, *settings: Any) -> tuple[float, float]:
    """What the picture lacks of what all rays would bring, and the bound that it states itself; both by the whole. From either
    side, a sheet shows what it sends itself and this share of what its two neighbours show.
    """
    neighbours = np.eye(SHEETS, k=1) + np.eye(SHEETS, k=-1)
    exact = np.linalg.solve(np.eye(SHEETS) - share * neighbours, np.full(SHEETS, 0.1))[ABOVE]
    image = see_sheets(share, *settings)
    return float(abs(image.pixels[0, 0, 0] - exact) / exact), image.stats["truncation_bound"] / exact


def trees() -> list[Panel]:
    all_rays = [2**d - 1 for d in DEPTHS]
    most = [min(rays, 511) for rays in all_rays]
    pruned = [lack(0.45, d, CUTOFF) for d in DEPTHS]
    return [
        Panel("half reflected, half transmitted, at every surface", "greatest depth", DEPTHS, "rays of one eye ray", [
            Curve("depth alone, float", NAIVE, [count_rays(d, 0) for d in DEPTHS], all_rays, all_rays),
            Curve("depth alone, double", DOUBLE, [count_rays(d, 0, "reference") for d in DEPTHS], all_rays, all_rays),
            Curve("weight at least 1/256, float", ROBUST, [count_rays(d, CUTOFF) for d in DEPTHS], 2**9, figures=most),
            Curve("2ᵈ − 1", OTHER, all_rays, 16_383, 16_383),
        ], x_log=False),
        Panel("shares of 0.45: what is left out", "greatest depth", DEPTHS, "relative error", [
            Curve("depth alone, float", NAIVE, [lack(0.45, d, 0)[0] for d in DEPTHS], figures=[*[None] * 9, 0.23]),
            Curve("weight at least 1/256, float", ROBUST, [e for e, _ in pruned], [b + 256 * UNIT["standard"] for _, b in pruned],
                  figures=[*[None] * 9, 0.48]),
        ], x_log=False, y_log=False),
    ]  # fmt: skip


STUDIES = [
    Study(18, "depth between mirrors", "the geometric series", series,
          PictureCost("a picture between mirrors of 0.9", lambda: see_mirrors(0.9, depth=256, cutoff=0.01, size=(128, 128)),
                      lambda: see_mirrors(0.9, depth=5, size=(128, 128))), slow=True),
    Study(19, "trees of rays", "2ᵈ − 1; what is pruned is bounded by its weight", trees,
          PictureCost("a picture of half-mirrors, depth 14", lambda: see_sheets(0.5, 14, CUTOFF, size=(16, 16)),
                      lambda: see_sheets(0.5, 14, 0, size=(16, 16))), slow=True),
]  # fmt: skip
