"""The classic scenes against POV-Ray, which computes in double precision and shares no code with us.

The scenes are from the shared exporter and from the project's own, whose pictures are the same.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from nff import read_nff
from peer_pictures import FINE, FOLDER, OFF, SIZE, Pixels, compare, read_ppm, render, save_difference
from write_pov import write_pov

pytestmark = pytest.mark.peers

SCENES = ["balls", "tetra"]

Povray = Callable[[Path], Pixels]


@pytest.fixture(scope="session")
def povray() -> Povray:
    """Renders a scene in FOLDER with POV-Ray, one sample a pixel: linear, from 0 to 1, 16 bits."""
    if not shutil.which("povray"):
        pytest.skip("POV-Ray is missing: install povray")

    def run(scene: Path) -> Pixels:
        out = scene.with_suffix(".ppm")
        files, size = [f"+I{scene.name}", f"+O{out.name}"], [f"+W{SIZE}", f"+H{SIZE}"]
        command = ["povray", *files, *size, "+FP16", "File_Gamma=1.0", "-D", "-A", "-GA"]
        result = subprocess.run(command, cwd=FOLDER, check=False, capture_output=True, text=True, timeout=600)
        assert result.returncode == 0, result.stderr[-2000:]
        return read_ppm(out)

    return run


@pytest.fixture(scope="session")
def shared(povray: Povray, peers: Path, spd: Path) -> Callable[[str], Pixels]:
    """A database's picture by its name, exported by the shared program; each once."""
    translator = peers / "nff_to_pov.py"
    if not translator.is_file():
        pytest.skip(f"there is no {translator}")
    known: dict[str, Pixels] = {}

    def run(name: str) -> Pixels:
        FOLDER.mkdir(parents=True, exist_ok=True)
        if name not in known:
            scene = FOLDER / f"{name}.pov"
            with scene.open("w") as file:
                subprocess.run([sys.executable, translator, spd / f"{name}.nff"], stdout=file, check=True, timeout=60)
            known[name] = povray(scene)
        return known[name]

    return run


@pytest.fixture(scope="session")
def own(povray: Povray) -> Callable[[Path], Pixels]:
    """An NFF scene's picture, exported by the project's own program."""

    def run(scene: Path) -> Pixels:
        FOLDER.mkdir(parents=True, exist_ok=True)
        exported = FOLDER / f"{scene.stem}-own.pov"
        exported.write_text(write_pov(read_nff(scene)))
        return povray(exported)

    return run


@pytest.mark.parametrize("name", SCENES)
def test_pictures(program: Path, spd: Path, shared: Callable[[str], Pixels], name: str) -> None:
    theirs = shared(name)
    scene = spd / f"{name}.nff"
    ours, fine = (np.clip(render(program, scene, size), 0, 1) for size in (SIZE, FINE))
    save_difference(f"{name}-povray", ours, theirs)
    found = compare(ours, theirs, fine)
    print(name, found)
    assert found.mean <= (0.0004 if name == "balls" else 0.00001)
    assert found.channel_off <= (0.003 if name == "balls" else 0.0001)
    assert found.unexplained <= 0.0001


@pytest.mark.parametrize("name", SCENES)
def test_pictures_in_double_precision(program: Path, spd: Path, shared: Callable[[str], Pixels], name: str) -> None:
    theirs = shared(name)
    ours = np.clip(render(program, spd / f"{name}.nff", SIZE, "reference"), 0, 1)
    save_difference(f"{name}-povray-reference", ours, theirs)
    difference = np.abs(ours - theirs)
    print(name, "mean", difference.mean(), "greatest", difference.max())
    assert difference.mean() <= 0.00001  # 16 bits: up to 0.000008
    assert (difference.max(-1) > OFF).mean() <= 0.00001  # two pixels may straddle an edge


# Gears is left out: the shared program fans its concave polygons from their first corner.
@pytest.mark.parametrize("name", ["balls", "mount", "rings", "tetra"])
def test_own_exporter(spd: Path, shared: Callable[[str], Pixels], own: Callable[[Path], Pixels], name: str) -> None:
    theirs, ours = shared(name), own(spd / f"{name}.nff")
    save_difference(f"{name}-own-and-shared-povray", ours, theirs)
    difference = np.abs(ours - theirs)
    print(name, "mean", difference.mean(), "off", (difference.max(-1) > OFF).mean())
    assert difference.mean() <= 0.00001
    assert (difference.max(-1) > OFF).mean() <= 0.0001


CONCAVE = """v
from 1 2 7
at 0 0 0
up 0 1 0
angle 40
hither 1
resolution 512 512
b 0.1 0.2 0.3
l 3 4 9 0.9 0.8 0.7
l -3 4 5
f 1 0.5 0.2 0.7 0.2 15 0 0
p 6
2 -2 0
2 -1 0
-1 -1 0
-1 2 0
-2 2 0
-2 -2 0
pp 4
0 0 0.5  -0.3 -0.3 1
2 0 0    0.3 -0.3 1
2 2 0.5    0.3 0.3 1
0 2 0   -0.3 0.3 1
p 4
-2 -2.5 2
2 -2.5 2
2 -2.5 -2
-2 -2.5 -2
"""


def test_own_exporter_of_other_polygons(program: Path, own: Callable[[Path], Pixels], tmp_path: Path) -> None:
    """A concave polygon, a smooth patch, and a light with a colour, none of which the databases have but gears."""
    scene = tmp_path / "concave.nff"
    scene.write_text(CONCAVE)
    ours, theirs = np.clip(render(program, scene, SIZE), 0, 1), own(scene)
    save_difference("concave-povray", ours, theirs)
    difference = np.abs(ours - theirs)
    print("mean", difference.mean(), "off", (difference.max(-1) > OFF).mean())
    assert difference.mean() <= 0.0001
    assert (difference.max(-1) > OFF).mean() <= 0.0005
