"""The classic scenes against POV-Ray, which computes in double precision and shares no code with us."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from peer_pictures import FINE, FOLDER, OFF, SIZE, Pixels, compare, read_ppm, render, save_difference

pytestmark = pytest.mark.peers

SCENES = ["balls", "tetra"]


@pytest.fixture(scope="module")
def povray(peers: Path, spd: Path) -> Callable[[str], Pixels]:
    """Renders a database by its name with POV-Ray, one sample a pixel: linear, from 0 to 1, 16 bits; each once."""
    translator = peers / "nff_to_pov.py"
    if not translator.is_file():
        pytest.skip(f"there is no {translator}")
    if not shutil.which("povray"):
        pytest.skip("POV-Ray is missing: install povray")
    known: dict[str, Pixels] = {}

    def run(name: str) -> Pixels:
        FOLDER.mkdir(parents=True, exist_ok=True)
        if name not in known:
            scene, out = FOLDER / f"{name}.pov", FOLDER / f"{name}-povray.ppm"
            with scene.open("w") as file:
                subprocess.run([sys.executable, translator, spd / f"{name}.nff"], stdout=file, check=True, timeout=60)
            files, size = [f"+I{scene.name}", f"+O{out.name}"], [f"+W{SIZE}", f"+H{SIZE}"]
            command = ["povray", *files, *size, "+FP16", "File_Gamma=1.0", "-D", "-A", "-GA"]
            result = subprocess.run(command, cwd=FOLDER, check=False, capture_output=True, text=True, timeout=600)
            assert result.returncode == 0, result.stderr[-2000:]
            known[name] = read_ppm(out)
        return known[name]

    return run


@pytest.mark.parametrize("name", SCENES)
def test_pictures(program: Path, spd: Path, povray: Callable[[str], Pixels], name: str) -> None:
    theirs = povray(name)
    scene = spd / f"{name}.nff"
    ours, fine = (np.clip(render(program, scene, size), 0, 1) for size in (SIZE, FINE))
    save_difference(f"{name}-povray", ours, theirs)
    found = compare(ours, theirs, fine)
    print(name, found)
    assert found.mean <= (0.0004 if name == "balls" else 0.00001)
    assert found.channel_off <= (0.003 if name == "balls" else 0.0001)
    assert found.unexplained <= 0.0001


@pytest.mark.parametrize("name", SCENES)
def test_pictures_in_double_precision(program: Path, spd: Path, povray: Callable[[str], Pixels], name: str) -> None:
    theirs = povray(name)
    ours = np.clip(render(program, spd / f"{name}.nff", SIZE, "reference"), 0, 1)
    save_difference(f"{name}-povray-reference", ours, theirs)
    difference = np.abs(ours - theirs)
    print(name, "mean", difference.mean(), "greatest", difference.max())
    assert difference.mean() <= 0.00001  # 16 bits: up to 0.000008
    assert (difference.max(-1) > OFF).mean() <= 0.00001  # two pixels may straddle an edge
