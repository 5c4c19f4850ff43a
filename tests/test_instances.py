"""Instances: as good as copies, the same bits by every way, and one group's memory for all of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pictures import everything, same_bits
from shapes import FLOAT_FIRST, LEVELS, REAL, UNIT, dot, length, only, unit, units

import feeler

LIT: dict[str, Any] = {
    "camera": {"eye": [0.3, 1.5, 9], "look_at": [0, 0.3, 0], "fov": 38},
    "image": {"size": [96, 64]},
    "background": [0.3, 0.4, 0.5],
    "ambient": 0.1,
    "lights": [{"point": [4, 6, 5], "colour": 0.9}],
}
FLOOR = {"plane": {"normal": [0, 1, 0], "point": [0, -1.2, 0]}}
TETRAHEDRON = {
    "vertices": [[-0.5, -0.4, 0.3], [0.6, -0.4, 0.2], [0, -0.4, -0.5], [0, 0.6, 0]],
    "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
}
FACES: list[dict[str, Any]] = [
    {"box": {"low": [-0.5, -0.4, -0.3], "high": [0.5, 0.4, 0.6]}},
    {"polygon": {"corners": [[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.1, 0.1, 0], [-0.4, 0.5, 0]]}},
    {"mesh": TETRAHEDRON},
    {"mesh": {**TETRAHEDRON, "smooth": True}},
]
CURVED: list[dict[str, Any]] = [
    {"sphere": {"radius": 0.5}},
    {"disc": {"radius": 0.6, "normal": [0.3, 0.2, 1]}},
    {"cone": {"base": [0, -0.4, 0], "top": [0, 0.6, 0.1], "base_radius": 0.5}},
    {"cylinder": {"base": [0, -0.4, 0], "top": [0, 0.6, 0.1], "radius": 0.4, "capped": False}, "sides": "back"},
]
GLASS = {"transmission": 0.8, "reflection": 0.1, "ior": 1.5, "specular": 0.3}
STRETCH: list[dict[str, Any]] = [{"rotate_x": 20}, {"scale": [1.5, 0.5, 1]}, {"rotate_y": 35}]
MOVES: dict[str, list[dict[str, Any]]] = {
    "translate": [{"translate": [0.25, 0.5, -0.125]}],
    "rotate": [{"rotate": {"axis": [1, 2, 3], "angle": 50}}, {"translate": [0.1, 0.2, 0.3]}],
    "mirror": [{"scale": [-1, 1, 1]}, {"rotate_z": 30}],
    "scale": [{"scale": 1.3}, {"translate": [0, 0.3, 0]}],
    "stretch": STRETCH,
}


# One kernel for many scenes; that it gives the same bits as their own is tested too.
GENERAL: dict[str, Any] = {"general": True, "depth": 6}


def places(count: int) -> list[dict[str, Any]]:
    return [{"translate": [1.4 * (i % 4) - 2.1, 1.6 * (i // 4) - 0.3, 0.3 * (i % 3)]} for i in range(count)]


def copies_and_instances(move: str, material: str) -> list[feeler.Scene]:
    shapes = FACES + (CURVED if move != "stretch" else [])
    scene = {**LIT, "materials": {"matte": {"ambient": 0.7, "diffuse": 0.7}, "glass": GLASS}}
    objects = [{**shape, "material": material} for shape in shapes]
    moves = [MOVES[move] + [place] for place in places(len(shapes))]
    copies = [{**o, "transform": m} for o, m in zip(objects, moves, strict=True)]
    groups = {f"group {i}": [o] for i, o in enumerate(objects)}
    instances = [{"instance": name, "transform": m} for name, m in zip(groups, moves, strict=True)]
    return [
        feeler.Scene({**scene, "objects": [FLOOR, *copies]}),
        feeler.Scene({**scene, "groups": groups, "objects": [FLOOR, *instances]}),
    ]


@pytest.mark.parametrize("material", ["matte", "glass"])
@pytest.mark.parametrize("move", MOVES)
def test_instances_are_as_copies(move: str, material: str) -> None:
    """Within 1/4096, but for at most one pixel in a thousand: an edge may pass its centre on the other side."""
    copies, instances = (scene.render(**GENERAL) for scene in copies_and_instances(move, material))
    difference = abs(copies.pixels.astype(float) - instances.pixels).max(-1)
    assert (difference > 1 / 4096).mean() <= 1e-3
    assert len(np.unique(copies.pixels.reshape(-1, 4), axis=0)) > 200


def placed(scale: float = 1.0, identity: bool = False, **more: Any) -> dict[str, Any]:
    """Every primitive several times: moved, mirrored and flattened, one in the other, of glass, and an ellipsoid."""
    scene = everything(scale)
    plane, *rest = scene["objects"]

    def at(*xyz: float) -> dict[str, Any]:
        return {"translate": [scale * x for x in xyz]}

    groups: dict[str, Any] = {"all": rest}
    if identity:
        return {**scene, "groups": groups, "objects": [plane, {"instance": "all"}], **more}
    turned = [{"rotate": {"axis": [1, 2, 3], "angle": 40}}, {"scale": [0.7, -0.5, 0.6]}, at(1.2, 1.2, -0.5)]
    ball = {"sphere": {"radius": scale * 0.3, "centre": at(-1, 2.4, 1)["translate"]}, "material": "glass"}
    groups["two"] = [{"instance": "all", "transform": turned}, ball]
    objects = [
        plane,
        {"instance": "all", "transform": at(-0.3, 0.1, 0.2)},
        {"instance": "two", "transform": at(-0.5, 0, 0.7)},
        {"instance": "all", "material": "glass", "transform": [{"scale": 0.4}, at(1.5, 0.1, 2.8)]},
        {
            "sphere": {"radius": scale * 0.5},
            "material": "glass",
            "transform": [{"scale": [1, 0.4, 1.3]}, at(0.2, 0.2, 3)],
        },
    ]
    return {**scene, "groups": groups, "objects": objects, **more}


@pytest.mark.parametrize("level", LEVELS)
def test_the_identity_is_nothing(level: str) -> None:
    picture = feeler.Scene(everything()).render(level=level)
    instances = feeler.Scene(placed(identity=True)).render(level=level)
    assert same_bits(instances.pixels, picture.pixels)
    assert instances.stats["rays"] == picture.stats["rays"]


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    return feeler.Scene(placed())


@pytest.fixture(scope="module")
def picture(scene: feeler.Scene) -> Any:
    pixels = scene.render().pixels
    assert np.isfinite(pixels).all()
    return pixels


@pytest.mark.parametrize("options", [{"brute_force": True}, {"general": True}, {"work_group": (5, 3)}, {"tile": 100}])
def test_the_same_bits(scene: feeler.Scene, picture: Any, options: dict[str, Any]) -> None:
    assert same_bits(scene.render(**options).pixels, picture)


def test_lanes(scene: feeler.Scene) -> None:
    """Packets, and a ray side by side with eight boxes, with a tree and without."""
    for samples in (1, 16):
        options: dict[str, Any] = {"samples": samples, "region": (8, 6, 32, 24), "work_group": (8, 8)}
        alone = scene.render(lanes=1, **options)
        together = scene.render(lanes=16, **options)
        assert same_bits(together.pixels, alone.pixels)
        assert together.stats["rays"] == alone.stats["rays"]
    assert same_bits(scene.render(lanes=16, brute_force=True, **options).pixels, alone.pixels)


@pytest.mark.parametrize("scale", [1e-18, 1e-22])
def test_lanes_of_spheres_whose_squares_vanish(scale: float) -> None:
    rng = np.random.default_rng(5)
    hits = 0
    for _ in range(25):
        turn = {"axis": rng.normal(size=3).tolist(), "angle": 40}
        shape = [{"scale": (10 ** rng.uniform(-1.5, 0.3, 3)).tolist()}, {"rotate": turn}]
        scene = feeler.Scene({
            "camera": {"eye": [0, 0, 0.9 * scale], "look_at": [0, 0, 0], "fov": 120},
            "background": 0.5,
            "groups": {"g": [{"sphere": {"radius": 0.3 * scale}}]},
            "objects": [{"instance": "g", "transform": shape}],
        })  # fmt: skip
        one, many = (scene.render(size=(61, 61), samples=4, lanes=lanes, tile=4000) for lanes in (1, 16))
        assert same_bits(one.pixels, many.pixels)
        hits += one.stats["rays"]["eye_hits"]
    assert hits > 1000


def test_lanes_with_filtered_shadows() -> None:
    scene = feeler.Scene(placed(filtered_shadows=True))
    options: dict[str, Any] = {"samples": 4, "region": (8, 6, 32, 24)}
    alone = scene.render(lanes=1, **options)
    assert same_bits(scene.render(lanes=4, brute_force=True, **options).pixels, alone.pixels)


@pytest.mark.parametrize("exponent", [-40, 7, 40])
def test_scaled_by_a_power_of_two(picture: Any, exponent: int) -> None:
    assert same_bits(feeler.Scene(placed(2.0**exponent)).render().pixels, picture)


# ---- ellipsoids, against their quadric


class Ellipsoids:
    """One instance of a unit sphere, as the device has it: a random map, of any size and place, rounded to the level."""

    def __init__(self, level: str, seed: int) -> None:
        rng = np.random.default_rng(seed)
        real = REAL[level]
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.choice([-1, 1])
        size = np.exp(rng.uniform(-5, 5))
        to_world = turn @ np.diag(size * np.exp(rng.uniform(-1.2, 1.2, 3))) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        self.to_object = np.linalg.inv(to_world).astype(real).astype(float)
        self.to_world = np.linalg.inv(self.to_object)
        self.offset = (rng.normal(size=3) * size * rng.choice([0, 1, 100])).astype(real).astype(float)
        self.size = size
        power = 2.0 ** np.floor(np.log2(abs(self.to_object).max()))
        flags = np.array([1, power, 1 / power])
        reach = length(self.to_world) * (1 + 64 * UNIT[level]) + 8 * UNIT[level] * abs(self.offset)
        rows = [*np.column_stack([self.to_world, self.offset]), *np.column_stack([self.to_object, flags])]
        rows += [[*(self.offset - reach), 0], [*(self.offset + reach), 0]]
        sphere = [0, 0, 0, 1, -1.001, -1.001, -1.001, 0, 1.001, 1.001, 1.001, 0]
        block = np.repeat([-1.001, -1.001, -1.001, 1.001, 1.001, 1.001, 0, 0, 0, 1], 8)
        self.scene = {
            "primitives": [[7, 0, 0xFFFFFFFF, 0], [0, 0, 0, 0]],
            "spheres": [sphere],
            "instances": [np.concatenate(rows)],
            "instance_roots": [[1, 2, 0, 0]],
            "links": [[0, 7 << 29], [0, 1]],
            "blocks": block,
            "block_numbers": [0] * 8 + [1] * 8,
            "count": [0, 1, 0, 0],
        }
        self.options = only("TRANSMISSION", "INSTANCE", "SPHERE") + " -DHAS_TREE=0"
        self.level = level

    def probe(self, name: str, *arguments: Any) -> Any:
        return feeler.probe(name, *arguments, level=self.level, options=self.options)

    def meet(self, origin: Any, direction: Any) -> tuple[Any, Any]:
        """The ray and its hit."""
        ray = self.probe("make_ray", origin, direction)
        return ray, self.probe("closest_hit", self.scene, ray, True)

    def inside(self, points: Any) -> Any:
        """In the group's space, in extended precision."""
        p = np.asarray(points, np.longdouble) - self.offset
        return p @ self.to_object.astype(np.longdouble).T

    def distances(self, origin: Any, direction: Any) -> tuple[Any, Any]:
        """Both roots of the quadric along rays, not a number where there are none."""
        o = self.inside(origin)
        d = np.asarray(direction, np.longdouble) @ self.to_object.astype(np.longdouble).T
        a, b, c = dot(d, d), dot(o, d), dot(o, o) - 1
        with np.errstate(invalid="ignore"):
            root = np.sqrt(b * b - a * c)
        return (-b - root) / a, (-b + root) / a


@pytest.mark.parametrize("level", FLOAT_FIRST)
@pytest.mark.parametrize("seed", range(8))
def test_an_ellipsoid_is_its_quadric(level: str, seed: int) -> None:
    e, rng, count, real = Ellipsoids(level, seed), np.random.default_rng(seed + 100), 2000, REAL[level]
    on = units(rng, count) @ e.to_world.T + e.offset
    origin = (e.offset + units(rng, count) * e.size * np.exp(rng.uniform(0, 5, (count, 1)))).astype(real)
    direction = unit((on - origin).astype(float)).astype(real)
    ray, hit = e.meet(origin, direction)
    first, second = e.distances(origin, direction)
    grazing = ~(second - first > 0.01 * e.size)  # nearly: the discriminant is small beside its terms
    expected = np.where(first > 0, first, second)
    found = hit.primitive >= 0
    assert (found | grazing | ~(expected > 0)).all()
    assert (hit.inside[found] == 1).all()
    clear = found & ~grazing
    scale = length(origin.astype(float) - e.offset) + e.size
    assert (abs(hit.distance - expected)[clear] < 2000 * UNIT[level] * scale[clear]).all()

    identity = e.probe("identify", e.scene, True, hit)
    s = e.probe("find_surface", e.scene, ray, hit, found, identity)
    q = e.inside(s.point)
    gradient = q @ e.to_object.astype(np.longdouble)
    normal = unit(gradient)
    assert (length(s.normal - normal)[clear] < 3000 * UNIT[level]).all()
    where = origin + expected[:, None] * direction
    assert (length(s.point - where)[clear] < 8000 * UNIT[level] * scale[clear]).all()
    off = abs(length(q) - 1) / length(gradient)
    assert (off <= dot(abs(normal), s.error))[found].all(), "the point is within its bound of the surface"

    start = e.probe("spawn", s.point, s.error, s.normal)
    away = units(rng, count)
    away = np.where((dot(away, normal) > 0.01)[:, None], away, normal).astype(real)
    _, again = e.meet(start, away)
    assert (again.primitive < 0)[found].all(), "what leaves an ellipsoid does not hit it"


def inverses(matrices: Any) -> Any:
    """In extended precision, from doubles."""
    a = matrices.astype(np.longdouble)
    x = np.linalg.inv(matrices).astype(np.longdouble)
    for _ in range(2):
        x = x @ (2 * np.eye(3, dtype=np.longdouble) - a @ x)
    return x


@pytest.mark.parametrize("level", FLOAT_FIRST)
def test_the_bound_of_placed_points(level: str) -> None:
    """A point that is exact in its group: in the world it is within its bound, and a ray that starts off it begins on the
    same side in the group. Maps of all sizes, stretched and turned, near the world's origin and far from it.
    """
    rng, count, real = np.random.default_rng(200), 5000, REAL[level]
    turns = [np.linalg.qr(rng.normal(size=(count, 3, 3)))[0] for _ in range(2)]
    size = np.exp(rng.uniform(-8, 8, (count, 1)))
    to_object = (turns[0] * (np.exp(rng.uniform(-3, 3, (count, 3))) / size)[:, None] @ turns[1]).astype(real)
    exact = inverses(to_object.astype(float))
    offset = (rng.normal(size=(count, 3)) * size * rng.choice([0, 1, 1, 1000], (count, 1))).astype(real)
    unit_of = 2.0 ** np.floor(np.log2(abs(to_object.astype(float)).max((1, 2))))
    flags = np.stack([np.ones(count), unit_of, 1 / unit_of], 1)
    out = np.concatenate([exact.astype(real), offset[..., None]], 2)
    back = np.concatenate([to_object, flags.astype(real)[..., None]], 2)
    rows = np.concatenate([out.reshape(count, 12), back.reshape(count, 12), np.zeros((count, 8), real)], 1)
    options: dict[str, Any] = {"level": level, "options": only("TRANSMISSION", "INSTANCE", "SPHERE")}
    at = feeler.probe("find_placement", {"instances": rows, "count": [0, 0, 0, 0]}, np.arange(count), **options)
    point = (rng.normal(size=(count, 3)) * np.exp(rng.uniform(-3, 3, (count, 3)))).astype(real)
    turned = unit((exact.swapaxes(1, 2) @ units(rng, count)[..., None])[..., 0].astype(float))  # all alike in the world
    normal = np.where(rng.random((count, 1)) < 0.5, units(rng, count), turned).astype(real)
    s = feeler.probe("place_surface", at, (point, np.zeros_like(point), normal, normal), **options)
    where = (exact @ point[..., None].astype(np.longdouble))[..., 0] + offset
    assert (abs(s.point - where) <= s.error).all()
    for side in (1, -1):
        start = feeler.probe("spawn", s.point, s.error, side * s.normal, **options)
        ray = feeler.probe("make_ray", start, side * s.normal, **options)
        inside = feeler.probe("move_ray", at, ray, **options).origin.astype(np.longdouble)
        height = side * dot(inside - point, normal.astype(np.longdouble))
        assert (height >= 0).all()


def test_a_stretched_sphere_is_an_instance() -> None:
    ball = {"sphere": {"radius": 0.7}, "material": {"diffuse": [0.2, 0.5, 0.8]}}
    silent = feeler.Scene({**LIT, "objects": [{**ball, "transform": STRETCH}]})
    said = feeler.Scene({**LIT, "groups": {"ball": [ball]}, "objects": [{"instance": "ball", "transform": STRETCH}]})
    assert silent.info()["primitives"] == {"spheres": 1, "instances": 1}
    assert same_bits(silent.render().pixels, said.render().pixels)


# ---- scenes


def test_nested_groups_are_flattened() -> None:
    ball: dict[str, Any] = {"sphere": {"radius": 0.5}}
    right: dict[str, Any] = {"translate": [1, 0, 0]}
    up: dict[str, Any] = {"scale": [1, 0.5, 0.25]}
    nested = {
        "pair": [{"instance": "one"}, {"instance": "one", "transform": right, "material": "red"}],
        "one": [ball],
        "four": [{"instance": "pair"}, {"instance": "pair", "transform": up, "material": "blue"}],
    }
    colours = {"red": {"emission": [1, 0, 0]}, "blue": {"emission": [0, 0, 1]}}
    scene = feeler.Scene({**LIT, "materials": colours, "groups": nested, "objects": [{"instance": "four"}]})
    assert scene.info()["primitives"] == {"spheres": 1, "instances": 4}
    plain = [{"instance": "one"}, {"instance": "one", "transform": right, "material": "red"},
             {"instance": "one", "transform": up, "material": "blue"},
             {"instance": "one", "transform": [right, up], "material": "blue"}]  # fmt: skip
    flat = feeler.Scene({**LIT, "materials": colours, "groups": {"one": [ball]}, "objects": plain})
    assert same_bits(scene.render().pixels, flat.render().pixels)


ROOMS: dict[str, dict[str, Any]] = {
    "mesh": {"mesh": {"vertices": [[-2, -2, -2], [2, -2, -2], [2, -2, 2], [-2, -2, 2], [0, 3, 0]],
                      "triangles": [[0, 1, 2], [0, 2, 3], [0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]]}},
    "sphere": {"sphere": {"centre": [0.25, 0, 0], "radius": 1.5}},
    "cylinder": {"cylinder": {"base": [0, -1.5, 0], "top": [0, 1.5, 0], "radius": 1.5}},
}  # fmt: skip


@pytest.mark.parametrize("move", ["identity", "translate", "rotate", "mirror", "scale"])
@pytest.mark.parametrize("room", ROOMS)
def test_the_eye_in_an_instance(room: str, move: str) -> None:
    """The eye's own media are found through instances, of what is glass by its instance only too: another glass within it
    bends by both, and an instance of the room is as a copy.
    """
    common = {
        **LIT,
        "camera": {"eye": [0, 0, 0.1], "look_at": [0.3, 0.2, -5], "fov": 60},
        "materials": {"glass": GLASS, "other": {**GLASS, "ior": 1.2}},
    }
    seen = [
        {"sphere": {"centre": [0.15, 0.1, -0.6], "radius": 0.25}, "material": "other"},
        {"sphere": {"centre": [1, 0.5, -6], "radius": 1}, "material": {"diffuse": 0.8}},
    ]
    placed = {"transform": MOVES.get(move, []), "material": "glass"}
    copy, instance = {**ROOMS[room], **placed}, {"instance": "room", **placed}
    groups = {"room": [ROOMS[room]]}
    expected = feeler.Scene({**common, "objects": [copy, *seen]}).render(**GENERAL).pixels
    found = feeler.Scene({**common, "groups": groups, "objects": [instance, *seen]}).render(**GENERAL).pixels
    if move == "identity":
        assert same_bits(found, expected)
    assert (abs(found.astype(float) - expected).max(-1) > 1 / 4096).mean() <= 1e-3


def test_a_thousand_take_the_memory_of_one() -> None:
    side = 225
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    vertices = np.stack([x, np.sin(x / 9) + np.cos(y / 7), y], -1).reshape(-1, 3)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    triangles = np.concatenate([
        np.stack([corner, corner + side, corner + 1], 1), np.stack([corner + 1, corner + side, corner + side + 1], 1)
    ])  # fmt: skip
    assert len(triangles) > 100_000
    groups = {"field": [{"mesh": {"vertices": vertices, "triangles": triangles}}]}

    def memory(count: int) -> int:
        objects = [{"instance": "field", "transform": {"translate": [0, 3 * i, 0]}} for i in range(count)]
        return int(feeler.Scene({"groups": groups, "objects": objects}).info()["memory_bytes"]["total"])

    one, thousand = memory(1), memory(1000)
    assert one > 5_000_000
    assert thousand - one < 1000 * 400


def test_groups_of_included_files(cli: Any, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "ball.yaml").write_text("groups: {ball: [{mesh: {file: ball.obj}}]}\n")
    (tmp_path / "parts" / "ball.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "scene.yaml").write_text(
        "include: [parts/ball.yaml]\nobjects: [{instance: ball}, {instance: ball, transform: {scale: 2}}]\n"
    )
    done = cli("info", "scene.yaml", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["primitives"] == {"triangles": 1, "instances": 2}


@pytest.mark.parametrize(("scene", "place"), [
    ({"groups": {"a": [{"sphere": {"radius": 1}}]}, "objects": [{"instance": "b"}]}, "objects[0].instance"),
    ({"groups": {"a": [{"plane": {"normal": [0, 1, 0]}}]}}, "groups.a[0].plane"),
    ({"groups": {"a": []}}, "groups.a"),
])  # fmt: skip
def test_errors_of_a_dict_name_the_key(scene: dict[str, Any], place: str) -> None:
    with pytest.raises(feeler.Error) as caught:
        feeler.Scene(scene)
    assert place in str(caught.value)
