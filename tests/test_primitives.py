"""The primitives' functions one by one: their points lie where they say, rays leave what they left, decisions are right
beyond a stated bound, closed shapes have no holes. The oracles are formulas in extended precision.

Printed with -s: the greatest errors, in units of what each bound allows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shapes import (
    BOX,
    CONE,
    FLOAT_FIRST,
    LEVELS,
    REAL,
    SHAPES,
    SPHERE,
    TRIANGLE,
    UNIT,
    WAYS,
    Shapes,
    cross,
    cross_every_way,
    dot,
    frame,
    gap,
    leave,
    length,
    point_on,
    random_shapes,
    ray,
    spawn,
    surface,
    unit,
    units,
)  # fmt: skip

import feeler

FLAT = ["plane", "disc", "triangle", "polygon"]
SOLID = ["sphere", "box", "cylinder", "cone"]
COUNT = {"standard": 100_000, "reference": 20_000}


def aim(shapes: Shapes, count: int, seed: int, most: float = 1e4) -> tuple[Any, Any, Any]:
    """Primitives' numbers, and rays at them from 1.5 to `most` times their size away, as the device will have them."""
    rng = np.random.default_rng(seed)
    numbers = rng.integers(0, shapes.count, count)
    target = point_on(shapes, rng, numbers)
    size = (shapes.high - shapes.low).max(1)[numbers]
    size = np.where(size > 0, size, length(target))[:, None]  # a plane has none
    away = size * np.exp(rng.uniform(np.log(1.5), np.log(most), (count, 1)))
    origin = (target - units(rng, count) * away).astype(REAL[shapes.level]).astype(float)
    return numbers, origin, unit(target - origin)


@pytest.mark.parametrize("level", FLOAT_FIRST)
@pytest.mark.parametrize("name", FLAT + SOLID + ["open cone"])
def test_points_are_within_their_error_and_rays_leave(name: str, level: str) -> None:
    """Pbrt's Reintersect, with sizes of 1e-3 … 1e3 and rays from up to 1e4 sizes away."""
    shapes = random_shapes(name, level, 1000, seed=2)
    numbers, origin, direction = aim(shapes, COUNT[level], seed=1)
    r = ray(level, origin, direction)
    found, c = cross_every_way(shapes, r, numbers)
    assert found.mean() > (0.7 if name == "open cone" else 0.995)
    s = surface(shapes, r, c, numbers)
    allowed = dot(abs(s.normal.astype(float)), s.error.astype(float))
    distance = gap(shapes, numbers, s.point)
    print(
        f"{level} {name}: {found.sum()} points, {np.nanmax((distance / np.maximum(allowed, 1e-300))[found]):.2f} of the error"
    )
    assert (distance <= allowed)[found].all()
    if name == "open cone":
        return  # seen from inside too: a ray that leaves may rightly meet it again
    rng = np.random.default_rng(3)
    outside = np.where(dot(s.normal, r.direction)[:, None] < 0, s.normal, -s.normal).astype(float)
    for side in (outside, -outside) if name in FLAT else (outside,):
        second = ray(level, spawn(level, s, side), leave(rng, side))
        again, _ = cross_every_way(shapes, second, numbers)
        if name == "triangle":  # a thin one's exact normal is another: rays that do not leave by it
            a, b, c3 = np.moveaxis(shapes.points[numbers].astype(np.longdouble), 1, 0)
            exact = np.cross(b - a, c3 - a)
            again &= dot(exact, side) * dot(exact, second.direction) > 0
        assert not (again & found).any(), f"{(again & found).sum()} rays hit what they left"


@pytest.mark.parametrize("level", LEVELS)
def test_rays_inside_a_sphere_meet_its_other_side(level: str) -> None:
    shapes = random_shapes("sphere", level, 1000, seed=5)
    numbers, origin, direction = aim(shapes, COUNT[level], seed=6, most=100)
    r = ray(level, origin, direction)
    _, c = cross_every_way(shapes, r, numbers)
    s = surface(shapes, r, c, numbers)
    inwards = -s.normal.astype(float)
    start = spawn(level, s, inwards)
    second = ray(level, start, leave(np.random.default_rng(7), inwards))
    again, c = cross_every_way(shapes, second, numbers)
    assert again.all()
    o, d = start.astype(np.longdouble), second.direction.astype(np.longdouble)
    f, radius = o - shapes.rows[numbers, :3], shapes.rows[numbers, 3].astype(np.longdouble)
    b = -dot(f, d)
    exact = (b + np.sqrt(b * b - dot(d, d) * (dot(f, f) - radius * radius))) / dot(d, d)
    # An error of the chord's distance from the centre is r / (half the chord) times as large along a flat one.
    error = abs(c.distance - exact) / (UNIT[level] * (length(o) + radius) * np.maximum(1, 2 * radius / exact))
    print(
        f"{level}: the other side of a sphere within {error.max():.1f} u, flatness allowed for; nearest {exact.min():.1e}"
    )
    assert error.max() < 8


# ---- decisions


def hits_sphere(o: Any, d: Any, centre: Any, radius: Any) -> Any:
    f = o - centre
    across = length(f - d * (dot(f, d) / dot(d, d))[:, None])
    return (radius > 0) & (across < radius) & ((dot(f, d) < 0) | (length(f) < radius))


def hits_box(o: Any, d: Any, low: Any, high: Any) -> Any:
    with np.errstate(all="ignore"):
        a, b = (low - o) / d, (high - o) / d
    near, far = np.minimum(a, b).max(1), np.maximum(a, b).min(1)
    return (near < far) & (far > 0)


def hits_cylinder(o: Any, d: Any, rows: Any, slack: Any) -> Any:
    """A capped one, `slack` wider each way."""
    q, axis = o - rows[:, :3], rows[:, 12:15].astype(np.longdouble)
    axis = unit(axis)
    oz, dz = dot(q, axis), dot(d, axis)
    p, e = q - oz[:, None] * axis, d - dz[:, None] * axis
    radius, height = np.maximum(rows[:, 3] + slack, 0), rows[:, 7]
    b, a = -dot(p, e), dot(e, e)
    root = np.sqrt(np.maximum(b * b - a * (dot(p, p) - radius * radius), 0))
    ends = (-slack - oz) / dz, (height + slack - oz) / dz
    near, far = np.maximum((b - root) / a, np.minimum(*ends)), np.minimum((b + root) / a, np.maximum(*ends))
    return (b * b >= a * (dot(p, p) - radius * radius)) & (near < far) & (far > 0) & (radius > 0)


def inside_triangle(o: Any, d: Any, corners: Any) -> Any:
    """By how far the ray passes inside of the nearest edge; negative outside."""
    a = corners.astype(np.longdouble) - o[:, None]
    distances = []
    for i in range(3):
        p, q = a[:, i], a[:, (i + 1) % 3]
        distances.append(dot(d, np.cross(p, q)) / length(np.cross(d, q - p)))
    e = np.stack(distances)
    return np.maximum(e.min(0), -e.max(0))


# How far from the outline a decision may be wrong: this many u times how far the origin is (and the shape reaches).
WRONG_WITHIN = {"sphere": 8, "box": 8, "cylinder": 16, "triangle": 12}


@pytest.mark.parametrize("name", WRONG_WITHIN)
@pytest.mark.parametrize("away", [1.5, 1e2, 1e4, 1e6])
def test_decisions_are_right_beyond_their_bound(name: str, away: float) -> None:
    """NUMERICS rows 1, 3, 4, 8: rays near the outlines of shapes, from near and far; 0 wrong ones."""
    rng = np.random.default_rng(11)
    n, level = 20_000, "standard"
    shapes = random_shapes(name, level, 500, seed=12, least=0.1, most=10)
    numbers = rng.integers(0, shapes.count, n)
    size = (shapes.high - shapes.low).max(1)[numbers]
    middle = ((shapes.low + shapes.high) / 2)[numbers]
    target = middle + (size / 2)[:, None] * rng.uniform(-1.2, 1.2, (n, 3))
    d = units(rng, n)
    if name == "sphere":  # around the outline
        u, v = frame(d)
        turn = rng.uniform(0, 2 * np.pi, (n, 1))
        off = (size / 2)[:, None] * (1 + rng.normal(size=(n, 1)) * (away + 12) * 3e-6)
        target = middle + off * (u * np.cos(turn) + v * np.sin(turn))
    origin = (target - d * size[:, None] * away).astype(np.float32).astype(float)
    r = ray(level, origin, unit(target - origin))
    found, _ = cross_every_way(shapes, r, numbers)
    o, e = r.origin.astype(np.longdouble), r.direction.astype(np.longdouble)
    rows = shapes.rows[numbers]
    reach = length(o - middle) + size + length(middle)
    slack = WRONG_WITHIN[name] * UNIT[level] * reach
    if name == "sphere":
        surely, maybe = (hits_sphere(o, e, rows[:, :3], rows[:, 3] + x) for x in (-slack, slack))
    elif name == "box":
        low, high, x = shapes.low[numbers], shapes.high[numbers], slack[:, None]
        surely, maybe = hits_box(o, e, low, high), hits_box(o, e, low - x, high + x)  # never missed
    elif name == "cylinder":
        surely, maybe = (hits_cylinder(o, e, rows, x) for x in (-slack, slack))
    else:
        margin = inside_triangle(o, e, shapes.points[numbers])
        surely, maybe = margin > slack, margin > -slack
    print(f"{name} at {away:g}: {found.sum()} hits, {(surely != maybe).sum()} within the bound")
    assert (surely & ~found).sum() == 0, "misses"
    assert (found & ~maybe).sum() == 0, "false hits"


def test_a_big_sphere_as_the_ground() -> None:
    """NUMERICS row 2: (|f| - r)(|f| + r) keeps what |f|² - r² loses."""
    radius, height = 1e5, 1.0
    down = np.array([[0, 0, -1.0], [0.6, 0, -0.8], [0.8, 0, -0.6]])
    origin = np.array([0, 0, height])
    crossing = feeler.probe(
        "intersect_sphere", ray("standard", origin, down), [0, 0, -radius], radius, 0, options=SHAPES
    )
    top = np.float64(np.float32(height)) + radius
    b = -down[:, 2] * top
    c = np.float64(np.float32(height)) * (top + radius)
    exact = c / (b + np.sqrt(b * b - c))
    # The height above a sphere of this radius is known to one rounding of the distance to its centre.
    assert abs(crossing.distance - exact).max() < 2 * np.spacing(np.float32(top))


def test_a_plane_at_a_grazing_angle() -> None:
    """NUMERICS row 5: a point at a distance of 1e7 is on the plane to within its error, and rays leave it."""
    rng = np.random.default_rng(4)
    n = 20_000
    shapes = Shapes(1, "standard", np.hstack([np.zeros((1, 4)), unit(np.array([[0.3, 0.8, 0.2]])), [[0]]]), np.zeros((1, 3)),
                    np.zeros((1, 3)))  # fmt: skip
    normal = shapes.rows[0, 4:7]
    u, v = frame(normal[None])
    turn = rng.uniform(0, 2 * np.pi, (n, 1))
    d = unit(u * np.cos(turn) + v * np.sin(turn) - normal * 1e-7 * rng.uniform(0.5, 2, (n, 1)))
    numbers = np.zeros(n, int)
    r = ray("standard", normal, d)
    found, c = cross(shapes, r, numbers)
    assert found.mean() > 0.5
    assert c.distance[found].max() > 1e6
    s = surface(shapes, r, c, numbers)
    assert (gap(shapes, numbers, s.point) <= dot(abs(s.normal), s.error))[found].all()
    again, _ = cross(
        shapes, ray("standard", spawn("standard", s, normal), leave(rng, np.tile(normal, (n, 1)))), numbers
    )
    assert not (again & found).any()


@pytest.mark.parametrize("way", WAYS)
def test_a_needle_is_hit_only_within_its_box(way: str) -> None:
    """NUMERICS row 10 (embree#387): long thin triangles met at a grazing angle."""
    rng = np.random.default_rng(21)
    n = 20_000
    a = rng.uniform(-300, 300, (n, 3))
    along = units(rng, n)
    points = np.stack([a, a + 11.2 * along, a + 9.7 * along + 10 ** rng.uniform(-4, 0, (n, 1)) * units(rng, n)], 1)
    shapes = Shapes(TRIANGLE, "standard", points=points)
    numbers = np.arange(n)
    target = point_on(shapes, rng, numbers)
    origin = (
        (target - unit(along + 0.01 * units(rng, n)) * rng.uniform(10, 600, (n, 1))).astype(np.float32).astype(float)
    )
    r = ray("standard", origin, unit(target - origin))
    found, c = cross(shapes, r, numbers, way)
    assert found.sum() > 1000
    at = origin + r.direction.astype(float) * c.distance[:, None].astype(float)
    slack = 16 * UNIT["standard"] * (length(origin) + length(target) + c.distance)[:, None]
    within = (at >= shapes.low - slack) & (at <= shapes.high + slack)
    assert within.all(1)[found].all()


def test_a_corner_far_from_the_others() -> None:
    """So far that the edges to it are one in float: the third edge tells the normal."""
    corners = np.array([[178.8, 10310265, -165879], [0, 0.16, 0], [-2e-6, -0.014, 1.5e-4]]).astype(np.float32)
    exact = corners.astype(np.longdouble)
    normal = unit(np.cross(exact[1] - exact[0], exact[2] - exact[0])[None])[0]
    for first in range(3):
        ray = feeler.probe("make_ray", [0, 0, 1], [0, 0, -1.0], options=SHAPES)
        s = feeler.probe("surface_triangle", ray, *np.roll(corners, first, 0), 0.25, 0.25, options=SHAPES)
        assert abs(s.normal - normal).max() < 8 * UNIT["standard"], first


def test_points_beside_a_corner_are_within_their_error() -> None:
    """Heights just above a power of two, two of three weights that vanish: the sum's roundings are as large as they get."""
    rng = np.random.default_rng(9)
    n = 200_000
    corners = rng.uniform(-1, 1, (n, 3, 3))
    corners[..., 2] = 1 + rng.uniform(0.001, 0.01, (n, 1)) + 1e-3 * corners[..., 2]
    shapes = Shapes(TRIANGLE, "standard", points=corners)
    small = rng.uniform(0, 1e-3, (n, 2))
    r = ray("standard", [0, 0, 5], [0, 0, -1.0])
    s = feeler.probe(
        "surface_triangle", r, *np.moveaxis(shapes.points, 1, 0), small[:, 0], 1 - small.sum(1), options=SHAPES
    )
    share = gap(shapes, np.arange(n), s.point) / dot(abs(s.normal.astype(float)), s.error.astype(float))
    print(f"{share.max():.2f} of the error")
    assert share.max() <= 1


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("step", [4e-5, 1e-5, 2e-6])
def test_a_thin_layer_is_met(step: float, way: str) -> None:
    """NUMERICS row 13: a ray that leaves a sphere meets another that is slightly larger."""
    rng = np.random.default_rng(8)
    n = 10_000
    rows = np.array([[0, 0, 0, 1.0], [0, 0, 0, 1 + step]])
    shapes = Shapes(SPHERE, "standard", rows, -rows[:, 3:].repeat(3, 1), rows[:, 3:].repeat(3, 1))
    outer = shapes.rows[1, 3] - 1
    d = units(rng, n)
    r = ray("standard", d * 5, -d)
    zero, one = np.zeros(n, int), np.ones(n, int)
    _, c = cross(shapes, r, zero, way)
    s = surface(shapes, r, c, zero)
    found, c = cross(shapes, ray("standard", spawn("standard", s, s.normal), d), one, way)
    assert found.all()
    assert abs(c.distance - outer).max() < 16 * UNIT["standard"]


# ---- boxes of the tree


def mixed(rng: np.random.Generator, shape: tuple[int, ...], special: list[float], reach: float) -> Any:
    """Random numbers, many of them special, rounded to float."""
    values = np.where(rng.random(shape) < 0.5, rng.choice(special, shape), rng.uniform(-reach, reach, shape))
    return values.astype(np.float32).astype(float)


def test_boxes_are_never_missed() -> None:
    """NUMERICS rows 6, 7: a box that the exact ray touches ahead of it is found; NaN never decides.

    A ray in the plane of a face counts as inside on the low side: then one of two boxes that share the face has it.
    """
    rng = np.random.default_rng(17)
    n = 200_000
    places = [0.0, 1.0, -1.0, 0.5, 1e-6, 1e4]
    o, corners = mixed(rng, (n, 3), places, 10), mixed(rng, (n, 2, 3), places, 10)
    d = mixed(rng, (n, 3), [0.0, -0.0, 1.0, -1.0, 1e-20, -1e-20, 1e-30, 0.25], 1)
    o, corners, d = (a[length(d) > 1e-3] for a in (o, corners, d))
    d = unit(d).astype(np.float32).astype(float)
    low, high = corners.min(1), corners.max(1)
    i = feeler.probe("intersect_bounds", ray("standard", o, d), low, high, options=SHAPES)
    assert np.isfinite(i).all()
    with np.errstate(all="ignore"):
        a, b = ((x - o.astype(np.longdouble)) / d for x in (low, high))
    within = (o >= low) & (o < high)
    near = np.where(d == 0, np.where(within, -np.inf, np.inf), np.minimum(a, b)).max(1)
    far = np.where(d == 0, np.where(within, np.inf, -np.inf), np.maximum(a, b)).min(1)
    meets = (near <= far) & (far > 1e-30)
    print(f"{meets.sum()} boxes met")
    bad = meets & ~((i[:, 0] <= i[:, 1]) & (i[:, 1] > 0))
    assert not bad.any(), (o[bad][:3], d[bad][:3], low[bad][:3], high[bad][:3])


def test_kinds_are_those_of_the_kernels() -> None:
    for name, number in {"SPHERE": SPHERE, "BOX": BOX, "TRIANGLE": TRIANGLE, "CONE": CONE}.items():
        assert f"#define KIND_{name} {number}u" in feeler.kernel_source()
