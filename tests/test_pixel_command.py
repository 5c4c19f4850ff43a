"""`feeler pixel` as a command and a drawing: it tells what Python tells, and what it refuses."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
from pixel_trees import all_rays, look, pixel
from test_pixel import CEILING, GLASS

import feeler


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
    "below 0": (["scene", "-1", "2"], 2, "'-1' is no coordinate"),
    "below 0, the other": (["scene", "1", "-2"], 2, "'-2' is no coordinate"),
    "one too many": (["scene", "1", "1", "-1"], 2, "'-1' is too much"),
    "folder": (["scene", "1", "1", "--svg", "none/a.svg"], 1, "cannot write into the folder 'none': No such file"),
    "ending": (["scene", "1", "1", "--svg", "a.png"], 2, "the drawing of a pixel is an .svg file, not 'a.png'"),
    "no ending": (["scene", "1", "1", "--svg", ".svg"], 2, "the drawing of a pixel is an .svg file, not '.svg'"),
    "no -o": (["scene", "1", "1", "-o", "a.svg"], 2, "unknown option '-o'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_bad_calls(cli: Any, scene_file: Path, tmp_path: Path, name: str) -> None:
    arguments, code, message = WRONG[name]
    done = cli("pixel", *[scene_file if word == "scene" else word for word in arguments])
    assert done.returncode == code and message in done.stderr and done.stdout == ""
    assert not list(tmp_path.iterdir())


def test_too_many_rays() -> None:
    """Each meets the next shell, and sends two on: 15 for each of 4096 samples."""
    shells = [{"sphere": {"radius": radius}, "material": "glass"} for radius in range(1, 6)]
    with pytest.raises(feeler.Error, match="the pixel has 61440 rays, at most 50000 can be told: less depth") as caught:
        look({"materials": GLASS, "objects": shells}, (0, 0, 0), (0, 0, -1), samples=4096)
    assert caught.value.kind == "bad usage"
    assert len(all_rays(pixel({"materials": GLASS, "objects": shells}, (0, 0, 0), (0, 0, -1)))) == 15


@pytest.mark.parametrize(
    ("arguments", "message"), [((-1, 0), "x is a whole"), ((0.5, 0), "x is a whole"), ((0, 3), "not in the")]
)
def test_bad_calls_of_python(scene_file: Path, arguments: Any, message: str) -> None:
    with pytest.raises(feeler.Error, match=message):
        feeler.load(scene_file).pixel(*arguments)
