"""`feeler pixel`: trees that are known by hand, and the picture's own bits."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import unit

import feeler

Json = dict[str, Any]
NO_LIGHT = {"point": [0, 0, 99], "colour": 0}  # or there would be kernels without shadows
TOLERANCE = 2e-6  # of a float near 1, a few operations deep


def near(value: Any) -> Any:
    return pytest.approx(value, rel=TOLERANCE, abs=TOLERANCE)


def pixel(description: Json, eye: Any, look_at: Any, **settings: Any) -> Json:
    """The tree of the one pixel of a picture that looks along a line, by the kernel that serves all these scenes."""
    return look(description, eye, look_at, **settings).tree


def look(description: Json, eye: Any, look_at: Any, depth: int = 4, **settings: Any) -> feeler.Pixel:
    view = {"eye": list(eye), "look_at": list(look_at), "up": [1, 0, 0], "fov": 1}
    scene = feeler.Scene({"camera": view, "image": {"size": [1, 1]}, "lights": [NO_LIGHT], **description})
    return scene.pixel(0, 0, depth=depth, general=True, **settings)


def rays(tree: Json) -> Iterator[Json]:
    """A ray and all that follow from it."""
    yield tree
    for way in ("reflection", "transmission"):
        if tree.get(way, {}).get("sent"):
            yield from rays(tree[way]["ray"])


def all_rays(found: Json) -> list[Json]:
    return [ray for tree in found["trees"] for ray in rays(tree)]


# ---- a mirror that shows a ceiling, which one lamp lights; another is blocked, a third is behind it

SHARE = np.array([0.9, 0.8, 0.7])
DIFFUSE = np.array([0.5, 0.25, 0.125])
LAMP = np.array([0.8, 1.0, 0.6])
AMBIENT = np.array([0.1, 0.3, 0.2])
CEILING = {
    "ambient": 0.5,
    "lights": [
        {"point": [4, 0, -2], "diffuse": LAMP.tolist()},
        {"point": [-4, 0, -2]},
        {"point": [0, 5, -2]},
    ],
    "materials": {
        "mirror": {"reflection": SHARE.tolist()},
        "plaster": {"diffuse": DIFFUSE.tolist(), "ambient": AMBIENT.tolist()},
    },
    "objects": [
        {"disc": {"centre": [0, 0, -2], "normal": [0, 1, 1], "radius": 0.5}, "material": "mirror"},
        {"plane": {"point": [0, 3, 0], "normal": [0, -1, 0]}, "material": "plaster"},
        {"sphere": {"centre": [-2, 1.5, -2], "radius": 0.5}, "material": "plaster"},
    ],
}


def test_a_mirror_a_lamp_and_a_blocker() -> None:
    found = pixel(CEILING, (0, 0, 0), (0, 0, -1))
    (eye,) = found["trees"]
    assert (eye["number"], eye["kind"], eye["level"], eye["sample"]) == (0, "eye", 1, 0)
    assert eye["origin"] == [0, 0, 0] and eye["direction"] == [0, 0, -1] and eye["weight"] == [1, 1, 1]
    hit = eye["hit"]
    assert hit["distance"] == near(2) and hit["point"] == near([0, 0, -2])
    assert (hit["object"]["number"], hit["object"]["shape"], hit["material"]) == (0, "disc", "mirror")
    assert hit["normal"] == near([0, 0.5**0.5, 0.5**0.5]) and hit["shading"] == hit["normal"] and hit["entering"]
    assert hit["reflected"] == near([0, 1, 0])
    assert eye["local"]["colour"] == [0, 0, 0] and eye["adds"] == [0, 0, 0]
    assert eye["reflection"]["share"] == near(SHARE) and eye["reflection"]["weight"] == near(SHARE)
    assert (eye["transmission"]["sent"], eye["transmission"]["unsent"]) == (False, "coefficients")

    ray = eye["reflection"]["ray"]
    assert (ray["number"], ray["kind"], ray["level"]) == (1, "reflection", 2)
    assert ray["origin"] == near([0, 0, -2]) and ray["direction"] == near([0, 1, 0])
    assert ray["hit"]["object"]["number"] == 1 and ray["hit"]["point"] == near([0, 3, -2])
    assert ray["hit"]["normal"] == near([0, -1, 0]) and ray["hit"]["indices"] is None
    free, blocked, behind = ray["local"]["lights"]
    diffuse = DIFFUSE * LAMP * 0.6  # a triangle of 3, 4 and 5
    assert free["direction"] == near([0.8, -0.6, 0]) and free["distance"] == near(5) and free["cosine"] == near(0.6)
    assert (free["side"], free["diffuse"], free["specular"]) == ("front", near(diffuse), [0, 0, 0])
    assert free["feeler"]["length"] == near(5) and free["feeler"]["blocked_by"] is None
    assert free["feeler"]["share"] == [1, 1, 1] and free["feeler"]["origin"] == near([0, 3, -2])
    blocker = blocked["feeler"]["blocked_by"]
    assert (blocker["object"]["number"], blocker["object"]["shape"]) == (2, "sphere")
    assert blocker["distance"] == near(2) and blocked["feeler"]["length"] == near(5)
    assert blocked["feeler"]["share"] == [0, 0, 0] and blocked["colour"] == [0, 0, 0]
    assert (behind["feeler"], behind["no_feeler"], behind["side"]) == (None, "behind", "back")
    assert behind["cosine"] == near(-1)

    local = diffuse + AMBIENT * 0.5
    assert ray["local"]["ambient"] == near(AMBIENT * 0.5) and ray["local"]["colour"] == near(local)
    assert ray["adds"] == near(SHARE * local) and found["colour"] == near(SHARE * local)
    assert ray["colour"] == near(local) and eye["colour"] == near(SHARE * local)
    assert found["rays"] == {"eye": 1, "reflection": 1, "transmission": 0, "shadow": 2}
    most, least = found["made_of"]
    assert (most["term"], most["light"], most["ray"], most["level"]) == ("diffuse", 0, "reflection", 2)
    assert (least["term"], least["object"]["number"]) == ("ambient", 1)
    assert most["colour"] == near(SHARE * diffuse)
    assert most["share"] == near(sum(SHARE * diffuse) / sum(SHARE * local))


@pytest.mark.parametrize(("settings", "why"), [({"depth": 1}, "depth"), ({"cutoff": 0.95}, "cutoff")])
def test_what_is_not_sent(settings: Json, why: str) -> None:
    found = pixel(CEILING, (0, 0, 0), (0, 0, -1), **settings)
    (ray,) = all_rays(found)
    assert (ray["reflection"]["sent"], ray["reflection"]["unsent"]) == (False, why)
    assert ray["reflection"]["weight"] == near(SHARE) and found["discarded_weight"] == near(SHARE)
    assert found["words"][0] == "black, because"
    assert found["words"][-1] == "not sent, by depth or cutoff: rays that weigh 0.9 0.8 0.7 together"


def test_why_is_it_black() -> None:
    """In words: every reason, and nothing that is no reason."""
    dark = {**CEILING, "ambient": 0, "lights": CEILING["lights"][1:]}
    told = look(dark, (0, 0, 0), (0, 0, -1))
    assert told.colour == (0, 0, 0)
    heading, first, second = told.words
    assert heading == "black, because"
    assert first.startswith("  the eye ray meets objects[0] disc 'mirror': there is no ambient light")
    assert second == (
        "  a reflection ray of level 2 meets objects[1] plane 'plaster': there is no ambient light; "
        "lights[0] is blocked by objects[2] sphere 'plaster'; "
        "lights[1] is behind the surface, where the material transmits no light; it neither reflects nor transmits"
    )
    text = str(told)
    assert "lights[0]  blocked by objects[2] sphere 'plaster' at 2 of 5\n" in text
    assert text.endswith("\n".join(told.words))


def test_the_nearest_blocker_counts() -> None:
    """Not whichever is found first, and none that lies beyond the light."""
    heights = [7, 4, 9, 3, 8, 2, 6, 5, 12, 2.5, 30, 11]
    objects = [{"plane": {"normal": [0, 1, 0]}, "material": {"diffuse": 1}}]
    objects += [
        {"disc": {"centre": [0, h, 0], "normal": [0, 1, 0], "radius": 3}, "material": {"diffuse": 1}} for h in heights
    ]
    objects += [{"plane": {"point": [0, 9.5, 0], "normal": [0, -1, 0]}, "material": {"diffuse": 1}}]  # asked first
    lights = [{"point": [0, 10, 0]}, {"point": [0, 1.5, 0]}, {"directional": [0, -1, 0]}]
    found = pixel({"lights": lights, "objects": objects}, (0.5, 1, 0), (0, 0, 0))
    far, near_by, endless = found["trees"][0]["local"]["lights"]
    for light in (far, endless):
        assert light["feeler"]["blocked_by"]["object"]["number"] == 1 + heights.index(2)
        assert light["feeler"]["blocked_by"]["distance"] == near(2)
    assert near_by["feeler"]["blocked_by"] is None and near_by["diffuse"] == near([1, 1, 1])
    assert (far["feeler"]["length"], endless["feeler"]["length"]) == (near(10), None)
    heading, shadow = found["words"][-2:]
    assert heading == "in shadow"
    assert shadow.startswith("  objects[0] plane") and "lights[0,2] are blocked by objects[6] disc" in shadow


GLOSS = {"plane": {"normal": [0, 1, 0]}, "material": {"specular": 1}}


@pytest.mark.parametrize(
    ("eye", "light", "why"),
    [
        ((3, 4, 0), {"point": [10, 5, 0]}, "outside the highlight"),
        ((3, 4, 0), {"point": [-3, 4, 0], "specular": 0}, "coefficients"),
        ((0, 4, 0), {"point": [5, 0, 0]}, "grazing"),
        ((0, 4, 0), {"point": [0, 0, 0]}, "at the light"),
        ((0, 4, 0), {"point": [0, -1, 0]}, "behind"),
    ],
)
def test_why_no_feeler_is_sent(eye: Any, light: Json, why: str) -> None:
    (told,) = pixel({"lights": [light], "objects": [GLOSS]}, eye, (0, 0, 0))["trees"][0]["local"]["lights"]
    assert (told["feeler"], told["no_feeler"], told["colour"]) == (None, why, [0, 0, 0])


def test_without_shadows_there_are_no_feelers() -> None:
    scene = {"shadows": False, "lights": [{"point": [-3, 4, 0]}], "objects": [GLOSS]}
    (told,) = pixel(scene, (3, 4, 0), (0, 0, 0))["trees"][0]["local"]["lights"]
    assert (told["feeler"], told["no_feeler"], told["highlight"]) == (None, "no shadows", near(1))
    assert told["specular"] == told["colour"] == near([1, 1, 1])


# ---- glass

GLASS = {"glass": {"transmission": 0.9, "reflection": 0.25, "ior": 1.5}}
BACKGROUND = np.array([0.2, 0.4, 0.6])


def test_through_a_glass_sphere() -> None:
    """At half its radius: 30 degrees, and within asin(1 / 3)."""
    ball = {"materials": GLASS, "objects": [{"sphere": {"radius": 1}, "material": "glass"}]}
    found = pixel({**ball, "background": BACKGROUND.tolist()}, (0, 0.5, 5), (0, 0.5, 0), depth=3, cutoff=0.3)
    eye = found["trees"][0]
    inside = eye["transmission"]["ray"]
    beyond = inside["transmission"]["ray"]
    assert eye["hit"]["entering"] and eye["hit"]["indices"] == [1, 1.5]
    assert eye["media"] == [] and eye["hit"]["media_behind"] == ["glass"] and inside["media"] == ["glass"]
    cosine = 8**0.5 / 3
    assert -np.dot(eye["hit"]["transmitted"], eye["hit"]["normal"]) == near(cosine)
    assert inside["direction"] == eye["hit"]["transmitted"] and inside["hit"]["distance"] == near(2 * cosine)
    assert not inside["hit"]["entering"] and inside["hit"]["indices"] == [1.5, 1]
    assert inside["hit"]["media_behind"] == [] and beyond["media"] == [] and beyond["hit"] is None
    turned = 2 * (np.pi / 6 - np.arcsin(1 / 3))
    assert beyond["direction"] == near([0, -np.sin(turned), -np.cos(turned)])
    assert beyond["weight"] == near([0.81] * 3) and beyond["adds"] == near(0.81 * BACKGROUND)
    assert beyond["background"] == near(BACKGROUND)
    assert eye["reflection"]["unsent"] == inside["reflection"]["unsent"] == "cutoff"
    assert inside["reflection"]["weight"] == near([0.225] * 3)
    assert found["colour"] == near(0.81 * BACKGROUND) and found["discarded_weight"] == near([0.475] * 3)
    assert [part["term"] for part in found["made_of"]] == ["background"]


@pytest.mark.parametrize("alpha", [False, True])
def test_nothing_is_met(alpha: bool) -> None:
    """Pixels that a picture passes over have their ray, too."""
    ball = {"materials": GLASS, "objects": [{"sphere": {"radius": 1}, "material": "glass"}]}
    found = pixel({**ball, "background": BACKGROUND.tolist()}, (0, 0, 5), (0, 0, 6), alpha=alpha)
    (ray,) = all_rays(found)
    shown = 0 * BACKGROUND if alpha else BACKGROUND
    assert ray["hit"] is None and ray["adds"] == near(shown) and found["colour"] == near(shown) and found["alpha"] == 0
    assert ("the eye ray meets nothing, and the background is left out" in "".join(found["words"])) == alpha


def test_total_reflection_from_within() -> None:
    """The eye is in the glass; at 43.5 degrees nothing leaves it."""
    cube = {"materials": GLASS, "objects": [{"box": {"low": [-1, -1, -1], "high": [1, 1, 1]}, "material": "glass"}]}
    found = pixel(cube, (0, 0, 0), (0, 0.95, -1), depth=2)
    eye = found["trees"][0]
    assert eye["media"] == ["glass"] and eye["hit"]["total_reflection"] and eye["hit"]["transmitted"] is None
    assert eye["transmission"] == {"share": [0, 0, 0], "weight": [0, 0, 0], "sent": False, "unsent": "total reflection"}
    ray = eye["reflection"]["ray"]
    assert ray["direction"] == near(unit(np.array([0, 0.95, 1]))) and ray["weight"] == near([0.25] * 3)
    assert ray["media"] == ["glass"] and ray["hit"]["total_reflection"]
    assert ray["reflection"]["unsent"] == "depth"
    assert any("reflects totally" in line for line in found["words"])


def test_hidden_and_touching_boundaries() -> None:
    """Ice in water is not there for the eye where the water's priority is higher; what touches is one boundary."""

    def layer(low: float, high: float, name: str) -> Json:
        return {"box": {"low": [-9, -9, low], "high": [9, 9, high]}, "material": name}

    media = {"water": {"transmission": 1, "ior": 1.25, "priority": 2}, "ice": {"transmission": 1, "ior": 1.5}}
    objects = [layer(-4, 0, "water"), layer(-3, -2, "ice"), layer(-5, -4, "ice")]
    found = pixel({"materials": media, "objects": objects}, (0, 0, 1), (0, 0, 0))
    first, second, third, last = all_rays(found)
    assert [(one["object"]["number"], one["entering"]) for one in second["passed"]] == [(1, True), (1, False)]
    assert [one["distance"] for one in second["passed"]] == near([2, 3])
    assert first["hit"]["indices"] == [1, 1.25] and second["hit"]["indices"] == [1.25, 1.5]
    assert {second["hit"]["object"]["number"], second["hit"]["touching"][0]["object"]["number"]} == {0, 2}
    assert third["media"] == ["ice"] and third["hit"]["indices"] == [1.5, 1] and last["hit"] is None


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


# ---- names and places


def test_a_scene_far_away_and_instances(tmp_path: Path) -> None:
    """Coordinates are the scene file's though the device has others; an object is told with its line, and what is inside."""
    (tmp_path / "far.yaml").write_text(
        "camera: {eye: [1000000, 0, 2000010], look_at: [1000000, 0, 2000000], fov: 1}\n"
        "image: {size: [1, 1]}\n"
        "ambient: 1\n"
        "lights: [{point: [0, 0, 0], colour: 0}]\n"
        "materials: {red: {ambient: [1, 0, 0]}}\n"
        "groups:\n"
        "  two:\n"
        "    - {sphere: {centre: [9, 0, 0], radius: 1}, material: red}\n"
        "    - {sphere: {radius: 1}, material: red}\n"
        "objects:\n"
        "  - {sphere: {centre: [1000005, 0, 2000000], radius: 1}, material: red}\n"
        "  - instance: two\n"
        "    transform: [{scale: 2}, {translate: [1000000, 0, 2000000]}]\n"
    )
    hit = feeler.load(tmp_path / "far.yaml").pixel(0, 0, depth=4, general=True).tree["trees"][0]["hit"]
    assert hit["point"] == pytest.approx([1000000, 0, 2000002], abs=1e-4)
    assert (hit["object"]["number"], hit["object"]["shape"]) == (1, "instance")
    assert hit["object"]["place"] == f"{tmp_path / 'far.yaml'}:12:5"
    assert (hit["object"]["inside"]["number"], hit["object"]["inside"]["shape"]) == (1, "sphere")
    assert hit["object"]["inside"]["place"] == f"{tmp_path / 'far.yaml'}:9:8"


def test_filtered_feelers() -> None:
    """Each surface takes its part; what is opaque ends the feeler."""
    panes = [{"disc": {"centre": [0, h, 0], "normal": [0, 1, 0], "radius": 5}, "material": m}
             for h, m in ((0, "floor"), (1, "pane"), (2, "pane"), (3, "wall"))]  # fmt: skip
    scene = {
        "filtered_shadows": True,
        "lights": [{"point": [0, 2.5, 0]}, {"point": [0, 4, 0]}],
        "materials": {"floor": {"diffuse": 1}, "wall": {"diffuse": 1}, "pane": {"transmission": [0.5, 0.25, 1]}},
        "objects": panes,
    }
    found = pixel(scene, (0, 0.5, 0), (0, 0, 0.0001))
    clear, ended = found["trees"][0]["local"]["lights"]
    assert [one["distance"] for one in clear["feeler"]["crossed"]] == near([1, 2])
    assert clear["feeler"]["crossed"][0]["share"] == near([0.5, 0.25, 1])
    assert clear["feeler"]["share"] == near([0.25, 0.0625, 1]) and clear["feeler"]["blocked_by"] is None
    assert clear["diffuse"] == near([0.25, 0.0625, 1])
    assert ended["feeler"]["blocked_by"]["object"]["number"] == 3 and ended["feeler"]["share"] == [0, 0, 0]


# ---- the program, and what is drawn


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pixel") / "a & b.yaml"
    lamps = json.dumps(CEILING["lights"])
    path.write_text(
        f"camera: {{eye: [0, 0, 0], look_at: [0, 0, -1], fov: 20}}\nimage: {{size: [5, 3]}}\nlights: {lamps}\n"
        f"materials: {json.dumps(CEILING['materials'])}\nobjects: {json.dumps(CEILING['objects'])}\n"
    )
    return path


def test_the_program_tells_the_same(cli: Any, scene_file: Path, tmp_path: Path) -> None:
    told = feeler.load(scene_file).pixel(2, 1)
    text = cli("pixel", scene_file, 2, 1)
    assert text.returncode == 0 and text.stderr == ""
    assert text.stdout == f"{told}\n"
    assert "└ reflection ray 1, level 2, weight 0.9 0.8 0.7, brings " in text.stdout
    assert "at 2, from its front" in text.stdout and "(a & b.yaml:5:" in text.stdout
    written = cli("pixel", scene_file, 2, 1, "--json", "--svg", "tree.svg")
    assert json.loads(written.stdout) == told.tree
    assert (tmp_path / "tree.svg").read_text() == f"{told.svg}\n"
    drawn = cli("pixel", scene_file, 2, 1, "--svg", "-")
    assert drawn.stdout == f"{told.svg}\n"


def test_the_drawing(scene_file: Path, tmp_path: Path) -> None:
    """A box for each ray, an edge to each that was sent, a mark for each light, names escaped."""
    told = feeler.load(scene_file).pixel(2, 1)
    told.save(tmp_path / "a.svg")
    root = ET.parse(tmp_path / "a.svg").getroot()
    marks = [(one.tag.partition("}")[2], one.get("class", "")) for one in root.iter()]
    assert [kind for tag, kind in marks if tag == "rect" and kind in ("eye", "reflection")] == ["reflection", "eye"]
    assert marks.count(("path", "edge reflection")) == 1
    circles = [kind for tag, kind in marks if tag == "circle"]
    assert circles[:3] == ["lit", "blocked", "unlit"]
    assert "a & b" in "".join(root.itertext())
    assert told._repr_svg_() == told.svg
    with pytest.raises(feeler.Error, match=r"\.svg file"):
        told.save(tmp_path / "a.png")


WRONG = {
    "outside": (["scene", "5", "0"], 2, "the pixel 5,0 is not in the picture of 5 x 3 pixels"),
    "no number": (["scene", "a", "0"], 2, "'a' is no coordinate"),
    "a fraction": (["scene", "1", "0.5"], 2, "'0.5' is no coordinate"),
    "too large": (["scene", "1", "99999999999999999999"], 2, "is no coordinate"),
    "missing": (["scene", "1"], 2, "SCENE X Y is missing"),
    "no scene": (["nowhere.yaml", "1", "1"], 1, "nowhere.yaml: cannot be opened"),
    "sample": (["scene", "1", "1", "--sample", "1"], 2, "there is no sample 1: the pixel has 1, from 0 on"),
    "folder": (["scene", "1", "1", "--svg", "none/a.svg"], 1, "none"),
}


@pytest.mark.parametrize("name", WRONG)
def test_bad_calls(cli: Any, scene_file: Path, name: str) -> None:
    arguments, code, message = WRONG[name]
    done = cli("pixel", *[scene_file if word == "scene" else word for word in arguments])
    assert done.returncode == code and message in done.stderr and done.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "message"), [((-1, 0), "x is a whole"), ((0.5, 0), "x is a whole"), ((0, 3), "not in the")]
)
def test_bad_calls_of_python(scene_file: Path, arguments: Any, message: str) -> None:
    with pytest.raises(feeler.Error, match=message):
        feeler.load(scene_file).pixel(*arguments)
