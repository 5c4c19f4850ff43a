"""Rows 1 to 4: spheres, cylinders and cones as roots of a quadratic."""

from __future__ import annotations

import functools
from fractions import Fraction
from typing import Any

import numpy as np
from shapes import CAPPED, REAL, UNIT, dot, frame, only, unit, units

import feeler

from .cost import Cost
from .study import DOUBLE, NAIVE, OTHER, ROBUST, Curve, Panel, Study, later

SPHERE = only("TRANSMISSION", "SPHERE", "ONE_SIDED")
CONE = only("TRANSMISSION", "CONE")
FRONT_HIDDEN, BACK_HIDDEN = 2, 1


def cross_sphere(origin: Any, direction: Any, radius: Any, level: str, naive: str, flags: int = 0) -> Any:
    options = f"{SPHERE} {naive}"
    r = feeler.probe("make_ray", origin, direction, level=level, options=options)
    return feeler.probe("intersect_sphere", r, [0, 0, 0], radius, flags, level=level, options=options)


def round_to(level: str, *arrays: Any) -> list[Any]:
    return [np.asarray(a, float).astype(REAL[level]).astype(float) for a in arrays]


# ---- row 1

DISTANCES = [1.5, 10, 100, 1000, 2000, 4100, 1e4, 1e5, 1e6]
METHODS = [
    ("b² − 4ac, float", NAIVE, "standard", "-DNAIVE_SPHERE"),
    ("b² − 4ac, double", DOUBLE, "reference", "-DNAIVE_SPHERE"),
    ("chord's distance, float", ROBUST, "standard", ""),
]  # fmt: skip


def aim_at_sphere(distance: float, least: float, most: float, count: int, level: str) -> tuple[Any, Any]:
    """Rays at the unit sphere that pass its middle at `least` to `most`."""
    rng = np.random.default_rng(101)
    d = units(rng, count)
    u, v = frame(d)
    turn = rng.uniform(0, 2 * np.pi, (count, 1))
    target = rng.uniform(least, most, (count, 1)) * (u * np.cos(turn) + v * np.sin(turn))
    (origin,) = round_to(level, target - distance * d)
    (direction,) = round_to(level, unit(target - origin))
    return origin, direction


def half_chord_error(distance: float, level: str, naive: str) -> float:
    """The greatest of 1000 rays', radii."""
    origin, direction = aim_at_sphere(distance, 0, 0.5, 1000, level)
    ends = [
        cross_sphere(origin, direction, 1, level, naive, hidden).distance.astype(np.longdouble)
        for hidden in (BACK_HIDDEN, FRONT_HIDDEN)
    ]
    o, d = origin.astype(np.longdouble), direction.astype(np.longdouble)
    squared = dot(d, d)
    chord = o - d * (dot(o, d) / squared)[:, None]
    exact = np.sqrt((1 - dot(chord, chord)) / squared)
    return float(np.max(abs((ends[1] - ends[0]) / 2 - exact)))


@functools.cache
def sure_sphere_decisions(distance: float, level: str, count: int) -> tuple[Any, Any]:
    """Which rays surely meet the sphere, and which surely do not, by exact rationals: what is nearer to the outline than 8 u of
    the distance is neither.
    """
    slack = Fraction(8 * UNIT["standard"] * (distance + 2))
    surely, never = [], []
    for o, d in zip(*aim_at_sphere(distance, 0, 2, count, level), strict=True):
        p, q = [Fraction(x) for x in o], [Fraction(x) for x in d]
        across = sum((p[i - 2] * q[i - 1] - p[i - 1] * q[i - 2]) ** 2 for i in range(3))
        squared = sum(x * x for x in q)
        surely.append(slack < 1 and across < (1 - slack) ** 2 * squared)
        never.append(across > (1 + slack) ** 2 * squared)
    return np.array(surely), np.array(never)


def wrong_sphere_decisions(distance: float, level: str, naive: str, count: int) -> float:
    origin, direction = aim_at_sphere(distance, 0, 2, count, level)
    found = cross_sphere(origin, direction, 1, level, naive).found != 0
    surely, never = sure_sphere_decisions(distance, level, count)
    return float(np.mean((surely & ~found) | (never & found)))


def spheres() -> list[Panel]:
    tries = 1000
    errors = {m[0]: [half_chord_error(x, m[2], m[3]) for x in DISTANCES] for m in METHODS}
    wrong = {m[0]: [wrong_sphere_decisions(x, m[2], m[3], tries) for x in DISTANCES] for m in METHODS}
    # Each end is rounded as a distance is, and the chord's middle is known to a few u of the distance.
    bound = [8 * UNIT["standard"] * (x + 2) for x in DISTANCES]
    naive = errors[METHODS[0][0]]
    claims: dict[str, Any] = {
        NAIVE: {"figures": [None, None, 0.0017, 0.13, 0.88, 1.6, None, None, None], "fails": [None] * 5 + [1] * 4},
        ROBUST: {"bound": bound},
        DOUBLE: later(naive, DISTANCES.index(1e4)),  # half of which distance float's half chord is worth nothing
    }
    hits: dict[str, Any] = {
        NAIVE: {"figures": [0, 0, 0, None, None, None, 0.45, 0.49, 0.27], "fails": [None] * 3 + [0.005] * 6},
        ROBUST: {"bound": 0},
        DOUBLE: {"bound": 0},
    }
    return [
        Panel("half the chord", "distance / radius", DISTANCES, "greatest error / radius",
              [Curve(m[0], m[1], errors[m[0]], **claims[m[1]]) for m in METHODS]),
        Panel("hit or miss", "distance / radius", DISTANCES, "wrong decisions",
              [Curve(m[0], m[1], wrong[m[0]], **hits[m[1]]) for m in METHODS], tries),
    ]  # fmt: skip


# ---- row 2

RADII = [1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7]


def ground_error(height: float, radius: float, level: str, naive: str) -> float:
    """The greatest relative error of the distance down to a sphere's top from this height, at slopes down to 0.6; at most 1."""
    (direction,) = round_to(level, unit(np.array([[0.8 * x, 0, -1.0] for x in np.linspace(0, 1, 200)])))
    centre = [0, 0, -radius]
    options = f"{SPHERE} {naive}"
    r = feeler.probe("make_ray", [0, 0, height], direction, level=level, options=options)
    found = feeler.probe("intersect_sphere", r, centre, radius, 0, level=level, options=options)
    d, top = direction.astype(np.longdouble), np.longdouble(radius) + height
    squared, b, c = dot(d, d), -d[:, 2] * top, height * (top + radius)
    exact = c / (b + np.sqrt(b * b - squared * c))
    distance = np.where(found.found != 0, found.distance, 0)
    return float(min(np.max(abs(distance - exact) / exact), 1))


def plane_error(height: float) -> float:
    """The same for the plane that takes the sphere's place."""
    options = only("TRANSMISSION", "PLANE")
    (direction,) = round_to("standard", unit(np.array([[0.8 * x, 0, -1.0] for x in np.linspace(0, 1, 200)])))
    r = feeler.probe("make_ray", [0, 0, height], direction, options=options)
    found = feeler.probe("intersect_plane", r, [0, 0, 0], [0, 0, 1.0], 0, options=options)
    exact = -height / direction[:, 2].astype(np.longdouble)
    return float(np.max(abs(found.distance - exact) / exact))


# At 10⁵ and 10⁷; and with a height that the sum R + 1.1 has rounded, for all of them, at 10⁶.
LOST: dict[str, Any] = {"bound": [None] * 5 + [0.06, None], "fails": [None] * 5 + [0.008, 0.04]}
GROUND_SAYS: dict[bool, dict[str, dict[str, Any]]] = {
    True: {"naive": {"figures": [None] * 4 + [0.007, None, 0.22]},
           "half": {"figures": [None] * 4 + [0.002, None, 0.16], "bound": [3e-7] * 3 + [None] * 4},
           "factored": {"figures": [1.6e-7, None, None, 1.6e-7, 1.2e-7, None, 1.6e-7]}},
    False: {"naive": LOST, "half": LOST, "factored": {"fails": LOST["fails"]}},
}  # fmt: skip


def ground() -> list[Panel]:
    panels = []
    for height, title in ((1.0, "height 1"), (float(np.float32(1.1)), "height 1.1")):
        lost = (
            0 if height == 1 else 4 * UNIT["standard"]
        )  # the distance to the centre is rounded, and with it the height
        bound = [8 * UNIT["standard"] + lost * r / height for r in RADII]
        plane = plane_error(height)
        says = GROUND_SAYS[height == 1]

        def errors(level: str, naive: str, height: float = height) -> list[float]:
            return [ground_error(height, r, level, naive) for r in RADII]

        naive = errors("standard", "-DNAIVE_SPHERE")
        panels.append(Panel(f"a sphere as the ground, the eye at {title}", "radius", RADII, "greatest relative error", [
            Curve("b² − 4ac, float", NAIVE, naive, **says["naive"]),
            Curve("c = f·f − r², float", OTHER, errors("standard", "-DNAIVE_SPHERE=2"), **says["half"]),
            Curve("b² − 4ac, double", DOUBLE, errors("reference", "-DNAIVE_SPHERE"), **later(naive)),
            Curve("c = (|f| − r)(|f| + r), float", ROBUST, errors("standard", ""), bound, **says["factored"]),
            Curve("a plane, float", OTHER, [plane] * len(RADII), 4 * UNIT["standard"], figures=[5e-8] * len(RADII)),
        ]))  # fmt: skip
    return panels


# ---- row 3

TILTS = [0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]


def cone_error(tilt: float, level: str, naive: str) -> float:
    """The greatest relative error of where a ray from within a cone meets its side, if it has the slope of the side but for
    this share; 1 for none.
    """
    rng = np.random.default_rng(103)
    count, slope = 2000, 0.25
    turn = rng.uniform(0, 2 * np.pi, count)
    across = slope * (1 + tilt * rng.choice([-1, 1], count))
    (direction,) = round_to(level, np.stack([across * np.cos(turn), across * np.sin(turn), np.ones(count)], 1))
    (start,) = round_to(level, np.stack([*rng.uniform(-0.6, 0.6, (2, count)), 0 * turn], 1))
    options = f"{CONE} {naive}"
    body = {"base": [0, 0, 0], "radius": 1, "slope": -slope, "height": 3.9,
            "frame": {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}}  # fmt: skip
    r = feeler.probe("make_ray", start, direction, level=level, options=options)
    found = feeler.probe("intersect_cone", r, body, 0, level=level, options=options)
    p, e = start[:, :2].astype(np.longdouble), direction[:, :2].astype(np.longdouble)
    b, c, a = dot(p, e) + slope, dot(p, p) - 1, dot(e, e) - slope**2
    exact = -c / (b + np.sqrt(b * b - a * c))  # the nearer root: c < 0 < b
    sure = (b > 0) & (exact < 3.8)
    with np.errstate(all="ignore"):
        error = np.where(found.found != 0, abs(found.distance - exact) / exact, 1)[sure]
    return float(np.max(np.minimum(np.nan_to_num(error, nan=1), 1)))


def parallel_rays() -> list[Panel]:
    grown = [4e-7 / x for x in TILTS]
    lost = {"figures": [min(g, 1) for g in grown], "bound": 1, "fails": [None] * 7 + [1, 1]}
    held = {"bound": 16 * UNIT["standard"], "figures": [3e-7] * len(TILTS)}
    methods = [("b² − 4ac, float", NAIVE, "standard", "-DNAIVE_CONE", lost),
               ("b² − 4ac, double", DOUBLE, "reference", "-DNAIVE_CONE", later(grown)),
               ("Lagrange's identity, q, float", ROBUST, "standard", "", held)]  # fmt: skip
    return [
        Panel("a ray within a cone, almost parallel to its side", "slope of the ray / of the side, − 1", TILTS,
              "greatest relative error; 1: lost",
              [Curve(name, kind, [cone_error(x, level, naive) for x in TILTS], **claim)
               for name, kind, level, naive, claim in methods]),
    ]  # fmt: skip


# ---- row 4

OFFSETS = [1, 10, 100, 1e3, 1e4, 1e5]


def seam_misses(offset: float, level: str, naive: str, count: int) -> float:
    """Rays from within capped cylinders and cones at the rims, where cap and side meet, and at the apex."""
    rng = np.random.default_rng(104)
    shapes = 400
    axis = units(rng, shapes)
    u, v = frame(axis)
    radius, height = rng.uniform(0.3, 1, (2, shapes, 1))
    top = radius * rng.choice([0.0, 0.5, 1.0, 1.5], (shapes, 1))
    base = offset * units(rng, shapes)
    axis, u, v, radius, height, top, base = round_to(level, axis, u, v, radius, height, top, base)
    (slope,) = round_to(level, (top - radius) / height)
    n = rng.integers(0, shapes, count)
    turn = rng.uniform(0, 2 * np.pi, (count, 1))
    above = rng.random((count, 1)) < 0.5
    arm = np.where(above, top[n], radius[n])
    rim = base[n] + np.where(above, height[n], 0) * axis[n] + arm * (np.cos(turn) * u[n] + np.sin(turn) * v[n])
    (origin,) = round_to(level, base[n] + axis[n] * height[n] * rng.uniform(0.3, 0.7, (count, 1)))
    options = f"{CONE} {naive}"
    r = feeler.probe("make_ray", origin, unit(rim - origin), level=level, options=options)
    body = {"base": base[n], "radius": radius[n, 0], "slope": slope[n, 0], "height": height[n, 0],
            "frame": {"x": u[n], "y": v[n], "z": axis[n]}}  # fmt: skip
    found = feeler.probe("intersect_cone", r, body, CAPPED, level=level, options=options)
    return float(np.mean(found.found == 0))


def seams() -> list[Panel]:
    tries = 20_000
    methods = [("side and caps apart, float", NAIVE, "standard", "-DNAIVE_CONE", {"figures": [0.06] * len(OFFSETS)}),
               ("side and caps apart, double", DOUBLE, "reference", "-DNAIVE_CONE", {"figures": [0.05] * len(OFFSETS)}),
               ("intervals overlap, float", ROBUST, "standard", "", {"bound": 0})]  # fmt: skip
    return [
        Panel("rays from within, at the rims", "distance of the body from 0 / radius", OFFSETS,
              "rays that leave through the seam",
              [Curve(name, kind, [seam_misses(x, level, naive, tries) for x in OFFSETS], **claim)
               for name, kind, level, naive, claim in methods], tries),
    ]  # fmt: skip


def sphere_inputs(rng: np.random.Generator, count: int) -> list[Any]:
    o, d = units(rng, count) * 5, units(rng, count)
    d = unit(d * 0.4 - o / 5)
    return [*o.T, *d.T]


CONE_CODE = """
frustum f;
f.base = make_vectors(splat(0), splat(0), splat(0));
f.frame.x = make_vectors(splat(1), splat(0), splat(0));
f.frame.y = make_vectors(splat(0), splat(1), splat(0));
f.frame.z = make_vectors(splat(0), splat(0), splat(1));
f.radius = splat(1); f.slope = splat(-0.25f); f.height = splat(2);
crossing c = intersect_cone(make_ray(IN3(0), IN3(3)), f, FLAG_CAPPED); OUT = c.found ? c.distance : splat(-1);
"""
SPHERE_CODE = """
crossing c = intersect_sphere(make_ray(IN3(0), IN3(3)), make_vectors(splat(0), splat(0), splat(0)), splat(1), 0);
OUT = c.found ? c.distance : splat(-1);
"""
CONE_COST = Cost("one ray and one capped cone", "-DNAIVE_CONE", CONE_CODE, sphere_inputs, ("CONE",))
STUDIES = [
    Study(1, "sphere far away", "exact rationals; the chord in extended precision", spheres,
          Cost("one ray and one sphere", "-DNAIVE_SPHERE", SPHERE_CODE, sphere_inputs, ("SPHERE",))),
    Study(2, "sphere as the ground", "the root in extended precision", ground,
          Cost("one ray and one sphere, c factored", "-DNAIVE_SPHERE=2", SPHERE_CODE, sphere_inputs, ("SPHERE",))),
    Study(3, "along the side of a cone", "the root in extended precision", parallel_rays, CONE_COST),
    Study(4, "cap and side", "a closed body has no way out", seams, CONE_COST),
]  # fmt: skip
