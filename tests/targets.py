"""What the long suites ask: primitives of one kind as they are, or each in an instance of its own under a random affine
map; closed meshes are groups of triangles. Ranges are pbrt's: radii of 10^±4, coordinates of 10^±8.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from blocks import WIDTH
from shapes import (
    BOX,
    CONE,
    PLANE,
    REAL,
    SHAPES,
    SPHERE,
    TRIANGLE,
    UNIT,
    WAYS,
    Shapes,
    dot,
    length,
    only,
    point_on,
    random_shapes,
    spread,
    unit,
    units,
    wide_shapes,
)

import feeler

ICOSAHEDRON = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
               (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7),
               (9, 8, 1)]  # fmt: skip


def ball(centre: Any, radius: float) -> tuple[Any, Any]:
    """The vertices and triangles of an icosahedron, each face divided in four."""
    g = (1 + np.sqrt(5)) / 2
    v = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1],
         [-g, 0, -1], [-g, 0, 1]]  # fmt: skip
    vertices = list(unit(np.array(v, float)))
    middles: dict[tuple[int, int], int] = {}

    def middle(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(vertices)
            vertices.append(unit((vertices[a] + vertices[b])[None])[0])
        return middles[key]

    triangles = []
    for a, b, c in ICOSAHEDRON:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        triangles += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return (np.array(vertices) * radius + centre).astype(np.float32).astype(float), np.array(triangles)


BALL, FACES = ball(np.zeros(3), 1.0)


def balls(level: str, size: Any, centre: Any) -> Shapes:
    """Closed meshes, the triangles of one after those of another."""
    return Shapes(TRIANGLE, level, points=(centre[:, None] + size[:, None] * BALL)[:, FACES].reshape(-1, 3, 3))


class Targets:
    """Many primitives of one kind, and how rays meet them."""

    options = SHAPES

    def __init__(self, shapes: Shapes) -> None:
        self.shapes, self.level, self.count = shapes, shapes.level, shapes.count
        self.scene = shapes.scene()
        size = (shapes.high - shapes.low).max(1)
        self.middle = (shapes.low + shapes.high) / 2
        self.size = np.where(size > 0, size, np.maximum(length(self.middle), 1e-3))  # a plane has none

    def probe(self, name: str, *arguments: Any, way: str = "alone") -> Any:
        lanes, options = WAYS[way]
        return feeler.probe(name, *arguments, level=self.level, lanes=lanes, options=self.options + options)

    def rounded(self, points: Any) -> Any:
        return np.asarray(points).astype(REAL[self.level]).astype(float)

    def point_on(self, rng: np.random.Generator, numbers: Any) -> Any:
        return point_on(self.shapes, rng, numbers)

    def point_inside(self, rng: np.random.Generator, numbers: Any) -> Any:
        return point_on(self.shapes, rng, numbers)

    def rim(self, rng: np.random.Generator, numbers: Any) -> Any:
        return rim(self.shapes, rng, numbers)

    def depth(self, points: Any, numbers: Any) -> Any:
        """How far points are inside, in units of u times their distance and the shape's size."""
        return depth(self.shapes, points, numbers)

    def ray(self, origin: Any, direction: Any) -> Any:
        return self.probe("make_ray", origin, direction)

    def meet(self, ray: Any, numbers: Any, way: str = "alone") -> tuple[Any, Any]:
        """Whether each ray meets the one of its number, and the hit."""
        if self.shapes.kind == PLANE:
            c = self.probe("intersect_unbounded", self.scene, ray, self.scene["primitives"][numbers])
            return (c.found != 0) & (c.distance > 0), (c.distance, numbers, c.u, c.v)
        none = (np.finfo(REAL[self.level]).max, -1, 0, 0)
        h = self.probe("traverse_below", self.scene, ray, True, none, self.scene["links"][numbers], False, way=way)
        return h.primitive >= 0, tuple(h)

    def surface(self, ray: Any, hit: Any, numbers: Any) -> Any:
        identity = (numbers * 0 + self.shapes.kind, numbers, numbers * 0, numbers * 0 + self.shapes.flags)
        return self.probe("find_surface", self.scene, ray, hit, True, identity)

    def outward(self, surface: Any, numbers: Any) -> Any:
        """The exact surface's normal: of a thin triangle, or near a cone's tip, the device's says too little."""
        if self.shapes.kind == TRIANGLE:
            a, b, c = np.moveaxis(self.shapes.points[numbers].astype(np.longdouble), 1, 0)
            n = np.cross(b - a, c - a)
            return n * np.where(dot(n, surface.normal) < 0, -1, 1)[:, None]
        if self.shapes.kind != CONE:
            return surface.normal.astype(float)
        return cone_normal(self.shapes.rows[numbers], surface.point.astype(float))

    def passes_tip(self, ray: Any, numbers: Any) -> Any:
        """Whether rays pass a cone's tip within 256 u of its size: there, where sides meet, both crossings are one."""
        if self.shapes.kind != CONE:
            return numbers < 0
        rows = self.shapes.rows[numbers]
        tip = rows[:, :3] + rows[:, 12:15] * rows[:, 7:8]
        origin, direction = self.inwards(ray, numbers)
        way = tip - origin
        off = length(way - direction * dot(way, direction)[:, None])
        size = (self.shapes.high - self.shapes.low).max(1)[numbers] + (0 if self.options == SHAPES else length(tip))
        return (rows[:, 15] == 0) & (off < 256 * UNIT[self.level] * size)

    def inwards(self, ray: Any, numbers: Any) -> tuple[Any, Any]:
        return ray.origin.astype(float), ray.direction.astype(float)

    def spawn(self, surface: Any, side: Any) -> Any:
        return self.probe("spawn", surface.point, surface.error, side)


class Placed(Targets):
    """Each `per` neighbours of the shapes, in an instance of their own."""

    options = only("TRANSMISSION", "INSTANCE", "SPHERE", "DISC", "BOX", "TRIANGLE", "POLYGON", "CONE")

    def __init__(self, shapes: Shapes, rng: np.random.Generator, per: int = 1, identity: bool = False) -> None:
        self.shapes, self.level, self.per = shapes, shapes.level, per
        self.count = count = shapes.count // per
        self._place(rng, identity)
        base = shapes.scene(1 if per == 1 else WIDTH)
        blocks = len(base["links"]) // count
        numbers = np.arange(count)
        instances = np.stack([numbers * 0 + 7, numbers, numbers * 0 + 0xFFFFFFFF, numbers * 0], 1)
        roots = count + blocks * numbers
        self.scene = {
            **base,
            "primitives": np.concatenate([instances, base["primitives"]]),
            "links": np.concatenate([np.stack([numbers * 0, numbers + (7 << 29)], 1), base["links"] + [0, count]]),
            "block_numbers": np.concatenate([np.repeat(numbers, WIDTH), base["block_numbers"] + count]),
            "instances": self._rows(),
            "instance_roots": np.stack([roots, roots + blocks, numbers, numbers * 0], 1),
            "count": [0, count, 0, 0],
        }

    def _place(self, rng: np.random.Generator, identity: bool) -> None:
        """Maps as the device has them: the inverse is rounded, and the map is what that is the inverse of."""
        n = self.count
        turns = [np.linalg.qr(rng.normal(size=(n, 3, 3)))[0] for _ in range(2)]
        scales = abs(spread(rng, (n, 1), 4)) * np.exp(rng.uniform(-1.2, 1.2, (n, 3)))
        to_world = (turns[0] * (scales * rng.choice([-1, 1], (n, 1)))[:, None]) @ turns[1]
        offset = np.where(rng.random((n, 1)) < 0.5, spread(rng, (n, 3), 8), rng.uniform(-10, 10, (n, 3)) * scales)
        if identity:
            to_world, offset = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3))
        self.turned = not identity
        self.to_object = self.rounded(np.linalg.inv(to_world))
        self.to_world = np.linalg.inv(self.to_object)
        self.offset = self.rounded(offset)

    def _rows(self) -> Any:
        """As place_group in host/instances.c."""
        low, high = (a.reshape(self.count, self.per, 3) for a in self.shapes.bounds())
        low, high = low.min(1), high.max(1)
        step = 4 * UNIT[self.level]
        reach = np.maximum(abs(low), abs(high))
        way = np.einsum("nij,njk,nkl,nl->ni", abs(self.to_world), abs(self.to_object), abs(self.to_world), reach)
        middle = self._out((low + high) / 2, np.arange(self.count))
        half = np.einsum("nij,nj->ni", abs(self.to_world), (high - low) / 2) + 4 * step * way
        size = 2 * half.max(1, keepdims=True)
        half += step * (size + abs(middle) + half)
        self.middle, self.size = middle, 2 * half.max(1)
        power = 2.0 ** np.floor(np.log2(abs(self.to_object).max((1, 2))))
        flags = np.stack([power * 0 + self.turned, power, 1 / power], 1)
        zero = np.zeros((self.count, 1))
        out = np.concatenate([self.to_world, self.offset[..., None]], 2).reshape(-1, 12)
        back = np.concatenate([self.to_object, flags[..., None]], 2).reshape(-1, 12)
        return np.hstack([out, back, middle - half, zero, middle + half, zero])

    def _out(self, points: Any, numbers: Any) -> Any:
        return np.einsum("nij,nj->ni", self.to_world[numbers], points) + self.offset[numbers]

    def _some(self, rng: np.random.Generator, numbers: Any) -> Any:
        """One primitive of each group."""
        return numbers * self.per + rng.integers(0, self.per, len(numbers))

    def point_on(self, rng: np.random.Generator, numbers: Any) -> Any:
        return self._out(point_on(self.shapes, rng, self._some(rng, numbers)), numbers)

    def point_inside(self, rng: np.random.Generator, numbers: Any) -> Any:
        if self.per == 1:
            return self.point_on(rng, numbers)
        corners = self.shapes.points.reshape(-1, 3)
        some = numbers[:, None] * 3 * self.per + rng.integers(0, 3 * self.per, (len(numbers), 4))
        weights = rng.dirichlet(np.ones(4), len(numbers))
        return self._out((weights[..., None] * corners[some]).sum(1), numbers)

    def rim(self, rng: np.random.Generator, numbers: Any) -> Any:
        return self._out(rim(self.shapes, rng, self._some(rng, numbers)), numbers)

    def depth(self, points: Any, numbers: Any) -> Any:
        back, out = self.to_object[numbers], self.to_world[numbers]
        q = np.einsum("nij,nj->ni", back, points - self.offset[numbers])
        stretch = np.linalg.norm(back, axis=(1, 2)) * np.linalg.norm(out, axis=(1, 2))
        if self.per == 1:
            return depth(self.shapes, q, numbers, length(q)) / stretch
        a, b, c = np.moveaxis(self.shapes.points.reshape(self.count, self.per, 3, 3), 2, 0)
        normals = unit(np.cross(b - a, c - a))
        inside = np.empty(len(q))
        for k in range(self.count):
            mine = numbers == k
            inside[mine] = -(q[mine] @ normals[k].T - dot(normals[k], a[k])).max(1, initial=-np.inf)
        reach = length(self.shapes.points).reshape(self.count, -1).max(1)[numbers]
        return inside / (UNIT[self.level] * reach * stretch)

    def meet(self, ray: Any, numbers: Any, way: str = "alone") -> tuple[Any, Any]:
        none = (np.finfo(REAL[self.level]).max, -1, 0, 0, -1)
        h = self.probe("traverse_below", self.scene, ray, True, none, self.scene["links"][numbers], False, way=way)
        return h.primitive >= 0, tuple(h)

    def outward(self, surface: Any, numbers: Any) -> Any:
        if self.shapes.kind != CONE:
            return surface.normal.astype(float)
        back = self.to_object[numbers]
        points = np.einsum("nij,nj->ni", back, surface.point - self.offset[numbers])
        return unit(np.einsum("nji,nj->ni", back, cone_normal(self.shapes.rows[numbers], points)))

    def inwards(self, ray: Any, numbers: Any) -> tuple[Any, Any]:
        back = self.to_object[numbers]
        origin = np.einsum("nij,nj->ni", back, ray.origin - self.offset[numbers])
        return origin, unit(np.einsum("nij,nj->ni", back, ray.direction.astype(float)))

    def surface(self, ray: Any, hit: Any, numbers: Any) -> Any:
        index = np.maximum(hit[4] - self.count, 0)
        identity = (numbers * 0 + self.shapes.kind, index, numbers * 0, numbers * 0 + self.shapes.flags, numbers)
        return self.probe("find_surface", self.scene, ray, hit, True, identity)


def aim(targets: Targets, rng: np.random.Generator, numbers: Any, target: Any) -> tuple[Any, Any]:
    """Rays at these points: from anywhere (coordinates of 10^±8), from some sizes away, or from up to 1e4 sizes away."""
    count = len(numbers)
    away = np.exp(rng.uniform(np.log(1.2), np.log(1e4), (count, 1)))
    away[1::3] = 3
    origin = target - units(rng, count) * away * targets.size[numbers][:, None]
    origin[::3] = spread(rng, origin[::3].shape, 8)
    origin = targets.rounded(origin)
    way = target - origin
    way[(way == 0).all(1)] = [0, 0, 1]
    return origin, unit(way)


def cone_normal(rows: Any, points: Any) -> Any:
    p = points - rows[:, :3]
    along = np.einsum("ni,ni->n", p, rows[:, 12:15])[:, None] * rows[:, 12:15]
    across = p - along
    with np.errstate(invalid="ignore"):  # on a cylinder's axis there is none: it is no number, and so on no side
        return unit(across / np.maximum(length(across), 1e-300)[:, None] - rows[:, 11:12] * rows[:, 12:15])


def rim(shapes: Shapes, rng: np.random.Generator, numbers: Any) -> Any:
    """Points on edges and vertices, half of each where there are both."""
    n = len(numbers)
    t = np.where(rng.random((n, 1)) < 0.5, 0, rng.uniform(0, 1, (n, 1)))
    if shapes.points is not None:
        corners = shapes.points[numbers]
        first = rng.integers(0, corners.shape[1], n)
        a, b = corners[np.arange(n), first], corners[np.arange(n), (first + 1) % corners.shape[1]]
        return a * (1 - t) + b * t
    if shapes.kind == BOX:
        corner = rng.integers(0, 2, (n, 3)).astype(float)
        corner[np.arange(n), rng.integers(0, 3, n)] += t[:, 0]
        corner = np.where(corner > 1, 2 - corner, corner)
        return shapes.low[numbers] * (1 - corner) + shapes.high[numbers] * corner
    rows = shapes.rows[numbers]
    if shapes.kind == SPHERE:  # its poles
        return rows[:, :3] + rows[:, 3:4] * np.eye(3)[rng.integers(0, 3, n)] * rng.choice([-1, 1], (n, 1))
    turn, top = rng.uniform(0, 2 * np.pi, (n, 1)), rng.random((n, 1)) < 0.5
    if shapes.kind != CONE:
        e = units(rng, n)
        across = unit(np.cross(rows[:, 4:7], e))
        return rows[:, :3] + rows[:, 3:4] * across
    around = np.cos(turn) * rows[:, 4:7] + np.sin(turn) * rows[:, 8:11]
    return rows[:, :3] + np.where(top, rows[:, 7:8] * rows[:, 12:15] + rows[:, 15:] * around, rows[:, 3:4] * around)


def depth(shapes: Shapes, points: Any, numbers: Any, reach: Any = 0) -> Any:
    """How far points are inside of solids, in units of u times their distance from the middle and its from the origin."""
    size = (shapes.high - shapes.low).max(1)[numbers] + reach
    if shapes.kind == BOX:
        inside = np.minimum(points - shapes.low[numbers], shapes.high[numbers] - points).min(1)
    elif shapes.kind == SPHERE:
        inside = shapes.rows[numbers, 3] - length(points - shapes.rows[numbers, :3])
    else:
        rows = shapes.rows[numbers]
        p = points - rows[:, :3]
        x, y, z = (np.einsum("ni,ni->n", p, rows[:, i : i + 3]) for i in (4, 8, 12))
        side = (rows[:, 3] + rows[:, 11] * z - np.hypot(x, y)) / np.sqrt(1 + rows[:, 11] ** 2)
        inside = np.minimum(side, np.minimum(z, rows[:, 7] - z))
    with np.errstate(divide="ignore", invalid="ignore"):  # less than an ulp of its coordinates is no size
        return inside / (UNIT[shapes.level] * size)


SINGLE = ["sphere", "plane", "disc", "box", "triangle", "polygon", "convex polygon", "cylinder", "open cylinder", "pointed cone",
          "truncated cone", "open pointed cone", "open truncated cone"]  # fmt: skip
SOLID = {"sphere", "box", "cylinder", "pointed cone", "truncated cone", "mesh"}
FLAT = {"plane", "disc", "triangle", "stretched triangle", "polygon", "convex polygon"}
MOVED = [name for name in SINGLE if name not in ("plane", "polygon", "open truncated cone")]
KINDS = [*SINGLE, "stretched triangle", "mesh", *(f"{name} in an instance" for name in [*MOVED, "mesh"])]


def make_targets(kind: str, level: str, seed: int, count: int = 2000) -> Targets:
    """Random ones of a kind, such as "cylinder" or "mesh in an instance"."""
    name, placed, _ = kind.partition(" in an instance")
    rng = np.random.default_rng(seed)
    if name == "mesh":
        count //= 40
        near = rng.uniform(-10, 10, (count, 3))
        size = abs(spread(rng, (count, 1), 4)) if not placed else np.ones((count, 1))
        far = (rng.random((count, 1)) < 0.5) & (not placed)
        centre = np.where(far, spread(rng, (count, 3), 8), near * size)
        centre = np.clip(centre, -1e4 * size, 1e4 * size)  # farther away, its triangles have no area in float
        return Placed(balls(level, size, centre), rng, len(FACES), not placed)
    if placed:
        return Placed(random_shapes(name, level, count, seed, 0.1, 10), rng)
    return Targets(wide_shapes(name, level, count, seed))
