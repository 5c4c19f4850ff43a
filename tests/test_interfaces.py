"""One picture by every way in: C, the program, Python, and queues that a caller makes."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exr import read_exr
from pictures import everything, same_bits
from places import BUILD, ROOT

import feeler


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    return feeler.Scene(everything())


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """render_bits.c, as a user would build a program: the public header and the shared library alone."""
    folder = tmp_path_factory.mktemp("render_bits")
    (folder / "feeler.h").write_text((ROOT / "host" / "feeler.h").read_text())
    compiler = [*shlex.split(os.environ.get("CC", "gcc")), *shlex.split(os.environ.get("CFLAGS", ""))]
    warnings = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    source = ROOT / "tests" / "render_bits.c"
    command = [*compiler, *warnings, f"-I{folder}", "-o", folder / "render_bits", source, f"-L{BUILD}", "-lfeeler"]
    subprocess.run([*command, f"-Wl,-rpath,{BUILD}"], check=True)
    return folder / "render_bits"


@pytest.mark.parametrize("level", ["standard", "reference"])
def test_c_and_the_program_and_python(cli: Any, compiled: Path, tmp_path: Path, level: str) -> None:
    """The same file; in double, the EXR is its rounding to float."""
    (tmp_path / "scene.yaml").write_text(json.dumps(everything()))
    number = ["draft", "standard", "reference"].index(level)
    done = subprocess.run(
        [compiled, "scene.yaml", str(number), "bits"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    expected = feeler.load(tmp_path / "scene.yaml").render(level=level).pixels
    assert expected.dtype == (np.float64 if level == "reference" else np.float32)
    assert len(np.unique(expected.reshape(-1, 4), axis=0)) > 500
    assert same_bits(np.fromfile(tmp_path / "bits", expected.dtype).reshape(expected.shape), expected)
    done = cli("render", "scene.yaml", "-o", "out.exr", "--level", level)
    assert done.returncode == 0, done.stderr
    assert same_bits(read_exr(tmp_path / "out.exr")[0], np.ascontiguousarray(expected[..., :3].astype(np.float32)))


def test_the_c_program_reports_errors(compiled: Path, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text("depht: 3\n")
    done = subprocess.run(
        [compiled, "scene.yaml", "1", "bits"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr.startswith("scene.yaml:1:1: ")
    assert not (tmp_path / "bits").exists()


def test_a_queue_out_of_order(scene: feeler.Scene, queue: Any) -> None:
    """Many launches that the queue may reorder: each one's results wait for it."""
    import pyopencl as cl

    flags = cl.command_queue_properties
    for properties in (
        flags.OUT_OF_ORDER_EXEC_MODE_ENABLE,
        flags.OUT_OF_ORDER_EXEC_MODE_ENABLE | flags.PROFILING_ENABLE,
    ):
        loose = cl.CommandQueue(queue.context, properties=properties)
        expected = scene.render().pixels
        for _ in range(3):
            assert same_bits(scene.render(queue=loose, tile=64).pixels, expected)


MATTE = {"image": {"size": [32, 24]}, "lights": [{"point": [3, 4, 5]}], "objects": [{"sphere": {"radius": 3}}]}


@pytest.mark.parametrize("description", [everything(), MATTE], ids=["everything", "matte"])
def test_writes_that_a_launch_could_overtake(cli: Any, tmp_path: Path, description: dict[str, Any]) -> None:
    """Nothing is launched before the scene is on the device, though a blocking write need not wait for that."""
    library = tmp_path / "late_driver.so"
    compiler = [*shlex.split(os.environ.get("CC", "gcc")), "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([*compiler, "-o", library, ROOT / "tests" / "late_driver.c", "-ldl"], check=True)
    (tmp_path / "scene.yaml").write_text(json.dumps(description))
    for name, environment in (("usual", {}), ("late", {"LD_PRELOAD": str(library)})):
        done = cli("render", "scene.yaml", "-o", f"{name}.exr", env={**os.environ, **environment})
        assert done.returncode == 0, done.stderr
    assert same_bits(read_exr(tmp_path / "late.exr")[0], read_exr(tmp_path / "usual.exr")[0])


@pytest.mark.parametrize("profiling", [False, True])
def test_times_of_a_queue(scene: feeler.Scene, queue: Any, profiling: bool) -> None:
    import pyopencl as cl

    properties = cl.command_queue_properties.PROFILING_ENABLE if profiling else 0
    own = cl.CommandQueue(queue.context, properties=properties)
    for tile in (64, None):
        seconds = scene.render(queue=own, tile=tile, size=(96, 72)).stats["seconds"]
        assert 0 <= seconds["trace"] <= seconds["total"], (tile, seconds)
        assert 0 < seconds["kernel"] <= seconds["trace"] if profiling else seconds["kernel"] is None, (tile, seconds)
