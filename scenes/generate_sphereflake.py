#!/usr/bin/env python3
"""Writes a sphereflake: a sphere that carries smaller ones, which carry smaller ones, down to a level.

    generate_sphereflake.py [LEVEL] > sphereflake.yaml

The children of a sphere stand where a spiral of golden angles meets the cap around its outward axis; every one touches
its parent and is RATIO as large. A level has nine times the spheres of the one above: in all 1, 10, 91, 820, 7381, …
"""

from __future__ import annotations

import math
import sys

Vector = tuple[float, float, float]

CHILDREN = 9
RATIO = 0.37
CAP = math.radians(112)  # how far from the axis the children reach
GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))

HEAD = """\
# A sphereflake of level {level}: {count} spheres. Made by generate_sphereflake.py.
camera: {{eye: [2.2, 4.2, 6.6], look_at: [0.1, 1.3, 0], fov: 31}}
image: {{size: [640, 480], samples: 16}}
background: [0.12, 0.16, 0.24]
ambient: 0.2
depth: 6
cutoff: 0.01

lights:
  - {{point: [-6, 9, 7], colour: [1.15, 1.08, 0.95]}}
  - {{point: [7, 5, 3], colour: [0.16, 0.24, 0.4]}}

materials:
  floor: {{ambient: [0.05, 0.08, 0.13], diffuse: [0.07, 0.1, 0.17], reflection: 0.35}}
{materials}
objects:
  - {{plane: {{point: [0, 0, 0], normal: [0, 1, 0]}}, material: floor}}
"""

# From the largest sphere to the smallest: embers to flames.
COLOURS = [
    (0.5, 0.07, 0.1),
    (0.72, 0.16, 0.08),
    (0.95, 0.42, 0.1),
    (1.0, 0.7, 0.25),
    (1.0, 0.93, 0.7),
    (1.0, 1.0, 0.95),
]


def material(level: int) -> str:
    r, g, b = COLOURS[level % len(COLOURS)]
    shares = [f"[{r * k:.3f}, {g * k:.3f}, {b * k:.3f}]" for k in (0.6, 0.62, 0.3)]
    return (
        f"  glaze-{level}: {{ambient: {shares[0]}, diffuse: {shares[1]}, specular: 0.4, shininess: 90, "
        f"reflection: {shares[2]}}}\n"
    )


def across(axis: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors that make a right-handed frame with a unit vector."""
    x, y, z = axis
    helper = (1.0, 0.0, 0.0) if abs(x) < 0.6 else (0.0, 1.0, 0.0)
    u = (y * helper[2] - z * helper[1], z * helper[0] - x * helper[2], x * helper[1] - y * helper[0])
    length = math.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
    u = (u[0] / length, u[1] / length, u[2] / length)
    return u, (y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0])


def directions(axis: Vector) -> list[Vector]:
    """Unit vectors around the axis, evenly over the cap: equal steps of the cosine, golden angles around."""
    u, v = across(axis)
    found = []
    for i in range(CHILDREN):
        cosine = 1 - (1 - math.cos(CAP)) * (i + 0.5) / CHILDREN
        sine = math.sqrt(1 - cosine * cosine)
        a, b = sine * math.cos(i * GOLDEN_ANGLE), sine * math.sin(i * GOLDEN_ANGLE)
        found.append(tuple(cosine * axis[k] + a * u[k] + b * v[k] for k in range(3)))
    return found  # type: ignore[return-value]


def grow(centre: Vector, radius: float, axis: Vector, level: int, deepest: int) -> None:
    x, y, z = centre
    print(f"  - {{sphere: {{centre: [{x:.6f}, {y:.6f}, {z:.6f}], radius: {radius:.6f}}}, material: glaze-{level}}}")
    if level == deepest:
        return
    small = radius * RATIO
    for d in directions(axis):
        reach = radius + small
        grow((x + reach * d[0], y + reach * d[1], z + reach * d[2]), small, d, level + 1, deepest)


def main() -> None:
    level = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    if not 0 <= level <= 7:
        sys.exit("generate_sphereflake.py: LEVEL must be 0 to 7")
    count = sum(CHILDREN**i for i in range(level + 1))
    materials = "".join(material(i) for i in range(level + 1))
    print(HEAD.format(level=level, count=count, materials=materials), end="")
    grow((0, 1.05, 0), 1.0, (0, 1, 0), 0, level)


if __name__ == "__main__":
    main()
