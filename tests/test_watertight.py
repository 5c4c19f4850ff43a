"""Closed shapes have no holes: a ray from inside always meets them (NUMERICS rows 4, 8, 9)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from blocks import WIDTH
from shapes import TRIANGLE, WAYS, Shapes, cross, only, point_on, random_shapes, ray, unit, units

import feeler

ICOSAHEDRON = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
               (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7),
               (9, 8, 1)]  # fmt: skip
MESH = only("TRANSMISSION", "TRIANGLE", "POLYGON", "CONE")


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


def closest(scene: dict[str, Any], origin: Any, direction: Any, way: str) -> Any:
    lanes, options = WAYS[way]
    r = feeler.probe("make_ray", origin, direction, options=MESH + options, lanes=lanes)
    return feeler.probe("closest_hit", scene, r, True, options=MESH + options, lanes=lanes)


def at_edges(rng: np.random.Generator, vertices: Any, edges: Any, count: int) -> Any:
    """Points on edges, a third of them vertices."""
    pick = edges[rng.integers(0, len(edges), count)]
    t = np.where(rng.random((count, 1)) < 1 / 3, 0, rng.uniform(0, 1, (count, 1)))
    return vertices[pick[:, 0]] * (1 - t) + vertices[pick[:, 1]] * t


def mesh_scene(vertices: Any, faces: Any, polygons: bool) -> tuple[dict[str, Any], Any]:
    """The scene of a closed mesh, of triangles or polygons, and its edges."""
    shapes = Shapes(TRIANGLE, "standard", points=vertices[faces])
    if polygons:
        corners = vertices[faces]
        normal = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        zero = np.zeros((len(faces), 1))
        shapes = Shapes(5, "standard", np.hstack([corners.mean(1), zero, normal, zero]), points=corners)
    edges = np.concatenate([faces[:, [i, (i + 1) % faces.shape[1]]] for i in range(faces.shape[1])])
    return shapes.scene(WIDTH), edges


CUBE = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("polygons", [False, True])
@pytest.mark.parametrize(
    ("centre", "radius"), [((0, 0, 0), 1.0), ((148376, 1234, -223423), 2.0), ((1e-3, 2e-3, 0), 1e-3)]
)
def test_closed_meshes_have_no_holes(polygons: bool, centre: tuple[float, ...], radius: float, way: str) -> None:
    """NUMERICS rows 8, 9: rays from inside through edges and vertices (Embree's own test fails at such a place)."""
    rng = np.random.default_rng(31)
    vertices, faces = ball(np.array(centre), radius)
    scene, edges = mesh_scene(vertices, faces, polygons)
    n = 20_000
    origin = (centre + radius * 0.3 * units(rng, n)).astype(np.float32).astype(float)
    hit = closest(scene, origin, unit(at_edges(rng, vertices, edges, n) - origin), way)
    assert (hit.primitive < 0).sum() == 0
    assert (hit.distance > 0).all()


@pytest.mark.parametrize("way", WAYS)
def test_polygons_that_share_edges_have_no_holes(way: str) -> None:
    rng = np.random.default_rng(32)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)]) * 2.0 - 1
    vertices = ((corners * [1, 0.3, 2]) @ turn + [3, -5, 1]).astype(np.float32).astype(float)
    scene, edges = mesh_scene(vertices, CUBE, True)
    n = 100_000
    origin = ((rng.uniform(-0.9, 0.9, (n, 3)) * [1, 0.3, 2]) @ turn + [3, -5, 1]).astype(np.float32).astype(float)
    assert (closest(scene, origin, unit(at_edges(rng, vertices, edges, n) - origin), way).primitive < 0).sum() == 0


@pytest.mark.parametrize("way", WAYS)
def test_two_triangles_of_a_square_share_their_diagonal(way: str) -> None:
    """The known case of NUMERICS row 8, and rays at points of the diagonal."""
    square = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0.0]])
    scene, _ = mesh_scene(square, np.array([[0, 1, 2], [0, 2, 3]]), False)
    rng = np.random.default_rng(33)
    known = np.array([[0.30458447, 0.30458447, -0.9024725]])
    d = np.concatenate([known, unit(rng.uniform(-4.9, 4.9, (20_000, 1)) * [1, 1, 0] - [0, 0, 10])])
    assert (closest(scene, [0, 0, 10.0], d, way).primitive < 0).sum() == 0


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["cylinder", "cone"])
def test_capped_ones_have_no_holes(name: str, way: str) -> None:
    """NUMERICS rows 3, 4: rays from inside at the rims, and parallel to the axis."""
    rng = np.random.default_rng(34)
    shapes = random_shapes(name, "standard", 1000, seed=35)
    n = 100_000
    numbers = rng.integers(0, 1000, n)
    origin = point_on(shapes, rng, numbers)
    rows = shapes.rows[numbers]
    turn = rng.uniform(0, 2 * np.pi, (n, 1))
    top = rng.random((n, 1)) < 0.5
    rim = rows[:, :3] + np.where(top, rows[:, 7:8], 0) * rows[:, 12:15] + np.where(top, rows[:, 15:], rows[:, 3:4]) * (
        np.cos(turn) * rows[:, 4:7] + np.sin(turn) * rows[:, 8:11])  # fmt: skip
    origin = (origin + rows[:, :3] + rows[:, 12:15] * rows[:, 7:8] / 2) / 2  # well inside
    d = np.where(rng.random((n, 1)) < 0.9, unit(rim - origin), rows[:, 12:15] + 1e-20)
    found, _ = cross(shapes, ray("standard", origin, d), numbers, way)
    assert (~found).sum() == 0
