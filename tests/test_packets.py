"""Many rays by one tree, one ray by many boxes: every way of finding a hit gives the bits of trying each primitive alone."""

from __future__ import annotations

import functools
import operator
from typing import Any

import numpy as np
import pytest
from blocks import WIDTH, mix, renumber, tree_tables
from shapes import FLOAT_FIRST, LEVELS, REAL, Shapes, column, members, only, random_shapes, unit, units

import feeler

KINDS = ["sphere", "disc", "box", "triangle", "polygon", "cylinder", "open cone"]
FEATURES = ("TRANSMISSION", "SPHERE", "DISC", "BOX", "TRIANGLE", "POLYGON", "CONE")
BRUTE, TREE = only(*FEATURES), only(*FEATURES, "TREE")
PLAIN = only("TRANSMISSION", "TRIANGLE")  # for rays, with all that is in one, and boxes
PACKET = 16  # rays that may travel together
STEPS = 3  # hits along a ray, one behind the other

# Lanes, rays among them.
WAYS = [(1, 1), (2, 1), (4, 1), (8, 1), (16, 1), (2, 2), (4, 4), (8, 8), (16, 16)]


def shapes_of(level: str) -> list[Shapes]:
    """Some of each kind about the origin, some of them twice; boxes on a grid, where faces and edges coincide."""
    parts = []
    for seed, name in enumerate(KINDS):
        s = random_shapes(name, level, 11, seed=70 + seed, least=0.2, most=1.5)
        parts.append(move(s, np.random.default_rng(seed), name == "box"))
    return parts


TWICE = np.array([0, 0, 2, 3, 4, 5, 6, 4, 8, 0, 6])  # within a block and across


def move(s: Shapes, rng: np.random.Generator, grid: bool) -> Shapes:
    """The shapes moved near the origin, those of TWICE in the place of others; onto whole numbers where `grid`."""
    target = rng.integers(-2, 3, (s.count, 3)) if grid else rng.uniform(-2, 2, (s.count, 3))
    offset = target - (s.low + s.high) / 2
    rows, points = s.rows.copy(), s.points
    if rows.shape[1]:
        rows[:, :3] += offset
    low, high = s.low + offset, s.high + offset
    if grid:
        low, high = target, target + rng.integers(1, 3, (s.count, 3)) / 2
    points = None if points is None else (points + offset[:, None])[TWICE]
    moved = Shapes(s.kind, s.level, rows[TWICE], low[TWICE], high[TWICE], points)
    moved.flags = s.flags
    return moved


@functools.cache
def scene_of(level: str, size: int) -> tuple[dict[str, Any], Any, Any]:
    """All kinds in blocks of `size`, numbered in no order, and the primitives' boxes as the device has them."""
    parts = shapes_of(level)
    tables = mix([part.scene(size) for part in parts])
    numbers = np.random.default_rng(3).permutation(len(tables["primitives"]))
    boxes = np.concatenate([np.hstack(part.bounds()) for part in parts]).astype(REAL[level]).astype(float)
    placed = np.empty_like(boxes)
    placed[numbers] = boxes
    return renumber(tables, numbers), placed[:, :3], placed[:, 3:]


def make_rays(level: str) -> tuple[Any, Any]:
    """Rays in packets of PACKET, and which of them are active: from one eye, from everywhere, along axes both ways."""
    rng = np.random.default_rng(71)
    n = 24  # packets of each sort
    eye = np.repeat(8 * units(rng, n), PACKET, 0)
    spread = rng.normal(size=(n * PACKET, 3)) * np.repeat(10.0 ** rng.uniform(-4, 0, (n, 1)), PACKET, 0)
    camera = unit(np.repeat(rng.uniform(-1, 1, (n, 3)), PACKET, 0) - eye + spread)
    inside, everywhere = rng.uniform(-2, 2, (n * PACKET, 3)), units(rng, n * PACKET)
    axes = np.repeat(np.eye(3)[rng.integers(0, 3, n)], PACKET, 0)
    ways = axes * rng.choice([1.0, -1.0], (n * PACKET, 1))
    grid = rng.integers(-6, 7, (n * PACKET, 3)) / 2
    nearly = unit(ways + rng.choice([0, -0.0, 1e-3, -1e-3, 1e-12, -1e-12, 1e-25, -1e-25], (n * PACKET, 3)))
    origin = np.concatenate([eye, inside, grid - 6 * ways, inside, grid])
    direction = np.concatenate([camera, everywhere, np.where(ways == 0, rng.choice([0.0, -0.0], ways.shape), ways),
                                nearly, everywhere])  # fmt: skip
    share = np.repeat(rng.choice([0, 0.1, 0.5, 1, 1], len(origin) // PACKET), PACKET)
    return feeler.probe("make_ray", origin, direction, level=level, options=PLAIN), rng.random(len(origin)) < share


def nearest(level: str, r: Any) -> Any:
    """The nearest hit of each ray, by each primitive alone in a block and one lane; ties go to the lower number."""
    scene, _, _ = scene_of(level, 1)
    numbers = scene["block_numbers"][::WIDTH]
    none = (np.finfo(REAL[level]).max, -1, 0, 0)
    h = feeler.probe("traverse_below", scene, column(r), True, none, scene["links"], False, level=level, options=BRUTE)
    assert ((h.primitive == numbers) | (h.primitive == -1)).all()
    order = np.lexsort([np.broadcast_to(numbers, h.distance.shape), h.distance, h.primitive < 0], axis=-1)[:, 0]
    return type(h)(*[part[np.arange(len(order)), order] for part in h])


def beyond(r: Any, h: Any, active: Any) -> tuple[Any, Any]:
    """The rays beyond their hits, and which of them had one."""
    active = active & (h.primitive >= 0)
    return r._replace(least=np.where(active, h.distance, r.least), last=np.where(active, h.primitive, r.last)), active


@functools.cache
def expected(level: str) -> list[tuple[Any, Any, Any, Any]]:
    """Rays, which are active, and their nearest hits, step after step; and a limit for each, some of them the hit's own."""
    rng = np.random.default_rng(72)
    r, active = make_rays(level)
    steps = []
    for _ in range(STEPS):
        h = nearest(level, r)
        own = np.where(h.primitive >= 0, h.distance, 1)
        limit = own * rng.choice([0.5, 1, 1 + 2**-20.0, 2, np.inf], len(own))
        steps.append((r, active, h, limit.astype(REAL[level])))
        r, active = beyond(r, h, active)
    return steps


@pytest.mark.parametrize("level", LEVELS)
def test_the_rays_are_worth_it(level: str) -> None:
    """There are hits and misses, ties between primitives, packets that go both ways, and some that are thinly filled."""
    shares = [(h.primitive[active] >= 0).mean() for _, active, h, _ in expected(level)]
    assert 0.5 < shares[0] < 0.95 and shares[2] > 0.3, shares
    r, active, h, _ = expected(level)[0]
    assert len(np.unique(h.primitive)) > 40
    behind = expected(level)[1][2]
    again = active & (behind.primitive >= 0) & (behind.distance == h.distance)
    assert again.sum() > 100
    assert (behind.primitive > h.primitive)[again].all()
    assert (behind.distance >= h.distance)[active & (behind.primitive >= 0)].all()
    inverse = r.inverse.reshape(-1, PACKET, 3)
    assert ((inverse.min(1) < 0) & (inverse.max(1) > 0)).any(1).mean() > 0.5
    filled = active.reshape(-1, PACKET).sum(1)
    assert all(((filled >= low) & (filled <= high)).sum() > 5 for low, high in [(0, 0), (1, 2), (5, 15), (16, 16)])


OFTEN = [("standard", *way, True) for way in WAYS] + [("standard", *way, False) for way in [(1, 1), (8, 1), (8, 8)]]
OFTEN += [("reference", *way, True) for way in [(1, 1), (8, 1), (4, 4)]]
EVERY = [(level, *way, tree) for level in LEVELS for way in WAYS for tree in (True, False)]


@pytest.mark.parametrize(
    ("level", "lanes", "rays", "tree"),
    [*OFTEN, *[pytest.param(*way, marks=pytest.mark.slow) for way in EVERY if way not in OFTEN]],
)
def test_every_way_finds_the_same(level: str, lanes: int, rays: int, tree: bool) -> None:
    """Nearest hits and whether there is any before a limit, through blocks of one, of three and of eight."""
    options: dict[str, Any] = {"level": level, "lanes": lanes, "options": f"{TREE if tree else BRUTE} -DRAYS={rays}"}
    for size in (1, 3, WIDTH):
        tables, low, high = scene_of(level, size)
        if tree:
            tables = tree_tables(tables, low, high, np.random.default_rng(73))
        for step, (r, active, h, limit) in enumerate(expected(level)):
            found = feeler.probe("traverse", tables, r, active, np.inf, False, **options)
            for name in h._fields:
                same = getattr(found, name) == getattr(h, name)
                assert same[active].all(), (size, step, name, np.flatnonzero(active & ~same)[:5])
            assert (found.primitive[~active] == -1).all()
            blocked = feeler.probe("traverse", tables, r, active, limit, True, **options).primitive >= 0
            assert np.array_equal(blocked, active & (h.primitive >= 0) & (h.distance < limit)), (size, step)


# ---- boxes


def make_boxes(level: str, shape: tuple[int, ...]) -> tuple[Any, Any]:
    """Among the rays, small and large, on the grid and off it, some of them flat, and some nowhere."""
    rng = np.random.default_rng(74)
    middle = np.where(rng.random((*shape, 1)) < 0.5, rng.integers(-3, 4, (*shape, 3)), rng.uniform(-4, 4, (*shape, 3)))
    half = np.where(rng.random((*shape, 1)) < 0.5, rng.choice([0, 0.5, 1], (*shape, 3)), rng.uniform(0, 1, (*shape, 3)))
    nowhere = rng.random((*shape, 1)) < 0.05
    return tuple(np.where(nowhere, np.inf, middle + side * half).astype(REAL[level]) for side in (-1, 1))


def meets(i: Any, least: Any, limit: Any) -> Any:
    return (i[..., 0] <= i[..., 1]) & (i[..., 1] >= least) & (i[..., 0] <= limit)


def beam_of(r: Any, active: Any, rays: int, level: str) -> tuple[Any, dict[str, Any]]:
    """The beams of packets of so many rays, and how to ask them."""
    options: dict[str, Any] = {"level": level, "lanes": rays, "options": PLAIN}
    return feeler.probe("make_beam", r, active, **options), options


@pytest.mark.parametrize("level", FLOAT_FIRST)
@pytest.mark.parametrize("rays", [2, 4, 8, 16])
def test_a_beam_leaves_out_no_box_that_a_ray_meets(rays: int, level: str) -> None:
    rng = np.random.default_rng(75)
    r, active = make_rays(level)
    used = np.repeat(active.reshape(-1, rays).any(1), rays)
    r, active = members(r, operator.itemgetter(used)), active[used]
    packets, boxes = len(active) // rays, 30 * rays
    r = r._replace(
        least=np.where(rng.random(len(active)) < 0.5, 0, rng.uniform(0, 9, len(active))).astype(r.least.dtype)
    )
    low, high = make_boxes(level, (packets, boxes))
    far = rng.uniform(0, 12, (packets, boxes, 1)).astype(low.dtype)
    pick = np.arange(packets)[:, None] * rays + rng.integers(0, rays, (packets, boxes))
    corner = r.origin[pick] + r.direction[pick] * far  # on a ray
    beside = rng.choice([-1, 0, 1], low.shape) * rng.uniform(0, 1, low.shape).astype(low.dtype)
    touching = rng.random((packets, boxes, 1)) < 0.5
    low = np.where(touching, np.minimum(corner, corner + beside), low)
    high = np.where(touching, np.maximum(corner, corner + beside), high)
    limit = np.where(rng.random((packets, 1)) < 0.5, np.finfo(REAL[level]).max, rng.uniform(0, 9, (packets, 1)))
    beam, options = beam_of(r, active, rays, level)
    found = feeler.probe("meet_boxes", column(beam), low, high, limit, **options)
    assert set(np.unique(found)) == {0, (1 << min(rays, WIDTH)) - 1}

    each = feeler.probe("intersect_bounds", column(r), *(np.repeat(x, rays, 0) for x in (low, high)), level=level,
                        options=PLAIN)  # fmt: skip
    met = meets(each, r.least[:, None], np.repeat(limit, rays, 0)) & active[:, None]
    met = met.reshape(packets, rays, -1).any(1)
    assert not (met & (found == 0)).any()
    one_eye = (np.ptp(r.origin.reshape(packets, rays, 3), 1) == 0).all(1)
    spared = (found == 0)[one_eye][~met[one_eye]].mean()
    print(f"{rays} rays, {level}: {met.mean():.3f} of the boxes met, {spared:.3f} of the others spared from one eye")
    assert spared > 0.8
    assert met.sum() > 1000


@pytest.mark.parametrize(("rays", "width"), [(2, 8), (8, 8), (16, 8), (16, 16)])
def test_boxes_side_by_side_are_boxes_alone(rays: int, width: int) -> None:
    """Bit by bit the same answer, and none for lanes beyond a node's children."""
    r, _ = make_rays("standard")
    for first in range(0, len(r.least), 7 * PACKET):
        few = members(r, operator.itemgetter(slice(first, first + rays)))
        beam, options = beam_of(few, True, rays, "standard")
        options["options"] += f" -DWIDTH={width}"
        low, high = make_boxes("standard", (20, rays))
        found = feeler.probe("meet_boxes", beam, low, high, 100.0, **options)
        alone = np.zeros_like(found)
        for k in range(min(rays, width)):
            one = feeler.probe(
                "meet_boxes", beam, *(np.repeat(x[:, k], rays, 0) for x in (low, high)), 100.0, **options
            )
            alone |= np.where(one != 0, np.uint32(1 << k), np.uint32(0))
        assert np.array_equal(found, alone)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("lanes", [1, 8])
def test_a_row_of_boxes_is_met_like_each(lanes: int, level: str) -> None:
    """intersect_rows takes for granted which planes come first; its intervals are those of intersect_bounds. The lanes
    hold the entry k and the next, and the result is lane 0's.
    """
    r, _ = make_rays(level)
    options: dict[str, Any] = {"level": level, "lanes": lanes, "options": f"{PLAIN} -DRAYS=1"}
    first = feeler.probe("near_sides", r.inverse, **options)
    for low, high in zip(*make_boxes(level, (12, WIDTH)), strict=True):
        rows = np.concatenate([low.T.ravel(), high.T.ravel(), np.zeros(WIDTH)])
        found = feeler.probe("intersect_rows", column(r), column(first), rows, np.arange(WIDTH), **options)
        each = feeler.probe("intersect_bounds", column(r), low, high, level=level, options=PLAIN)
        somewhere = np.isfinite(low).all(1)
        assert np.array_equal(found[:, somewhere], each[:, somewhere])
        assert not meets(found[:, ~somewhere], 0, np.finfo(REAL[level]).max).any()
