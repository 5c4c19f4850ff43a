#!/usr/bin/env python3
"""Writes three chains that are linked as Borromean rings: no two hold each other, all three together do not come apart.

    generate_rings.py [SEGMENTS] > rings.yaml

Each chain runs along an ellipse, in three planes at right angles. Its links are rings of SEGMENTS open cylinders with
spheres at their joints (an even number of links, each turned a quarter against the one before).
"""

from __future__ import annotations

import math
import sys

Vector = tuple[float, float, float]

LINKS = 30
LONG, SHORT = 2.15, 1.2  # the ellipse's half axes
WIRE = 0.062
ROUNDNESS = 0.62  # a link's width against its length

HEAD = """\
# Three chains linked as Borromean rings: {count} cylinders and as many spheres. Made by generate_rings.py.
camera: {{eye: [4.2, 4.1, 6.6], look_at: [0.1, -0.3, 0], fov: 36}}
image: {{size: [640, 480], samples: 16}}
background: [0.42, 0.46, 0.52]
ambient: 0.2
depth: 5
cutoff: 0.01

lights:
  - {{point: [-4, 9, 6], colour: [0.78, 0.74, 0.68]}}
  - {{point: [8, 4, 2], colour: [0.24, 0.27, 0.34]}}

materials:
  gold: {{ambient: [0.5, 0.34, 0.1], diffuse: [0.42, 0.28, 0.08], specular: [0.6, 0.5, 0.3], shininess: 90,
    reflection: [0.56, 0.42, 0.18]}}
  silver: {{ambient: 0.3, diffuse: 0.26, specular: 0.8, shininess: 120, reflection: [0.55, 0.56, 0.58]}}
  copper: {{ambient: [0.5, 0.2, 0.12], diffuse: [0.42, 0.16, 0.09], specular: [0.6, 0.4, 0.3], shininess: 90,
    reflection: [0.5, 0.26, 0.18]}}
  floor: {{ambient: [0.66, 0.58, 0.48], diffuse: [0.64, 0.56, 0.46], reflection: 0.14}}

objects:
  - {{plane: {{point: [0, -2.4, 0], normal: [0, 1, 0]}}, material: floor}}
"""


def combine(a: float, u: Vector, b: float, v: Vector, start: Vector) -> Vector:
    return (start[0] + a * u[0] + b * v[0], start[1] + a * u[1] + b * v[1], start[2] + a * u[2] + b * v[2])


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def ellipse(turn: float) -> tuple[float, float]:
    return LONG * math.cos(turn), SHORT * math.sin(turn)


def even_turns(count: int) -> list[float]:
    """Parameters of points that cut the ellipse into parts of equal length."""
    steps = 4096
    lengths = [0.0]
    for i in range(steps):
        a, b = ellipse(2 * math.pi * i / steps), ellipse(2 * math.pi * (i + 1) / steps)
        lengths.append(lengths[-1] + math.dist(a, b))
    turns, i = [], 0
    for k in range(count):
        while lengths[i + 1] < lengths[-1] * k / count:
            i += 1
        turns.append(2 * math.pi * i / steps)
    return turns


def text(p: Vector) -> str:
    return f"[{p[0]:.5f}, {p[1]:.5f}, {p[2]:.5f}]"


def link(centre: Vector, along: Vector, aside: Vector, half: float, segments: int, material: str) -> None:
    """One ring: an oval of cylinders, half its length along the chain."""
    points = []
    for i in range(segments):
        angle = 2 * math.pi * i / segments
        points.append(combine(half * math.cos(angle), along, half * ROUNDNESS * math.sin(angle), aside, centre))
    for i, p in enumerate(points):
        q = points[(i + 1) % segments]
        print(f"  - material: {material}")
        print(f"    cylinder: {{base: {text(p)}, top: {text(q)}, radius: {WIRE}, capped: false}}")
        print(f"  - {{sphere: {{centre: {text(p)}, radius: {WIRE}}}, material: {material}}}")


def chain(u: Vector, v: Vector, segments: int, material: str) -> None:
    normal = cross(u, v)
    turns = even_turns(LINKS)
    places = [combine(*pair(ellipse(t), u, v), (0, 0, 0)) for t in turns]
    spacing = math.dist(places[0], places[1])
    # Neighbours hold each other: a link is as much longer than the spacing as its own wire and its neighbour's need.
    half = spacing / 2 + 2 * WIRE
    for k, place in enumerate(places):
        a, b = -LONG * math.sin(turns[k]), SHORT * math.cos(turns[k])
        length = math.hypot(a, b)
        along = combine(a / length, u, b / length, v, (0, 0, 0))
        across = cross(normal, along)
        tilt = math.pi / 4 + (k % 2) * math.pi / 2
        link(place, along, combine(math.cos(tilt), normal, math.sin(tilt), across, (0, 0, 0)), half, segments, material)


def pair(coordinates: tuple[float, float], u: Vector, v: Vector) -> tuple[float, Vector, float, Vector]:
    return coordinates[0], u, coordinates[1], v


def main() -> None:
    segments = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    if not 3 <= segments <= 1000:
        sys.exit("generate_rings.py: SEGMENTS must be 3 to 1000")
    print(HEAD.format(count=3 * LINKS * segments), end="")
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    chain(x, y, segments, "gold")
    chain(y, z, segments, "silver")
    chain(z, x, segments, "copper")


if __name__ == "__main__":
    main()
