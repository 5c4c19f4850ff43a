"""YAML scenes: defaults, numbers, transforms, includes, long lists. Bad ones are in tests/invalid."""

from __future__ import annotations

import math
import random
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from describe import describe, refusal
from hypothesis import given
from hypothesis import strategies as st

import feeler

Vector = list[float]


def load(folder: Path, text: str) -> dict[str, Any]:
    path = folder / "scene.yaml"
    path.write_text(text)
    scene: dict[str, Any] = describe(path)
    return scene


def test_defaults(tmp_path: Path) -> None:
    scene = load(tmp_path, "{}\n")
    assert scene["size"] == [640, 480] and scene["depth"] == 5 and scene["fov"] == 45
    assert scene["eye"] == [0, 0, 10] and scene["look_at"] == [0, 0, 0] and scene["up"] == [0, 1, 0]
    assert scene["background"] == [0, 0, 0]
    assert scene["objects"] == scene["lights"] == scene["materials"] == scene["warnings"] == []


def test_default_material_is_made_once_and_only_when_needed(tmp_path: Path) -> None:
    scene = load(tmp_path, "objects: [{sphere: {radius: 1}}, {sphere: {radius: 2}}]\n")
    assert len(scene["materials"]) == 1
    assert scene["materials"][0]["diffuse"] == [0.7, 0.7, 0.7]


def test_grey_and_light_colours(tmp_path: Path) -> None:
    text = "background: 0.25\nlights:\n  - {point: [1, 2, 3], colour: [0.5, 1, 2], specular: 0}\n  - directional: [0, -2, 0]\n"
    scene = load(tmp_path, text)
    assert scene["background"] == [0.25] * 3
    first, second = scene["lights"]
    assert first["diffuse"] == [0.5, 1, 2] and first["specular"] == [0, 0, 0]
    assert second["position"] == [0, 1, 0], "kept as the way to the light"
    assert second["diffuse"] == second["specular"] == [1, 1, 1] and second["ambient"] == [0, 0, 0]


def test_numbers_are_read_to_the_last_bit(tmp_path: Path) -> None:
    draw = random.Random(1)
    texts = [
        "1e-320",
        "4.9e-324",
        "123456789012345678901234567890e-25",
        "9007199254740993e-2",
        "0.1",
        "+.5",
        "5.",
        "1E2",
        "-0.0",
    ]
    texts += [f"{draw.uniform(-1, 1):.{draw.randint(1, 25)}f}" for _ in range(200)]
    texts += [f"{draw.uniform(-10, 10):.{draw.randint(1, 18)}e}" for _ in range(200)]
    lines = "".join(f"  - {{sphere: {{radius: 1, centre: [{text}, 0, 0]}}}} #\n" for text in texts)
    scene = load(tmp_path, "objects:\n" + lines)
    assert [o["centre"][0][0] for o in scene["objects"]] == [float(text) for text in texts]


# ---- transforms ----


def shape(folder: Path, body: str, transform: str) -> dict[str, Any]:
    objects = load(folder, f"objects:\n  - {body}\n    transform: {transform}\n")["objects"]
    assert len(objects) == 1
    only: dict[str, Any] = objects[0]
    return only


def test_steps_apply_in_order(tmp_path: Path) -> None:
    moved = shape(
        tmp_path, "sphere: {centre: [1, 0, 0], radius: 1}", "[{rotate_y: 90}, {scale: 2}, {translate: [1, 2, 3]}]"
    )
    assert moved["centre"] == [[1, 2, 1]] and moved["radius"] == 2


@pytest.mark.parametrize(
    "step",
    ["rotate_x: 180", "rotate: {axis: [3, 0, 0], angle: -540}", "rotate: {axis: [1, 0, 0], angle: 3600000180}",
     "scale: [1, -1, -1]"],
)  # fmt: skip
def test_half_a_turn_is_exact(tmp_path: Path, step: str) -> None:
    assert shape(tmp_path, "sphere: {centre: [1, 2, 3], radius: 1}", f"{{{step}}}")["centre"] == [[1, -2, -3]]


def test_rotation_is_counter_clockwise(tmp_path: Path) -> None:
    x, y, z = shape(tmp_path, "sphere: {centre: [1, 0, 0], radius: 1}", "{rotate_z: 30}")["centre"][0]
    assert (x, y, z) == pytest.approx((math.cos(math.pi / 6), 0.5, 0))


def test_matrix(tmp_path: Path) -> None:
    rows = "[[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7]]"
    assert shape(tmp_path, "sphere: {centre: [1, 2, 3], radius: 1}", f"{{matrix: {rows}}}")["centre"] == [[3, 7, 10]]
    rows = rows[:-1] + ", [0, 0, 0, 1]]"
    assert shape(tmp_path, "sphere: {centre: [1, 2, 3], radius: 1}", f"{{matrix: {rows}}}")["centre"] == [[3, 7, 10]]


def test_cylinder_and_cone(tmp_path: Path) -> None:
    moved = shape(tmp_path, "cylinder: {base: [0, 0, 0], top: [0, 2, 0], radius: 0.5}", "{scale: -3}")
    assert moved["radii"] == [1.5, 1.5] and moved["top"] == [[0, -6, 0]] and moved["capped"]
    cone = "cone: {base: [0, 0, 0], top: [0, 2, 0], base_radius: 1, capped: false}"
    moved = shape(tmp_path, cone, "{rotate_x: 90}")
    assert moved["radii"] == [1, 0] and moved["top"] == [[0, 0, 2]] and not moved["capped"]


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Vector, b: Vector) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def minus(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def volume(mesh: dict[str, Any]) -> float:
    """Positive when every triangle runs counter-clockwise from outside."""
    corners = [[mesh["vertices"][i] for i in triangle] for triangle in mesh["triangles"]]
    return sum(dot(a, cross(b, c)) / 6 for a, b, c in corners)


@pytest.mark.parametrize(
    ("step", "expected"),
    [
        ("rotate: {axis: [1, 2, 3], angle: 40}", 6),
        ("matrix: [[1, 0.5, 0, 9], [0, 1, 0, 8], [0, 0, 1, 7]]", 6),
        ("matrix: [[-1, 0.5, 0, 9], [0, 2, 0, 8], [0, 0, 3, 7]]", 36),
    ],
)
def test_turned_box_is_a_closed_mesh_facing_out(tmp_path: Path, step: str, expected: float) -> None:
    mesh = shape(tmp_path, "box: {low: [-1, 0, 1], high: [0, 2, 4]}", f"{{{step}}}")
    assert mesh["shape"] == "mesh" and len(mesh["triangles"]) == 12
    edges = [(t[i], t[(i + 1) % 3]) for t in mesh["triangles"] for i in range(3)]
    assert len(set(edges)) == 36 and all((b, a) in edges for a, b in edges)
    assert volume(mesh) == pytest.approx(expected)


@pytest.mark.parametrize("step", ["rotate_x: 90", "scale: [1, -2, 3]", "translate: [1, 2, 3]", "rotate_y: -270"])
def test_straight_box_stays_one(tmp_path: Path, step: str) -> None:
    assert shape(tmp_path, "box: {low: [-1, 0, 1], high: [0, 2, 4]}", f"{{{step}}}")["shape"] == "box"


def test_mirrored_triangle_keeps_its_front(tmp_path: Path) -> None:
    body = "triangle: {corners: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], normals: [[0, 0, 1], [0, 1, 1], [1, 0, 1]]}"
    mirrored = shape(tmp_path, body, "{scale: [-2, 1, 1]}")
    a, b, c = mirrored["corners"]
    assert (a, b, c) == ([0, 0, 0], [0, 1, 0], [-2, 0, 0])
    assert cross(minus(b, a), minus(c, a))[2] > 0
    assert mirrored["normals"][1] == pytest.approx([-1 / math.sqrt(5), 0, 2 / math.sqrt(5)]), "the inverse transpose"


def test_polygon_turns_round_in_a_mirror(tmp_path: Path) -> None:
    body = "polygon: {corners: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]}"
    corners = shape(tmp_path, body, "{scale: [-1, 1, 1]}")["corners"]
    assert sum(cross(a, b)[2] for a, b in pairwise([*corners, corners[0]])) == 2


# ---- meshes ----

TENT = "vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]], triangles: [[0, 1, 2], [1, 3, 2]]"


def test_mesh_is_flat_unless_asked(tmp_path: Path) -> None:
    assert load(tmp_path, f"objects: [{{mesh: {{{TENT}}}}}]\n")["objects"][0]["normals"] == []


def test_smooth_makes_unit_normals(tmp_path: Path) -> None:
    normals = load(tmp_path, f"objects: [{{mesh: {{{TENT}, smooth: true}}}}]\n")["objects"][0]["normals"]
    assert len(normals) == 4 and normals[0] == [0, 0, 1]
    assert all(dot(n, n) == pytest.approx(1) for n in normals)
    assert normals[1] == pytest.approx(normals[2])


def test_degenerate_triangles_are_dropped_and_counted(tmp_path: Path) -> None:
    flat = "{triangle: {corners: [[0, 0, 0], [0.1, 0.1, 0.1], [0.3, 0.3, 0.3]]}}"
    mesh = (
        "{mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], triangles: [[0, 1, 2], [0, 1, 3], [1, 1, 2]]}}"
    )
    scene = load(tmp_path, f"objects: [{flat}, {mesh}]\n")
    (warning,) = scene["warnings"]
    assert warning.endswith(".yaml: 3 degenerate triangles left out: they have no area")
    assert [o["triangles"] for o in scene["objects"]] == [[[0, 1, 2]]]


@pytest.mark.parametrize("exponent", [-40, 0, 40])
def test_what_is_degenerate_does_not_depend_on_scale(tmp_path: Path, exponent: int) -> None:
    thin: list[Vector] = [[0, 0, 0], [1, 0, 0], [0.5, 1e-13, 0]]
    corners = [[x * 2.0**exponent for x in corner] for corner in thin]
    scene = load(tmp_path, f"objects: [{{triangle: {{corners: {corners}}}}}]\n")
    assert len(scene["objects"]) == 1 and not scene["warnings"]


# ---- includes, aliases ----


def test_include(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "a.yaml").write_text("include: [b.yaml]\nobjects: [{sphere: {radius: 1}, material: gold}]\n")
    (tmp_path / "parts" / "b.yaml").write_text("materials: {gold: {diffuse: [1, 0.8, 0]}}\n")
    scene = load(tmp_path, "include: [parts/a.yaml, parts/b.yaml]\nobjects: [{sphere: {radius: 2}, material: gold}]\n")
    assert [m["name"] for m in scene["materials"]] == ["gold"], "reached twice, read once"
    assert sorted(o["radius"] for o in scene["objects"]) == [1, 2]


def test_aliases(tmp_path: Path) -> None:
    scene = load(tmp_path, "materials:\n  a: &a {diffuse: &c [1, 0, 0]}\n  b: *a\n  c: {specular: *c}\n")
    assert [m["diffuse"] for m in scene["materials"]] == [[1, 0, 0], [1, 0, 0], [0, 0, 0]]
    assert scene["materials"][2]["specular"] == [1, 0, 0]


# ---- long lists: read by a short cut that must not show ----


@given(st.integers(0, 2**32), st.sampled_from([0, 2, 4]))
def test_short_cut_does_not_show(tmp_path_factory: pytest.TempPathFactory, seed: int, indent: int) -> None:
    draw = random.Random(seed)
    lines = []
    for i in range(200):
        sphere = (
            f"sphere: {{centre: [{draw.random():.3f},{draw.random():.3f} , -{i}], radius: {draw.random() + 0.1:.2f}}}"
        )
        plain = [f"- {sphere}", f"- {{{sphere}, material: m, sides: back}}", f"-  {{ {sphere} }}"]
        odd = [
            f"- {sphere}\n{' ' * indent}  material: m",
            f"- {{{sphere},\n{' ' * indent}   material: m}}",
            "# nothing",
            "",
        ]
        lines.append(" " * indent + draw.choice(plain if draw.random() < 0.99 else odd))
    text = "materials: {m: {diffuse: 1}}\nobjects:\n" + "\n".join(lines) + "\n"
    folder = tmp_path_factory.mktemp("lists")
    assert load(folder, text) == load(folder, text + "# feeler-lines- in a text turns the short cut off\n")


def test_long_text_is_no_list(tmp_path: Path) -> None:
    lines = "".join(f"  - {{sphere: {{radius: {i + 1}}}}}\n" for i in range(200))
    path = tmp_path / "scene.yaml"
    path.write_text("objects: |\n" + lines)
    assert refusal(path) == "scene.yaml:1:10: expected a list of objects, not a text"


# ---- docs/scene-format.md ----

# A map with an unknown key, by the place in the document where its keys are: the message names all that are known.
MAPS: dict[str, Any] = {
    "The scene": {"?": 0},
    "camera": {"camera": {"?": 0}},
    "image": {"image": {"?": 0}},
    "lights": {"lights": [{"?": 0}]},
    "materials": {"materials": {"m": {"?": 0}}},
    "transform": {"objects": [{"sphere": {"radius": 1}, "transform": {"?": 0}}]},
    "objects": {"objects": [{"?": 0}]},
}  # fmt: skip


def known_keys(scene: dict[str, Any]) -> set[str]:
    with pytest.raises(feeler.Error, match="known: ") as caught:
        feeler.Scene(scene)
    return set(re.findall(r"\w+", caught.value.text.partition("known: ")[2]))


def table_rows(document: str, heading: str) -> list[list[str]]:
    """The rows of a section's tables, heads and all, as lists of cells."""
    section = re.split(r"^#+ ", document, flags=re.MULTILINE)
    (text,) = [part for part in section if part.startswith(f"{heading}\n")]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("|")]


def names(cell: str) -> list[str]:
    return re.findall(r"`(\w+)`", cell)


def test_every_key_is_documented_and_no_other(root: Path) -> None:
    document = (root / "docs" / "scene-format.md").read_text()
    rows = {heading: table_rows(document, heading) for heading in [*MAPS, "groups and instances"]}
    shapes: dict[str, set[str]] = {}
    shape = ""
    head = [row[0] for row in rows["objects"]].index("shape")
    for first, second, *_ in rows["objects"][head + 2 :]:
        shape = names(first)[0] if first else shape
        shapes.setdefault(shape, set()).update(names(second))
    for heading, scene in MAPS.items():
        documented = {name for row in rows[heading] for name in names(row[0])}
        if heading == "objects":
            documented.update(name for row in rows["groups and instances"] for name in names(row[0]))
        assert documented == known_keys(scene), heading
    assert len(shapes) == 9
    for shape, keys in shapes.items():
        assert keys == known_keys({"objects": [{shape: {"?": 0}}]}), shape
