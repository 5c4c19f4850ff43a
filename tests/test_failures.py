"""What cannot be done for reasons that lie in the machine: too little memory, kernels that do not build."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from spheres import write_spheres

BROKEN = {**os.environ, "FEELER_KERNEL_OPTIONS": "-Dreals=struct"}


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_spheres(tmp_path / "spheres.nff", (16, 12))


def render_within(kilobytes: int, program: Path, scene: Path, size: str) -> subprocess.CompletedProcess[str]:
    command = ["bash", "-c", f'ulimit -v {kilobytes}; exec "$@"', "bash", str(program), "render", scene.name]
    return subprocess.run(
        [*command, "-o", "a.exr", "--size", size],
        cwd=scene.parent,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


def test_a_picture_too_large_for_the_memory(program: Path, scene: Path) -> None:
    """16000 x 16000 pixels are 4.1 GB; within 3 GB the driver itself has enough, as the small picture shows."""
    (scene.parent / "a.exr").write_text("old")
    done = render_within(3_000_000, program, scene, "16000x16000")
    assert done.returncode == 1
    assert re.fullmatch(r"feeler: .*out of memory.*\n", done.stderr), done.stderr
    assert "16000 x 16000" in done.stderr
    assert done.stdout == ""
    assert sorted(p.name for p in scene.parent.iterdir()) == ["a.exr", "spheres.nff"]
    assert (scene.parent / "a.exr").read_text() == "old"
    done = render_within(3_000_000, program, scene, "16x12")
    assert done.returncode == 0, done.stderr


def test_what_writes_pictures_is_missing(program: Path, scene: Path) -> None:
    """It is loaded while a render goes on; a long one stops as soon as that has failed."""
    lonely = scene.parent / "lonely"
    lonely.mkdir()
    for name in ("feeler", "libfeeler.so"):
        shutil.copy(program.parent / name, lonely)
    command = [lonely / "feeler", "render", scene, "-o", scene.parent / "spheres.png"]
    for size in ("16x12", "8000x8000"):
        done = subprocess.run([*command, "--size", size], capture_output=True, text=True, check=False, timeout=300)
        assert done.returncode == 1
        assert re.fullmatch(r"feeler: .*spheres\.png: cannot write pictures: .*libfeeler-image\.so.*\n", done.stderr)
        assert sorted(p.name for p in scene.parent.iterdir()) == ["lonely", "spheres.nff"]


def test_a_kernel_that_does_not_build(cli: Any, scene: Path) -> None:
    done = cli("render", scene, "-o", "a.png", env=BROKEN)
    assert done.returncode == 1
    message = next(line for line in done.stderr.splitlines() if line.startswith("feeler: "))
    assert re.match(r"feeler: the kernels do not build: \w+\.cl:[1-9]\d*\b", message), message
    assert sorted(p.name for p in scene.parent.iterdir()) == ["spheres.nff"]


def test_a_kernel_that_does_not_build_in_python(scene: Path) -> None:
    code = f"""
import feeler
try:
    feeler.load({str(scene)!r}).render()
except feeler.Error as error:
    print(error.kind, error.text, error.log, sep="\\n")
"""
    done = subprocess.run([sys.executable, "-c", code], env=BROKEN, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    kind, text, log = done.stdout.split("\n", 2)
    assert kind == "device"
    assert re.search(r"\w+\.cl:[1-9]\d*\b", text)
    assert "error: " in log
