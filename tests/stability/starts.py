"""Rows 12 to 14: where a ray starts that leaves a surface."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from pictures import everything
from shapes import REAL, frame, length, only, unit, units

import feeler

from .cost import Cost
from .study import DOUBLE, NAIVE, OTHER, ROBUST, Curve, Panel, Study, kernel_options

SHAPES = only("TRANSMISSION", "SPHERE", "BOX", "TRIANGLE", "ONE_SIDED")
POINT = "-DNAIVE_POINT"
TMIN, OFFSET, ULPS = f"{POINT} -DNAIVE_TMIN=1e-4", f"{POINT} -DNAIVE_OFFSET=1e-3", "-DNAIVE_ULPS"


@functools.cache
def points_on_sphere(radius: float, level: str, naive: str, count: int, seed: int) -> Any:
    """Points on spheres about 0 as rays from 5 radii find them, their error bounds and normals."""
    rng = np.random.default_rng(seed)
    d = units(rng, count)
    u, v = frame(d)
    turn = rng.uniform(0, 2 * np.pi, (count, 1))
    arm = radius * np.sqrt(rng.uniform(0, 0.98, (count, 1)))
    origin = (5 * radius * d + arm * (u * np.cos(turn) + v * np.sin(turn))).astype(REAL[level]).astype(float)
    options = f"{SHAPES} {naive}"
    r = feeler.probe("make_ray", origin, -d, level=level, options=options)
    c = feeler.probe("intersect_sphere", r, [0, 0, 0], radius, 0, level=level, options=options)
    assert (c.found != 0).all()
    return feeler.probe("surface_sphere", r, c.distance, [0, 0, 0], radius, level=level, options=options)


def leave(s: Any, slope: float, level: str, naive: str, seed: int) -> Any:
    """Rays that leave surfaces outwards, at this slope to them."""
    rng = np.random.default_rng(seed)
    n = unit(s.normal.astype(float))
    u, v = frame(n)
    turn = rng.uniform(0, 2 * np.pi, (len(n), 1))
    d = unit(slope * n + np.sqrt(1 - slope**2) * (u * np.cos(turn) + v * np.sin(turn)))
    options = f"{SHAPES} {naive}"
    start = feeler.probe("spawn", s.point, s.error, s.normal, level=level, options=options)
    return feeler.probe("make_ray", start, d, level=level, options=options)


# ---- row 12

SLOPES = [1, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]


@functools.cache
def self_hits(slope: float, radius: float, level: str, naive: str, count: int) -> float:
    s = points_on_sphere(radius, level, naive, count, 112)
    r = leave(s, slope, level, naive, 113)
    options = f"{SHAPES} {naive}"
    c = feeler.probe("intersect_sphere", r, [0, 0, 0], radius, 0, level=level, options=options)
    least = 1e-4 if "TMIN" in naive else 0
    return float(np.mean((c.found != 0) & (c.distance > least)))


def acne() -> list[Panel]:
    tries = 20_000
    none: dict[str, Any] = {"bound": 0}
    # By slope, and by radius.
    steep = {"figures": [0, None, 0.27, 0.4, 0.4, 0.4, 0.4]}
    methods = [("tmin 1e-4, float", NAIVE, "standard", TMIN, steep, {"figures": [0, 0, 0.46, None], "fails": [None] * 3 + [0.3]}),
               ("tmin 1e-4, double", DOUBLE, "reference", TMIN, none, none),
               ("1e-3 along the normal, float", OTHER, "standard", OFFSET, none, {"figures": [0, 0, 0, 0.24]}),
               ("the point's error bound, float", ROBUST, "standard", "", none, none)]  # fmt: skip
    radii = [1e-2, 1.0, 1e2, 1e4]
    return [
        Panel("a sphere of radius 10", "slope of the ray that leaves", SLOPES, "rays that hit what they left",
              [Curve(name, kind, [self_hits(x, 10, level, naive, tries) for x in SLOPES], **claim)
               for name, kind, level, naive, claim, _ in methods], tries),
        Panel("rays at a slope of 1/100", "radius of the sphere", radii, "rays that hit what they left",
              [Curve(name, kind, [self_hits(0.01, x, level, naive, tries) for x in radii], **claim)
               for name, kind, level, naive, _, claim in methods], tries),
    ]  # fmt: skip


# ---- row 13

GAPS = [1e-2, 1e-3, 1e-4, 4e-5, 1e-5, 4e-6, 2e-6]


def lost_layers(gap: float, level: str, naive: str, count: int) -> float:
    """Rays leave the unit sphere along its normal; a second one is so much larger: those that do not meet it."""
    s = points_on_sphere(1.0, level, naive, count, 114)
    r = leave(s, 0.9, level, naive, 115)
    c = feeler.probe("intersect_sphere", r, [0, 0, 0], 1 + gap, 0, level=level, options=f"{SHAPES} {naive}")
    least = 1e-4 if "TMIN" in naive else 0
    outside = length(r.origin.astype(float)) >= REAL[level](1 + gap).astype(float)
    return float(np.mean((c.found == 0) | (c.distance <= least) | outside))


def layers() -> list[Panel]:
    tries = 10_000
    # Where the gap is the offset, it is a matter of rounding.
    thinner = {"bound": [0, *[1] * 6], "fails": [None, 0.4, 1, 1, 1, 1, 1]}
    methods = [("1e-3 along the normal, float", NAIVE, "standard", OFFSET, thinner),
               ("1e-3 along the normal, double", DOUBLE, "reference", OFFSET, thinner),
               ("tmin 1e-4, float", OTHER, "standard", TMIN, {"bound": [0, 0, *[1] * 5], "fails": [*[None] * 3, 1, 1, 1, 1]}),
               ("the point's error bound, float", ROBUST, "standard", "", {"bound": 0})]  # fmt: skip
    return [
        Panel("a sphere of radius 1 and another around it", "gap between them", GAPS, "rays that miss the outer one",
              [Curve(name, kind, [lost_layers(x, level, naive, tries) for x in GAPS], **claim)
               for name, kind, level, naive, claim in methods], tries),
    ]  # fmt: skip


# ---- row 14

POWERS = [-24, -16, -8, 0, 8, 16, 24]


def offset_share(power: int, level: str, naive: str) -> float:
    """The greatest distance between a point on a sphere of radius 2^power and where its ray starts, by the radius."""
    radius = 2.0**power
    s = points_on_sphere(radius, level, naive, 2000, 116)
    start = feeler.probe("spawn", s.point, s.error, s.normal, level=level, options=f"{SHAPES} {naive}")
    return float(np.max(length(start.astype(np.longdouble) - s.point) / radius))


@functools.cache
def picture(power: int, level: str, naive: str) -> Any:
    """Of every primitive, all lengths times 2^power."""
    with kernel_options(naive):
        return feeler.Scene(everything(2.0**power)).render(level=level).pixels


def changed_pixels(power: int, level: str, naive: str) -> float:
    """The share of pixels that differ from the unscaled scene's in any bit."""
    return float(np.mean((picture(power, level, naive) != picture(0, level, naive)).any(-1)))


OFFSETS = [("a number of ulps, float", NAIVE, "standard", ULPS), ("1e-3 along the normal, float", OTHER, "standard", OFFSET),
           ("a number of ulps, double", DOUBLE, "reference", ULPS), ("the point's error bound, float", ROBUST, "standard", "")]  # fmt: skip


def scales() -> list[Panel]:
    x = [2.0**p for p in POWERS]
    shares = {m[0]: [offset_share(p, m[2], m[3]) for p in POWERS] for m in OFFSETS}
    ulps, flat = shares[OFFSETS[0][0]], shares[OFFSETS[3][0]]
    claims: dict[str, Any] = {
        NAIVE: {"figures": [256, 1, 0.004, 1.5e-5, 1.5e-5, 1.5e-5, 1.5e-5]},
        OTHER: {"figures": [*(1e-3 / size for size in x[:5]), 0, 0]},
        DOUBLE: {"figures": [*ulps[:3], *[None] * 4], "bound": [*[None] * 3, *(u / 16 for u in ulps[3:])]},
        ROBUST: {"bound": flat[3], "figures": [5.4e-7] * len(POWERS)},
    }
    return [
        Panel("how far a ray starts from its point", "size of the scene", x, "greatest offset / size",
              [Curve(m[0], m[1], shares[m[0]], **claims[m[1]]) for m in OFFSETS]),
    ]  # fmt: skip


def scaled_pictures() -> list[Panel]:
    powers = [-20, -10, 0, 10, 20]
    changed = {m[0]: [changed_pixels(p, m[2], m[3]) for p in powers] for m in OFFSETS}
    claims: dict[str, Any] = {
        NAIVE: {"figures": [0.3, *[None] * 4], "bound": 0.36, "fails": [None, 0.01, None, 0.01, 0.01]},
        OTHER: {"figures": [0.31, *[None] * 4], "bound": 0.37, "fails": [None, 0.01, None, 0.01, 0.01]},
        DOUBLE: {"figures": changed[OFFSETS[0][0]]},
        ROBUST: {"bound": 0},
    }
    return [
        Panel("a scene of every primitive, scaled by 2ᵏ", "size of the scene", [2.0**p for p in powers],
              "pixels that have other bits",
              [Curve(m[0], m[1], changed[m[0]], **claims[m[1]]) for m in OFFSETS], 48 * 36),
    ]  # fmt: skip


def spawn_inputs(rng: np.random.Generator, count: int) -> list[Any]:
    n = units(rng, count)
    return [*n.T, *(abs(n) * 3e-7).T, *n.T]


SPAWN_CODE = "const vectors p = spawn(IN3(0), IN3(3), IN3(6)); OUT = p.x + p.y + p.z;"
OFFSET_COST = Cost("the start of one ray", "-DNAIVE_OFFSET=1e-3f", SPAWN_CODE, spawn_inputs)
STUDIES = [
    Study(12, "fixed tmin", "a convex body is not met by rays that leave it", acne, OFFSET_COST),
    Study(13, "offset too large", "the outer sphere holds the ray", layers, OFFSET_COST),
    Study(14, "fixed number of ulps", "a size of 2ᵏ changes no digit", scales,
          Cost("the start of one ray", "-DNAIVE_ULPS", SPAWN_CODE, spawn_inputs)),
    Study(14, "pictures of scaled scenes", "the same bits", scaled_pictures, slow=True),
]  # fmt: skip
