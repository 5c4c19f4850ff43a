"""Scenes of 10³ … 10⁷ primitives, for how time grows with their number: spheres in a cube, and a height field as a mesh.

    growth_scenes.py spheres FOLDER N    writes spheres-N.nff, which both tracers read
    growth_scenes.py field FOLDER N      writes field-N.ply, with field-N.yaml for feeler and field-N.nff for Embree

and prints as JSON what it wrote.
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

BACKGROUND = "0.078 0.361 0.753"
LIGHT = "3 1 5"
SIZE = 1024


@dataclass(frozen=True)
class GrowthScene:
    """A scene for feeler and the same for the Embree tracer; `primitives` as it came out, near the number asked for."""

    primitives: int
    ours: Path
    theirs: Path
    mesh: Path | None = None


def _nff_head(eye: str, look_at: str, angle: float, fill: str) -> str:
    return (
        f"v\nfrom {eye}\nat {look_at}\nup 0 0 1\nangle {angle!r}\nhither 0.01\nresolution {SIZE} {SIZE}\n"
        f"b {BACKGROUND}\nl {LIGHT}\nf {fill}\n"
    )


def write_spheres(folder: Path, count: int) -> GrowthScene:
    """Mirroring spheres anywhere in the unit cube; they fill 7 % of it, whatever their number."""
    path = folder / f"spheres-{count}.nff"
    random = np.random.default_rng(1)
    line = f"s %.7f %.7f %.7f {0.25 * count ** (-1 / 3):.7g}\n"
    with path.open("w") as file:
        file.write(_nff_head("1.9 1.6 2.1", "0.5 0.5 0.5", 32, "1 0.75 0.33 0.6 0.3 20 0 0"))
        for first in range(0, count, 100_000):
            centres = random.random((min(100_000, count - first), 3))
            file.write(line * len(centres) % tuple(centres.ravel().tolist()))
    return GrowthScene(count, path, path)


def _heights(side: int) -> np.ndarray:
    """Waves of eight octaves over the unit square, (side, side, 3): x, y, z."""
    random = np.random.default_rng(1)
    x, y = np.meshgrid(*2 * [np.linspace(0, 1, side, dtype=np.float32)])
    z = np.zeros_like(x)
    for frequency in 2.0 ** np.arange(2, 10):
        a, b, c = random.random(3) * 2 * math.pi
        z += (
            0.25 / frequency * (np.sin(frequency * x + a) * np.cos(frequency * y + b) + np.sin(frequency * (x + y) + c))
        )
    return np.stack([x, y, z], -1)


def _faces(side: int) -> np.ndarray:
    """Two triangles for each square of the grid."""
    at = np.arange(side * side, dtype=np.int32).reshape(side, side)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    faces = np.empty((side - 1, side - 1, 2), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"][:, :, 0] = np.stack([a, b, c], -1)
    faces["corners"][:, :, 1] = np.stack([a, c, d], -1)
    return faces


def write_field(folder: Path, count: int) -> GrowthScene:
    """A height field of some `count` triangles, as binary PLY, with a scene for each tracer."""
    side = round(math.sqrt(count / 2)) + 1
    mesh, ours, theirs = (folder / f"field-{count}.{ending}" for ending in ("ply", "yaml", "nff"))
    vertices, faces = _heights(side).astype("<f4"), _faces(side)
    with mesh.open("wb") as file:
        file.write(
            f"ply\nformat binary_little_endian 1.0\nelement vertex {side * side}\n"
            f"property float x\nproperty float y\nproperty float z\nelement face {faces.size}\n"
            f"property list uchar int vertex_indices\nend_header\n".encode()
        )
        vertices.tofile(file)
        faces.tofile(file)
    fov = 45.0
    # NFF's angle spans pixel centres, our fov pixel edges.
    angle = math.degrees(2 * math.atan(math.tan(math.radians(fov / 2)) * (SIZE - 1) / SIZE))
    theirs.write_text(_nff_head("0.5 -0.7 0.7", "0.5 0.45 0", angle, "1 0.85 0.7 0.7 0 1 0 0"))
    ours.write_text(
        f"camera: {{eye: [0.5, -0.7, 0.7], look_at: [0.5, 0.45, 0], up: [0, 0, 1], fov: {fov}}}\n"
        f"image: {{size: [{SIZE}, {SIZE}]}}\n"
        f"background: [{', '.join(BACKGROUND.split())}]\n"
        f"lights: [{{point: [{', '.join(LIGHT.split())}]}}]\n"
        f"objects: [{{mesh: {{file: {mesh.name}}}, material: {{diffuse: [0.7, 0.595, 0.49]}}}}]\n"
    )
    return GrowthScene(faces.size, ours, theirs, mesh)


KINDS = {"spheres": write_spheres, "field": write_field}

if __name__ == "__main__":
    into = Path(sys.argv[2])
    into.mkdir(parents=True, exist_ok=True)
    scene = KINDS[sys.argv[1]](into, int(sys.argv[3]))
    print(json.dumps(asdict(scene), default=str))
