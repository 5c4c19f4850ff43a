"""The program on a terminal and under Ctrl-C: progress, colours, and what an interrupted render leaves behind."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import re
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
from exr import read_exr
from spheres import write_spheres


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_spheres(tmp_path / "spheres.nff")


# ---- terminals ----


def stderr_on_a_terminal(program: Path, folder: Path, arguments: list[Any], **environment: str) -> str:
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [program, *arguments], cwd=folder, stderr=theirs, env={**os.environ, "TERM": "xterm", **environment}
    )
    os.close(theirs)
    text = b""
    with contextlib.suppress(OSError):  # Linux's way to say that the other side is closed
        while part := os.read(ours, 4096):
            text += part
    os.close(ours)
    process.wait(timeout=60)
    return text.decode()


def test_progress_on_a_terminal(program: Path, tmp_path: Path, scene: Path) -> None:
    options = ["--size", "256x256", "--samples", "128"]
    text = stderr_on_a_terminal(program, tmp_path, ["render", scene, "-o", "a.png", *options])
    assert re.search(r"\rspheres \[#*-*\] +\d+ %  ETA \d+:\d\d", text)
    assert "Mrays/s" in text.rsplit("\033[K", 1)[1]
    assert stderr_on_a_terminal(program, tmp_path, ["render", scene, "-o", "a.png", "--quiet"]) == ""
    text = stderr_on_a_terminal(program, tmp_path, ["render", scene, "-o", "a.png", *options], TERM="dumb")
    assert "ETA" not in text
    assert "\r" not in text.replace("\r\n", "\n")


def test_colours_on_a_terminal(program: Path, tmp_path: Path) -> None:
    call = ["render", "missing.nff", "-o", "a.png"]
    assert "\033[1;31mfeeler:" in stderr_on_a_terminal(program, tmp_path, call, NO_COLOR="")
    assert "\033" not in stderr_on_a_terminal(program, tmp_path, call, NO_COLOR="1")
    assert "\033" not in stderr_on_a_terminal(program, tmp_path, call, NO_COLOR="", TERM="dumb")


# ---- interruption ----


def start_long_render(program: Path, folder: Path, scene: Path) -> subprocess.Popen[str]:
    """That has its kernel already and is at its tiles: how long a compiler takes on a busy machine is not known."""
    options = ["--size", "2048x2048", "--samples", "4096"]
    warm = [program, "render", scene, "-o", "warm.exr", *options, "--region", "0,0,8,8", "--quiet"]
    subprocess.run(warm, cwd=folder, check=True, timeout=300)
    (folder / "warm.exr").unlink()
    options += ["--stats", "a.json"]
    process = subprocess.Popen(
        [program, "render", scene, "-o", "a.exr", *options], cwd=folder, stderr=subprocess.PIPE, text=True
    )
    time.sleep(4)
    assert process.poll() is None, "the render ended before it could be interrupted"
    return process


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interruption(program: Path, tmp_path: Path, scene: Path, number: signal.Signals) -> None:
    (tmp_path / "a.exr").write_text("old")
    process = start_long_render(program, tmp_path, scene)
    process.send_signal(number)
    start = time.monotonic()
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert time.monotonic() - start < 5
    assert "interrupted" in stderr
    assert "a.partial.exr" in stderr
    assert (tmp_path / "a.exr").read_text() == "old"
    assert not (tmp_path / "a.json").exists()
    pixels, header = read_exr(tmp_path / "a.partial.exr")
    assert pixels.shape == (2048, 2048, 3)
    assert "interrupted" in header["feeler:interrupted"]
    assert json.loads((tmp_path / "a.partial.json").read_text())["size"] == [2048, 2048]
    assert not list(tmp_path.glob(".*"))


def test_interruption_stops_the_scenes_that_follow(program: Path, tmp_path: Path, scene: Path) -> None:
    write_spheres(tmp_path / "second.nff")
    process = subprocess.Popen(
        [program, "render", scene, "second.nff", "-o", "{name}.png", "--size", "2048x2048", "--samples", "4096", "-q"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(3)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["second.nff", "spheres.nff", "spheres.partial.png"]
