"""Row 22: the shadow terminator of smooth normals."""

from __future__ import annotations

from typing import Any

import numpy as np

import feeler

from .cost import PictureCost
from .study import DOUBLE, NAIVE, OTHER, ROBUST, Curve, Panel, Study

SEGMENTS = [8, 12, 16, 24, 32, 64, 128]


def globe(segments: int, smooth: bool) -> dict[str, Any]:
    """A unit sphere of so many segments and half as many rings."""
    rings = segments // 2
    vertices = [[0, 1, 0]]
    for i in range(1, rings):
        polar = np.pi * i / rings
        turn = 2 * np.pi * np.arange(segments) / segments
        vertices += np.stack(
            [np.sin(polar) * np.cos(turn), 0 * turn + np.cos(polar), np.sin(polar) * np.sin(turn)], 1
        ).tolist()
    vertices.append([0, -1, 0])
    last, faces = len(vertices) - 1, []
    for j in range(segments):
        k = (j + 1) % segments
        faces.append([0, 1 + k, 1 + j])
        faces.append([last, last - segments + j, last - segments + k])
        for i in range(rings - 2):
            a, b = 1 + i * segments, 1 + (i + 1) * segments
            faces += [[a + j, a + k, b + k], [a + j, b + k, b + j]]
    return {"mesh": {"vertices": vertices, "triangles": faces, "normals": vertices, "smooth": smooth}}


def see(shape: dict[str, Any], level: str, terminator: bool = False, samples: int = 1) -> feeler.Image:
    """Lit from the side and seen from the front. `terminator`: smooth_terminator."""
    return feeler.Scene({
        "camera": {"eye": [0, 0, 6], "look_at": [0, 0, 0], "fov": 22},
        "image": {"size": [160, 160]},
        "lights": [{"directional": [-1, -0.3, -0.2]}],
        "objects": [{**shape, "material": {"diffuse": 1}}],
        "smooth_terminator": terminator,
    }).render(level=level, samples=samples)  # fmt: skip


def picture(shape: dict[str, Any], level: str, terminator: bool = False) -> Any:
    return see(shape, level, terminator).pixels[..., 0]


def terminator() -> list[Panel]:
    exact = picture({"sphere": {"radius": 1}}, "reference")

    def error(segments: int, smooth: bool, level: str, terminator: bool = False) -> float:
        """The mean of the difference where either is between black and a third: at the terminator, and off the outline."""
        found = picture(globe(segments, smooth), level, terminator)
        y, x = np.mgrid[:160, :160] - 79.5
        inside = np.hypot(x, y) < 0.75 * 160 / 2 / np.tan(np.radians(11)) / np.sqrt(35)
        near = inside & (np.maximum(found, exact) > 0) & (exact < 0.33)
        return float(abs(found - exact)[near].mean())

    sagitta = 1 - np.cos(np.pi / np.array(SEGMENTS))  # of the facets
    naive = [error(s, True, "standard") for s in SEGMENTS]
    robust = [error(s, True, "standard", True) for s in SEGMENTS]
    claims: dict[str, Any] = {
        # The remedy leaves a third to a seventh of it, and flat facets are 2.5 to 65 times worse.
        NAIVE: {
            "figures": [0.07, None, 0.01, None, None, None, 0.0002],
            "bound": [8.4 * r for r in robust],
            "fails": [2.4 * r for r in robust],
        },
        ROBUST: {"figures": [0.01, None, 0.003, *[None] * 4], "bound": list(sagitta / 4)},
        DOUBLE: {"bound": [1.0001 * n for n in naive], "fails": [0.9999 * n for n in naive]},
        OTHER: {
            "figures": [2.5 * naive[0], *[None] * 5, 65 * naive[-1]],
            "bound": [78 * n for n in naive],
            "fails": [2 * n for n in naive],
        },
    }
    return [
        Panel("a smooth mesh against the sphere itself", "segments around", SEGMENTS, "mean error at the terminator", [
            Curve("smooth normals, facets decide, float", NAIVE, naive, **claims[NAIVE]),
            Curve("smooth_terminator, float", ROBUST, robust, **claims[ROBUST]),
            Curve("the same, double", DOUBLE, [error(s, True, "reference") for s in SEGMENTS], **claims[DOUBLE]),
            Curve("flat facets, float", OTHER, [error(s, False, "standard") for s in SEGMENTS], **claims[OTHER]),
        ]),
    ]  # fmt: skip


STUDIES = [
    Study(22, "shadow terminator", "the analytic sphere", terminator,
          PictureCost("a picture of a globe of 64 segments", lambda: see(globe(64, True), "standard", True, 16),
                      lambda: see(globe(64, True), "standard", False, 16)), slow=True),
]  # fmt: skip
