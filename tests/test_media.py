"""Media and extensions in whole pictures: what a small lamp behind glass, or the lit background, must look like."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pictures import render
from shapes import dot, length
from test_closed_forms import camera, eye_rays, refract

SIZE = (64, 48)
UP = np.array([0, 0, 1.0])


def glass(ior: float, **more: Any) -> dict[str, Any]:
    return {"transmission": 1, "ior": ior, **more}


def layer(low: float, high: float, material: dict[str, Any]) -> dict[str, Any]:
    return {"box": {"low": [-50, -50, low], "high": [50, 50, high]}, "material": material}


def lamp(z: float, radius: float = 1.0) -> dict[str, Any]:
    return {"disc": {"centre": [0, 0, z], "normal": [0, 0, 1], "radius": radius}, "material": {"emission": 1}}


def lands_on_lamp(
    view: dict[str, Any], layers: list[tuple[float, float]], z: float, first: float = 1.0
) -> tuple[Any, Any]:
    """Per pixel, whether a ray bent at each (height, index below it) reaches the lamp, and where that is sure."""
    p, d = eye_rays(view, SIZE)
    p, index = p + 0 * d, first
    for height, below in layers:
        p = p + d * ((height - p[..., 2]) / d[..., 2])[..., None]
        found, d = refract(-d, UP, index / below)
        assert found.all()
        index = below
    p = p + d * ((z - p[..., 2]) / d[..., 2])[..., None]
    away = length(p[..., :2])
    return away < 1, abs(away - 1) > 1e-4


VIEW = camera((0, -3, 3), (0, -0.4, -1), up=(0, 0, 1), fov=35)
A, B = 1.3, 1.8
LAYERS: dict[str, tuple[list[dict[str, Any]], list[tuple[float, float]]]] = {
    "one": ([layer(-2, 0, glass(A))], [(0, A), (-2, 1)]),
    "overlapping": ([layer(-1.5, 0, glass(A)), layer(-2, -1, glass(B, priority=1))], [(0, A), (-1, B), (-2, 1)]),
    "overlapping, the upper wins": ([layer(-1.5, 0, glass(A, priority=1)), layer(-2, -1, glass(B))],
                                    [(0, A), (-1.5, B), (-2, 1)]),
    "nested": ([layer(-3, 0, glass(A)), layer(-2, -1, glass(B))], [(0, A), (-1, B), (-2, A), (-3, 1)]),
    "nested with priorities": ([layer(-3, 0, glass(A, priority=3)), layer(-2, -1, glass(B, priority=4))],
                               [(0, A), (-1, B), (-2, A), (-3, 1)]),
    "hidden": ([layer(-3, 0, glass(A, priority=3)), layer(-2, -1, glass(B))], [(0, A), (-3, 1)]),
    "touching": ([layer(-1, 0, glass(A)), layer(-2, -1, glass(B))], [(0, A), (-1, B), (-2, 1)]),
    "touching, numbered from below": ([layer(-2, -1, glass(B)), layer(-1, 0, glass(A))], [(0, A), (-1, B), (-2, 1)]),
}  # fmt: skip


@pytest.mark.parametrize("where", ["below", "within"])
@pytest.mark.parametrize("name", LAYERS)
def test_parallel_layers(name: str, where: str) -> None:
    """n1 sin a1 = n_k sin a_k, seen by where a lamp appears: under all layers, or within the last."""
    objects, bends = LAYERS[name]
    z = bends[-1][0] + (-1.0 if where == "below" else 0.25)
    path = bends if where == "below" else bends[:-1]
    image = render({"camera": VIEW, "image": {"size": SIZE}, "objects": [*objects, lamp(z)]}, depth=8)
    expected, sure = lands_on_lamp(VIEW, path, z)
    assert 50 < expected.sum() < 2500
    wrong = ((image.pixels[..., 0] > 0.5) != expected) & sure
    assert not wrong.any(), f"{wrong.sum()} pixels"


@pytest.mark.parametrize("nested", [False, True])
def test_the_eye_in_glass(nested: bool) -> None:
    """The eye's own media are found first: rays bend only where they leave."""
    view = camera((0, -0.5, -0.5), (0, 0, -2), up=(0, 1, 0), fov=35)
    objects = [layer(-1, 2, glass(1.5))] + ([layer(-1.5, 3, glass(1.2, priority=-1))] if nested else [])
    image = render({"camera": view, "image": {"size": SIZE}, "objects": [*objects, lamp(-2.5)]})
    bends = [(-1.0, 1.2), (-1.5, 1.0)] if nested else [(-1.0, 1.0)]
    expected, sure = lands_on_lamp(view, bends, -2.5, 1.5)
    assert expected.sum() > 50
    assert not (((image.pixels[..., 0] > 0.5) != expected) & sure).any()


def test_the_eye_below_a_plane() -> None:
    """A plane is a half-space: who is in the water sees glass through it."""
    view = camera((0, -3, -0.4), (0, -0.6, -2), up=(0, 0, 1), fov=50)
    water = {"plane": {"normal": [0, 0, 1]}, "material": glass(A)}
    image = render({"camera": view, "image": {"size": SIZE}, "objects": [water, layer(-2, -1, glass(B)), lamp(-2.5)]})
    expected, sure = lands_on_lamp(view, [(-1.0, B), (-2.0, A)], -2.5, A)
    assert 50 < expected.sum() < 2500
    assert not (((image.pixels[..., 0] > 0.5) != expected) & sure).any()


@pytest.mark.parametrize("where", ["below", "within"])
def test_more_media_than_the_list_takes(where: str) -> None:
    """The eye is in as many as fit, one inside the other: the next one's surface bends too, on both sides."""
    index = [1.1, 1.7, 1.2, 1.6, 1.3, 1.5, 1.4, A]
    objects = [layer(-13.0 + k, 13.0 - k, glass(ior)) for k, ior in enumerate(index)]
    z = -1.75 if where == "within" else -3.0
    objects += [layer(-2, -1, glass(B)), lamp(z)]
    image = render({"camera": VIEW, "image": {"size": SIZE}, "objects": objects})
    bends = [(-1.0, B)] if where == "within" else [(-1.0, B), (-2.0, A)]
    expected, sure = lands_on_lamp(VIEW, bends, z, A)
    assert 50 < expected.sum() < 2500
    assert not (((image.pixels[..., 0] > 0.5) != expected) & sure).any()


@pytest.mark.parametrize("extension", [False, True])
def test_snells_window(extension: bool) -> None:
    """From within glass: the background inside the cone of 41.8103°, the reflection (rho_rg, extended by rho_tg) outside."""
    view = camera((0, 0, 0), (0, 0.01, 1), fov=110)
    material = glass(1.5, transmission=0.6, reflection=0.25, total_reflection=extension)
    box = {"box": {"low": [-1e3, -1e3, -2e3], "high": [1e3, 1e3, 1]}, "material": material}
    scene = {"camera": view, "image": {"size": SIZE}, "background": 1, "objects": [box], "lights": []}
    image = render(scene, cutoff=0.9)  # the first hit's rays alone; their weights are what is discarded
    _, d = eye_rays(view, SIZE)
    angle = np.degrees(np.arccos(d[..., 2]))
    inside, sure = angle < 41.8103, abs(angle - 41.8103) > 1e-3
    assert 200 < inside.sum() < inside.size - 200
    assert sure.all()
    assert image.stats["rays"]["transmission"] == image.stats["rays"]["reflection"] == 0
    assert image.stats["discarded_weight"]["mean"] == pytest.approx(
        (0.85 * inside + (0.85 if extension else 0.25) * ~inside).mean(), rel=1e-5
    )
    sent = render(scene, depth=5, cutoff=0.5)
    assert (abs(sent.pixels[..., 0] - 0.6)[inside] < 1e-6).all()
    if not extension:
        assert sent.stats["rays"]["transmission"] == inside.sum()


def test_a_glass_sphere_hides_nothing() -> None:
    """All light that enters leaves: no total reflection from outside, so that a lit background shows everywhere."""
    scene = {"camera": camera((0, 0, 4), fov=32), "image": {"size": SIZE}, "background": [1, 0.5, 0.25],
             "objects": [{"sphere": {"radius": 1}, "material": glass(1.5)}]}  # fmt: skip
    image = render(scene)
    assert (image.pixels[..., :3] == np.array([1, 0.5, 0.25], np.float32)).all()
    assert image.stats["rays"]["transmission"] == 2 * image.stats["rays"]["eye_hits"]


def test_fresnel_weights() -> None:
    """Red carries the reflected share, green the other, blue both."""
    view = camera((0, -3, 1.5), up=(0, 0, 1), fov=60)
    material = glass(1.5, reflection=[1, 0, 1], transmission=[0, 1, 1], fresnel=True)
    sheet = {"disc": {"normal": [0, 0, 1], "radius": 40}, "material": material}
    pixels = render({"camera": view, "image": {"size": SIZE}, "background": 1, "objects": [sheet]}).pixels
    _, d = eye_rays(view, SIZE)
    eye = np.array(view["eye"])
    hits = (d[..., 2] < 0) & (length(eye - d * (eye[2] / d[..., 2])[..., None]) < 39)
    cos_v = -d[..., 2]
    cos_t = np.sqrt(1 - (1 - cos_v**2) / 2.25)
    share = (
        ((cos_v - 1.5 * cos_t) / (cos_v + 1.5 * cos_t)) ** 2 + ((cos_t - 1.5 * cos_v) / (cos_t + 1.5 * cos_v)) ** 2
    ) / 2
    assert hits.sum() > 500
    assert abs(pixels[..., 0] - share)[hits].max() < 1e-5
    assert abs(pixels[..., 1] - (1 - share))[hits].max() < 1e-5
    assert abs(pixels[..., 2] - 1)[hits].max() < 1e-6


@pytest.mark.parametrize("filtered", [False, True])
def test_filtered_shadows(filtered: bool) -> None:
    """A feeler through two sheets carries the product of their rho_tg; what lets nothing through blocks it."""
    share = np.array([0.5, 0.25, 1])
    sheets = [{"disc": {"centre": [0, 0, z], "normal": [0.1, 0, 1], "radius": 0.5}, "material": glass(1.5, transmission=list(share))}
              for z in (1, 1.5)]  # fmt: skip
    opaque = {"disc": {"centre": [2, 0, 1], "normal": [0, 0, 1], "radius": 0.5}, "material": {}}
    floor = {"disc": {"normal": [0, 0, 1], "radius": 50}, "material": {"diffuse": 1}}
    view = camera((0, -8, 0.9), (1, 0, 0.2), up=(0, 0, 1), fov=30)
    scene = {"camera": view, "image": {"size": SIZE}, "filtered_shadows": filtered, "lights": [{"directional": [0, 0, -1]}],
             "objects": [floor, opaque, *sheets]}  # fmt: skip
    pixels = render(scene).pixels[..., :3]
    eye, d = eye_rays(view, SIZE)
    q = eye - d * (eye[2] / d[..., 2])[..., None]
    on_floor = (d[..., 2] < 0) & (length(q) < 40)
    for z, x in ((1.0, 2.0), (1.0, 0.0), (1.5, 0.0)):  # what the sheets hide from the eye, generously
        p = eye + d * ((z - eye[2]) / np.where(d[..., 2] == 0, 1e-9, d[..., 2]))[..., None]
        on_floor &= abs(dot(p - [x, 0, z], p - [x, 0, z])) > 0.6**2
    radial = length(q[..., :2])
    under_glass, under_opaque = radial < 0.45, length(q[..., :2] - [2, 0]) < 0.49
    free = (radial > 0.55) & (length(q[..., :2] - [2, 0]) > 0.51)
    assert min((on_floor & part).sum() for part in (under_glass, under_opaque, free)) > 5
    assert abs(pixels[on_floor & under_glass] - (share**2 if filtered else 0)).max() < 1e-6
    assert (pixels[on_floor & under_opaque] == 0).all()
    assert abs(pixels[on_floor & free] - 1).max() < 1e-6


# ---- boundaries that another medium hides, and boundaries at one place

SIDE = camera((1.5, 1.2, 5), fov=35)
FLOOR = {"plane": {"normal": [0, 1, 0], "point": [0, -2, 0]}, "material": {"diffuse": [0.8, 0.4, 0.2], "emission": 0.1}}


def solid(low: Any, high: Any, material: str) -> dict[str, Any]:
    return {"box": {"low": list(low), "high": list(high)}, "material": material}


def draw(objects: list[dict[str, Any]], materials: dict[str, Any], level: str = "standard") -> Any:
    scene = {"camera": SIDE, "image": {"size": SIZE}, "background": [0.3, 0.5, 0.8], "lights": [{"point": [3, 5, 4]}],
             "materials": materials, "objects": [*objects, FLOOR], "cutoff": 0.02}  # fmt: skip
    image = render(scene, depth=8, level=level)
    assert len(np.unique(image.pixels.reshape(-1, 4), axis=0)) > 300
    return image


def expect_same(image: Any, expected: Any, tolerance: float = 0.0) -> None:
    assert image.stats["rays"] == expected.stats["rays"]
    wrong = (abs(image.pixels - expected.pixels) > tolerance).any(-1)
    assert not wrong.any(), f"{wrong.sum()} pixels"


def test_where_a_hidden_face_lies_does_not_matter() -> None:
    """Reflections within glass go through the end of a liquid of lower priority as if it were not there."""
    materials = {
        "glass": {"transmission": 0.7, "reflection": 0.4, "ior": 1.5, "priority": 2},
        "liquid": {"transmission": [0.9, 0.5, 0.5], "reflection": 0.4, "ior": 1.33, "priority": 1},
    }
    block = solid((-1, -1, 0), (1, 1, 1), "glass")
    images = [draw([block, solid((-0.8, -0.8, -1), (0.8, 0.8, z), "liquid")], materials) for z in (0.3, 0.7)]
    assert images[0].stats["rays"]["reflection"] > 3000
    expect_same(*images)


@pytest.mark.parametrize("at", [0, 0.25, -0.0, 1 / 3])
def test_two_boxes_that_touch_are_one(at: float) -> None:
    materials = {"glass": {"transmission": 0.9, "reflection": 0.1, "ior": 1.5}}
    whole = draw([solid((-1, -1, -1), (1, 1, 1), "glass")], materials)
    halves = [solid((-1, -1, -1), (1, 1, at), "glass"), solid((-1, -1, at), (1, 1, 1), "glass")]
    for objects in (halves, halves[::-1]):
        expect_same(draw(objects, materials), whole, 1e-6)


@pytest.mark.parametrize("level", ["standard", "reference"])
def test_water_that_fills_a_glass(level: str) -> None:
    """Five walls and the water exactly between them are a block of glass whose hollow water displaces, by priority."""
    glass = {"transmission": 0.9, "ior": 1.5}
    w = 0.8
    walls = [solid(low, high, "glass") for low, high in [
        ((-1, -1, -1), (-w, 1, 1)), ((w, -1, -1), (1, 1, 1)), ((-w, -1, -1), (w, 1, -w)), ((-w, -1, w), (w, 1, 1)),
        ((-w, -1, -w), (w, -w, w))]]  # fmt: skip
    water = solid((-w, -w, -w), (w, 1, w), "water")
    block = solid((-1, -1, -1), (1, 1, 1), "glass")
    expected = draw([block, water], {"glass": glass, "water": {**glass, "ior": 1.33, "priority": 1}}, level)
    for objects in ([*walls, water], [water, *walls]):
        expect_same(draw(objects, {"glass": glass, "water": {**glass, "ior": 1.33}}, level), expected, 1e-5)


@pytest.mark.parametrize("height", [0.0, -1.0, 0.3])
@pytest.mark.parametrize("shape", ["box", "cylinder"])
def test_a_glass_stands_on_a_table(shape: str, height: float) -> None:
    """The table is seen through the glass, as through one that reaches into it; what is below it never is."""
    materials = {"glass": {"transmission": 1, "ior": 1.5}, "table": {"emission": [1, 0.5, 0.25]},
                 "cellar": {"emission": [0, 0, 5]}}  # fmt: skip
    planes = [{"plane": {"normal": [0, 1, 0], "point": [0, height - below, 0]}, "material": material}
              for below, material in ((0, "table"), (0.5, "cellar"))]  # fmt: skip

    def stand(bottom: float) -> Any:
        ends = {"low": [-1, bottom, -1], "high": [1, height + 1, 1]} if shape == "box" else {
            "base": [0, bottom, 0], "top": [0, height + 1, 0], "radius": 1}  # fmt: skip
        view = camera((0.5, height + 2.5, 5), (0, height, 0), fov=35)
        scene = {"camera": view, "image": {"size": SIZE}, "materials": materials}
        return render({**scene, "objects": [{shape: ends, "material": "glass"}, *planes]}, depth=8)

    standing, sunk = stand(height), stand(height - 0.25)
    assert (standing.pixels[..., 2] <= 0.25).all()
    assert standing.stats["rays"]["transmission"] > 700
    assert (standing.pixels != sunk.pixels).any(-1).sum() <= 2  # at the rim of the bottom


# ---- where rays land, to a few roundings: a light under all layers says how far from it, by its cosine

DEPTH, FOOT = -6.0, 1.5  # the floor, and how far above it the light is


def stack_of(rng: np.random.Generator, way: str) -> list[tuple[float, float, float, int]]:
    """Three layers (low, high, index, priority) that touch, overlap, or lie apart or inside one another."""
    index = rng.uniform(1.05, 2.4, 3)
    if way == "touching":
        z = [0.0, *-np.cumsum(rng.uniform(0.2, 1.2, 3))]
        return [(z[i + 1], z[i], index[i], 0) for i in range(3)]
    ends = np.sort(rng.uniform(-4, 0.5, (3, 2)), axis=1)
    return [(*ends[i], index[i], int(p)) for i, p in enumerate(rng.permutation(3))]


def indices_below(layers: list[tuple[float, float, float, int]]) -> list[tuple[float, float]]:
    """Each height where the index changes, from above, and the index below it: of the layers there, the highest priority's."""
    path, before = [], 1.0
    for z in sorted({z for low, high, _, _ in layers for z in (low, high)}, reverse=True):
        here = [(priority, index) for low, high, index, priority in layers if low < z <= high]
        index = max(here)[1] if here else 1.0
        if index != before:
            path.append((z, index))
        before = index
    return path


@pytest.mark.parametrize("where", ["above", "within"])
@pytest.mark.parametrize("way", ["touching", "anyhow"])
@pytest.mark.parametrize("seed", range(4))
def test_layers_obey_snell_end_to_end(seed: int, way: str, where: str) -> None:
    """n_1 sin a_1 = n_k sin a_k through boundaries that touch, overlap or are hidden, from outside and from within glass."""
    rng = np.random.default_rng(seed)
    layers = stack_of(rng, way)
    path = indices_below(layers)
    eye, first = 2.0, 1.0
    if where == "within":
        low, high, _, _ = layers[rng.integers(0, 3)]
        eye = low + (high - low) * rng.uniform(0.3, 0.7)
        first = ([1.0] + [index for z, index in path if z > eye])[-1]
        path = [(z, index) for z, index in path if z < eye]
    view = camera((0, -2, eye), (0.2, -1, eye - 2), up=(0, 0, 1), fov=30)
    objects = [layer(low, high, glass(index, priority=priority)) for low, high, index, priority in layers]
    floor = {"plane": {"normal": [0, 0, 1], "point": [0, 0, DEPTH]}, "material": {"diffuse": 1}}
    scene = {
        "camera": view,
        "image": {"size": SIZE},
        "objects": [*objects, floor],
        "lights": [{"point": [0, 0, DEPTH + FOOT]}],
    }
    pixels = render(scene, depth=8).pixels[..., 0]
    p, d = eye_rays(view, SIZE)
    p, index, passes = p + 0 * d, first, np.ones(d.shape[:2], bool)
    slope = length(d[..., :2])
    for height, below in path:
        p = p + d * ((height - p[..., 2]) / d[..., 2])[..., None]
        found, d = refract(-d, UP, index / below)
        passes &= found & (d[..., 2] < -0.1)  # the flatter, the farther a rounding takes a ray
        d = np.where(passes[..., None], d, -UP)
        index = below
    assert abs(index * length(d[..., :2]) - first * slope)[passes].max() < 1e-12
    p = p + d * ((DEPTH - p[..., 2]) / d[..., 2])[..., None]
    expected = FOOT / np.sqrt(FOOT**2 + (p[..., :2] ** 2).sum(-1))
    assert passes.mean() > 0.3
    error = abs(pixels - expected)[passes].max()
    print(f"{len(path)} bends from {first:.2f}: {error:.1e}")
    assert error < 3e-6


def test_touching_bends_as_overlapping_does() -> None:
    """Two layers that end at the same height, and two that overlap there with a priority, send rays to the same places."""
    floor = {"plane": {"normal": [0, 0, 1], "point": [0, 0, DEPTH]}, "material": {"diffuse": 1}}
    scene = {"camera": VIEW, "image": {"size": SIZE}, "lights": [{"point": [0, 0, DEPTH + FOOT]}]}
    stacks = [
        [layer(-1, 0, glass(A)), layer(-2, -1, glass(B))],
        [layer(-1, 0, glass(A, priority=1)), layer(-2, -0.5, glass(B))],
        [layer(-1.5, 0, glass(A)), layer(-2, -1, glass(B, priority=1))],
    ]
    touching, *others = (render({**scene, "objects": [*stack, floor]}, depth=8).pixels for stack in stacks)
    assert touching[..., 0].std() > 0.05
    assert all(abs(pixels - touching).max() < 1e-6 for pixels in others)
