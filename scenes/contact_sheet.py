#!/usr/bin/env python3
"""Puts the gallery's pictures on one sheet.

    contact_sheet.py OUT.png FOLDER

FOLDER holds the pictures of 640 x 480 that `make gallery` rendered. Needs numpy and matplotlib.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

mpl.use("Agg")
from matplotlib import pyplot as plt

Picture = NDArray[np.float32]

WIDTH, HEIGHT, GAP, CAPTION = 320, 240, 8, 24
PAPER, INK = "#1b1d20", "#c9ced6"

# What stands at (row, column), some twice as wide and high as the others. Two names in a cell are shown half and half.
CELLS = {
    (0, 0): (("first",), "first: the demo picture"),
    (0, 2): (("still-life",), "still-life: every term of the model"),
    (0, 3): (("water",), "water: total internal reflection"),
    (1, 2): (("glass-of-water",), "glass-of-water: media that touch and overlap"),
    (2, 0): (("night",), "night: emission, diffuse transmission"),
    (2, 1): (("mirror-room",), "mirror-room: depth 48"),
    (3, 0): (("forest",), "forest: instances of groves of two trees"),
    (3, 2): (("figure-16-1", "figure-16-1-shadow"), "figure-16-1: without | with shadow"),
    (3, 3): (("sphereflake",), "sphereflake: level 4, generated"),
    (4, 2): (("rings",), "rings: Borromean chains, generated"),
    (4, 3): (("seashell",), "seashell: a mesh, generated"),
}
LARGE = [(0, 0), (1, 2), (3, 0)]


def read(path: Path) -> Picture:
    picture: Picture = np.asarray(plt.imread(path), np.float32)[..., :3]
    if picture.shape != (2 * HEIGHT, 2 * WIDTH, 3):
        sys.exit(f"contact_sheet.py: {path} is not {2 * WIDTH} x {2 * HEIGHT}")
    return picture


def halve(picture: Picture) -> Picture:
    """Averages blocks of two by two pixels."""
    half: Picture = picture.reshape(HEIGHT, 2, WIDTH, 2, 3).mean(axis=(1, 3))
    return half


def side_by_side(left: Picture, right: Picture) -> Picture:
    """The left half of one and the right half of the other, with a line between them."""
    joined = np.hstack((left[:, :WIDTH], right[:, WIDTH:]))
    joined[:, WIDTH - 1 : WIDTH + 1] = 1
    return joined


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit("usage: contact_sheet.py OUT.png FOLDER")
    out, folder = Path(sys.argv[1]), Path(sys.argv[2])
    cell_width, cell_height = WIDTH + GAP, HEIGHT + CAPTION + GAP
    width, height = 4 * cell_width + GAP, 5 * cell_height + GAP
    figure = plt.figure(figsize=(width / 100, height / 100), dpi=100, facecolor=PAPER)
    for (row, column), (names, caption) in CELLS.items():
        pictures = [read(folder / f"{name}.png") for name in names]
        picture = side_by_side(*pictures) if len(pictures) == 2 else pictures[0]
        if (row, column) not in LARGE:
            picture = halve(picture)
        x, y = GAP + column * cell_width, GAP + row * cell_height
        if (row, column) in LARGE:
            x, y = x + GAP // 2, y + (CAPTION + GAP) // 2
        figure.figimage(picture, x, height - y - picture.shape[0], origin="upper", resize=False)
        below = height - y - picture.shape[0] - CAPTION * 0.68
        figure.text(x / width, below / height, caption, color=INK, fontsize=9, family="DejaVu Sans")
    figure.savefig(out, dpi=100, facecolor=PAPER, metadata={"Software": None})


if __name__ == "__main__":
    main()
