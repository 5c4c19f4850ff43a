#!/usr/bin/env python3
"""Writes a seashell as a scene beside two mesh files (binary PLY with normals), one for each colour of its bands.

    generate_seashell.py OUT.yaml [LEVEL]

writes OUT.yaml, OUT-light.ply and OUT-dark.ply. LEVEL n has about 2^(2n) * 500 triangles; 4, the default, has 130 000.

The surface is a logarithmic spiral: a ribbed ring that turns around the axis, rises along it and shrinks by the same
factor on every turn. Its normals come from the derivatives of the formula, so the bands' borders meet without a seam.
"""

from __future__ import annotations

import math
import struct
import sys
from pathlib import Path

Vector = tuple[float, float, float]

TURNS = 6.5
SHRINK = math.log(1.72)  # of the size on every turn, as a logarithm
HEIGHT = 1.9  # of the spire, in radii of the spiral
TUBE = 0.93  # the tube's radius against the spiral's
RIBS = 13  # on every turn
BANDS = 9

SCENE = """\
# A seashell of {triangles} triangles with interpolated normals, in two mesh files. Made by generate_seashell.py.
camera: {{eye: [0.4, 3.0, 8.4], look_at: [0.1, 1.12, 0], fov: 31}}
image: {{size: [640, 480], samples: 16}}
background: [0.55, 0.74, 0.82]
ambient: 0.2
depth: 4
cutoff: 0.01

lights:
  - {{point: [-6, 8, 6], colour: [0.74, 0.68, 0.58]}}
  - {{point: [6, 4, 6], diffuse: [0.13, 0.17, 0.21], specular: 0}}

materials:
  light: {{ambient: [0.85, 0.74, 0.62], diffuse: [0.8, 0.69, 0.57], specular: 0.22, shininess: 45, reflection: 0.05}}
  dark: {{ambient: [0.62, 0.3, 0.18], diffuse: [0.62, 0.3, 0.18], specular: 0.22, shininess: 45, reflection: 0.05}}
  sand: {{ambient: [0.74, 0.6, 0.42], diffuse: [0.74, 0.6, 0.42]}}
  sea: {{ambient: [0.1, 0.42, 0.5], diffuse: [0.1, 0.36, 0.44], specular: 0.3, shininess: 60, reflection: 0.3}}
  pearl: {{ambient: [0.7, 0.66, 0.68], diffuse: [0.62, 0.58, 0.6], specular: 0.5, shininess: 120, reflection: 0.2}}

objects:
  - {{box: {{low: [-30, -1, -7], high: [30, 0, 20]}}, material: sand}}
  - {{plane: {{point: [0, -0.06, 0], normal: [0, 1, 0]}}, material: sea}}
  - mesh: {{file: {light}}}
    material: light
    transform: {transform}
  - mesh: {{file: {dark}}}
    material: dark
    transform: {transform}
  - {{sphere: {{centre: [1.75, 0.2, 1.9], radius: 0.2}}, material: pearl}}
  - {{sphere: {{centre: [2.3, 0.14, 1.6], radius: 0.14}}, material: pearl}}
  - {{sphere: {{centre: [-1.9, 0.16, 2.2], radius: 0.16}}, material: pearl}}
"""
TILT = -76.0  # degrees: the spire lies to the right
SIZE = 1.45


def lowest(level: int) -> float:
    """The height of the tilted, scaled shell's lowest point."""
    sine, cosine = math.sin(math.radians(TILT)), math.cos(math.radians(TILT))
    steps = 64 * 2 ** min(level, 2)
    points = [point(1.5 * i / steps, j / 128) for i in range(steps + 1) for j in range(128)]
    return min(SIZE * (sine * x + cosine * y) for x, y, _ in points)


def point(turn: float, around: float) -> Vector:
    """The surface: `turn` counts turns from the mouth inwards, `around` goes once around the tube (0 to 1)."""
    size = math.exp(-SHRINK * turn)
    a, b = 2 * math.pi * turn, 2 * math.pi * around
    rib = 1 + 0.05 * math.cos(RIBS * a) * (0.5 + 0.5 * math.cos(b))
    tube = TUBE * rib * (1 + 0.12 * math.cos(2 * b))
    out = size * (1 + tube * math.cos(b)) * 0.55
    return out * math.cos(a), 0.55 * HEIGHT * 1.55 * (1 - size) + size * tube * math.sin(b) * 0.8, -out * math.sin(a)


def normal(turn: float, around: float) -> Vector:
    h = 1e-5
    a, b = point(turn + h, around), point(turn - h, around)
    c, d = point(turn, around + h), point(turn, around - h)
    u, v = (a[0] - b[0], a[1] - b[1], a[2] - b[2]), (c[0] - d[0], c[1] - d[1], c[2] - d[2])
    n = (v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0])
    length = math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
    return n[0] / length, n[1] / length, n[2] / length


def write_ply(path: Path, vertices: list[bytes], triangles: list[tuple[int, int, int]]) -> None:
    """Only the vertices that the triangles use."""
    used = {old: new for new, old in enumerate(sorted({i for t in triangles for i in t}))}
    properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(used)}\n{properties}"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    body = [vertices[old] for old in used]
    faces = [struct.pack("<Biii", 3, *(used[i] for i in t)) for t in triangles]
    path.write_bytes(head.encode() + b"".join(body) + b"".join(faces))


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit("usage: generate_seashell.py OUT.yaml [LEVEL]")
    out = Path(sys.argv[1])
    level = int(sys.argv[2]) if len(sys.argv) > 2 else 4
    if not 0 <= level <= 6:
        sys.exit("generate_seashell.py: LEVEL must be 0 to 6")
    across = 4 * BANDS * 2 ** max(level - 2, 0)  # a multiple of the bands, so that each border is an edge
    along = max(8, round(TURNS * 70 * 2 ** (level - 4))) * 2
    vertices = []
    for i in range(along + 1):
        for j in range(across):
            where = (TURNS * i / along, j / across)
            vertices.append(struct.pack("<6f", *point(*where), *normal(*where)))
    bands: dict[str, list[tuple[int, int, int]]] = {"light": [], "dark": []}
    for i in range(along):
        for j in range(across):
            a, b = i * across + j, i * across + (j + 1) % across
            band = "dark" if (j * 2 * BANDS // across) % 2 else "light"
            bands[band] += [(a, b, a + across), (b, b + across, a + across)]
    names = {}
    for band, triangles in bands.items():
        names[band] = f"{out.stem}-{band}.ply"
        write_ply(out.with_name(names[band]), vertices, triangles)
    transform = (
        f"[{{scale: {SIZE}}}, {{rotate_z: {TILT}}}, {{rotate_y: -32}}, "
        f"{{translate: [-0.75, {-lowest(level) - 0.12:.5f}, 0.2]}}]"
    )
    count = sum(map(len, bands.values()))
    out.write_text(SCENE.format(triangles=count, transform=transform, **names))


if __name__ == "__main__":
    main()
