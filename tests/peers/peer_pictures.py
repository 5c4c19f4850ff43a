"""Our pictures and those of other renderers, how they differ, and whether an edge explains it."""

from __future__ import annotations

import functools
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from exr import read_exr
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from PIL import Image

Pixels = NDArray[Any]  # linear RGB, (height, width, 3), row 0 at the top

SIZE = 512
FINE = (
    3 * (SIZE - 1) + 1
)  # an NFF view spans pixel centres: every third centre of a picture of this size is one of SIZE
OFF = 0.05
FOLDER = Path(__file__).resolve().parents[2] / "build" / "peers"  # of pictures and programs


@functools.cache
def render(program: Path, scene: Path, size: int, level: str = "standard") -> Pixels:
    """Our picture of a scene: linear RGB."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    out = FOLDER / f"{scene.stem}-{size}-{level}.exr"
    options = ["--size", f"{size}x{size}", "--samples", "1", "--level", level, "--quiet"]
    subprocess.run([program, "render", scene, "-o", out, *options], check=True, timeout=600)
    return read_exr(out)[0][..., :3]


def read_pfm(path: Path) -> Pixels:
    """A colour PFM, its rows turned over: the file begins with the lowest."""
    kind, size, scale, data = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert (kind, float(scale)) == (b"PF", -1)
    return np.frombuffer(data, "<f4").reshape(height, width, 3)[::-1]


def read_ppm(path: Path) -> Pixels:
    """A binary PPM of 16 bits, from 0 to 1."""
    data = path.read_bytes()
    header = re.match(rb"P6" + 3 * rb"\s+(?:#.*\n\s*)*(\d+)" + rb"\s", data)
    assert header
    width, height, greatest = map(int, header.groups())
    assert greatest == 65535
    return np.frombuffer(data[header.end() :], ">u2").reshape(height, width, 3) / greatest


def find_range(fine: Pixels) -> tuple[Pixels, Pixels]:
    """The least and the greatest of each channel within a pixel of each pixel's centre, from the picture of size FINE."""
    padded = np.pad(fine, ((3, 3), (3, 3), (0, 0)), mode="edge")
    windows = sliding_window_view(padded, (7, 7), (0, 1))[::3, ::3]
    return windows.min((-1, -2)), windows.max((-1, -2))


@dataclass
class Comparison:
    """How two pictures differ.

    Attributes:
        mean: of the absolute differences of all channels.
        off: share of the pixels whose mean over the channels is off by more than OFF.
        channel_off: share of the pixels of which some channel is.
        unexplained: share of the latter that no edge explains: theirs is nowhere within a pixel of ours.
    """

    mean: float
    off: float
    channel_off: float
    unexplained: float


def compare(ours: Pixels, theirs: Pixels, fine: Pixels) -> Comparison:
    """Compares two pictures of the same size.

    At a silhouette or a shadow's edge a renderer may see either side, and both are near in our fine picture. A shade that
    is wrong is not there: `unexplained` finds it, however few the pixels.
    """
    difference = np.abs(ours - theirs)
    channel_off = difference.max(-1) > OFF
    low, high = find_range(fine)
    within = ((theirs >= low - 0.02) & (theirs <= high + 0.02)).all(-1)
    return Comparison(
        float(difference.mean()),
        float((difference.mean(-1) > OFF).mean()),
        float(channel_off.mean()),
        float((channel_off & ~within).mean()),
    )


def save_difference(name: str, ours: Pixels, theirs: Pixels) -> None:
    """Writes build/peers/NAME.png: ours, theirs and eight times their absolute difference, side by side."""
    row = np.concatenate([ours, theirs, 8 * np.abs(ours - theirs)], axis=1)
    Image.fromarray((255 * np.clip(row, 0, 1) ** (1 / 2.2)).astype(np.uint8)).save(FOLDER / f"{name}.png")
