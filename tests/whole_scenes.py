"""Whole scenes for hypothesis, as dicts: every primitive, material, light, transform, group and extension, sizes and places from
tiny to the format's limits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

usual = st.sampled_from([0.0, 0.5, 1.0, -1.0]) | st.floats(-3, 3)
extreme = st.sampled_from([1e15, -1e15, 1e8, -1e8, 1e-8, 1e-30, -0.0])
coordinates = st.integers(0, 40).flatmap(lambda i: extreme if i == 0 else usual)
points = st.lists(coordinates, min_size=3, max_size=3)
directions = st.lists(usual | st.sampled_from([1e-20, 1e-8]), min_size=3, max_size=3).filter(
    lambda d: max(map(abs, d)) > 1e-3
)
sizes = st.integers(0, 40).flatmap(
    lambda i: st.sampled_from([1e-30, 1e-12, 1e6, 1e15]) if i == 0 else st.floats(0.05, 2)
)
shares = st.sampled_from([0.0, 1.0]) | st.floats(0, 1)
powers = st.sampled_from([0.0, 1.0, 1e6, 1e-30]) | st.floats(0, 3)


def colours(numbers: st.SearchStrategy[float]) -> st.SearchStrategy[Any]:
    return numbers | st.lists(numbers, min_size=3, max_size=3)


materials = st.fixed_dictionaries({}, optional={
    **dict.fromkeys(["ambient", "diffuse", "specular", "diffuse_transmission", "specular_transmission", "reflection",
                     "transmission"], colours(shares)),
    "emission": colours(powers),
    "shininess": st.sampled_from([1e-30, 1.0, 1e6]) | st.floats(0.1, 1000),
    "ior": st.sampled_from([0.1, 1.0, 10.0]) | st.floats(0.5, 2.5),
    "priority": st.sampled_from([-1e6, 1e6]) | st.integers(-2, 2),
    "total_reflection": st.booleans(),
    "fresnel": st.booleans(),
})  # fmt: skip

strengths = st.fixed_dictionaries(
    {}, optional=dict.fromkeys(["colour", "diffuse", "specular", "ambient"], colours(powers))
)
lights = st.one_of(
    st.builds(lambda p, s: {"point": p, **s}, points, strengths),
    st.builds(lambda d, s: {"directional": d, **s}, directions, strengths),
)


def plus(a: list[float], b: Any) -> list[float]:
    return [x + y for x, y in zip(a, b, strict=True)]


@st.composite
def polygons(draw: st.DrawFn) -> dict[str, Any]:
    """Flat and often concave ones."""
    centre, n, size = draw(points), np.array(draw(directions)), draw(sizes)
    u = np.cross(n / abs(n).max(), [0.3, 0.5, 0.8])
    v = np.cross(n / abs(n).max(), u)
    arms = draw(st.lists(st.floats(0.2, 1), min_size=3, max_size=9))
    turn = np.linspace(0, 2 * np.pi, len(arms) + 1)[:-1]
    return {
        "corners": [plus(centre, size * a * (np.cos(t) * u + np.sin(t) * v)) for a, t in zip(arms, turn, strict=True)]
    }


@st.composite
def meshes(draw: st.DrawFn) -> dict[str, Any]:
    """Open, closed, or with triangles anyhow."""
    vertices = draw(st.lists(points, min_size=4, max_size=7))
    corner = st.integers(0, len(vertices) - 1)
    closed = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
    triangles = draw(st.just(closed) | st.lists(st.lists(corner, min_size=3, max_size=3), min_size=1, max_size=6))
    mesh: dict[str, Any] = {"vertices": vertices, "triangles": triangles}
    if draw(st.booleans()):
        mesh["normals"] = draw(st.lists(directions, min_size=len(vertices), max_size=len(vertices)))
    elif draw(st.booleans()):
        mesh["smooth"] = True
    return mesh


def ends(centre: list[float], axis: list[float], size: float) -> dict[str, Any]:
    return {"base": centre, "top": plus(centre, [size * x for x in axis])}


bounded = st.one_of(
    st.builds(lambda c, r: {"sphere": {"centre": c, "radius": r}}, points, sizes),
    st.builds(lambda c, n, r: {"disc": {"centre": c, "normal": n, "radius": r}}, points, directions, sizes),
    st.builds(lambda c, s: {"box": {"low": c, "high": plus(c, s)}}, points, st.lists(sizes, min_size=3, max_size=3)),
    st.builds(lambda c: {"triangle": {"corners": c}}, st.lists(points, min_size=3, max_size=3)),
    st.builds(lambda c, n: {"triangle": {"corners": c, "normals": n}}, st.lists(points, min_size=3, max_size=3),
              st.lists(directions, min_size=3, max_size=3)),
    st.builds(lambda p: {"polygon": p}, polygons()),
    st.builds(lambda e, r, c: {"cylinder": {**e, "radius": r, "capped": c}}, st.builds(ends, points, directions, sizes), sizes,
              st.booleans()),
    st.builds(lambda e, r, t, c: {"cone": {**e, "base_radius": r, "top_radius": t, "capped": c}},
              st.builds(ends, points, directions, sizes), sizes, st.just(0.0) | sizes, st.booleans()),
    st.builds(lambda m: {"mesh": m}, meshes()),
)  # fmt: skip
planes = st.builds(lambda p, n: {"plane": {"point": p, "normal": n}}, points, directions)

factors = st.sampled_from([-1.0, 0.5]) | st.floats(0.2, 3)
steps = st.one_of(
    st.builds(lambda t: {"translate": t}, points),
    st.builds(lambda a: {"rotate_y": a}, st.sampled_from([0.0, 90.0]) | st.floats(-180, 180)),
    st.builds(lambda d, a: {"rotate": {"axis": d, "angle": a}}, directions, st.floats(-180, 180)),
    st.builds(lambda s: {"scale": s}, factors | st.lists(factors, min_size=3, max_size=3)),
)
transforms = st.lists(steps, max_size=3)


@st.composite
def scenes(draw: st.DrawFn, **fixed: Any) -> dict[str, Any]:
    """Valid but for what only the numbers of some extremes can make degenerate."""
    named = {f"m{i}": m for i, m in enumerate(draw(st.lists(materials, min_size=1, max_size=4)))}
    material = st.sampled_from(sorted(named)) | materials

    def objects(shapes: Any, most: int, sides: bool = True) -> Any:
        optional = {"material": material, "transform": transforms}
        if sides:
            optional["sides"] = st.sampled_from(["both", "front", "back"])
        extra = st.fixed_dictionaries({}, optional=optional)
        return st.lists(st.builds(lambda shape, more: {**shape, **more}, shapes, extra), min_size=1, max_size=most)

    groups = {f"g{i}": g for i, g in enumerate(draw(st.lists(objects(bounded, 3), max_size=2)))}
    things = draw(objects(bounded | planes, 6))
    if groups:
        instances = st.sampled_from(sorted(groups)).map(lambda name: {"instance": name})
        things += draw(objects(instances, 3, sides=False))
    return {
        "camera": {"eye": draw(points), "look_at": draw(points), "up": [0.1, 1, 0.2], "fov": draw(st.floats(1, 150))},
        "image": {"size": [16, 12]},
        "background": draw(colours(powers)),
        "ambient": draw(colours(powers)),
        "cutoff": draw(st.sampled_from([0.0, 0.01])),
        "depth": draw(st.integers(5, 8)),
        "lights": draw(st.lists(lights, max_size=3)),
        "materials": named,
        "groups": groups,
        "objects": things,
        **fixed,
    }
