"""Writes an NFF scene for POV-Ray 3.7, so that both renderers compute the same picture.

    write_pov.py SCENE.nff SCENE.pov
    povray +ISCENE.pov +OSCENE.png +W512 +H512 -D -A

No ambient light, white highlights, mirror share Ks, transmitted share T, depth 5, no cutoff, linear colours.
"""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from pathlib import Path

from nff import Cone, Fill, Polygon, Scene, Sphere, Vector, read_nff


def _subtract(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _unit(a: Vector) -> Vector:
    length = math.sqrt(_dot(a, a))
    return a[0] / length, a[1] / length, a[2] / length


def _text(v: Vector) -> str:
    return f"<{v[0]!r}, {v[1]!r}, {v[2]!r}>"


def _is_convex(corners: list[Vector]) -> bool:
    """Whether all corners turn one way, and only once round: a fan from any of them then covers the polygon."""
    count = len(corners)
    edges = [_subtract(corners[(k + 1) % count], corners[k]) for k in range(count)]
    turns = [_cross(edges[k - 1], edges[k]) for k in range(count)]
    angles = [math.atan2(math.sqrt(_dot(t, t)), _dot(edges[k - 1], edges[k])) for k, t in enumerate(turns)]
    return all(_dot(t, turns[0]) >= 0 for t in turns) and sum(angles) < 7


def _camera(scene: Scene) -> str:
    forward = _unit(_subtract(scene.look_at, scene.eye))
    right = _unit(_cross(forward, scene.up))
    up = _cross(right, forward)
    extent = 2 * math.tan(math.radians(scene.angle) / 2)
    return (
        # NFF's angle spans pixel centres, POV-Ray's frame their outer edges.
        f"#declare Extent = {extent!r} * image_height / (image_height - 1);\n"
        f"camera {{ perspective location {_text(scene.eye)} direction {_text(forward)} "
        f"right Extent * {_text(right)} up Extent * {_text(up)} }}"
    )


def _material(name: str, fill: Fill) -> str:
    # Of diffuse, phong and reflection POV-Ray multiplies diffuse alone by 1 - transmit.
    finish = f"ambient 0 diffuse {fill.kd / (1 - fill.t) if fill.t < 1 else 0!r}"
    if fill.ks > 0:
        finish += f" reflection {fill.ks!r}"
        finish += f" phong {fill.ks!r} phong_size {fill.shine!r}" if fill.shine > 0 else ""
    interior = f" interior {{ ior {fill.ior!r} }}" if fill.t > 0 else ""
    pigment = f"pigment {{ rgb {_text(fill.colour)} transmit {fill.t!r} }}"
    return f"#declare {name} = material {{ texture {{ {pigment} finish {{ {finish} }} }}{interior} }}"


def _triangles(polygon: Polygon) -> list[str]:
    lines = []
    for k in range(1, len(polygon.corners) - 1):
        three = (0, k, k + 1)
        if polygon.normals:
            corners = ", ".join(f"{_text(polygon.corners[i])}, {_text(polygon.normals[i])}" for i in three)
            lines.append(f"  smooth_triangle {{ {corners} }}")
        else:
            lines.append(f"  triangle {{ {', '.join(_text(polygon.corners[i]) for i in three)} }}")
    return lines


def _concave(polygon: Polygon, material: str) -> str:
    corners = ", ".join(map(_text, [*polygon.corners, polygon.corners[0]]))
    return f"polygon {{ {len(polygon.corners) + 1}, {corners} material {{ {material} }} }}"


def write_pov(scene: Scene) -> str:
    """The scene as POV-Ray reads it; triangles of one material are one mesh, which POV-Ray traces fastest."""
    names: dict[Fill, str] = {}
    meshes: dict[str, list[str]] = defaultdict(list)
    shapes = []
    for shape in scene.shapes:
        material = names.setdefault(shape.fill, f"M{len(names)}")
        end = f"material {{ {material} }} }}"
        if isinstance(shape, Sphere):
            shapes.append(f"sphere {{ {_text(shape.centre)}, {shape.radius!r} {end}")
        elif isinstance(shape, Cone):
            base, top = f"{_text(shape.base)}, {shape.base_radius!r}", f"{_text(shape.top)}, {shape.top_radius!r}"
            shapes.append(f"cone {{ {base}, {top} open {end}")
        elif len(shape.corners) == 3 or shape.normals or _is_convex(shape.corners):
            meshes[material] += _triangles(shape)
        else:
            shapes.append(_concave(shape, material))
    return "\n".join([
        "#version 3.7;",
        "global_settings { assumed_gamma 1 max_trace_level 5 adc_bailout 0 }",
        _camera(scene),
        f"background {{ rgb {_text(scene.background)} }}",
        *(f"light_source {{ {_text(position)} rgb {_text(colour)} }}" for position, colour in scene.lights),
        *(_material(name, fill) for fill, name in names.items()),
        *("\n".join(["mesh {", *lines, f"  material {{ {name} }} }}"]) for name, lines in meshes.items()),
        *shapes,
        "",
    ])  # fmt: skip


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit("usage: write_pov.py SCENE.nff SCENE.pov")
    Path(sys.argv[2]).write_text(write_pov(read_nff(Path(sys.argv[1]))))


if __name__ == "__main__":
    main()
