"""What must never change a picture's bits: work groups, tiles, regions, threads, lanes, specialisation, the tree, scale."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exr import read_exr
from pictures import everything, same_bits

import feeler

LEVELS = ["standard", "reference"]


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    return feeler.Scene(everything())


@pytest.fixture(scope="module")
def picture(scene: feeler.Scene) -> Any:
    """With one sample; uses a lane per work-item."""
    pixels = scene.render().pixels
    assert np.isfinite(pixels).all()
    assert len(np.unique(pixels.reshape(-1, 4), axis=0)) > 500
    return pixels


@pytest.mark.parametrize("work_group", [(1, 1), (8, 8), (16, 4), (5, 3), (48, 1)])
def test_work_groups(scene: feeler.Scene, picture: Any, work_group: tuple[int, int]) -> None:
    assert same_bits(scene.render(work_group=work_group).pixels, picture)


@pytest.mark.parametrize("tile", [1, 37, 500, 100_000])
def test_tiles(scene: feeler.Scene, picture: Any, tile: int) -> None:
    region = (20, 10, 28, 15) if tile == 1 else None
    expected = picture[10:15, 20:28] if region else picture
    assert same_bits(scene.render(tile=tile, region=region).pixels, np.ascontiguousarray(expected))


@pytest.mark.parametrize("region", [(0, 0, 48, 36), (5, 3, 21, 17), (47, 35, 48, 36), (0, 30, 48, 31)])
def test_regions(scene: feeler.Scene, picture: Any, region: tuple[int, int, int, int]) -> None:
    x0, y0, x1, y1 = region
    part = scene.render(region=region, work_group=(4, 4)).pixels
    assert same_bits(part, np.ascontiguousarray(picture[y0:y1, x0:x1]))


# Of odd size, so that the pixels in the middle have samples whose rays go both ways along an axis.
# One tile: how large they are without is a matter of time, and the sum behind a mean of their order.
# One work group: by itself it depends on the lanes and the samples, and each is compiled.
SMALL: dict[str, Any] = {"size": (29, 23), "region": (5, 3, 28, 20), "tile": 100_000, "work_group": (4, 4)}
SAMPLES = (1, 3, 4, 5, 16, 64)
WIDTHS = (1, 2, 4, 8, 16)


def compare_lanes(scenes: list[feeler.Scene], level: str, ways: list[dict[str, Any]], samples: Any = SAMPLES) -> None:
    """Rays that travel together, or one in all lanes, have the bits of rays on their own."""
    for scene in scenes:
        for count in samples:
            expected = scene.render(lanes=1, samples=count, level=level, **SMALL)
            for way in ways:
                image = scene.render(samples=count, level=level, **way, **SMALL)
                assert same_bits(image.pixels, expected.pixels), (way, count)
                for key in ("rays", "discarded_weight", "deepest_level", "truncation_bound"):
                    assert image.stats[key] == expected.stats[key], (way, count, key)


@pytest.fixture(scope="module")
def mixed(scene: feeler.Scene) -> list[feeler.Scene]:
    """Scenes that have every feature: their kernels are the same."""
    return [scene, *(feeler.Scene(random_scene(seed)) for seed in (6, 7))]


@pytest.mark.parametrize(
    ("level", "lanes", "brute_force"), [("standard", 16, False), ("reference", 4, True), ("draft", 8, False)]
)
def test_lanes(mixed: list[feeler.Scene], level: str, lanes: int, brute_force: bool) -> None:
    compare_lanes(mixed, level, [{"lanes": lanes, "brute_force": brute_force}])


def test_every_number_of_lanes() -> None:
    compare_lanes([feeler.Scene(SPECIALISED["matte"])], "standard", [{"lanes": lanes} for lanes in WIDTHS])


@pytest.mark.slow
@pytest.mark.parametrize("level", ["draft", *LEVELS])
def test_every_number_of_lanes_with_everything(mixed: list[feeler.Scene], level: str) -> None:
    ways = [{"lanes": lanes, "brute_force": brute} for lanes in WIDTHS for brute in (False, True)]
    compare_lanes(mixed, level, ways)


BLOCKS = [(2, (2, 1)), (4, (1, 4)), (8, (2, 2)), (8, (4, 2)), (16, (4, 4)), (16, (2, 1))]


def test_several_pixels_of_a_work_item() -> None:
    """The region's edges are no multiples of any."""
    scene = feeler.Scene(SPECIALISED["matte"])
    compare_lanes([scene], "standard", [{"lanes": lanes, "pixels": pixels} for lanes, pixels in BLOCKS])
    tiled = scene.render(lanes=8, pixels=(4, 2), samples=5, **{**SMALL, "tile": 37})
    assert same_bits(tiled.pixels, scene.render(lanes=1, samples=5, **SMALL).pixels)


@pytest.mark.slow
@pytest.mark.parametrize("level", LEVELS)
def test_several_pixels_with_everything(mixed: list[feeler.Scene], level: str) -> None:
    ways = [
        {"lanes": lanes, "pixels": pixels, "brute_force": brute} for lanes, pixels in BLOCKS for brute in (False, True)
    ]
    compare_lanes(mixed, level, ways)


@pytest.mark.parametrize("level", LEVELS)
def test_brute_force_is_the_tree(scene: feeler.Scene, level: str) -> None:
    assert same_bits(scene.render(brute_force=True, level=level).pixels, scene.render(level=level).pixels)


@pytest.mark.parametrize("exponent", [-40, -17, -1, 3, 24, 40])
def test_scaled_by_a_power_of_two(picture: Any, exponent: int) -> None:
    assert same_bits(feeler.Scene(everything(2.0**exponent)).render().pixels, picture)


def test_scaled_in_double(scene: feeler.Scene) -> None:
    expected = scene.render(level="reference").pixels
    for exponent in (-40, 40):
        assert same_bits(feeler.Scene(everything(2.0**exponent)).render(level="reference").pixels, expected)


@pytest.mark.parametrize("threads", [1, 3])
def test_the_program_gives_the_same_bits(cli: Any, tmp_path: Path, picture: Any, threads: int) -> None:
    (tmp_path / "scene.yaml").write_text(json.dumps(everything()))
    environment = {**os.environ, "POCL_MAX_PTHREAD_COUNT": str(threads)}
    done = cli("render", "scene.yaml", "-o", "out.exr", env=environment)
    assert done.returncode == 0, done.stderr
    pixels, _ = read_exr(tmp_path / "out.exr")
    assert same_bits(pixels, np.ascontiguousarray(picture[..., :3]))


def test_a_queue_of_ones_own(scene: feeler.Scene, picture: Any, queue: Any) -> None:
    assert same_bits(scene.render(queue=queue).pixels, picture)


# ---- specialised and general kernels

CAMERA = {"eye": [0, 1, 6], "look_at": [0, 0, 0], "fov": 40}
LIT = {"camera": CAMERA, "image": {"size": [40, 30]}, "background": [0.2, 0.4, 0.6], "lights": [{"point": [3, 5, 4]}]}
FLOOR = {"plane": {"normal": [0, 1, 0], "point": [0, -1, 0]}}

SPECIALISED: dict[str, dict[str, Any]] = {
    "matte": {**LIT, "objects": [{"sphere": {"radius": 1}}, FLOOR]},
    "without shadows": {**LIT, "shadows": False, "objects": [{"sphere": {"radius": 1}}, FLOOR]},
    "glass": {**LIT, "objects": [
        {"sphere": {"radius": 1}, "material": {"transmission": 0.8, "ior": 1.5, "specular": 0.4}},
        {"sphere": {"radius": 0.5}, "material": {"transmission": 0.8, "ior": 1.2}}, FLOOR]},
    "a mirror that asks for Fresnel weights": {**LIT, "objects": [
        {"sphere": {"radius": 1}, "material": {"reflection": 0.5, "fresnel": True, "ior": 1.5}}]},
    "specular transmission with a priority": {**LIT, "shadows": False, "lights": [{"point": [1, 1, -8]}], "objects": [
        {"box": {"low": [-3, -3, -0.9], "high": [3, 3, 3]}, "material": {"transmission": 0.9, "ior": 1.5}},
        {"disc": {"radius": 1, "normal": [0, 0, 1], "centre": [0, 0, -0.89]},
         "material": {"specular_transmission": 0.9, "ior": 1.3, "priority": -1, "shininess": 3}}]},
    "a mirror seen at a grazing angle": {
        "camera": {"eye": [0, 0, 0], "look_at": [0.8, -0.3, 0], "up": [0, 0, 1], "fov": 2e-5}, "image": {"size": [40, 30]},
        "background": [0.2, 0.4, 0.6], "objects": [
            {"plane": {"normal": [0.3, 0.8, 0.1], "point": [-0.03, -0.08, -0.01]},
             "material": {"reflection": 0.5, "emission": 0.1}}]},
}  # fmt: skip


@pytest.mark.parametrize("name", SPECIALISED)
def test_specialised_is_general(name: str) -> None:
    scene = feeler.Scene(SPECIALISED[name])
    special, general = scene.render(), scene.render(general=True)
    assert special.stats["features"] != general.stats["features"]
    assert special.stats["rays"] == general.stats["rays"]
    assert same_bits(special.pixels, general.pixels)


def test_everything_specialised_is_general(scene: feeler.Scene, picture: Any) -> None:
    reference = scene.render(level="reference").pixels
    assert same_bits(scene.render(general=True, level="reference").pixels, reference)


# ---- random scenes


def random_scene(seed: int) -> dict[str, Any]:
    """Primitives of all kinds, with duplicates and triangles that overlap in a plane; all features present."""
    rng = np.random.default_rng(seed)
    base = everything()
    names = list(base["materials"])

    def place() -> list[float]:
        return list(rng.choice([rng.uniform(-2, 2), 0.0, 0.5, 1.0], 3) + rng.uniform(-1, 1, 3) * rng.integers(0, 2))

    objects: list[dict[str, Any]] = []
    for _ in range(6):
        size = float(rng.choice([0.25, 0.5, rng.uniform(0.1, 1)]))
        corner = np.array(place())
        shapes: list[dict[str, Any]] = [
            {"sphere": {"centre": place(), "radius": size}},
            {"disc": {"centre": place(), "normal": list(rng.normal(size=3)), "radius": size}},
            {"box": {"low": list(corner), "high": list(corner + size)}},
            {"cylinder": {"base": list(corner), "top": list(corner + [0, size, 0]), "radius": size / 2}},
            {
                "cone": {
                    "base": list(corner),
                    "top": list(corner + rng.normal(size=3)),
                    "base_radius": size,
                    "capped": False,
                }
            },
            {"triangle": {"corners": [list(corner + [0, *rng.uniform(-1, 1, 2)]) for _ in range(3)]}},
            {"triangle": {"corners": [list(corner + [0, *rng.uniform(-1, 1, 2)]) for _ in range(3)]}},
            {
                "polygon": {
                    "corners": [
                        list(corner + np.array(c) * size) for c in ([0, 0, 0], [1, 0, 0], [0.4, 0.4, 0], [0, 1, 0])
                    ]
                }
            },
        ]
        objects += [{**shape, "material": names[rng.integers(len(names))]} for shape in shapes]
    objects += [{**objects[i], "material": names[rng.integers(len(names))]} for i in rng.integers(0, len(objects), 8)]
    return {
        **base,
        "objects": base["objects"] + objects,
        "camera": {"eye": [0, 0.5, 6], "look_at": [0, 0.5, 0], "fov": 50},
    }


@pytest.mark.parametrize("seed", range(6))
def test_random_scenes(seed: int) -> None:
    """Coplanar triangles, duplicates and coincident faces: the tree is brute force, and no pixel is NaN or infinite."""
    scene = feeler.Scene(random_scene(seed))
    image = scene.render(size=(64, 48))
    assert np.isfinite(image.pixels).all()
    assert (image.pixels >= 0).all()
    brute = scene.render(size=(64, 48), brute_force=True)
    assert brute.stats["rays"] == image.stats["rays"]
    assert same_bits(brute.pixels, image.pixels)


@pytest.mark.parametrize(("samples", "pixels"), [(1, (1, 1)), (33, (1, 1)), (1, (4, 4))])
def test_pixels_without_a_hit(samples: int, pixels: tuple[int, int]) -> None:
    """Pixels are passed over at once where their eye rays meet nothing of the tree, and nowhere else: things are as small as
    pixels, and cameras look along axes, too.
    """
    rng = np.random.default_rng(samples)
    for k in range(12):
        centres = rng.uniform(-1, 1, (6, 3))
        things = [{"sphere": {"centre": c.tolist(), "radius": float(10 ** rng.uniform(-2.5, -0.5))}} for c in centres]
        direction = np.eye(3)[k % 3] if k < 6 else rng.normal(size=3)
        eye = centres[0] + (3 + k) * direction * (-1) ** k
        camera = {"eye": eye.tolist(), "look_at": centres[0].tolist(), "fov": float(rng.uniform(5, 60))}
        camera["up"] = np.eye(3)[(k + 1) % 3].tolist()
        scene = feeler.Scene({"camera": camera, "lights": [{"point": [9, 9, 9]}], "objects": things})
        tree, brute = (
            scene.render(size=(61, 47), samples=samples, pixels=pixels, brute_force=b) for b in (False, True)
        )
        assert same_bits(tree.pixels, brute.pixels)
        assert tree.stats["rays"] == brute.stats["rays"]
        assert tree.stats["rays"]["eye_hits"] > 0
