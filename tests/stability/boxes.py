"""Rows 6, 7 and 26: slabs, and hits in their own boxes."""

from __future__ import annotations

from typing import Any

import numpy as np
from shapes import REAL, only, unit, units

import feeler

from .cost import Cost
from .faces import CLAMP_COST
from .study import DOUBLE, NAIVE, OTHER, ROBUST, Curve, Panel, Study, between

BOXES = only("TRANSMISSION", "BOX", "TRIANGLE")


def meets(level: str, origin: Any, direction: Any, low: Any, high: Any, naive: str) -> Any:
    options = f"{BOXES} {naive}"
    r = feeler.probe("make_ray", origin, direction, level=level, options=options)
    i = feeler.probe("intersect_bounds", r, low, high, level=level, options=options)
    return (i[:, 0] <= i[:, 1]) & (i[:, 1] > 0)


# ---- row 6

COMPONENTS = [1e-1, 1e-10, 1e-20, 1e-30, 1e-37, 1e-39, 1e-42, 0.0]


def lost_on_faces(component: float, level: str, naive: str, count: int) -> float:
    """Rays that begin on the plane of a box's lower face and go into the box by this component: boxes not met."""
    rng = np.random.default_rng(106)
    low = rng.uniform(-2, -1, (count, 3)).astype(np.float32).astype(float)
    high = rng.uniform(1, 2, (count, 3)).astype(np.float32).astype(float)
    axis = rng.integers(0, 3, count)
    row = np.arange(count)
    origin = rng.uniform(-0.5, 0.5, (count, 3)).astype(np.float32).astype(float)
    origin[row, (axis + 1) % 3] = -5
    origin[row, axis] = low[row, axis]
    target = np.zeros((count, 3))
    direction = unit(target - origin)
    direction[row, axis] = 0
    direction = unit(direction).astype(np.float32).astype(float)
    direction[row, axis] = component
    return float(np.mean(~meets(level, origin, direction, low, high, naive)))


def slabs() -> list[Panel]:
    tries = 10_000
    # In float 1/d is infinite under 3·10⁻³⁹.
    all_of = [[float(x <= least) for x in COMPONENTS] for least in (2.9e-39, 0)]
    methods = [("1/d as it is, float", NAIVE, "standard", "-DNAIVE_SLAB", {"bound": all_of[0], "fails": all_of[0]}),
               ("1/d as it is, double", DOUBLE, "reference", "-DNAIVE_SLAB", {"bound": all_of[1], "fails": all_of[1]}),
               ("|d| at least 2⁻⁶⁰, float", ROBUST, "standard", "", {"bound": 0})]  # fmt: skip
    return [
        Panel("rays that begin on the plane of a face", "the direction's component across it",
              [f"{c:g}" for c in COMPONENTS], "boxes not met",
              [Curve(name, kind, [lost_on_faces(x, level, naive, tries) for x in COMPONENTS], **claim)
               for name, kind, level, naive, claim in methods], tries, x_log=False),
    ]  # fmt: skip


# ---- row 7

THICKNESSES = [0.0, 1e-8, 1e-7, 3e-7, 1e-6, 1e-5, 1e-3]


def lost_flat_boxes(thickness: float, level: str, naive: str, count: int) -> float:
    """Boxes of this thickness, turned any way along the axes, that the exact ray passes through: those not met."""
    rng = np.random.default_rng(107)
    axis = rng.integers(0, 3, count)
    row = np.arange(count)
    low = rng.uniform(-1, 0, (count, 3))
    high = rng.uniform(0.1, 1, (count, 3))
    low[row, axis] = rng.uniform(0.5, 1, count)
    high[row, axis] = low[row, axis] + thickness
    real = REAL[level]
    low, high = low.astype(real).astype(np.longdouble), high.astype(real).astype(np.longdouble)
    origin = (4 * units(rng, count)).astype(real).astype(np.longdouble)
    target = low + (high - low) * rng.uniform(0, 1, (count, 3))
    # A third goes through an edge: two slabs touch the ray's point at once.
    target[row, (axis + 1) % 3] = np.where(
        rng.random(count) < 1 / 3, high[row, (axis + 1) % 3], target[row, (axis + 1) % 3]
    )
    direction = unit((target - origin).astype(float)).astype(real).astype(np.longdouble)
    a, b = (low - origin) / direction, (high - origin) / direction
    near, far = np.minimum(a, b).max(1), np.maximum(a, b).min(1)
    exact = (near <= far) & (far > 0)
    found = meets(level, *(x.astype(float) for x in (origin, direction, low, high)), naive)
    return float((exact & ~found).sum() / exact.sum())


def rounding() -> list[Panel]:
    tries = 20_000
    thin = {"figures": [0.02, 0.02, 0.02, None, None, None, 0]}
    methods = [("far as rounded, float", NAIVE, "standard", "-DNAIVE_WIDEN", thin),
               ("far as rounded, double", DOUBLE, "reference", "-DNAIVE_WIDEN", {"figures": [0.02, 0, 0, 0, 0, 0, 0]}),
               ("far (1 + 2 γ₃), float", ROBUST, "standard", "", {"bound": 0})]  # fmt: skip
    return [
        Panel("flat boxes that the exact ray meets", "thickness of a box that is met from 3 to 5 away", [f"{x:g}" for x in THICKNESSES], "boxes not met",
              [Curve(name, kind, [lost_flat_boxes(x, level, naive, tries) for x in THICKNESSES], **claim)
               for name, kind, level, naive, claim in methods], tries, x_log=False),
    ]  # fmt: skip


# ---- row 26

SLOPES = [1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001]


def hits_before_box(slope: float, level: str, naive: str, count: int) -> float:
    """Triangles in a plane square to an axis: hits whose distance is out of the ray's interval in the triangle's own box."""
    rng = np.random.default_rng(126)
    real = REAL[level]
    axis = rng.integers(0, 3, count)
    row = np.arange(count)
    corners = rng.uniform(-1, 1, (count, 3, 3))
    corners[row, :, axis] = rng.uniform(-1, 1, (count, 1))
    corners = corners.astype(real).astype(float)
    target = (rng.dirichlet(np.ones(3), count)[..., None] * corners).sum(1)
    d = units(rng, count)
    d[row, axis] = 0
    d = unit(d)
    d[row, axis] = slope * rng.choice([-1, 1], count)
    origin = (target - 3 * unit(d)).astype(real).astype(float)
    options = f"{BOXES} {naive}"
    r = feeler.probe("make_ray", origin, unit(target - origin), level=level, options=options)
    c = feeler.probe("intersect_triangle", r, *np.moveaxis(corners, 1, 0), 0, level=level, options=options)
    low, high = corners.min(1), corners.max(1)
    c = feeler.probe("clamp_crossing", r, low, high, c, level=level, options=options)
    i = feeler.probe("intersect_bounds", r, low, high, level=level, options=options)
    found = c.found != 0
    return float((found & ((c.distance < i[:, 0]) | (c.distance > i[:, 1]))).sum() / found.sum())


def own_boxes() -> list[Panel]:
    tries = 10_000
    some = between(0.07, 0.5, len(SLOPES))
    methods = [("Möller–Trumbore, not clamped, float", NAIVE, "standard", "-DNAIVE_CLAMP -DNAIVE_TRIANGLE", some),
               ("Woop, not clamped, float", OTHER, "standard", "-DNAIVE_CLAMP", some),
               ("Woop, not clamped, double", DOUBLE, "reference", "-DNAIVE_CLAMP", some),
               ("clamped, float", ROBUST, "standard", "", {"bound": 0})]  # fmt: skip
    return [
        Panel("triangles square to an axis", "slope of the ray", SLOPES, "hits out of the triangle's own box",
              [Curve(name, kind, [hits_before_box(x, level, naive, tries) for x in SLOPES], **claim)
               for name, kind, level, naive, claim in methods], tries),
    ]  # fmt: skip


def box_inputs(rng: np.random.Generator, count: int) -> list[Any]:
    low = rng.uniform(-1, 0, (count, 3))
    high = low + rng.uniform(0.1, 1, (count, 3))
    origin = 3 * units(rng, count)
    return [*origin.T, *unit(rng.uniform(-0.5, 0.5, (count, 3)) - origin).T, *low.T, *high.T]


BOX_CODE = """
const interval i = intersect_bounds(make_ray(IN3(0), IN3(3)), IN3(6), IN3(9));
OUT = i.near <= i.far ? i.near : splat(-1);
"""
STUDIES = [
    Study(6, "0 times infinity", "by construction the ray goes in", slabs,
          Cost("a ray's reciprocals and one box", "-DNAIVE_SLAB", BOX_CODE, box_inputs)),
    Study(7, "rounded slabs", "the intervals in extended precision", rounding,
          Cost("a ray's reciprocals and one box", "-DNAIVE_WIDEN", BOX_CODE, box_inputs)),
    Study(26, "hits before their own box", "the box's own interval", own_boxes, CLAMP_COST),
]  # fmt: skip
