"""`feeler pixel`: trees that are known by hand, and the picture's own bits."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pixel_trees import Json, all_rays, look, near, pixel
from shapes import unit

import feeler

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
    assert [light["no_feeler"] for light in eye["local"]["lights"]] == ["grazing", "grazing", "coefficients"]
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
    drawn = " ".join("".join(ET.fromstring(told.svg).itertext()).split())
    assert all(" ".join(line.split()) in drawn for line in told.words)


def test_zeros_have_no_sign_in_words() -> None:
    """A plane that is met from its back has its normal turned."""
    behind = [{"plane": {"point": [0, 0, -1], "normal": [0, 0, -1]}, "material": "plaster"}]
    told = look({**CEILING, "objects": behind}, (0, 0, 0), (0, 0, -1))
    assert told.tree["trees"][0]["hit"]["normal"] == [0, 0, 1]
    assert "-0.0" in str(told.tree["trees"][0]["hit"]["normal"])
    assert "at (0, 0, -1), normal (0, 0, 1)\n" in str(told)


def test_why_is_it_nearly_black() -> None:
    """There is light, but what is on its way takes it."""
    only_red = {"mirror": {"reflection": [1, 0, 0]}, "plaster": {"diffuse": [0, 0, 0.5]}}
    told = look(
        {**CEILING, "ambient": 0, "lights": CEILING["lights"][:1], "materials": only_red}, (0, 0, 0), (0, 0, -1)
    )
    assert told.colour == (0, 0, 0) and told.words[0] == "black, because"
    assert told.words[2] == (
        "  a reflection ray of level 2 meets objects[1] plane 'plaster': its light is 0 0 0.18, its weight 1 0 0, "
        "so that it adds 0; there is no ambient light; it neither reflects nor transmits"
    )
    dim = {"background": 0.5, "materials": {"mirror": {"reflection": 0.0001, "ambient": 1e-5}}, "ambient": 1}
    told = look({**dim, "objects": CEILING["objects"][:1]}, (0, 0, 0), (0, 0, -1))
    assert told.colour == near([6e-5] * 3)
    assert told.words == [
        "black, because",
        "  the eye ray meets objects[0] disc 'mirror': its light is 1e-05, its weight 1, so that it adds 1e-05; "
        "lights[0] is black itself",
        "  a reflection ray of level 2 meets nothing: its light is 0.5, its weight 0.0001, so that it adds 5e-05",
    ]


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
        ((3, 4, 0), {"point": [-3, 4, 0], "specular": 0}, "no common term"),
        ((3, 4, 0), {"point": [-3, 4, 0], "colour": 0}, "black light"),
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


def test_a_name_that_is_no_utf_8(tmp_path: Path) -> None:
    """JSON knows no other; the file can be read all the same."""
    path = os.fsencode(tmp_path) + b"/caf\xe9.yaml"
    Path(os.fsdecode(path)).write_text(
        "camera: {eye: [0, 0, 5], look_at: [0, 0, 0]}\nimage: {size: [1, 1]}\nlights: [{point: [0, 0, 9], colour: 0}]\n"
        "objects: [{sphere: {radius: 1}}]\n"
    )
    told = feeler.load(os.fsdecode(path)).pixel(0, 0, depth=4, general=True)
    assert told.tree["scene"] == "caf?"
    assert told.tree["trees"][0]["hit"]["object"]["place"].endswith("/caf?.yaml:4:12")
    assert "(caf?.yaml:4:12)" in str(told)


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
