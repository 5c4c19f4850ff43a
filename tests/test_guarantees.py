"""What a picture may not depend on: the unit of length, the names of the axes, where in the world it is, how a light is
written; rays find back the way they came; no surface makes light.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pictures import everything, same_bits
from shapes import (
    BOX,
    CONE,
    DISC,
    LEVELS,
    PLANE,
    SHAPES,
    SPHERE,
    TRIANGLE,
    UNIT,
    Shapes,
    dot,
    length,
    unit,
    units,
)
from targets import SINGLE, Targets, aim, make_targets

import feeler

Change = Callable[[Any], Any]
POINTS = {"eye", "look_at", "point", "centre", "low", "high", "base", "top", "corners", "vertices"}
DIRECTIONS = {"up", "normal", "normals", "directional"}


def changed(scene: Any, point: Change, direction: Change) -> Any:
    """The scene with its points and directions changed, each an array of (..., 3)."""
    if isinstance(scene, list):
        return [changed(item, point, direction) for item in scene]
    if not isinstance(scene, dict):
        return scene
    kinds = {**dict.fromkeys(POINTS, point), **dict.fromkeys(DIRECTIONS, direction)}
    return {key: kinds[key](np.array(value, float)).tolist() if key in kinds else changed(value, point, direction)
            for key, value in scene.items()}  # fmt: skip


def everything_said() -> dict[str, Any]:
    scene = everything()
    scene["camera"]["up"] = [0, 1, 0]
    return scene


@pytest.fixture(scope="module")
def picture() -> Any:
    return feeler.Scene(everything()).render().pixels


def expect_alike(pixels: Any, expected: Any, bound: float = 5e-6) -> None:
    """But for at most one pixel in a thousand: an edge may pass its centre on the other side."""
    difference = abs(pixels.astype(float) - expected).max(-1)
    print(
        f"{(difference > bound).sum()} of {difference.size} pixels flipped, others within {difference[difference <= bound].max():.1e}"
    )
    assert (difference > bound).mean() <= 1e-3


# ---- the unit of length

TWOS = 2.0 ** np.arange(-20, 21)


def test_pictures_in_any_power_of_two(picture: Any) -> None:
    for scale in TWOS:
        assert same_bits(feeler.Scene(everything(scale)).render().pixels, picture), scale


LENGTHS = {SPHERE: [0, 1, 2, 3], PLANE: [0, 1, 2], DISC: [0, 1, 2, 3], BOX: [], 5: [0, 1, 2], CONE: [0, 1, 2, 3, 7, 15]}


def in_every_unit(shapes: Shapes) -> Shapes:
    """The shapes one after the other in each of the units."""
    scale = np.repeat(TWOS, shapes.count)[:, None]
    rows = np.tile(shapes.rows, (len(TWOS), 1))
    if shapes.kind != TRIANGLE:
        rows[:, LENGTHS[shapes.kind]] *= scale
    points = np.tile(shapes.points, (len(TWOS), 1, 1)) * scale[..., None] if shapes.points is not None else None
    low, high = (np.tile(a, (len(TWOS), 1)) * scale for a in (shapes.low, shapes.high))
    many = Shapes(shapes.kind, shapes.level, rows, low, high, points)
    many.flags = shapes.flags
    return many


@pytest.mark.parametrize("kind", SINGLE)
def test_crossings_in_any_power_of_two(kind: str) -> None:
    """Hits, surfaces and starts of the next rays have the same bits."""
    rng = np.random.default_rng(7)
    few = make_targets(kind, "standard", 8, 500)
    count = 2000
    numbers = rng.integers(0, few.count, count)
    origin, direction = aim(few, rng, numbers, few.point_on(rng, numbers))
    many = Targets(in_every_unit(few.shapes))
    numbers = (numbers + few.count * np.arange(len(TWOS))[:, None]).ravel()
    scale = np.repeat(TWOS, count)
    ray = many.ray(np.tile(origin, (len(TWOS), 1)) * scale[:, None], np.tile(direction, (len(TWOS), 1)))
    found, hit = many.meet(ray, numbers)
    surface = many.surface(ray, hit, numbers)
    start = many.spawn(surface, surface.normal)

    def same(values: Any, unit_of: Any = 1.0) -> bool:
        every = (values.T / unit_of).T.reshape(len(TWOS), count, -1)
        return bool(((every == every[20]) | ~found[:count, None]).all())

    assert TWOS[20] == 1
    assert found[:count].mean() > 0.2
    assert same(found)
    assert same(hit[0], scale) and same(hit[2]) and same(hit[3])
    assert same(surface.point, scale) and same(surface.error, scale) and same(surface.normal)
    assert same(start, scale)


# ---- the names of the axes


def turn(a: Any) -> Any:
    """X becomes y, y becomes z, z becomes x."""
    return np.roll(a, 1, -1)


@pytest.mark.parametrize("times", [1, 2])
def test_pictures_with_axes_permuted(times: int, picture: Any) -> None:
    """A sum's order changes with the axes, and so the last bits; nothing else."""
    scene = everything_said()
    for _ in range(times):
        scene = changed(scene, turn, turn)
    expect_alike(feeler.Scene(scene).render().pixels, picture)


def test_pictures_with_two_axes_swapped(picture: Any) -> None:
    """That is seen in a mirror, which turns closed meshes inside out."""

    def swap(a: Any) -> Any:
        return a[..., [1, 0, 2]]

    scene = changed(everything_said(), swap, swap)
    for item in scene["objects"]:
        if "mesh" in item:
            item["mesh"]["triangles"] = [triangle[::-1] for triangle in item["mesh"]["triangles"]]
    expect_alike(feeler.Scene(scene).render().pixels[:, ::-1], picture)


@pytest.mark.parametrize("kind", ["box", "triangle"])
def test_crossings_with_axes_permuted(kind: str) -> None:
    """Boxes and triangles know no order of axes: the distances have the same bits (but where a ray has two components of the
    same, greatest size).
    """
    rng = np.random.default_rng(9)
    one = make_targets(kind, "standard", 10)
    shapes = one.shapes
    points = turn(shapes.points) if shapes.points is not None else None
    other = Targets(Shapes(shapes.kind, "standard", None, turn(shapes.low), turn(shapes.high), points))
    numbers = rng.integers(0, one.count, 50_000)
    origin, direction = aim(one, rng, numbers, one.point_on(rng, numbers))
    found, hit = one.meet(one.ray(origin, direction), numbers)
    again, moved = other.meet(other.ray(turn(origin), turn(direction)), numbers)
    assert found.mean() > 0.5
    assert (found == again).all()
    assert all((a == b)[found].all() for a, b in zip(hit, moved, strict=True))


# ---- where in the world


def dyadic(a: Any) -> Any:
    return np.round(a * 1024) / 1024


@pytest.mark.parametrize("place", [(1e6, -1e6, 1e6), (0, 3e6, 0), (-(2.0**24), 0, 2.0**20)])
def test_a_world_far_away(place: tuple[float, ...], picture: Any) -> None:
    """Coordinates that double holds at both places give the same bits: the scene is packed about an origin of its own. Others
    round by 1e-10 when they are written down, and the picture is alike.
    """
    move = np.array(place)
    near = changed(everything(), dyadic, lambda a: a)
    far = changed(near, lambda a: a + move, lambda a: a)
    assert same_bits(feeler.Scene(far).render().pixels, feeler.Scene(near).render().pixels)
    expect_alike(feeler.Scene(changed(everything(), lambda a: a + move, lambda a: a)).render().pixels, picture)


# ---- how a light is written


def halved(light: dict[str, Any]) -> dict[str, Any]:
    colours = {
        "colour": 1.0,
        **{key: light[key] for key in light.keys() & {"colour", "diffuse", "specular", "ambient"}},
    }
    return {**light, **{key: (np.array(value) / 2).tolist() for key, value in colours.items()}}


def test_a_light_in_two_of_half_its_strength(picture: Any) -> None:
    """Products with halves are exact, and so is the sum of two equal ones; what is added in another order errs by an ulp
    each time.
    """
    scene = everything()
    split = (
        feeler.Scene({**scene, "lights": [halved(light) for light in scene["lights"] for _ in range(2)]})
        .render()
        .pixels
    )
    error = abs(split.astype(float) - picture) / np.maximum(picture, np.finfo(np.float32).tiny)
    print(f"within {error.max() / UNIT['standard']:.1f} u")
    assert (error <= 16 * UNIT["standard"]).all()
    lone = {**scene, "ambient": 0, "lights": [{**scene["lights"][0], "ambient": 0}]}
    lone["materials"] = {**scene["materials"], "lamp": {}}
    del lone["background"]
    one = feeler.Scene(lone).render(general=True).pixels
    two = feeler.Scene({**lone, "lights": [halved(lone["lights"][0])] * 2}).render(general=True).pixels
    assert one.any()
    assert same_bits(two, one)


def test_lights_add_up() -> None:
    scene = everything()
    scene["ambient"] = scene["background"] = 0
    scene["materials"]["lamp"] = {}
    for light in scene["lights"]:
        light.pop("ambient", None)
    both = feeler.Scene(scene).render(general=True).pixels[..., :3].astype(float)
    each = [
        feeler.Scene({**scene, "lights": [light]}).render(general=True).pixels[..., :3].astype(float)
        for light in scene["lights"]
    ]
    assert all(one.any() for one in each)
    assert (abs(sum(each) - both) <= 32 * UNIT["standard"] * both).all()


# ---- reversibility


@pytest.mark.parametrize("level", LEVELS)
def test_refraction_is_reversible(level: str) -> None:
    """Where the ray that came out goes back, it comes out where it came in: by the kernels' own refract."""
    rng = np.random.default_rng(11)
    n = 100_000
    normal = units(rng, n)
    v = units(rng, n)
    v = np.where(dot(v, normal)[:, None] < 0, -v, v)
    eta = np.exp(rng.uniform(np.log(0.1), np.log(10), n))
    there = feeler.probe("refract", v, normal, eta, level=level, options=SHAPES)
    back = feeler.probe("refract", there.direction, -normal, 1 / eta, level=level, options=SHAPES)
    found = there.found != 0
    assert 0.4 < found.mean() < 0.9
    cosines = np.minimum(dot(v, normal), -dot(there.direction, normal))  # the flatter, the less a direction says
    good = found & (cosines > 0.01)
    assert (back.found != 0)[good].all()
    error = length(back.direction - v) * cosines * np.minimum(eta, 1 / eta)
    print(f"{level}: {error[good].max() / UNIT[level]:.1f} u")
    assert error[good].max() < 8 * UNIT[level]


def pass_through(
    targets: Targets, numbers: Any, origin: Any, direction: Any, etas: list[float]
) -> tuple[Any, Any, Any]:
    """Rays on their way through as many surfaces as there are indices; which of them came through."""
    alive = np.ones(len(numbers), bool)
    for eta in etas:
        ray = targets.ray(origin, direction)
        found, hit = targets.meet(ray, numbers)
        s = targets.surface(ray, hit, numbers)
        facing = np.where(dot(s.normal, ray.direction)[:, None] < 0, s.normal, -s.normal)
        t = targets.probe("refract", -ray.direction, facing, eta)
        alive &= found & (t.found != 0)
        origin, direction = targets.spawn(s, -facing), t.direction
    return alive, origin, direction


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "truncated cone"])
def test_rays_through_glass_find_back(kind: str, level: str) -> None:
    """In through one side of a solid and out through another; then the same way back to where it began."""
    rng = np.random.default_rng(13)
    targets = make_targets(kind, level, 14)
    near = np.flatnonzero(length(targets.middle) < 20 * targets.size)
    numbers = near[rng.integers(0, len(near), 20_000)]
    size = targets.size[numbers]
    target = targets.point_on(rng, numbers)
    origin = targets.rounded(target - units(rng, len(numbers)) * 3 * size[:, None])
    direction = unit(target - origin)
    alive, end, out = pass_through(targets, numbers, origin, direction, [1 / 1.5, 1.5])
    again, back, home = pass_through(targets, numbers, end + 0.5 * size[:, None] * out, -out, [1 / 1.5, 1.5])
    both = alive & again
    assert both.mean() > 0.2
    line = origin - back
    off = length(line - home * dot(line, home)[:, None]) / size
    typical = np.quantile(off[both], [0.5, 0.99])
    print(f"{kind}, {level}: {both.sum()} rays, off by {typical[0]:.1e}, 99 % within {typical[1]:.1e} sizes")
    assert typical[0] < 64 * UNIT[level] and typical[1] < 1500 * UNIT[level]


# ---- energy

DARK = [{"point": [4, 6, 5], "colour": 0}]  # so that tests share a kernel


def test_nothing_gains_energy() -> None:
    """Surfaces that send on all of what arrives, and no light but what shines with at most 1: no pixel is above 1."""
    scene = everything()
    scene["materials"] = {
        name: {"reflection": share, "transmission": 1 - share, "ior": ior, "fresnel": fresnel, "total_reflection": share < 0.3}
        for name, (share, ior, fresnel) in {
            "glass": (0.25, 1.5, False), "weighted": (0.5, 1.33, True), "total": (0.125, 1.7, False), "mirror": (1, 1, False),
            "shade": (0.75, 1.1, False), "matte": (0.5, 1.2, False)}.items()} | {"lamp": {"emission": 1}}  # fmt: skip
    scene["materials"]["weighted"].update(reflection=1, transmission=1)  # times F and 1 - F
    scene |= {"ambient": 0, "lights": DARK, "cutoff": 0, "depth": 8}
    for background in (1.0, 0.25):
        image = feeler.Scene({**scene, "background": background}).render(general=True)
        pixels = image.pixels[..., :3].astype(float)
        assert pixels.max() <= 1 + 64 * UNIT["standard"]
        assert pixels.std() > 0.01


def test_a_white_furnace() -> None:
    """Where all shines alike, what is not seen is what was not sent."""
    scene = everything()
    scene["materials"] = {name: {"reflection": 0.25, "transmission": 0.75, "ior": ior, "total_reflection": True}
                          for name, ior in zip(scene["materials"], [1.5, 1.33, 1.7, 1, 1.1, 1.2, 1.4], strict=True)}  # fmt: skip
    scene |= {"ambient": 0, "lights": DARK, "cutoff": 0, "depth": 8, "background": 1}
    image = feeler.Scene(scene).render(general=True)
    seen = image.pixels[..., :3].astype(float).mean()
    unsent = image.stats["discarded_weight"]["mean"]
    print(f"{seen:.6f} seen, {unsent:.6f} not sent")
    assert unsent > 0.01
    assert seen + unsent == pytest.approx(1, abs=64 * UNIT["standard"])
