"""`feeler pixel`: the picture's own bits, and every term of (16.20) anew."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pixel_trees import Json, all_rays, near
from shapes import unit

import feeler

# ---- the picture's own bits, and every term

LIGHTS: list[Json] = [
    {"point": [3, 5, 4], "diffuse": [0.5, 0.6, 0.4], "specular": [0.6, 0.5, 0.4], "ambient": [0.1, 0, 0.05]},
    {"directional": [-1, -2, 1], "diffuse": 0.3, "specular": 0.2},
    {"point": [-1, 3, -4], "diffuse": 0.4, "specular": 0.5},
]
MATERIALS: Json = {
    "floor": {"ambient": 0.2, "diffuse": [0.4, 0.5, 0.3], "specular": 0.2, "reflection": 0.3},
    "sheet": {"diffuse": 0.2, "diffuse_transmission": [0.4, 0.3, 0.2], "specular_transmission": [0.2, 0.1, 0.6],
              "transmission": 0.4, "ior": 1.2, "shininess": 12},
    "glass": {"specular": 0.5, "shininess": 40, "transmission": [0.9, 0.8, 0.9], "reflection": 0.9, "ior": 1.5,
              "fresnel": True},
    "lamp": {"emission": [0.5, 0.6, 0.7], "ambient": 0.3},
}  # fmt: skip
CORNERS = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1], [0, 1.4, 0]], float)
PYRAMID = {"vertices": CORNERS, "triangles": np.array([[0, 1, 2], [0, 2, 3], [4, 1, 0], [4, 2, 1], [4, 3, 2], [4, 0, 3]]),
           "smooth": True}  # fmt: skip
WORLD: Json = {
    "camera": {"eye": [1, 3, 7], "look_at": [0, 0.5, 0], "fov": 45},
    "image": {"size": [24, 18]},
    "background": [0.1, 0.2, 0.3],
    "ambient": 0.3,
    "lights": LIGHTS,
    "materials": MATERIALS,
    "groups": {"pair": [{"sphere": {"radius": 0.7}, "material": "glass"},
                        {"cone": {"base": [0, 0.8, 0], "top": [0, 1.6, 0], "base_radius": 0.4}, "material": "lamp"}]},
    "objects": [
        {"plane": {"point": [0, -0.2, 0], "normal": [0, 1, 0]}, "material": "floor"},
        {"mesh": PYRAMID, "material": "glass"},
        {"disc": {"centre": [1.8, 0.8, 0], "normal": [0, 0, 1], "radius": 0.9}, "material": "sheet"},
        {"instance": "pair", "transform": [{"scale": [1, 1.3, 0.8]}, {"translate": [-2, 0.8, 0.5]}]},
    ],
}  # fmt: skip
PLACES = [(4, 8), (6, 5), (10, 8), (12, 10), (17, 8), (18, 9), (3, 15), (22, 1)]


@pytest.fixture(scope="module")
def world() -> feeler.Scene:
    return feeler.Scene(WORLD)


def check_terms(ray: Json) -> None:
    """(16.20) from the vectors that are told: every term of every light."""
    hit, local = ray["hit"], ray["local"]
    material = MATERIALS[hit["material"]]
    v, n = -np.array(ray["direction"]), np.array(hit["shading"])

    def coefficient(name: str) -> Any:
        return np.ones(3) * material.get(name, 0)

    if not local["lights"]:
        return
    ambient = 0.3 + np.array([0.1, 0, 0.05])
    total = coefficient("ambient") * ambient + coefficient("emission")
    assert local["ambient"] == near(coefficient("ambient") * ambient) and local["emission"] == near(
        coefficient("emission")
    )
    for number, light in enumerate(local["lights"]):
        assert light["light"] == number
        source = LIGHTS[number]
        towards = (
            -np.array(source["directional"]) if "directional" in source else np.subtract(source["point"], hit["point"])
        )
        assert light["direction"] == near(unit(towards))
        cosine = np.dot(light["direction"], n)
        assert light["cosine"] == near(cosine)
        assert (light["distance"] is None) == ("directional" in source)
        front, back = [sign * cosine > 0 and sign * np.dot(light["direction"], hit["normal"]) > 0 for sign in (1, -1)]
        assert light["side"] == ("front" if front else "back" if back else "neither")
        way = hit["transmitted"] if back else 2 * np.dot(v, n) * n - v
        share = np.array(light["feeler"]["share"] if light["feeler"] else [0, 0, 0])
        diffuse = coefficient("diffuse_transmission" if back else "diffuse") * source["diffuse"] * abs(cosine) * share
        shine = max(np.dot(way, light["direction"]), 0) if way is not None else 0
        highlight = shine ** material.get("shininess", 10) if shine > 0 else 0
        specular = coefficient("specular_transmission" if back else "specular") * source["specular"] * highlight * share
        assert light["diffuse_transmission" if back else "diffuse"] == pytest.approx(diffuse, rel=1e-5, abs=1e-6)
        assert light["specular_transmission" if back else "specular"] == pytest.approx(specular, rel=1e-4, abs=1e-6)
        assert light["colour"] == pytest.approx(diffuse + specular, rel=1e-4, abs=1e-6)
        blocked = bool(light["feeler"]) and light["feeler"]["blocked_by"] is not None
        assert blocked == (bool(light["feeler"]) and not share.any())
        total = total + diffuse + specular
    assert local["colour"] == pytest.approx(total, rel=1e-4, abs=1e-6)


def check_sent(ray: Json) -> None:
    """(16.12): weights and levels of what is sent on, and the colour that comes back."""
    colour = np.array(ray["local"]["colour"])
    for way in ("reflection", "transmission"):
        sent = ray[way]
        assert sent["weight"] == near(np.multiply(ray["weight"], sent["share"]))
        if sent["sent"]:
            child = sent["ray"]
            assert child["weight"] == sent["weight"] and child["level"] == ray["level"] + 1 and child["kind"] == way
            assert child["direction"] == ray["hit"]["reflected" if way == "reflection" else "transmitted"]
            assert child["origin"] == pytest.approx(ray["hit"]["point"], rel=1e-5, abs=1e-5)
            colour = colour + np.multiply(sent["share"], child["colour"])
    assert ray["colour"] == near(colour)
    assert np.add(ray["origin"], np.multiply(ray["hit"]["distance"], ray["direction"])) == pytest.approx(
        np.array(ray["hit"]["point"]), rel=1e-6, abs=1e-5
    )


@pytest.mark.parametrize("samples", [1, 16])
def test_the_same_as_the_picture(world: feeler.Scene, samples: int) -> None:
    """Bit for bit, by kernels of other lanes; and what is told adds up to it."""
    image = world.render(samples=samples)
    most = 0
    for x, y in PLACES:
        found = world.pixel(x, y, samples=samples).tree
        assert tuple(np.float32(found["colour"])) == tuple(image.pixels[y, x, :3])
        assert np.float32(found["alpha"]) == image.pixels[y, x, 3]
        told = all_rays(found)
        most = max(most, len(told))
        assert len(found["trees"]) == samples
        assert sum(np.array(ray["adds"]) for ray in told) / samples == near(found["colour"])
        assert sum(np.array(tree["colour"]) for tree in found["trees"]) / samples == near(found["colour"])
        assert sum(np.array(part["colour"]) for part in found["made_of"]) == near(found["colour"])
        assert sum(part["share"] for part in found["made_of"]) == near(1)
        kinds = [ray["kind"] for ray in told]
        feelers = [light for ray in told if ray["hit"] for light in ray["local"]["lights"] if light["feeler"]]
        counted = {kind: kinds.count(kind) for kind in ("eye", "reflection", "transmission")}
        assert {**counted, "shadow": len(feelers)} == found["rays"]
        assert sorted(ray["number"] for ray in told) == list(range(len(told)))
        unsent = sum(np.array(ray[way]["weight"]) for ray in told if ray["hit"] for way in ("reflection", "transmission")
                     if not ray[way]["sent"])  # fmt: skip
        assert unsent / samples == near(found["discarded_weight"])
        for ray in told:
            if ray["hit"]:
                check_terms(ray)
                check_sent(ray)
    assert samples == 1 or most > 64  # more than there is room for at first


def test_one_sample_of_many(world: feeler.Scene) -> None:
    every = world.pixel(10, 8, samples=16).tree["trees"]
    for sample in (0, 7, 15):
        one = world.pixel(10, 8, samples=16, sample=sample).tree
        assert one["trees"] == [every[sample]]
        assert sum(np.array(part["colour"]) for part in one["made_of"]) == near(every[sample]["colour"])


def test_all_sides_and_terms_were_met(world: feeler.Scene) -> None:
    """Else the checks above say little."""
    told = [ray for place in PLACES for ray in all_rays(world.pixel(*place, samples=16).tree)]
    lights = [light for ray in told if ray["hit"] for light in ray["local"]["lights"]]
    terms = {key for light in lights for key in light if "iffuse" in key or "pecular" in key if any(light[key])}
    assert terms == {"diffuse", "specular", "diffuse_transmission", "specular_transmission"}
    assert {light["side"] for light in lights} >= {"front", "back"}
    assert any(light["feeler"] and light["feeler"]["blocked_by"] for light in lights)
    met = [ray["hit"]["object"] for ray in told if ray["hit"]]
    assert {(one["number"], one["shape"]) for one in met} == {(0, "plane"), (1, "mesh"), (2, "disc"), (3, "instance")}
    inside = {(one["inside"]["number"], one["inside"]["shape"]) for one in met if "inside" in one}
    assert inside == {(0, "sphere"), (1, "cone")}
    triangles = {one["triangle"] for one in met if "triangle" in one}
    assert len(triangles) > 2 and triangles <= set(range(6))
    assert any(ray["hit"]["normal"] != ray["hit"]["shading"] for ray in told if ray["hit"])
