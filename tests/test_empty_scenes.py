"""Scenes without objects, without lights, without anything: exactly the background, exactly what shines by itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exr import read_exr

import feeler

SIZE = (9, 7)
EMPTY: dict[str, dict[str, Any]] = {
    "nothing": {},
    "a background": {"background": [1, 0, 0]},
    "lights": {"background": [0.25, 0.5, 2], "lights": [{"point": [1, 2, 3]}, {"directional": [0, -1, 0]}]},
    "no objects": {"objects": []},
    "a camera": {"camera": {"eye": [1, 2, 3], "look_at": [0, 0, 0]}, "background": [0, 0.5, 1], "ambient": 1},
}
SETTINGS: list[dict[str, Any]] = [
    {}, {"general": True}, {"level": "reference"}, {"level": "draft"}, {"brute_force": True}, {"samples": 4},
]  # fmt: skip
VIEWPOINT = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 40\nhither 0.01\nresolution 9 7\n"


def expect_background(pixels: Any, background: Any) -> None:
    assert pixels.shape[:2] == (SIZE[1], SIZE[0])
    assert (pixels[..., :3] == np.array(background, pixels.dtype)).all()


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_without_objects_there_is_the_background(settings: dict[str, Any]) -> None:
    for scene in EMPTY.values():
        image = feeler.Scene(scene).render(size=SIZE, **settings)
        expect_background(image.pixels, scene.get("background", [0, 0, 0]))
        assert (image.pixels[..., 3] == 0).all()
        samples = settings.get("samples", 1)
        assert image.stats["rays"] == {
            "eye": 63 * samples,
            "eye_hits": 0,
            "reflection": 0,
            "transmission": 0,
            "shadow": 0,
        }
        assert image.stats["truncation_bound"] == 0


def test_the_program_renders_empty_scenes(cli: Any, tmp_path: Path) -> None:
    names = []
    for number, scene in enumerate(EMPTY.values()):
        names.append(f"{number}.yaml")
        (tmp_path / names[-1]).write_text(json.dumps(scene))
    done = cli("render", *names, "-o", "{name}.exr", "--size", "9x7", "--stats", "{name}.json")
    assert done.returncode == 0, done.stderr
    for number, scene in enumerate(EMPTY.values()):
        expect_background(read_exr(tmp_path / f"{number}.exr")[0], scene.get("background", [0, 0, 0]))
        assert json.loads((tmp_path / f"{number}.json").read_text())["rays"]["eye_hits"] == 0
        assert cli("info", names[number], "--json").returncode == 0


@pytest.mark.parametrize("background", [None, [0.5, 0.25, 1]])
def test_an_nff_of_a_viewpoint(cli: Any, tmp_path: Path, background: list[float] | None) -> None:
    fill = "" if background is None else "b {} {} {}\n".format(*background)
    (tmp_path / "a.nff").write_text(fill + VIEWPOINT)
    done = cli("render", "a.nff", "-o", "a.exr")
    assert done.returncode == 0, done.stderr
    expect_background(read_exr(tmp_path / "a.exr")[0], background or [0, 0, 0])
    expect_background(feeler.load(tmp_path / "a.nff").render(level="reference").pixels, background or [0, 0, 0])


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_without_lights_there_are_ambient_and_emission(settings: dict[str, Any]) -> None:
    """c_a I_a + I_e, of numbers whose product is exact; every other term is there and has no light to show."""
    material = {"ambient": [0.5, 0.25, 1], "emission": [0.125, 2, 0], "diffuse": 1, "specular": 1, "shininess": 9,
                "diffuse_transmission": 1, "specular_transmission": 1}  # fmt: skip
    scene = {"camera": {"eye": [0, 0, 5], "look_at": [0, 0, 0], "fov": 20}, "ambient": [0.5, 1, 0.25], "background": 3,
             "objects": [{"box": {"low": [-9, -9, -1], "high": [9, 9, 1]}, "material": material}]}  # fmt: skip
    for lights in ({}, {"lights": []}):
        image = feeler.Scene({**scene, **lights}).render(size=SIZE, **settings)
        expect_background(image.pixels, [0.375, 2.25, 0.25])
        assert (image.pixels[..., 3] == 1).all()
        assert image.stats["rays"]["shadow"] == 0
