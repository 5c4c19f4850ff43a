"""Pictures of meshes: closed ones of triangles are the solids that they enclose."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pictures import everything, render, same_bits
from test_closed_forms import camera

import feeler

LIT = {
    "image": {"size": (64, 48)},
    "background": [0.3, 0.5, 0.8],
    "lights": [{"point": [3, 5, 4]}],
    "cutoff": 0.02,
    "materials": {
        "glass": {"transmission": [0.9, 0.8, 0.7], "reflection": 0.1, "ior": 1.5, "specular": 0.5, "shininess": 20}
    },
}
FLOOR = {"plane": {"normal": [0, 1, 0], "point": [0, -2, 0]}, "material": {"diffuse": [0.8, 0.4, 0.2], "emission": 0.1}}
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def cubes(*sizes: float, other_diagonal: bool = False) -> dict[str, Any]:
    """One mesh of cubes about the origin, each side in two triangles."""
    vertices = [[x, y, z] for s in sizes for x in (-s, s) for y in (-s, s) for z in (-s, s)]
    triangles = []
    for first in range(0, len(vertices), 8):
        for side in SIDES:
            a, b, c, d = (first + i for i in (side[1:] + side[:1] if other_diagonal else side))
            triangles += [[a, b, c], [a, c, d]]
    return {"mesh": {"vertices": vertices, "triangles": triangles}, "material": "glass"}


@pytest.mark.parametrize("level", ["standard", "reference"])
@pytest.mark.parametrize("other_diagonal", [False, True])
@pytest.mark.parametrize(
    ("view", "strays"),
    [
        (camera((0, 0, 5), fov=10), 0),  # a ray in every row through the diagonals, none near an edge
        (camera((0, 0, 5), fov=35), 16),
        (camera((0, 5, 0), up=(0, 0, 1), fov=35), 18),
        (camera((1, 2, 4), fov=35), 0),
    ],
    ids=["near the axis", "on the axis", "from above", "askew"],
)
def test_a_cube_is_a_box(view: dict[str, Any], strays: int, other_diagonal: bool, level: str) -> None:
    """A shared diagonal is met once. Rays that meet an edge of the cube itself, by symmetry, may take either side."""
    scene = {**LIT, "camera": view}
    mesh = render({**scene, "objects": [cubes(1, other_diagonal=other_diagonal), FLOOR]}, depth=8, level=level)
    solid = {"box": {"low": [-1, -1, -1], "high": [1, 1, 1]}, "material": "glass"}
    box = render({**scene, "objects": [solid, FLOOR]}, depth=8, level=level)
    for kind in ("eye_hits", "reflection", "transmission"):
        assert mesh.stats["rays"][kind] == box.stats["rays"][kind] > 2000
    assert (abs(mesh.pixels - box.pixels) > 1e-4).any(-1).sum() <= strays


@pytest.mark.parametrize(
    "view", [camera((1, 2, 4), fov=35), camera((0, 0.3, 0.1), (0, 0, -1), fov=60)], ids=["out", "in"]
)
def test_shells_within_shells(view: dict[str, Any]) -> None:
    """Three cubes in one mesh, deeper than most rays live: the general kernel keeps as many media as the special one."""
    scene = feeler.Scene({**LIT, "camera": view, "depth": 12, "objects": [cubes(1, 0.8, 0.5), FLOOR]})
    special, general = scene.render(), scene.render(general=True)
    assert special.stats["deepest_level"] > 6
    assert special.stats["features"] != general.stats["features"]
    assert special.stats["rays"] == general.stats["rays"]
    assert same_bits(special.pixels, general.pixels)


# ---- small things


def ball(centre: Any, radius: float, scale: float) -> dict[str, Any]:
    """A closed mesh of 48 x 24 facets on a sphere."""
    turn, tilt = np.arange(48) / 48 * 2 * np.pi, np.arange(1, 24) / 24 * np.pi
    rings = np.stack([np.outer(np.sin(tilt), np.cos(turn)), np.outer(np.cos(tilt), turn * 0 + 1),
                      np.outer(np.sin(tilt), np.sin(turn))], -1).reshape(-1, 3)  # fmt: skip
    vertices = (np.vstack([rings, [[0, 1, 0], [0, -1, 0]]]) * radius + centre) * scale
    triangles = []
    for j in range(48):
        k = (j + 1) % 48
        triangles += [[len(rings), k, j], [len(rings) + 1, 22 * 48 + j, 22 * 48 + k]]
        for i in range(22):
            a, b, c, d = 48 * i + j, 48 * i + k, 48 * i + 48 + j, 48 * i + 48 + k
            triangles += [[a, b, c], [b, d, c]]
    return {"mesh": {"vertices": vertices, "triangles": triangles}, "material": "mirror"}


PLACE = (0.9, 1.4, 1.2)


def tiny(scale: float, radius: float) -> dict[str, Any]:
    """Everything, seen as far as a ball of this radius reaches."""
    scene = everything(scale)
    view = {**scene["camera"], "look_at": [x * scale for x in PLACE], "fov": 150 * radius / 6}
    return {**scene, "camera": view, "objects": [*scene["objects"], ball(PLACE, radius, scale)]}


@pytest.mark.parametrize(("small", "radius"), [(1.0, 0.5), (1e-4, 0.5), (1e-4, 0.005)])
def test_small_things_scaled_by_a_power_of_two(small: float, radius: float) -> None:
    """Products of lengths neither vanish nor overflow: facets down to 3e-8 units, times 2^-40 and 2^40."""
    expected = feeler.Scene(tiny(small, radius)).render().pixels
    assert len(np.unique(expected.reshape(-1, 4), axis=0)) > 500
    assert (expected[..., 3] == 1).sum() > 500
    for exponent in (-40, 40):
        pixels = feeler.Scene(tiny(small * 2.0**exponent, radius)).render().pixels
        assert same_bits(pixels, expected), f"{(pixels != expected).any(-1).sum()} pixels at 2^{exponent}"


@pytest.mark.parametrize("term", ["diffuse", "diffuse_transmission"])
def test_lights_count_where_both_normals_agree(term: str) -> None:
    """A facet seen along its normal, shaded by one that leans 60°: lights between the two planes are on neither side."""
    lean, size = np.radians(60), 9
    corners = [[0, 3, 0], [-3, -3, 0], [3, -3, 0]]
    normal = [np.sin(lean), 0, np.cos(lean)]
    for angle in np.radians([-170, -135, -100, -80, -45, -20, 0, 45, 80, 100, 130, 170]):  # from the facet's normal
        to_light = np.array([np.sin(angle), 0, np.cos(angle)])
        image = render({
            "camera": camera((0, 0, 4), fov=5), "image": {"size": (size, size)}, "lights": [{"directional": list(-to_light)}],
            "objects": [{"triangle": {"corners": corners, "normals": [normal] * 3}, "material": {term: 0.75}}],
            "shadows": False,  # which would hide a mistake
        })  # fmt: skip
        side = 1 if term == "diffuse" else -1
        leaning, facet = side * (to_light @ normal), side * to_light[2]
        expected = 0.75 * leaning if leaning > 0 and facet > 0 else 0
        assert image.pixels[..., 0] == pytest.approx(expected, abs=1e-6), np.degrees(angle)


def test_normals_that_cancel() -> None:
    """Halfway between opposite normals there is none: the triangle's own counts, and no pixel is without a number."""
    corners, normals = [[0, 1, 0], [-2, -1, 0], [2, -1, 0]], [[1, 0, 0], [-1, 0, 0], [-1, 0, 0]]
    image = render({
        "camera": camera((0, 0, 4), fov=20), "image": {"size": (5, 5)}, "lights": [{"directional": [0, 0, -1]}],
        "objects": [{"triangle": {"corners": corners, "normals": normals}, "material": {"diffuse": 0.75}}],
    })  # fmt: skip
    assert np.isfinite(image.pixels).all()
    assert image.pixels[2, 2, 0] == 0.75
