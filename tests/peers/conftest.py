"""The tracers on Embree: ours, which the Makefile builds, and the shared one, which is compiled here."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from peer_pictures import FOLDER

EPSILON = "epsilon = 1e-4f"
PREPROCESS = ["g++", "-E", "-x", "c++", "-include", "embree3/rtcore.h", "/dev/null"]

Build = Callable[[str, str], Path]


@pytest.fixture(scope="session")
def own_embree() -> Path:
    """The project's tracer."""
    path = FOLDER / "embree_whitted"
    if not path.is_file():
        pytest.skip("build/peers/embree_whitted is not built: `make peers`, which needs libembree-dev")
    return path


@pytest.fixture(scope="session")
def build(peers: Path) -> Build:
    """Compiles the shared tracer under a name, with an epsilon in place of its own."""
    source = peers / "embree_whitted.cpp"
    if not source.is_file():
        pytest.skip(f"there is no {source}")
    if not shutil.which("g++") or subprocess.run(PREPROCESS, check=False, capture_output=True).returncode != 0:
        pytest.skip("g++ or Embree 3 is missing: install g++ and libembree-dev")

    def compile_with(name: str, epsilon: str) -> Path:
        FOLDER.mkdir(parents=True, exist_ok=True)
        text = source.read_text()
        assert text.count(EPSILON) == 1
        command = ["g++", "-std=c++17", "-O3", "-march=native", "-x", "c++", "-", "-o", str(FOLDER / name)]
        command += ["-lembree3", "-lpthread"]
        subprocess.run(command, input=text.replace(EPSILON, epsilon), text=True, check=True, timeout=300)
        return FOLDER / name

    return compile_with


@pytest.fixture(scope="session")
def embree(build: Build) -> Path:
    return build("embree_shared", EPSILON)


@pytest.fixture(scope="session")
def close_embree(build: Build) -> Path:
    """Its secondary rays start a hundredth as far from their surface; on these scenes that is still far enough."""
    return build("embree_shared_close", "epsilon = 1e-6f")
