"""NFF files: every entity, the classic databases, and what the format leaves open."""

from __future__ import annotations

import os
import subprocess
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from describe import describe, describer, refusal

VIEW = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 40\nhither 1\nresolution 64 48\n"
FILL = "f 1 1 1 0.5 0.2 20 0 0\n"


@pytest.fixture(scope="module")
def entities() -> dict[str, Any]:
    return describe(Path(__file__).parent / "data" / "entities.nff")


def nff(folder: Path, *lines: str) -> Path:
    path = folder / "scene.nff"
    path.write_text("".join(lines))
    return path


def test_view(entities: dict[str, Any]) -> None:
    assert (entities["eye"], entities["look_at"], entities["up"]) == ([0, -8, 3], [0, 0, 1], [0, 0, 1])
    assert (entities["fov"], entities["size"], entities["depth"]) == (45, [320, 200], 5)
    assert entities["spans_centres"] is True
    assert entities["background"] == [0.1, 0.2, 0.3]


def test_background_is_black_when_not_given(tmp_path: Path) -> None:
    assert describe(nff(tmp_path, VIEW))["background"] == [0, 0, 0]


def test_lights_without_colour_share(entities: dict[str, Any]) -> None:
    shared = pytest.approx([3**-0.5] * 3, rel=1e-15)
    assert [light["diffuse"] for light in entities["lights"]] == [shared, [0.5, 0.25, 0.125], shared]
    for light in entities["lights"]:
        assert light["specular"] == light["diffuse"]
        assert light["ambient"] == [0, 0, 0]


def test_equal_fills_are_one_material(entities: dict[str, Any]) -> None:
    plastic, glass = entities["materials"]
    assert plastic["diffuse"] == pytest.approx([0.8, 0.4, 0.2])
    assert plastic["specular"] == plastic["reflection"] == [0.1] * 3
    assert (plastic["shininess"], plastic["ior"]) == (20, 1)
    assert glass["transmission"] == [0.6] * 3 and glass["reflection"] == [0.3] * 3
    assert glass["ior"] == 1.5
    for material in (plastic, glass):
        for key in ("ambient", "emission", "diffuse_transmission", "specular_transmission"):
            assert material[key] == [0, 0, 0]


def test_shine_zero_is_no_highlight(entities: dict[str, Any]) -> None:
    glass = entities["materials"][1]
    assert glass["specular"] == [0, 0, 0] and glass["shininess"] == 1


def test_shapes(entities: dict[str, Any]) -> None:
    shapes = [thing["shape"] for thing in entities["objects"]]
    assert shapes == ["sphere"] * 2 + ["cone"] * 3 + ["triangle", "polygon"] + ["triangle"] * 4
    assert [thing["material"] for thing in entities["objects"]] == [0, 0, 1, 1] + [0] * 7
    assert [thing["line"] for thing in entities["objects"]] == [14, 15, 17, 18, 22, 23, 27, 34, 38, 38, 38]


def test_negative_radius_shows_the_inside(entities: dict[str, Any]) -> None:
    assert [thing["sides"] for thing in entities["objects"]] == ["both", "back", "both", "both", "back"] + ["both"] * 6
    assert entities["objects"][1]["radius"] == 0.25
    assert entities["objects"][4]["radii"] == [0.5, 0.25]


def test_cones_on_one_line_or_three(entities: dict[str, Any]) -> None:
    cylinder, cone = entities["objects"][2:4]
    assert cylinder["radii"] == [0.5, 0.5] and cylinder["base"] == [[0, 0, 0]] and cylinder["top"] == [[0, 0, 2]]
    assert cone["radii"] == [0.75, 0] and cone["base"] == [[1, 0, 0]] and cone["top"] == [[1, 0, 2]]
    assert not cylinder["capped"] and not cone["capped"]


def test_polygons(entities: dict[str, Any]) -> None:
    triangle, concave, smooth, *fan = entities["objects"][5:]
    assert triangle["corners"] == [[0, 0, 0], [1, 0, 0], [0, 1, 0]] and triangle["normals"] == []
    assert concave["corners"] == [[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 2, 0], [1, 1, 0], [0, 1, 0]]
    assert smooth["normals"][1] == pytest.approx([0, 0.6, 0.8])
    assert smooth["normals"][2] == [0, 0, 1], "of length 1"
    assert [part["corners"][0] for part in fan] == [[0, 0, 2]] * 3
    assert [part["corners"][1:] for part in fan] == [
        [[2, 0, 2], [3, 1, 2]],
        [[3, 1, 2], [2, 2, 2]],
        [[2, 2, 2], [0, 2, 2]],
    ]


def test_view_in_any_order_and_windows_lines(tmp_path: Path) -> None:
    text = "v\r\nresolution 8 4\r\nangle 30\r\nup 0 1 0\r\nat 0 0 0\r\nfrom 0 0 1\r\nhither 0.1\r\n# end"
    path = tmp_path / "scene.nff"
    path.write_bytes(text.encode())
    scene = describe(path)
    assert scene["size"] == [8, 4] and scene["eye"] == [0, 0, 1]


@pytest.mark.parametrize(
    "text",
    [
        "0.1",
        "+.5",
        "-0",
        "5.",
        "1e-3",
        "1E+2",
        "123456789012345.678901",
        "0.30000000000000004",
        "0.1000000000000000055511151231257827",
        "1e-320",
    ],
)
def test_numbers_are_correctly_rounded(tmp_path: Path, text: str) -> None:
    scene = describe(nff(tmp_path, VIEW, FILL, f"s {text} 0 0 1\n"))
    assert scene["objects"][0]["centre"][0][0] == float(text)


def test_locale_does_not_matter(tmp_path: Path) -> None:
    path = nff(tmp_path, VIEW, FILL, "s 0.25 0 0 1.5\n")
    for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "C"):
        environment = {**os.environ, "LC_ALL": name}
        done = subprocess.run([describer(), path], capture_output=True, text=True, check=True, env=environment)
        assert '"radius": 1.5}' in done.stdout


def test_nothing_but_a_view(tmp_path: Path) -> None:
    scene = describe(nff(tmp_path, VIEW))
    assert scene["objects"] == scene["lights"] == scene["materials"] == []


def test_degenerate_triangle_is_dropped_with_a_warning(tmp_path: Path) -> None:
    scene = describe(nff(tmp_path, VIEW, FILL, "p 3\n0 0 0\n1 1 1\n2 2 2\ns 0 0 0 1\n"))
    assert [thing["shape"] for thing in scene["objects"]] == ["sphere"]
    assert len(scene["warnings"]) == 1


def test_every_cut_is_refused_or_whole(tmp_path: Path) -> None:
    """Cut anywhere, a file gives an error with its place, or a scene of the entities before the cut."""
    text = (Path(__file__).parent / "data" / "entities.nff").read_bytes()
    path = tmp_path / "scene.nff"
    for end in range(0, len(text), 7):
        path.write_bytes(text[:end])
        done = subprocess.run([describer(), path.name], capture_output=True, text=True, check=False, cwd=tmp_path)
        assert done.returncode in (0, 1)
        if done.returncode:
            assert done.stderr.startswith("scene.nff:") and done.stderr.count("\n") == 1


def test_not_a_file(tmp_path: Path) -> None:
    assert refusal(tmp_path / "absent.nff") == "absent.nff: cannot be opened: No such file or directory"


DATABASES = {
    "balls": ({"sphere": 7381, "polygon": 1}, 3, 2),
    "gears": ({"polygon": 9345}, 5, 63),
    "mount": ({"triangle": 8192, "sphere": 4}, 1, 2),
    "rings": ({"sphere": 4200, "cone": 4200, "polygon": 1}, 3, 7),
    "tetra": ({"triangle": 4096}, 1, 1),
}


@pytest.mark.parametrize("name", DATABASES)
def test_databases(spd: Path, name: str) -> None:
    shapes, lights, materials = DATABASES[name]
    start = time.perf_counter()
    scene = describe(spd / f"{name}.nff")
    assert time.perf_counter() - start < 5
    assert Counter(thing["shape"] for thing in scene["objects"]) == shapes
    assert len(scene["lights"]) == lights
    assert len(scene["materials"]) == materials, "equal fills are one material"
    assert scene["size"] == [512, 512] and scene["fov"] == 45 and not scene["warnings"]


def test_gears_have_faces_of_144_corners(spd: Path) -> None:
    corners = Counter(len(thing["corners"]) for thing in describe(spd / "gears.nff")["objects"])
    assert corners[144] == 128
