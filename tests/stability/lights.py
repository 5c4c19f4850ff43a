"""Row 21: a light that lies on a surface."""

from __future__ import annotations

import numpy as np
from pictures import everything
from shapes import REAL, SPHERE, UNIT, Shapes, dot, length, only, unit, units

import feeler

from .cost import PictureCost
from .study import DOUBLE, NAIVE, ROBUST, Curve, Panel, Study, kernel_options

LIT = only("TRANSMISSION", "SPHERE", "SHADOWS")
OFFSETS = [0.1, 1, 10, 1e2]


def wrong_shadows(offset: float, level: str, naive: str, count: int) -> tuple[float, int]:
    """Lights on the unit sphere, points outside of it that the light can see by a margin (the sign of a scalar product
    says so), the whole so far from 0: the share of the points that are dark, and how many there are. Lights that rounding
    put into the sphere by more than 16 u of the way do not count.
    """
    rng = np.random.default_rng(121)
    centre = (offset * unit(np.array([0.5, -0.6, 0.62]))).astype(np.float32).astype(float)
    sphere = Shapes(SPHERE, level, np.array([[*centre, 1.0]]), (centre - 1)[None], (centre + 1)[None])
    n = units(rng, count)
    light = (centre + n).astype(REAL[level]).astype(float)
    e = units(rng, count)
    e = np.where(dot(e, n)[:, None] < 0, -e, e)
    e = unit(e + 0.1 * n)  # at least some degrees above the sphere's horizon
    point = (light + e * rng.uniform(0.1, 4, (count, 1))).astype(REAL[level]).astype(float)
    point[::50] = light[::50]
    options = f"{LIT} {naive}"
    lamps = {"position": light, "diffuse": [1, 1, 1], "specular": [1, 1, 1], "is_near": True}
    zero = np.zeros(3)
    q = {"point": point, "error": zero, "normal": e, "shading": e, "v": e, "r": e,
         "t": {"found": False, "direction": zero}}  # fmt: skip
    seen = feeler.probe("send_feelers", sphere.scene(), q, lamps, True, True, level=level, options=options)
    apart = length(point - light)
    depth = 1 - length((light - centre).astype(np.longdouble))
    slope = dot(point - light, n) / np.where(apart > 0, apart, 1)
    counts = (apart > 0) & (depth < 16 * UNIT[level] * apart * slope)
    dark = (seen.share[:, 0] != 1) & counts
    assert np.isfinite(seen.share).all(), "a light at the point itself gives no number"
    return float(dark.sum() / counts.sum()), int(counts.sum())


def feelers() -> list[Panel]:
    tries = 5000
    third = {"figures": [1 / 3] * len(OFFSETS)}
    methods = [("the whole way, float", NAIVE, "standard", "-DNAIVE_FEELER", third),
               ("the whole way, double", DOUBLE, "reference", "-DNAIVE_FEELER", third),
               ("64 u short of it, float", ROBUST, "standard", "", {"bound": 0})]  # fmt: skip
    found = {m[0]: [wrong_shadows(x, m[2], m[3], tries) for x in OFFSETS] for m in methods}
    counted = min(n for some in found.values() for _, n in some)
    return [
        Panel("a light on a sphere, seen from outside", "distance from 0 / radius", OFFSETS, "points in a false shadow",
              [Curve(m[0], m[1], [w for w, _ in found[m[0]]], **m[4]) for m in methods], counted),
    ]  # fmt: skip


def render(options: str) -> feeler.Image:
    with kernel_options(options):
        return feeler.Scene(everything()).render(size=(240, 180))


STUDIES = [
    Study(21, "light on a surface", "the sign of a scalar product", feelers,
          PictureCost("a picture of every primitive", lambda: render(""), lambda: render("-DNAIVE_FEELER"))),
]  # fmt: skip
