"""What the readers make of a file: the scene in memory as a dict, through the small C program describe_scene.c."""

from __future__ import annotations

import functools
import json
import os
import shlex
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import pytest
from places import BUILD, ROOT

# The program's own files are no part of the library.
PROGRAM = ("main", "options", "progress", "cmd_")


@functools.cache
def describer() -> Path:
    """The compiled program. Links the library's objects, since the library hides what is not public."""
    objects = [path for path in sorted(BUILD.glob("*.o")) if not path.stem.startswith(PROGRAM)]
    if not objects:
        pytest.fail(f"there are no object files in {BUILD}: run `make`")
    folder = Path(tempfile.mkdtemp(prefix="feeler-describe-"))
    archive, program = folder / "libfeeler.a", folder / "describe_scene"
    subprocess.run(["ar", "rcs", archive, *objects], check=True)
    flags = subprocess.run(
        ["pkg-config", "--libs", "assimp", "yaml-0.1"], check=True, capture_output=True, text=True
    ).stdout
    source = ROOT / "tests" / "describe_scene.c"
    compiler = [*shlex.split(os.environ.get("CC", "gcc")), *shlex.split(os.environ.get("CFLAGS", ""))]
    command = [
        *compiler,
        "-std=c11",
        "-Wall",
        "-Wextra",
        "-Werror",
        f"-I{ROOT / 'host'}",
        "-o",
        program,
        source,
        archive,
    ]
    subprocess.run([*command, *shlex.split(flags), "-lm", "-pthread"], check=True)
    return program


def describe(path: Path) -> dict[str, Any]:
    """The scene in `path`; see describe_scene.c for the keys."""
    done = subprocess.run([describer(), path], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr, "the readers print nothing"
    return json.loads(done.stdout)


def refusal(path: Path) -> str:
    """The error for a file that is refused."""
    done = subprocess.run(
        [describer(), path.name], capture_output=True, text=True, timeout=60, check=False, cwd=path.parent
    )
    assert done.returncode == 1 and not done.stdout
    return done.stderr.removesuffix("\n")
