"""The shadow terminator of meshes with smooth normals (NUMERICS row 22): by `smooth_terminator`, a sphere of 16 segments is
shaded as the sphere is.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pictures import same_bits
from shapes import dot, unit
from test_closed_forms import camera, eye_rays

import feeler

SIZE = (96, 96)
VIEW = camera((0, 0, 6), fov=22)
LIGHT = unit(np.array([1.0, 0.35, 0.1]))


def globe(segments: int) -> dict[str, Any]:
    """A unit sphere of meridians and parallels, with its own normals."""
    rings = segments // 2
    polar, turn = np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(segments) / segments
    ring = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], 1)
    sides = (np.sin(polar)[:, None, None] * ring + np.cos(polar)[:, None, None] * [0, 1, 0]).reshape(-1, 3)
    vertices = np.concatenate([sides, [[0, 1, 0], [0, -1, 0]]])
    i, j = np.arange(segments), (np.arange(segments) + 1) % segments
    top, bottom = len(vertices) - 2, len(vertices) - 1
    last = (rings - 2) * segments
    triangles = [np.stack([i * 0 + top, j, i], 1), np.stack([i * 0 + bottom, i + last, j + last], 1)]
    for k in range(rings - 2):
        a, b = k * segments, (k + 1) * segments
        triangles += [np.stack([a + i, a + j, b + i], 1), np.stack([a + j, b + j, b + i], 1)]
    return {"vertices": vertices, "triangles": np.concatenate(triangles), "normals": vertices}


def shade(mesh: dict[str, Any], smooth: bool, transform: Any = None, **more: Any) -> feeler.Image:
    item: dict[str, Any] = {"mesh": mesh, "material": {"diffuse": 1}}
    if transform is not None:
        more = {"groups": {"g": [item]}, **more}
        item = {"instance": "g", "transform": transform}
    scene = {"camera": VIEW, "image": {"size": SIZE}, "lights": [{"directional": (-LIGHT).tolist()}], "objects": [item],
             "smooth_terminator": smooth}  # fmt: skip
    return feeler.Scene({**scene, **more}).render()


def sphere_shading() -> tuple[Any, Any]:
    """What the sphere itself has, and where that is near the terminator and well inside of the outline."""
    eye, d = eye_rays(VIEW, SIZE)
    b, c = dot(d, eye), dot(eye, eye) - 1
    square = b * b - c
    q = eye - d * (b + np.sqrt(np.maximum(square, 0)))[..., None]
    return np.maximum(dot(q, LIGHT), 0), (square > 0.3) & (abs(dot(q, LIGHT)) < 0.3)


@pytest.mark.parametrize("place", ["in the world", "in an instance"])
def test_a_coarse_sphere_is_shaded_as_the_sphere(place: str) -> None:
    expected, band = sphere_shading()
    mesh = globe(16)
    at: Any = None
    if place == "in an instance":
        at = [{"scale": [-2, 2, 2]}, {"translate": [0.5, 0, 0]}]
        mesh["vertices"] = mesh["vertices"] / 2 + [0.25, 0, 0]
    without, with_it = (shade(mesh, smooth, at).pixels[..., 0] for smooth in (False, True))
    error = [abs(pixels - expected)[band] for pixels in (without, with_it)]
    sawtooth = [((pixels == 0) & (expected > 0.06) & band).sum() for pixels in (without, with_it)]
    print(f"{place}: greatest {error[0].max():.3f} → {error[1].max():.3f}, mean {error[0].mean():.4f} → {error[1].mean():.4f}, "
          f"wrongly dark {sawtooth[0]} → {sawtooth[1]} of {band.sum()}")  # fmt: skip
    assert sawtooth[0] > 50
    assert sawtooth[1] == 0
    assert error[1].mean() < error[0].mean() / 3
    assert error[1].max() < 0.06


def test_the_same_bits_by_every_way() -> None:
    mesh, more = globe(16), {"lights": [{"point": [3, 1, 1]}, {"directional": [-1, 0.2, -0.4]}]}
    item = {"mesh": mesh, "material": {"diffuse": 0.5, "specular": 0.5}}
    scene = feeler.Scene(
        {"camera": VIEW, "image": {"size": (48, 48)}, "objects": [item], "smooth_terminator": True, **more}
    )
    expected = scene.render(lanes=1, samples=5)
    for way in ({"lanes": 8, "samples": 5}, {"lanes": 16, "samples": 5, "brute_force": True}):
        image = scene.render(**way)
        assert same_bits(image.pixels, expected.pixels), way
        assert image.stats["rays"] == expected.stats["rays"]


def test_only_what_needs_it_has_it() -> None:
    for smooth, asked in ((True, True), (True, False), (False, True)):
        mesh = globe(8) | {"smooth": smooth}
        scene = feeler.Scene(
            {"lights": [{"point": [3, 1, 1]}], "objects": [{"mesh": mesh}], "smooth_terminator": asked}
        )
        assert ("terminator" in scene.info()["features"]) == (smooth and asked)


@pytest.mark.parametrize("seed", range(2))
def test_no_light_comes_in(seed: int) -> None:
    """From within a closed mesh, whatever its normals say, no light outside is seen."""
    rng = np.random.default_rng(seed)
    mesh = globe(16)
    mesh["normals"] = unit(mesh["normals"] + 0.3 * rng.normal(size=mesh["normals"].shape)) * rng.choice([-1, 1])
    scene = {"camera": camera((0, 0, 0.1), (0.3, 0.2, -1), fov=120), "image": {"size": SIZE}, "smooth_terminator": True,
             "lights": [{"directional": (-LIGHT).tolist()}, {"point": [2, 3, 1]}],
             "objects": [{"mesh": mesh, "material": {"diffuse": 1, "ambient": 1}}]}  # fmt: skip
    dark = feeler.Scene(scene).render().pixels
    assert not dark[..., :3].any()
    assert (dark[..., 3] == 1).all()
