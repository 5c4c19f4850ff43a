"""Rows 5 and 8 to 11: planes and triangles."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from shapes import REAL, UNIT, column, dot, frame, only, unit, units

import feeler

from .cost import Cost
from .study import DOUBLE, NAIVE, OTHER, ROBUST, Curve, Panel, Study, between

PLANE = only("TRANSMISSION", "PLANE")
TRIANGLE = only("TRANSMISSION", "TRIANGLE")


def round_to(level: str, array: Any) -> Any:
    return np.asarray(array, float).astype(REAL[level]).astype(float)


# ---- row 5

HEIGHTS = [1, 10, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7]


def off_plane(normal: Any, height: float, reach: float, level: str, naive: str) -> float:
    """How far points are off a plane through 0 at the most, for 2000 rays from this height that meet it `reach` away."""
    rng = np.random.default_rng(105)
    count = 2000
    normal = round_to(level, unit(np.array(normal)))
    u, v = frame(normal[None])
    turn = rng.uniform(0, 2 * np.pi, (count, 1))
    d = round_to(level, unit(u * np.cos(turn) + v * np.sin(turn) - normal * (height / reach)))
    options = f"{PLANE} {naive}"
    r = feeler.probe("make_ray", height * normal, d, level=level, options=options)
    c = feeler.probe("intersect_plane", r, [0, 0, 0], normal, 0, level=level, options=options)
    s = feeler.probe("surface_plane", r, c.distance, [0, 0, 0], normal, level=level, options=options)
    hit = (c.found != 0) & (c.distance > 0)
    off = abs(dot(s.point.astype(np.longdouble), unit(normal.astype(np.longdouble))))
    assert naive or (off <= dot(abs(s.normal), s.error))[hit].all(), "not within the stated bound"
    return float(off[hit].max())


def grazing() -> list[Panel]:
    methods = [("o + t d, float", NAIVE, "standard", "-DNAIVE_PLANE"),
               ("o + t d, double", DOUBLE, "reference", "-DNAIVE_PLANE"),
               ("put back, float", ROBUST, "standard", "")]  # fmt: skip

    def off(normal: list[float], height: Any) -> dict[str, list[float]]:
        return {m[1]: [off_plane(normal, height(x), 10 * x, m[2], m[3]) for x in HEIGHTS] for m in methods}

    def curves(values: dict[str, list[float]], claims: dict[str, Any]) -> list[Curve]:
        return [Curve(m[0], m[1], values[m[1]], **claims[m[1]]) for m in methods]

    flat = {kind: {"bound": [UNIT[level] * x for x in HEIGHTS], "fails": [UNIT[level] * x / 16 for x in HEIGHTS]}
            for kind, level in ((NAIVE, "standard"), (DOUBLE, "reference"))}  # fmt: skip
    values = off([0.3, 0.8, 0.2], lambda _: 1.0)
    naive, robust = values[NAIVE], values[ROBUST]
    # A gain of 1.2 to 2.2; and at the end no answer, but in double.
    tilted = {
        NAIVE: {
            "bound": [*(UNIT["standard"] * 10 * x for x in HEIGHTS[:-1]), None],
            "fails": [*(1.1 * r for r in robust[:-1]), 100],
        },
        ROBUST: {"fails": [*(n / 2.5 for n in naive[:-1]), 100]},
        DOUBLE: {
            "bound": [UNIT["reference"] * 10 * x for x in HEIGHTS],
            "fails": [UNIT["reference"] * 2 * x for x in HEIGHTS],
        },
    }
    return [
        Panel("the plane y = 0", "height of the eye, a tenth of the distance", HEIGHTS, "greatest distance from the plane",
              curves(off([0, 1, 0], lambda x: x), {**flat, ROBUST: {"bound": 0}})),
        Panel("a tilted plane, the eye at height 1", "distance / 10", HEIGHTS, "greatest distance from the plane",
              curves(values, tilted)),
    ]  # fmt: skip


# ---- rows 8, 9 and 11: a closed mesh, rays through its edges and vertices

CENTRES = [0.1, 1, 10, 1e2, 1e3, 1e4, 1e5]
MESH_RAYS = 2000


def ball() -> tuple[Any, Any]:
    """The unit icosahedron's vertices and faces, counter-clockwise from outside."""
    g = (1 + np.sqrt(5)) / 2
    v = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g], [g, 0, -1],
         [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]  # fmt: skip
    f = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
         (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]  # fmt: skip
    return unit(np.array(v, float)), np.array(f)


@functools.cache
def count_faces(offset: float, at: str, level: str, naive: str, inside: bool = True) -> Any:
    """How many faces of a closed mesh each ray meets ahead; rays start within, or far outside, and go through a point of an
    edge or through a vertex.
    """
    rng = np.random.default_rng(108)
    vertices, faces = ball()
    middle = offset * unit(np.array([0.6, 0.5, -0.62]))
    vertices = round_to(level, vertices + middle)
    start = middle + (0.3 if inside else 4) * units(rng, MESH_RAYS)
    pick = faces[rng.integers(0, len(faces), MESH_RAYS)]
    t = 0 if at == "vertex" else rng.uniform(0, 1, (MESH_RAYS, 1))
    ends = vertices.astype(np.longdouble)[pick]
    target = ends[:, 0] * (1 - t) + ends[:, 1] * t
    origin = round_to(level, start)
    options = f"{TRIANGLE} {naive}"
    r = feeler.probe("make_ray", origin, unit(target - origin), level=level, options=options)
    corners = np.moveaxis(vertices[faces], 1, 0)
    c = feeler.probe("intersect_triangle", column(r), *corners, 0, level=level, options=options)
    return ((c.found != 0) & (c.distance > 0)).sum(1)


def lost(at: str, level: str, naive: str) -> list[float]:
    return [float(np.mean(count_faces(x, at, level, naive) == 0)) for x in CENTRES]


def mesh_panels(methods: list[tuple[str, str, str, str, dict[str, Any], dict[str, Any]]]) -> list[Panel]:
    """What is claimed is said of rays through edges and of those through vertices."""
    return [
        Panel(f"rays from within a closed mesh through {where}", "distance of the mesh from 0 / radius",
              CENTRES, "rays that leave without a hit",
              [Curve(m[0], m[1], lost(at, m[2], m[3]), **m[claim]) for m in methods], MESH_RAYS)
        for at, where, claim in (("edge", "points of edges", 4), ("vertex", "vertices", 5))
    ]  # fmt: skip


NEAR, FAR = CENTRES.index(1e4), len(CENTRES) - CENTRES.index(1e4)  # how many
NONE: dict[str, Any] = {"bound": 0}


def fewer_far_away(low: float, high: float) -> dict[str, Any]:
    """In double: from `low` to `high`, but where the rays are not so well aimed under half of the least of those."""
    near = between(low, high, NEAR)
    return {"bound": near["bound"] + [low / 2] * FAR, "fails": near["fails"] + [None] * FAR}


def shared_edges() -> list[Panel]:
    some, more = between(0.05, 0.08, len(CENTRES)), between(0.09, 0.16, len(CENTRES))
    return mesh_panels([
        ("Möller–Trumbore, float", NAIVE, "standard", "-DNAIVE_TRIANGLE", some, some),
        ("the same, contracted", NAIVE, "standard", "-DNAIVE_TRIANGLE=2", more, more),
        ("Möller–Trumbore, double", DOUBLE, "reference", "-DNAIVE_TRIANGLE", fewer_far_away(0.05, 0.08), some),
        ("Woop's shear, exact signs", ROBUST, "standard", "", NONE, NONE),
    ])  # fmt: skip


def contraction() -> list[Panel]:
    some = between(0.02, 0.035, len(CENTRES))
    one: dict[str, Any] = {"bound": 2 / MESH_RAYS}  # of all that go through vertices; at most two at any one place
    return mesh_panels([
        ("edges contracted: fma(a, b, −c d)", NAIVE, "standard", "-DNAIVE_EDGES=2", some, one),
        ("edges rounded: a b − c d", OTHER, "standard", "-DNAIVE_EDGES", NONE, NONE),
        ("edges contracted, double", DOUBLE, "reference", "-DNAIVE_EDGES=2", fewer_far_away(0.02, 0.035), one),
        ("Kahan's difference of products", ROBUST, "standard", "", NONE, NONE),
    ])  # fmt: skip


SPACINGS = [2.0**-k for k in range(0, 13, 2)]
CUBE = [(0, 1, 2), (0, 2, 3), (4, 5, 7), (5, 6, 7), (0, 4, 1), (4, 5, 1), (1, 5, 2), (5, 6, 2), (2, 6, 3), (6, 7, 3), (3, 7, 0),
        (7, 4, 0)]  # fmt: skip


def odd_on_a_grid(spacing: float, level: str, naive: str) -> float:
    """Rays along z through a cube whose two faces across them are divided by different diagonals, at places of a grid: those
    that meet an odd number of triangles.
    """
    rng = np.random.default_rng(111)
    square = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    vertices = np.array([[x, y, z] for z in (-1, 1) for x, y in square], float)
    place = rng.integers(-round(1 / spacing), round(1 / spacing) + 1, (MESH_RAYS, 2)) * spacing
    options = f"{TRIANGLE} {naive}"
    origin = np.concatenate([place, np.full((MESH_RAYS, 1), -4)], 1)
    r = feeler.probe("make_ray", origin, [0, 0, 1.0], level=level, options=options)
    counts = np.zeros(MESH_RAYS, int)
    for face in CUBE:
        counts += (
            feeler.probe("intersect_triangle", r, *vertices[list(face)], 0, level=level, options=options).found != 0
        )
    return float(np.mean(counts % 2))


def parity() -> list[Panel]:
    """A ray from outside meets an even number of faces."""
    methods = [("an edge in both triangles, float", NAIVE, "standard", "-DNAIVE_TIES"),
               ("Möller–Trumbore, float", OTHER, "standard", "-DNAIVE_TRIANGLE"),
               ("an edge in both triangles, double", DOUBLE, "reference", "-DNAIVE_TIES"),
               ("an edge in one, float", ROBUST, "standard", "")]  # fmt: skip
    odd = {m[0]: [odd_on_a_grid(x, m[2], m[3]) for x in SPACINGS] for m in methods}
    naive = odd[methods[0][0]]
    grid: dict[str, Any] = {
        NAIVE: {"figures": [0.43, *[None] * 5, 1 / MESH_RAYS]},
        OTHER: {"figures": [0.43, *[None] * 6]},
        DOUBLE: {"bound": naive, "fails": naive},
        ROBUST: {"bound": 0},
    }
    hardly: dict[str, Any] = {"bound": 2 / MESH_RAYS}
    mesh: dict[str, Any] = {
        NAIVE: hardly,
        DOUBLE: hardly,
        OTHER: {"figures": [0.5] * len(CENTRES)},
        ROBUST: {"bound": 0},
    }
    return [
        Panel("rays along an axis through a cube", "grid of the rays / half the cube", SPACINGS,
              "rays that meet an odd number of faces",
              [Curve(m[0], m[1], odd[m[0]], **grid[m[1]]) for m in methods], MESH_RAYS),
        Panel("rays through points of an icosahedron's edges", "distance of the mesh from 0 / radius", CENTRES,
              "rays that meet an odd number of faces",
              [Curve(m[0], m[1], [float(np.mean(count_faces(x, "edge", m[2], m[3], False) % 2)) for x in CENTRES],
                     **mesh[m[1]]) for m in methods], MESH_RAYS),
    ]  # fmt: skip


# ---- row 10

WIDTHS = [1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]


def stray_hits(width: float, level: str, naive: str, clamped: bool, count: int) -> float:
    """Needles of the edges 11.2 and 9.7, `width` across, rays at 0.52 degrees to them from up to 600 away: hits whose point
    on the ray is outside of the triangle's box, padded by 1/1000 of its length.
    """
    rng = np.random.default_rng(110)
    along = units(rng, count)
    side, up = frame(along)
    a = rng.uniform(-300, 300, (count, 3))
    corners = round_to(level, np.stack([a, a + 11.2 * along, a + 9.7 * along + width * side], 1))
    weights = rng.dirichlet(np.ones(3), count)
    target = (weights[..., None] * corners).sum(1) + 2 * width * rng.normal(size=(count, 1)) * side
    tilt = np.radians(0.52)
    turn = rng.uniform(0, 2 * np.pi, (count, 1))
    d = unit(np.cos(tilt) * along + np.sin(tilt) * (np.cos(turn) * side + np.sin(turn) * up))
    origin = round_to(level, target - d * rng.uniform(10, 600, (count, 1)))
    options = f"{TRIANGLE} {naive}"
    r = feeler.probe("make_ray", origin, unit(target - origin), level=level, options=options)
    c = feeler.probe("intersect_triangle", r, *np.moveaxis(corners, 1, 0), 0, level=level, options=options)
    low, high = corners.min(1), corners.max(1)
    if clamped:
        c = feeler.probe("clamp_crossing", r, low, high, c, level=level, options=options)
    at = origin + r.direction.astype(float) * c.distance[:, None].astype(float)
    outside = ((at < low - 0.0112) | (at > high + 0.0112)).any(1)
    return float(np.mean((c.found != 0) & (c.distance > 0) & ~(outside == 0)))


def needles() -> list[Panel]:
    tries = 20_000
    methods = [("Möller–Trumbore, float", NAIVE, "standard", "-DNAIVE_TRIANGLE", False),
               ("Möller–Trumbore, double", DOUBLE, "reference", "-DNAIVE_TRIANGLE", False),
               ("Woop, not clamped, float", OTHER, "standard", "", False),
               ("Woop, clamped to the box, float", ROBUST, "standard", "", True)]  # fmt: skip
    found = {m[0]: [stray_hits(x, m[2], m[3], m[4], tries) for x in WIDTHS] for m in methods}
    thinner = [*found[methods[0][0]][1:], None]  # the thinner, the more
    claims = {NAIVE: {"figures": [*[None] * 6, 0.005], "bound": thinner}, DOUBLE: NONE, OTHER: NONE, ROBUST: NONE}
    return [
        Panel("rays at 0.52° to a needle", "width of the needle, 11.2 long", WIDTHS, "hits outside of its box",
              [Curve(m[0], m[1], found[m[0]], **claims[m[1]]) for m in methods], tries),
    ]  # fmt: skip


def triangle_inputs(rng: np.random.Generator, count: int) -> list[Any]:
    corners = rng.uniform(-1, 1, (3, count, 3))
    weights = rng.dirichlet(np.ones(3), count).T
    origin = 3 * units(rng, count)
    direction = unit((weights[..., None] * corners).sum(0) + 0.3 * units(rng, count) - origin)
    return [*origin.T, *direction.T, *corners[0].T, *corners[1].T, *corners[2].T]


TRIANGLE_CODE = """
crossing c = intersect_triangle(make_ray(IN3(0), IN3(3)), IN3(6), IN3(9), IN3(12), 0);
OUT = c.found ? c.distance : splat(-1);
"""
CLAMP_CODE = """
const ray r = make_ray(IN3(0), IN3(3));
crossing c = intersect_triangle(r, IN3(6), IN3(9), IN3(12), 0);
c = clamp_crossing(r, least_xyz(least_xyz(IN3(6), IN3(9)), IN3(12)), greatest_xyz(greatest_xyz(IN3(6), IN3(9)), IN3(12)), c);
OUT = c.found ? c.distance : splat(-1);
"""
PLANE_CODE = """
const ray r = make_ray(IN3(0), IN3(3));
const vectors n = make_vectors(splat(0.6f), splat(0.8f), splat(0));
const vectors p = make_vectors(splat(0), splat(0), splat(0));
const crossing c = intersect_plane(r, p, n, 0);
const surface s = surface_plane(r, c.distance, p, n);
OUT = s.point.x + s.point.y + s.point.z + s.error.x;
"""
CLAMP_COST = Cost("one ray and one triangle in its box", "-DNAIVE_CLAMP", CLAMP_CODE, triangle_inputs, ("TRIANGLE",))
STUDIES = [
    Study(5, "plane at a grazing angle", "the plane's equation in extended precision", grazing,
          Cost("one ray, one plane and the point on it", "-DNAIVE_PLANE", PLANE_CODE,
               lambda rng, n: triangle_inputs(rng, n)[:6])),
    Study(8, "shared edges", "a closed mesh has no way out", shared_edges,
          Cost("one ray and one triangle", "-DNAIVE_TRIANGLE", TRIANGLE_CODE, triangle_inputs, ("TRIANGLE",))),
    Study(9, "contraction", "a closed mesh has no way out", contraction,
          Cost("one ray and one triangle", "-DNAIVE_EDGES", TRIANGLE_CODE, triangle_inputs, ("TRIANGLE",))),
    Study(10, "needles", "the triangle's own box", needles, CLAMP_COST),
    Study(11, "edges in both triangles", "an even number of faces", parity,
          Cost("one ray and one triangle", "-DNAIVE_TIES", TRIANGLE_CODE, triangle_inputs, ("TRIANGLE",))),
]  # fmt: skip
