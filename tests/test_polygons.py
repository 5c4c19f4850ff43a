"""Polygons of many corners, convex or not, against the even-odd rule in fractions: never a wrong decision, corners and
edges included.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from shapes import FLOAT_FIRST, POLYGON, REAL, SHAPES, Shapes, column, cross_every_way, frame, ray, unit, units

import feeler

CORNERS = range(3, 41)
POLYGONS, RAYS = 6, 30  # of each number of corners; for each polygon


def is_inside(corners: Any) -> bool:
    """Even-odd rule for (0, 0). On a corner or an edge it counts as moved a little up, and right by still less."""
    inside = False
    points = corners.tolist()
    for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1], strict=True):
        if (ay > 0) != (by > 0):
            a, b, c, d = map(Fraction, (ax, ay, bx, by))
            inside ^= a - b * (c - a) / (d - b) > 0
    return inside


def outlines(rng: np.random.Generator, count: int) -> Any:
    """Polygons in a plane within [-1, 1]: stars, some of them convex, and some whose edges cross."""
    turn = np.sort(rng.uniform(0, 2 * np.pi, (POLYGONS, count)))
    arm = rng.uniform(0.1, 1, (POLYGONS, count))
    arm[0] = 1
    star = np.stack([arm * np.cos(turn), arm * np.sin(turn)], -1)
    star[-1] = rng.uniform(-1, 1, (count, 2))
    return star


def targets(rng: np.random.Generator, corners: Any) -> Any:
    """Points about polygons in a plane: anywhere, on edges, at corners."""
    n, count = corners.shape[:2]
    first = rng.integers(0, count, (n, RAYS))
    pick = np.arange(n)[:, None]
    a, b = corners[pick, first], corners[pick, (first + 1) % count]
    t = rng.uniform(0, 1, (n, RAYS, 1))
    sort = rng.integers(0, 3, (n, RAYS, 1))
    return np.where(
        sort == 0, rng.uniform(-1, 1, (n, RAYS, corners.shape[2])), np.where(sort == 1, a, a * (1 - t) + b * t)
    )


@pytest.mark.parametrize("level", FLOAT_FIRST)
def test_on_a_grid(level: str) -> None:
    """Rays along an axis through points of a grid: nothing is rounded, and many pass through corners and edges."""
    inside, on_corners = 0, 0
    for count in CORNERS:
        rng = np.random.default_rng(count)
        axis, forth = count % 3, rng.choice([-1.0, 1.0])
        flat = np.round(outlines(rng, count) * 12)
        at = np.round(targets(rng, flat / 12) * 24) / 2

        def in_space(points: Any, height: float, axis: int = axis) -> Any:
            return np.roll(np.insert(points, 2, height, -1), axis + 1, -1)

        direction = np.roll([0, 0, forth], axis + 1)
        rows = np.hstack([in_space(flat.mean(1), 2), np.zeros((POLYGONS, 1)), np.tile([*direction, 0], (POLYGONS, 1))])
        shapes = Shapes(POLYGON, level, rows, points=in_space(flat, 2))
        numbers = np.repeat(np.arange(POLYGONS), RAYS)
        at = at.reshape(-1, 2)
        found, _ = cross_every_way(shapes, ray(level, in_space(at, 2 - 5 * forth), direction), numbers)
        expected = [is_inside(flat[i] - point) for i, point in zip(numbers, at, strict=True)]
        assert np.array_equal(found, expected), count
        inside += sum(expected)
        on_corners += (flat[numbers] == at[:, None]).all(2).any(1).sum()
    assert inside > 1500
    assert on_corners > 1000


@pytest.mark.parametrize("level", FLOAT_FIRST)
def test_anyhow_turned(level: str) -> None:
    """What is decided is right for the corners as the ray sees them, which are rounded."""
    near = 0
    for count in CORNERS:
        rng = np.random.default_rng(100 + count)
        normal = units(rng, POLYGONS)
        u, v = (x[:, None] for x in frame(normal))
        centre, size = rng.uniform(-10, 10, (POLYGONS, 1, 3)), 10 ** rng.uniform(-2, 2, (POLYGONS, 1, 1))
        flat = outlines(rng, count)
        points, goals = (centre + size * (p[..., :1] * u + p[..., 1:] * v) for p in (flat, targets(rng, flat)))
        zero = np.zeros((POLYGONS, 1))
        shapes = Shapes(POLYGON, level, np.hstack([centre[:, 0], zero, normal, zero]), points=points)
        away = size * 10 ** rng.uniform(0.2, 2, (POLYGONS, RAYS, 1))
        origin = (goals - units(rng, POLYGONS * RAYS).reshape(goals.shape) * away).astype(REAL[level]).astype(float)
        r = ray(level, origin.reshape(-1, 3), unit(goals - origin).reshape(-1, 3))
        numbers = np.repeat(np.arange(POLYGONS), RAYS)
        found, _ = cross_every_way(shapes, r, numbers)
        corners = feeler.probe("apply_shear", column(r), shapes.points[numbers], level=level, options=SHAPES)[..., :2]
        expected = [is_inside(c) for c in corners]
        assert np.array_equal(found, expected), count
        near += (abs(corners).max(2).min(1) < 1e-5 * size.repeat(RAYS)).sum()
    assert near > 1000
