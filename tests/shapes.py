"""Primitives for tests of single kernel functions: packed as the device has them, met by rays through probe, and judged
in extended precision by formulas of their own.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from blocks import block_tables, corner_tables

import feeler

SPHERE, PLANE, DISC, BOX, TRIANGLE, POLYGON, CONE = range(7)
CAPPED = 16
UNIT = {"standard": 2.0**-24, "reference": 2.0**-53}
REAL: dict[str, Any] = {"standard": np.float32, "reference": np.float64}
LEVELS = ["standard", "reference"]
# Where double takes kernels of its own and shows little more.
FLOAT_FIRST = ["standard", pytest.param("reference", marks=pytest.mark.slow)]

# How rays meet a block: one ray has several entries side by side, as many as there are lanes; or many rays have one.
WAYS = {"alone": (1, " -DRAYS=1"), "together": (8, " -DRAYS=1"), "apart": (8, " -DRAYS=8")}


@functools.cache
def only(*features: str) -> str:
    """Build options that leave everything out but these features: a probe then builds in a second."""
    names = re.findall(r"#ifndef (HAS_\w+)", feeler.kernel_source())
    assert set(features) <= {name.removeprefix("HAS_") for name in names}
    return " ".join(f"-D{name}={int(name.removeprefix('HAS_') in features)}" for name in names)


SHAPES = only("TRANSMISSION", "SPHERE", "PLANE", "DISC", "BOX", "TRIANGLE", "POLYGON", "CONE")


def units(rng: np.random.Generator, count: int) -> Any:
    """Random directions, float64."""
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def dot(a: Any, b: Any) -> Any:
    return (np.asarray(a) * np.asarray(b)).sum(-1)


def length(a: Any) -> Any:
    return np.sqrt(dot(a, a))


def unit(a: Any) -> Any:
    return a / length(a)[..., None]


def frame(axis: Any) -> tuple[Any, Any]:
    """Two directions square to each axis and to each other."""
    helper = np.where(np.abs(axis[:, :1]) < 0.6, [[1.0, 0, 0]], [[0.0, 1, 0]])
    u = unit(np.cross(axis, helper))
    return u, np.cross(axis, u)


class Shapes:
    """Many primitives of one kind, each number rounded to the level's real first.

    `rows` holds the device's structs without their boxes, `points` the corners of triangles and polygons.
    """

    def __init__(self, kind: int, level: str, rows: Any = None, low: Any = None, high: Any = None, points: Any = None):
        real = REAL[level]
        self.kind, self.level, self.flags = kind, level, 0
        self.points: Any = None if points is None else np.asarray(points, real).astype(np.float64)
        if self.points is not None:
            low, high = self.points.min(1), self.points.max(1)
        self.rows = np.zeros((len(low), 0)) if rows is None else np.asarray(rows, real).astype(np.float64)
        self.count = len(low)
        self.low, self.high = np.asarray(low, float), np.asarray(high, float)

    def bounds(self) -> tuple[Any, Any]:
        """Boxes a little wider than the shapes, as packing makes them; a box is its own."""
        step = 8 * UNIT[self.level]
        size = (self.high - self.low).max(1, keepdims=True)
        pad = np.where(self.kind == BOX, 0, step * (size + np.maximum(abs(self.low), abs(self.high))))
        return self.low - pad, self.high + pad

    def _block_fields(self, low: Any, high: Any) -> Any:
        """Each primitive's fields in the order of a block's rows, see ROWS_SPHERE and the next in types.h."""
        if self.kind == TRIANGLE:
            return self.points.reshape(self.count, 9)
        rows = {
            SPHERE: [0, 1, 2, 3],
            DISC: [0, 1, 2, 3, 4, 5, 6],
            CONE: [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11],
        }
        return np.hstack([low, high, self.rows[:, rows.get(self.kind, [])]])

    def scene(self, size: int = 1) -> dict[str, Any]:
        """The tables of a `scene` without a tree, in blocks of `size`."""
        low, high = self.bounds()
        zero = np.zeros((self.count, 1))
        numbers = np.arange(self.count)
        primitives = np.stack([numbers * 0 + self.kind, numbers, numbers * 0, numbers * 0 + self.flags], 1)
        tables: dict[str, Any] = {"primitives": primitives}
        names = {SPHERE: "spheres", PLANE: "planes", DISC: "discs", BOX: "boxes", POLYGON: "polygons", CONE: "cones"}
        if self.kind == PLANE:
            return {**tables, "planes": self.rows, "block_numbers": numbers, "count": [0, 0, 0, self.count]}
        if self.kind == TRIANGLE:
            tables["triangles"] = np.hstack([numbers[:, None] * 3 + [0, 1, 2], numbers[:, None] * 0])
            tables["vertices"] = np.hstack([self.points.reshape(-1, 3), np.zeros((self.count * 3, 1))])
        else:
            tables[names[self.kind]] = np.hstack([self.rows, low, zero, high, zero])
        if self.kind == POLYGON:
            tables |= corner_tables(self.points)
        return tables | block_tables(self._block_fields(low, high), self.kind << 29 | self.flags << 24, size)


def members(value: Any, change: Callable[[Any], Any]) -> Any:
    """A struct with its arrays changed."""
    return type(value)(*(members(part, change) for part in value)) if isinstance(value, tuple) else change(value)


def column(value: Any) -> Any:
    """A struct with one more axis to each of its arrays, behind the first."""
    return members(value, lambda part: part[:, None])


def ray(level: str, origin: Any, direction: Any, options: str = SHAPES) -> Any:
    return feeler.probe("make_ray", origin, direction, level=level, options=options)


def cross(shapes: Shapes, r: Any, numbers: Any, way: str = "alone") -> tuple[Any, Any]:
    """Whether each ray meets the primitive of its number ahead of it, as a render finds it in a block; and where."""
    scene = shapes.scene()
    if shapes.kind == PLANE:
        c = feeler.probe(
            "intersect_unbounded", scene, r, scene["primitives"][numbers], level=shapes.level, options=SHAPES
        )
        return (c.found != 0) & (c.distance > 0), c
    lanes, options = WAYS[way]
    none = (np.finfo(REAL[shapes.level]).max, -1, 0, 0)
    c = feeler.probe("traverse_below", scene, r, True, none, scene["links"][numbers], False, level=shapes.level,
                     lanes=lanes, options=SHAPES + options)  # fmt: skip
    assert ((c.primitive == numbers) | (c.primitive == -1)).all()
    return c.primitive >= 0, c._replace(distance=np.where(c.primitive >= 0, c.distance, 0))


def cross_every_way(shapes: Shapes, r: Any, numbers: Any) -> tuple[Any, Any]:
    """As `cross`, and that every way finds the same."""
    found, c = cross(shapes, r, numbers)
    for way in ("together", "apart") if shapes.kind != PLANE else ():
        also, other = cross(shapes, r, numbers, way)
        assert np.array_equal(also, found), way
        for name in c._fields:
            assert (getattr(other, name) == getattr(c, name))[found].all(), (way, name)
    return found, c


def surface(shapes: Shapes, r: Any, c: Any, numbers: Any) -> Any:
    """The surface at each crossing."""
    scene = shapes.scene()
    hit = (c.distance, numbers, c.u, c.v)
    identity = (np.full(len(numbers), shapes.kind), numbers, numbers * 0, numbers * 0 + shapes.flags)
    return feeler.probe("find_surface", scene, r, hit, True, identity, level=shapes.level, options=SHAPES)


def spawn(level: str, s: Any, side: Any) -> Any:
    return feeler.probe("spawn", s.point, s.error, side, level=level, options=SHAPES)


def leave(rng: np.random.Generator, side: Any, grazing: float = 0.5) -> Any:
    """Directions to the side of a normal: this share of them grazing, down to a slope of 1e-6, the others evenly spread."""
    side = unit(side)
    e = units(rng, len(side))
    e = np.where(dot(e, side)[:, None] < 0, -e, e)
    slope = 10 ** rng.uniform(-6, 0, (len(side), 1))
    along = unit(e - side * dot(e, side)[:, None]) + side * slope
    return np.where(rng.random((len(side), 1)) < grazing, unit(along), e)


# ---- random ones, sizes from `least` to `most`, centres within ten sizes of the origin


def random_shapes(name: str, level: str, count: int, seed: int, least: float = 1e-3, most: float = 1e3) -> Shapes:
    rng = np.random.default_rng(seed)
    size = np.exp(rng.uniform(np.log(least), np.log(most), (count, 1)))
    centre = rng.uniform(-10, 10, (count, 3)) * size
    return make_shapes(name, level, rng, size, centre)


def spread(rng: np.random.Generator, shape: tuple[int, ...], decades: float) -> Any:
    """Numbers of either sign whose sizes are spread evenly over 10^±decades."""
    return rng.choice([-1, 1], shape) * 10 ** rng.uniform(-decades, decades, shape)


def wide_shapes(name: str, level: str, count: int, seed: int) -> Shapes:
    """As pbrt's Reintersect has them: radii of 10^±4, and coordinates of 10^±8 for one half; the others are within ten
    sizes of the origin.
    """
    rng = np.random.default_rng(seed)
    size = abs(spread(rng, (count, 1), 4))
    far = rng.random((count, 1)) < 0.5
    if name == "stretched triangle":  # pbrt's: every coordinate by itself
        return Shapes(TRIANGLE, level, points=spread(rng, (count, 3, 3), 8))
    centre = np.where(far, spread(rng, (count, 3), 8), rng.uniform(-10, 10, (count, 3)) * size)
    return make_shapes(name, level, rng, size, centre)


def make_shapes(name: str, level: str, rng: np.random.Generator, size: Any, centre: Any) -> Shapes:
    """Primitives of these sizes at these places, a quarter of them along the axes."""
    count, real = len(centre), REAL[level]
    axis = units(rng, count)
    axis[: count // 4] = np.eye(3)[rng.integers(0, 3, count // 4)]
    zero = np.zeros((count, 1))
    if name == "sphere":
        rows = np.hstack([centre, size]).astype(real)
        return Shapes(SPHERE, level, rows, rows[:, :3] - rows[:, 3:], rows[:, :3] + rows[:, 3:])
    if name == "plane":
        return Shapes(PLANE, level, np.hstack([centre, zero, axis, zero]), centre, centre)
    if name == "disc":
        return Shapes(DISC, level, np.hstack([centre, size, axis, zero]), centre - size, centre + size)
    if name == "box":
        low = centre.astype(real)
        high = (centre + size * rng.uniform(0.01, 1, (count, 3))).astype(real)
        return Shapes(BOX, level, None, low, high)
    if name in ("triangle", "polygon", "convex polygon"):
        return _random_faces(name, level, rng, size, centre, axis)
    return _random_cones(name, level, rng, size, centre, axis)


def _random_faces(name: str, level: str, rng: np.random.Generator, size: Any, centre: Any, axis: Any) -> Shapes:
    count, zero, real = len(centre), np.zeros((len(centre), 1)), REAL[level]
    u, v = frame(axis)
    if name == "triangle":
        return Shapes(TRIANGLE, level, points=centre[:, None] + size[:, None] * rng.uniform(-1, 1, (count, 3, 3)))
    turn = np.arange(7) / 7 * 2 * np.pi + rng.uniform(0, 6, (count, 1))
    arm = size * (1 if name == "convex polygon" else rng.uniform(0.2, 1, (count, 7)))
    corners = (
        centre[:, None] + (arm * np.cos(turn))[..., None] * u[:, None] + (arm * np.sin(turn))[..., None] * v[:, None]
    )
    middle = corners.astype(real).astype(float).mean(1)
    return Shapes(POLYGON, level, np.hstack([middle, zero, axis, zero]), points=corners)


# The radius at the top over that at the base.
TOPS = {"cylinder": [1.0], "cone": [0.0, 0.5, 1.5], "pointed cone": [0.0], "truncated cone": [0.5, 1.5]}


def _random_cones(name: str, level: str, rng: np.random.Generator, size: Any, centre: Any, axis: Any) -> Shapes:
    count = len(centre)
    u, v = frame(axis)
    radius, height = size * rng.uniform(0.1, 1, (count, 1)), size * rng.uniform(0.1, 1, (count, 1))
    top = radius * rng.choice(TOPS[name.removeprefix("open ")], (count, 1))
    slope = (top - radius) / height
    rows = np.hstack([centre, radius, u, height, v, slope, axis, top])
    reach = np.maximum(radius, top) * np.sqrt(np.maximum(0, 1 - axis**2))
    ends = np.stack([centre, centre + axis * height])
    shapes = Shapes(CONE, level, rows, ends.min(0) - reach, ends.max(0) + reach)
    shapes.flags = 0 if name.startswith("open ") else CAPPED
    return shapes


def point_on(shapes: Shapes, rng: np.random.Generator, numbers: Any) -> Any:
    """A point on or in each primitive, float64."""
    n = len(numbers)
    if shapes.points is not None:
        weights = rng.dirichlet(np.ones(3), n)
        corners = shapes.points[numbers]
        first = rng.integers(0, corners.shape[1], n) if shapes.kind == POLYGON else np.zeros(n, int)
        middle = corners.mean(1) if shapes.kind == POLYGON else corners[:, 2]
        second = (first + 1) % corners.shape[1]
        return (weights[:, :1] * corners[np.arange(n), first] + weights[:, 1:2] * corners[np.arange(n), second]
                + weights[:, 2:] * middle)  # fmt: skip
    rows = shapes.rows[numbers]
    if shapes.kind == PLANE:
        u, v = frame(rows[:, 4:7])
        spread = 10 * np.maximum(length(rows[:, :3]), 1e-3)[:, None]
        return rows[:, :3] + spread * (u * rng.normal(size=(n, 1)) + v * rng.normal(size=(n, 1)))
    if shapes.kind == DISC:
        u, v = frame(rows[:, 4:7])
        turn, arm = rng.uniform(0, 2 * np.pi, (n, 1)), rows[:, 3:4] * np.sqrt(rng.uniform(0, 1, (n, 1)))
        return rows[:, :3] + arm * (np.cos(turn) * u + np.sin(turn) * v)
    if shapes.kind == SPHERE:
        return rows[:, :3] + 0.99 * rows[:, 3:4] * units(rng, n) * rng.uniform(0, 1, (n, 1))
    if shapes.kind == BOX:
        return shapes.low[numbers] + (shapes.high - shapes.low)[numbers] * rng.uniform(0, 1, (n, 3))
    t, turn, arm = rng.uniform(0.01, 0.99, (n, 1)), rng.uniform(0, 2 * np.pi, (n, 1)), rng.uniform(0, 0.99, (n, 1))
    here = arm * (rows[:, 3:4] + (rows[:, 15:16] - rows[:, 3:4]) * t)
    around = here * (np.cos(turn) * rows[:, 4:7] + np.sin(turn) * rows[:, 8:11])
    return rows[:, :3] + rows[:, 12:15] * rows[:, 7:8] * t + around


def gap(shapes: Shapes, numbers: Any, points: Any) -> Any:
    """How far points on the device are from the primitive's own surface, extended precision; the part is the nearest."""
    p = np.asarray(points, np.longdouble)
    rows = shapes.rows[numbers].astype(np.longdouble)
    if shapes.kind == SPHERE:
        return abs(length(p - rows[:, :3]) - rows[:, 3])
    if shapes.kind in (PLANE, DISC, POLYGON):
        return abs(dot(p - rows[:, :3], unit(rows[:, 4:7])))
    if shapes.kind == BOX:
        low, high = shapes.low[numbers], shapes.high[numbers]
        assert ((p >= low) & (p <= high)).all()
        return np.minimum(abs(p - low), abs(p - high)).min(1)
    if shapes.kind == TRIANGLE:
        a, b, c = np.moveaxis(shapes.points[numbers].astype(np.longdouble), 1, 0)
        return abs(dot(p - a, unit(np.cross(b - a, c - a))))
    q = p - rows[:, :3]
    z = dot(q, rows[:, 12:15])
    side = length(q - z[:, None] * rows[:, 12:15]) - (rows[:, 3] + rows[:, 11] * z)
    side = abs(side) / np.sqrt(1 + rows[:, 11] ** 2)
    return np.minimum(side, np.minimum(abs(z), abs(z - rows[:, 7]))) if shapes.flags & CAPPED else side
