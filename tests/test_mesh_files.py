"""Mesh files: geometry, materials, the view of a bare mesh, and what is wrong with a file."""

from __future__ import annotations

import base64
import json
import math
import shutil
import struct
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from describe import describe, refusal

DATA = Path(__file__).parent / "data"

# A corner of the unit cube, closed, its triangles counter-clockwise from outside.
VERTICES = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def ply_header(form: str, extra: str = "") -> bytes:
    lines = ["ply", f"format {form} 1.0", "element vertex 4", *(f"property float {axis}" for axis in "xyz")]
    return "\n".join(
        [*lines, "element face 4", "property list uchar int vertex_indices", f"{extra}end_header\n"]
    ).encode()


def binary_ply(order: str) -> bytes:
    form = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    body = b"".join(struct.pack(order + "3f", *vertex) for vertex in VERTICES)
    return ply_header(form) + body + b"".join(struct.pack(order + "B3i", 3, *corners) for corners in TRIANGLES)


def binary_stl() -> bytes:
    """With normals that are wrong, as many files have them."""
    facets = [struct.pack("<12fH", 0, 0, 9, *(x for k in corners for x in VERTICES[k]), 0) for corners in TRIANGLES]
    return b"\0" * 80 + struct.pack("<I", len(facets)) + b"".join(facets)


def glb(material: dict[str, Any] | None = None, **node: Any) -> bytes:
    data = b"".join(struct.pack("<3f", *vertex) for vertex in VERTICES)
    data += b"".join(struct.pack("<3H", *corners) for corners in TRIANGLES)
    primitive: dict[str, Any] = {"attributes": {"POSITION": 0}, "indices": 1}
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **node}],
        "meshes": [{"primitives": [primitive]}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
    }
    if material is not None:
        primitive["material"] = 0
        document["materials"] = [material]
        document["extensionsUsed"] = list(material.get("extensions", {}))
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(data)
    return (
        struct.pack("<4sII", b"glTF", 2, length)
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(data), b"BIN\0")
        + data
    )


def write(path: Path, content: bytes | str) -> Path:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def meshes(scene: dict[str, Any]) -> list[dict[str, Any]]:
    assert all(thing["shape"] == "mesh" for thing in scene["objects"])
    return scene["objects"]


def volume(mesh: dict[str, Any]) -> float:
    """Positive when the triangles are counter-clockwise from outside."""
    total = 0.0
    for corners in mesh["triangles"]:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (mesh["vertices"][k] for k in corners)
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6


def is_closed(mesh: dict[str, Any]) -> bool:
    edges = Counter((a[i], a[(i + 1) % 3]) for a in mesh["triangles"] for i in range(3))
    return all(edges[b, a] == count == 1 for (a, b), count in edges.items())


def assert_tetrahedron(scene: dict[str, Any]) -> None:
    (mesh,) = meshes(scene)
    assert sorted(mesh["vertices"]) == sorted([list(vertex) for vertex in VERTICES])
    assert len(mesh["triangles"]) == 4 and is_closed(mesh)
    assert volume(mesh) == pytest.approx(1 / 6)


# ---- geometry ----


@pytest.mark.parametrize("name", ["tetrahedron.ply", "tetrahedron.stl"])
def test_text_formats(name: str) -> None:
    assert_tetrahedron(describe(DATA / name))


@pytest.mark.parametrize("order", ["<", ">"])
def test_binary_ply(tmp_path: Path, order: str) -> None:
    assert_tetrahedron(describe(write(tmp_path / "t.ply", binary_ply(order))))


def test_binary_stl_is_welded_and_its_normals_are_not_believed(tmp_path: Path) -> None:
    scene = describe(write(tmp_path / "t.stl", binary_stl()))
    assert_tetrahedron(scene)
    assert meshes(scene)[0]["normals"] == []


def test_glb(tmp_path: Path) -> None:
    assert_tetrahedron(describe(write(tmp_path / "t.glb", glb())))


def test_an_ending_in_capitals(tmp_path: Path) -> None:
    assert_tetrahedron(describe(write(tmp_path / "T.STL", binary_stl())))


def test_gltf_nodes_carry_transforms_and_mirrors_keep_the_outside_out() -> None:
    first, mirrored = meshes(describe(DATA / "two_tetrahedra.gltf"))
    assert volume(first) == pytest.approx(1 / 6)
    assert volume(mirrored) == pytest.approx(1 / 3), "twice as long, and not inside out"
    assert min(x for x, _, _ in mirrored["vertices"]) == 2 and max(x for x, _, _ in mirrored["vertices"]) == 4
    assert first["material"] == mirrored["material"]


def test_quadrilaterals_become_triangles() -> None:
    clay, glass = meshes(describe(DATA / "cube.obj"))
    assert (len(clay["triangles"]), len(glass["triangles"])) == (10, 2)
    assert len(clay["vertices"]) == 8 and len(glass["vertices"]) == 4
    assert volume(clay) + volume(glass) == pytest.approx(8)


def test_a_concave_face_keeps_its_area(tmp_path: Path) -> None:
    (mesh,) = meshes(
        describe(write(tmp_path / "l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n"))
    )
    areas = []
    for corners in mesh["triangles"]:
        (ax, ay, _), (bx, by, _), (cx, cy, _) = (mesh["vertices"][k] for k in corners)
        areas.append(((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2)
    assert sum(areas) == pytest.approx(3) and min(areas) > 0


def test_normals_of_the_file_are_kept(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nvn 0.6 0 0.8\nvn 0 0 1\nf 1//1 2//2 3//3\n"
    (mesh,) = meshes(describe(write(tmp_path / "n.obj", text)))
    assert mesh["normals"][0] == [0, 0, 1]
    assert mesh["normals"][1] == pytest.approx([0.6, 0, 0.8], abs=1e-7)


def test_normals_that_only_repeat_the_faces_are_dropped(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 -1\nvn -1 0 0\nf 1//1 3//1 2//1\nf 1//2 4//2 3//2\n"
    (mesh,) = meshes(describe(write(tmp_path / "n.obj", text)))
    assert mesh["normals"] == [] and len(mesh["vertices"]) == 4


@pytest.mark.parametrize(
    "text",
    [
        "v 0 0 0 # 1 2 3\r\n\t v 1 0 0\r\nv 0 1 0 1\r\n f 1 2 3 # x",
        "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "v 0 0 \\\n0\nv 1. .0 -.0e0\nv 0 +1 0 .5 .5 .5\nvt .0 0\nf -3/1 -2/1 \\\r\n-1/1\n",
        "v +0 .0 +.0\nv 1 0 0\nv 0 1 0\nf +1 +2 +3",
        "V 0 0 0\nv 1 0 0\nv 0 1 0\nF 1/ 2/ 3/\n",
    ],
)
def test_ways_to_write_a_triangle(tmp_path: Path, text: str) -> None:
    (mesh,) = meshes(describe(write(tmp_path / "t.obj", text)))
    assert mesh["triangles"] == [[0, 1, 2]] and mesh["vertices"] == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_points_and_lines_are_left_out_with_a_warning(tmp_path: Path) -> None:
    scene = describe(write(tmp_path / "l.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n"))
    assert sum(len(mesh["triangles"]) for mesh in meshes(scene)) == 1
    assert any("points or lines" in warning for warning in scene["warnings"])


def test_smooth_is_the_scenes_choice(tmp_path: Path) -> None:
    shutil.copy(DATA / "tetrahedron.stl", tmp_path)
    for smooth, count in (("true", 4), ("false", 0)):
        text = f"objects:\n  - mesh: {{file: tetrahedron.stl, smooth: {smooth}}}\n"
        (mesh,) = meshes(describe(write(tmp_path / "scene.yaml", text)))
        assert len(mesh["normals"]) == count
        assert all(math.hypot(*normal) == pytest.approx(1) for normal in mesh["normals"])


# ---- materials ----


def test_mtl() -> None:
    clay, glass = describe(DATA / "cube.obj")["materials"]
    assert (clay["name"], glass["name"]) == ("clay", "glass")
    assert clay["ambient"] == pytest.approx([0.1, 0.05, 0.02]) and clay["diffuse"] == pytest.approx([0.6, 0.4, 0.3])
    assert clay["specular"] == pytest.approx([0.2] * 3) and clay["shininess"] == 12
    assert clay["emission"] == [0, 0, 0.5]
    assert clay["reflection"] == clay["transmission"] == [0, 0, 0], "illum 2 casts no rays"
    assert glass["reflection"] == [0.25] * 3 and glass["transmission"] == pytest.approx([0.5, 0.25, 0.25])
    assert glass["ior"] == 1.5 and glass["diffuse"] == pytest.approx([0.25, 0.05, 0.05]), "of what is opaque"


def test_mtl_never_leaves_the_ranges(tmp_path: Path) -> None:
    write(tmp_path / "w.mtl", "newmtl w\nKd 7 -1 nan\nKs 3 3 3\nKe 1e9 0 0\nNs 1e9\nNi 99\nd -2\nillum 99\n")
    write(tmp_path / "w.obj", "mtllib w.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl w\nf 1 2 3\n")
    (wild,) = describe(tmp_path / "w.obj")["materials"]
    for key in ("ambient", "diffuse", "specular", "reflection", "transmission"):
        assert all(0 <= value <= 1 for value in wild[key])
    assert 0 < wild["shininess"] <= 1e6 and 0.1 <= wild["ior"] <= 10 and wild["emission"][0] <= 1e6


def test_clamped_values_of_mtl_are_warned_of(tmp_path: Path) -> None:
    write(tmp_path / "w.mtl", "newmtl w\nKd 0.5 1.5 0\nKs 1 1 1\nNs 0\nNi 99\nd 1\nillum 2\n")
    write(tmp_path / "w.obj", "mtllib w.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl w\nf 1 2 3\n")
    (warning,) = describe(tmp_path / "w.obj")["warnings"]
    assert warning.endswith("w.obj: material 'w': clamped to what a scene may hold: Kd, Ni")


def test_a_missing_material_library_is_warned_of(tmp_path: Path) -> None:
    path = write(tmp_path / "g.obj", "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n")
    assert any("gone.mtl" in warning for warning in describe(path)["warnings"])


def test_gltf_metal() -> None:
    (copper,) = describe(DATA / "two_tetrahedra.gltf")["materials"]
    assert copper["name"] == "copper"
    assert copper["reflection"] == pytest.approx([0.225, 0.125, 0.075], rel=1e-6), "a quarter: roughness 0.25"
    assert copper["emission"] == [0, 0, 0.125] and copper["shininess"] > 100


def test_gltf_glass(tmp_path: Path) -> None:
    volume_of = {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1},
    }
    solid = {
        "name": "glass",
        "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
        "extensions": volume_of,
    }
    sheet = {**solid, "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}
    (solid_glass,) = describe(write(tmp_path / "s.glb", glb(solid)))["materials"]
    (sheet_glass,) = describe(write(tmp_path / "t.glb", glb(sheet)))["materials"]
    for glass in (solid_glass, sheet_glass):
        assert glass["reflection"] == pytest.approx([0.04] * 3) and glass["transmission"] == pytest.approx([0.96] * 3)
        assert glass["diffuse"] == [0, 0, 0]
    assert solid_glass["ior"] == 1.5
    assert sheet_glass["ior"] == 1, "a thin sheet bends nothing"


@pytest.mark.parametrize("name", ["tetrahedron.ply", "tetrahedron.stl"])
def test_default_material(name: str) -> None:
    (pale,) = describe(DATA / name)["materials"]
    assert min(pale["diffuse"]) > 0.5 and 0 < pale["specular"][0] < 0.5 and pale["reflection"] == [0, 0, 0]


def test_the_scenes_material_replaces_the_files(tmp_path: Path) -> None:
    for name in ("cube.obj", "cube.mtl"):
        shutil.copy(DATA / name, tmp_path)
    text = "objects:\n  - mesh: {file: cube.obj}\n    material: {diffuse: [0.125, 0.25, 0.5]}\n"
    scene = describe(write(tmp_path / "scene.yaml", text))
    assert [scene["materials"][mesh["material"]]["diffuse"] for mesh in meshes(scene)] == [[0.125, 0.25, 0.5]] * 2


# ---- the view of a bare mesh ----


def seen_at(scene: dict[str, Any], point: list[float]) -> tuple[float, float]:
    """Where a point is in the picture: -1 … 1 from left to right and from bottom to top."""

    def cross(a: list[float], b: list[float]) -> list[float]:
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def unit(a: list[float]) -> list[float]:
        return [x / math.hypot(*a) for x in a]

    def dot(a: list[float], b: list[float]) -> float:
        return sum(x * y for x, y in zip(a, b, strict=True))

    ahead = unit([b - a for a, b in zip(scene["eye"], scene["look_at"], strict=True)])
    right = unit(cross(ahead, scene["up"]))
    offset = [b - a for a, b in zip(scene["eye"], point, strict=True)]
    slope = math.tan(math.radians(scene["fov"] / 2)) * dot(offset, ahead)
    width, height = scene["size"]
    return dot(offset, right) / (slope * width / height), dot(offset, cross(right, ahead)) / slope


@pytest.mark.parametrize("name", ["tetrahedron.ply", "tetrahedron.stl", "cube.obj", "two_tetrahedra.gltf"])
def test_the_camera_frames_the_mesh(name: str) -> None:
    scene = describe(DATA / name)
    points = [seen_at(scene, vertex) for mesh in meshes(scene) for vertex in mesh["vertices"]]
    (left, bottom), (right, top) = (tuple(pick(axis) for axis in zip(*points, strict=True)) for pick in (min, max))
    assert left == pytest.approx(-right, rel=0.02) and bottom == pytest.approx(-top, rel=0.02), "in the middle"
    assert max(right, top) == pytest.approx(1 / 1.15, rel=0.02), "as large as a margin lets it be"
    assert scene["size"] == [640, 480] and scene["fov"] == 40


def test_up_is_y_but_for_stl() -> None:
    assert describe(DATA / "tetrahedron.ply")["up"] == [0, 1, 0]
    assert describe(DATA / "tetrahedron.stl")["up"] == [0, 0, 1]


def test_the_view_scales_with_the_mesh(tmp_path: Path) -> None:
    unit = describe(DATA / "tetrahedron.ply")
    text = (DATA / "tetrahedron.ply").read_text()
    head, body = text.split("end_header\n")
    lines = body.splitlines()
    scaled = [" ".join(str(float(x) * 1024) for x in line.split()) for line in lines[:4]] + lines[4:]
    large = describe(write(tmp_path / "large.ply", head + "end_header\n" + "\n".join(scaled) + "\n"))
    assert large["eye"] == [1024 * x for x in unit["eye"]]
    assert large["lights"][0]["position"] == [1024 * x for x in unit["lights"][0]["position"]]


def test_the_key_light_is_on_the_left_above_and_behind() -> None:
    scene = describe(DATA / "cube.obj")
    key, fill = scene["lights"]
    assert (
        key["position"][0] < scene["eye"][0]
        and key["position"][1] > scene["eye"][1]
        and key["position"][2] > scene["eye"][2]
    )
    assert key["diffuse"][0] > 2 * fill["diffuse"][0] and fill["specular"] == [0, 0, 0]


# ---- files that are wrong; tests/invalid has more ----


@pytest.mark.parametrize("order", ["<", ">"])
def test_every_cut_of_a_binary_ply_is_noticed(tmp_path: Path, order: str) -> None:
    whole = binary_ply(order)
    for length in range(len(ply_header("binary_little_endian")), len(whole), 5):
        assert "cut short" in refusal(write(tmp_path / "t.ply", whole[:length]))


def test_every_cut_of_a_binary_stl_is_noticed(tmp_path: Path) -> None:
    whole = binary_stl()
    for length in range(1, len(whole), 13):
        assert "cut short" in refusal(write(tmp_path / "t.stl", whole[:length]))


def test_every_cut_of_a_glb_is_noticed(tmp_path: Path) -> None:
    whole = glb()
    for length in range(1, len(whole), 61):
        assert refusal(write(tmp_path / "t.glb", whole[:length])).startswith("t.glb: ")


def test_a_short_buffer(tmp_path: Path) -> None:
    document = json.loads((DATA / "two_tetrahedra.gltf").read_text())
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(b"\0" * 30).decode()
    assert "cannot be read" in refusal(write(tmp_path / "t.gltf", json.dumps(document)))


def test_vertices_that_are_not_finite(tmp_path: Path) -> None:
    content = binary_ply("<").replace(struct.pack("<f", 1), struct.pack("<f", math.inf), 1)
    assert refusal(write(tmp_path / "t.ply", content)) == "t.ply: vertex 1 (counted from 0) is not finite"
