"""The margin: edges and angles that rays meet exactly, and the same decisions taken in double precision."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
import pytest
from pictures import everything, same_bits
from test_channels import EYE, ball_on_floor

import feeler


def flat(objects: list[Any], **keys: Any) -> dict[str, Any]:
    """Seen from the z axis, by pixels whose rays go through whole multiples of 1/16 at z = 0."""
    fov = float(np.degrees(2 * np.arctan(31 / 32 / 8)))
    camera = {"eye": [0, 0, 8], "look_at": [0, 0, 0], "fov": fov}
    return {"camera": camera, "image": {"size": [31, 31]}, "objects": objects, "depth": 1, **keys}


SQUARE = [[0, -0.6, 0], [0.6, -0.6, 0], [0.6, 0.6, 0], [0, 0.6, 0]]
EDGES = {
    "polygon": {"polygon": {"corners": SQUARE}},
    "triangle": {"triangle": {"corners": [[0, -3, 0], [3, 0, 0], [0, 3, 0]]}},
    "box": {"box": {"low": [0, -0.6, -1], "high": [0.6, 0.6, 0]}},
    "disc": {"disc": {"centre": [1, 0, 0], "normal": [0, 0, 1], "radius": 1}},
    "sphere": {"sphere": {"centre": [1, 0, 0], "radius": 1}},
    "cylinder": {"cylinder": {"base": [1, -3, 0], "top": [1, 3, 0], "radius": 1}},
    "open end": {"cylinder": {"base": [0, 0, -1], "top": [3, 0, -1], "radius": 1, "capped": False}},
}


def look_at_edge(name: str, by: float = 0, **settings: Any) -> dict[str, Any]:
    """The channels of one of them alone, moved sideways; one more of each, out of sight, lets all share a kernel."""
    unseen = [{**shape, "transform": {"translate": [0, 0, 50]}} for shape in EDGES.values()]
    shape = {**EDGES[name], "transform": {"translate": [by, 0, 0]}}
    return feeler.Scene(flat([shape, *unseen])).render(channels=["margin", "object"], **settings).channels


@pytest.mark.parametrize("name", EDGES)
def test_margin_beside_an_edge(name: str) -> None:
    """In proportion to how far the ray passes by, and alike on both sides."""
    sides = [
        [look_at_edge(name, sign * 2.0**-k, region=(15, 15, 16, 16))["margin"][0, 0] for k in (10, 14, 15, 16)]
        for sign in (-1, 1)
    ]
    print(name, sides)
    for far, *near in sides:
        assert far == 16
        assert near[0] / near[1] == pytest.approx(2, rel=0.2) and near[1] / near[2] == pytest.approx(2, rel=0.2)
    assert sides[0][1:] == pytest.approx(sides[1][1:], rel=0.3)


@pytest.mark.parametrize("name", EDGES)
def test_margin_at_an_edge(name: str) -> None:
    """Edge or silhouette runs through the middle pixel's centre exactly: nobody can say what it shows."""
    found = look_at_edge(name)
    margin, number = found["margin"], found["object"]
    assert margin[15, 15] < 1
    assert (number[15, :15] == -1).all() and (number[15, 16:24] == 0).all()
    assert (margin[15, :15] == 16).all() and (margin[15, 16:24] == 16).all()
    assert (margin >= 0).all() and (margin <= 16).all() and (margin < 16).mean() < 0.05


def test_margin_of_two_at_one_place() -> None:
    """The nearer wins by less and less; what lies in one plane is undecidable, unless something hides it."""

    def scene(gap: float, *more: Any) -> feeler.Scene:
        other = [[x, y, gap] for x, y, _ in SQUARE]
        return feeler.Scene(flat([{"polygon": {"corners": SQUARE}}, {"polygon": {"corners": other}}, *more]))

    def at(scene: feeler.Scene) -> float:
        return float(scene.render(channels=["margin"]).channels["margin"][15, 19])

    assert at(scene(0.0)) == 0
    found = [at(scene(-(2.0**-k))) for k in (10, 12, 14, 16)]
    assert found[0] == 16 and 16 > found[1] > found[2] > found[3] > 0
    assert found[1] / found[2] == pytest.approx(4, rel=0.2)
    assert at(scene(0.0, {"polygon": {"corners": [[x, y, 1] for x, y, _ in SQUARE]}})) == 16


def test_margin_of_light_and_shadow() -> None:
    """A light in the plane of a floor is on no side of it; and a feeler may touch what casts the shadow."""
    floor = {"polygon": {"corners": [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]}, "material": "matte"}
    lid = {"polygon": {"corners": [[0.25, -3, 2], [3, -3, 2], [3, 3, 2], [0.25, 3, 2]]}, "material": "matte"}
    matte = {"materials": {"matte": {"diffuse": 0.5}}}
    for matter in ("diffuse", "diffuse_transmission"):
        thin = {"materials": {"matte": {matter: 0.5}}}
        beside = feeler.Scene(flat([floor], lights=[{"point": [9, 0, 0]}], **thin)).render(channels=["margin"])
        assert (beside.channels["margin"] < 1).all(), matter
    # From the light past the lid's edge, at x = 1/4, down to x = -1/2: exactly a pixel's centre.
    above = feeler.Scene(flat([floor, lid], lights=[{"point": [1, 0, 4]}], **matte)).render(channels=["margin"])
    column = above.channels["margin"][15]
    assert column[7] < 1 and (np.delete(column, 7) == 16).all()


def test_margin_of_a_filtered_shadow() -> None:
    """Each surface that a feeler crosses counts, whatever else is crossed for certain."""
    floor = {"polygon": {"corners": [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]}, "material": "matte"}
    panes = [{"polygon": {"corners": [[x, -3, z], [3, -3, z], [3, 3, z], [x, 3, z]]}, "material": "pane"}
             for x, z in ((0.25, 2), (-3, 3))]  # fmt: skip
    materials = {"matte": {"diffuse": 0.5}, "pane": {"transmission": 0.5}}
    scene = {**flat([floor, *panes], lights=[{"point": [1, 0, 4]}], materials=materials), "filtered_shadows": True}
    scene["camera"] = {**scene["camera"], "eye": [0, 0, 1], "fov": float(np.degrees(2 * np.arctan(31 / 32)))}
    column = feeler.Scene(scene).render(channels=["margin"]).channels["margin"][15]
    assert column[7] < 1 and (np.delete(column, 7) == 16).all()


def glass_below(normal: Any, ior: float, **keys: Any) -> dict[str, Any]:
    """Half of space is glass, up to a plane through the origin; who is in it sees total reflection beyond the critical angle."""
    glass = {"transmission": 0.5, "ior": ior}
    return {"objects": [{"plane": {"normal": normal}, "material": glass}], "depth": 2, **keys}


def test_margin_at_the_critical_angle() -> None:
    """Index 5/4, sine 4/5: twelve pixels lie on the circle of total reflection, in whole numbers 9² + 12² = 15²."""
    height = 45 / 64  # 3/4 of 15/16
    fov = float(np.degrees(2 * np.arctan(31 / 32 / height)))
    camera = {"eye": [0, 0, -height], "look_at": [0, 0, 0], "fov": fov}
    scene = feeler.Scene(glass_below([0, 0, 1], 1.25, camera=camera, image={"size": [31, 31]}))
    found = scene.render(channels=["margin", "rays"]).channels
    place = np.arange(31) - 15
    apart = place[:, None] ** 2 + place**2 - 15**2
    assert (apart == 0).sum() == 12
    assert (found["margin"][apart == 0] < 1).all()
    assert (found["margin"][apart != 0] == 16).all()
    assert np.array_equal(found["rays"][apart != 0], np.where(apart < 0, 2, 1)[apart != 0])


def tilted(rng: np.random.Generator) -> tuple[Any, Any, Any]:
    """Three directions square to each other."""
    return tuple(np.linalg.qr(rng.normal(size=(3, 3)))[0])


def expect_sure(scenes: Iterable[dict[str, Any]], decide: Callable[[feeler.Image], Any]) -> None:
    """Where the margin is above 1, float decides as double does; and float errs above 1/100 too.

    By general kernels, which all these tests share.
    """
    wrong, near, greatest = 0, 0, 0.0
    for scene in map(feeler.Scene, scenes):
        image = scene.render(channels=["margin", "rays"], general=True)
        differs = decide(image) != decide(scene.render(channels=["rays"], level="reference", general=True))
        margin = image.channels["margin"]
        assert not differs[margin > 1].any()
        wrong += differs.sum()
        near += ((margin > 1) & (margin < 16)).sum()
        greatest = margin[differs].max(initial=greatest)
    print("differ", wrong, "greatest margin there", greatest, "within 16 bounds", near)
    assert wrong > 20 and near > 1000 and greatest > 0.01


def test_total_reflection_beyond_its_bound_is_right() -> None:
    """Seen so closely that all pixels are near the critical angle."""
    rng = np.random.default_rng(5)

    def from_within() -> Iterator[dict[str, Any]]:
        for _ in range(16):
            normal, side, _ = tilted(rng)
            ior = rng.uniform(1.1, 2.4)
            eye = -normal
            ray = normal * np.sqrt(1 - 1 / ior**2) + side / ior
            camera = {"eye": eye, "look_at": eye + ray, "up": [0.3, 1, 0.2], "fov": float(np.degrees(2e-5))}
            yield glass_below(normal, ior, camera=camera, image={"size": [60, 60]})

    expect_sure(from_within(), lambda image: image.channels["rays"])


FAR = 1000.0


def on_ball(n: Any, side: Any, sine: float, **keys: Any) -> dict[str, Any]:
    """A ball of radius 1 seen from far away around the place n on it, at an angle of this sine. What enters stays inside."""
    towards = np.sqrt(1 - sine * sine) * n - sine * side
    camera = {"eye": n + FAR * towards, "look_at": n, "up": [0.3, 1, 0.2], "fov": float(np.degrees(1e-5))}
    ball = {"sphere": {"radius": 1}, "material": "ball", "sides": "front"}
    return {"camera": camera, "image": {"size": [90, 90]}, "objects": [ball], "lights": [], "depth": 2, **keys}


def test_critical_angles_on_a_ball_beyond_their_bound_are_right() -> None:
    """A bubble, where the doubtful point moves the normal: far more than rounding a flat one's does."""
    rng = np.random.default_rng(6)

    def bubbles() -> Iterator[dict[str, Any]]:
        for _ in range(12):
            ior = rng.uniform(0.4, 0.9)
            yield on_ball(*tilted(rng)[:2], ior, materials={"ball": {"transmission": 0.5, "ior": ior}})

    expect_sure(bubbles(), lambda image: image.channels["rays"])


@pytest.mark.parametrize("way", ["reflection", "transmission"])
def test_what_a_ball_turns_beyond_its_bound_is_right(way: str) -> None:
    """A lamp's edge, as far from the ball as the eye is: what the direction is off by, once it is turned, decides."""
    rng = np.random.default_rng(7)
    ior = 10.0  # the farther from 1, the more of what the normal is off by reaches the direction
    materials = {"ball": {way: 1, "ior": ior}, "lamp": {"emission": 1}}

    def turned() -> Iterator[dict[str, Any]]:
        for _ in range(24):
            n, side, up = tilted(rng)
            sine = rng.uniform(0.2, 0.8)
            along, sign = (sine, 1) if way == "reflection" else (sine / ior, -1)
            ray = along * side + sign * np.sqrt(1 - along * along) * n
            turn = rng.uniform(0, 2 * np.pi)
            across = np.cos(turn) * up + np.sin(turn) * np.cross(ray, up)
            middle, out = n + FAR * ray, 50 * np.cross(ray, across)
            corners = np.array([middle - 50 * across, middle + 50 * across, middle + 50 * across + out,
                                middle - 50 * across + out])  # fmt: skip
            scene = on_ball(n, side, sine, materials=materials)
            yield scene | {"objects": [*scene["objects"], {"polygon": {"corners": corners}, "material": "lamp"}]}

    expect_sure(turned(), lambda image: image.pixels[..., 0] > 0.5)


def lit_floors(rng: np.random.Generator, away: float) -> Iterator[dict[str, Any]]:
    """A light by some roundings above or below a tilted floor; a speck at the opposite place keeps the origin where it is."""
    heights = [0, *(sign * 2.0**k for sign in (-1, 1) for k in range(9))]
    for height in 5 * heights:
        normal, side, up = tilted(rng)
        at = away * tilted(rng)[0]
        light = at + side + height * 2.0**-24 * (away + 1) * normal
        camera = {"eye": at + normal + 0.1 * side, "look_at": at, "up": up, "fov": 20}
        floor = {"plane": {"point": at, "normal": normal}, "material": "ball"}
        speck = {"sphere": {"centre": -at - normal, "radius": 1e-3}}
        yield {"camera": camera, "image": {"size": [30, 30]}, "objects": [floor, speck], "lights": [{"point": light}]}


def lit_balls(rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Where a ball's day ends."""
    for _ in range(12):
        n, side, up = tilted(rng)
        yield on_ball(n, side, 0.5, lights=[{"directional": np.cos(1.0) * side + np.sin(1.0) * up}])


@pytest.mark.parametrize("where", ["floor", "far floor", "ball"])
def test_sides_of_lights_beyond_their_bound_are_right(where: str) -> None:
    """What counts most is rounding itself, what the way to the light is off by, and what the normal is."""
    rng = np.random.default_rng(8)
    scenes = lit_balls(rng) if where == "ball" else lit_floors(rng, FAR if where == "far floor" else 0)
    matte = {"materials": {"ball": {"diffuse": 1}}, "shadows": False, "depth": 2}
    expect_sure((scene | matte for scene in scenes), lambda image: image.pixels[..., 0] > 0)


KINDS = ("sphere", "triangle", "disc", "box", "cylinder", "cone", "polygon")


def crowd(seed: int, spread: float = 1e-2, away: float = 100.0) -> dict[str, Any]:
    """One of each kind whose edge or silhouette runs through the little that is seen from far away: many pixels are as near to
    it as rounding is large.
    """
    rng = np.random.default_rng(seed)
    eye = rng.normal(size=3)
    eye /= np.linalg.norm(eye)
    objects: list[dict[str, Any]] = []
    for kind in rng.permutation(KINDS):
        r = float(np.exp(rng.uniform(-1, 1)))
        side = np.cross(eye, rng.normal(size=3))
        side /= np.linalg.norm(side)
        up = np.cross(eye, side)
        m = eye * rng.uniform(-2, 2) + rng.normal(size=3) * spread * 0.3
        lean = side + eye * rng.normal() * 0.3
        axis = up + rng.normal() * 0.5 * eye
        c = m + side * r
        shapes: dict[str, Any] = {
            "sphere": {"centre": c, "radius": r},
            "triangle": {"corners": np.array([m + up * r, m - up * r + eye * rng.normal() * 0.3, c])},
            "disc": {"centre": m + lean / np.linalg.norm(lean) * r, "normal": np.cross(up, lean), "radius": r},
            "box": {"low": m - r * (rng.random(3) < 0.5), "high": 0},
            "cylinder": {"base": c - axis, "top": c + axis, "radius": r},
            "cone": {"base": c - axis, "top": c + axis, "base_radius": r * 0.9, "top_radius": r * 1.1, "capped": bool(r < 1)},
            "polygon": {"corners": np.array([m + up * r, m - up * r, m - up * r + lean, m + lean * 0.5, m + up * r + lean])},
        }  # fmt: skip
        if kind == "box":
            shapes["box"]["high"] = shapes["box"]["low"] + r
        objects.append({kind: shapes[kind]})
    camera = {"eye": eye * away, "look_at": [0, 0, 0], "up": [0.3, 1, 0.2], "fov": float(np.degrees(spread / away))}
    return {"camera": camera, "image": {"size": [120, 90]}, "depth": 1, "objects": objects}


def test_decisions_beyond_their_bounds_are_right() -> None:
    """Where the margin is above 1, float shows the object that double does. Elsewhere it may not, and sometimes does not."""
    wrong, near, greatest = 0, 0, 0.0
    for seed in range(10):
        scene = feeler.Scene(crowd(seed))
        image = scene.render(channels=["object", "margin"])
        exact = scene.render(channels=["object", "margin"], level="reference").channels
        margin, differs = image.channels["margin"], image.channels["object"] != exact["object"]
        assert margin.min() >= 0 and margin.max() <= 16
        assert not differs[margin > 1].any(), seed
        wrong += differs.sum()
        near += ((margin > 1) & (margin < 16)).sum()
        assert (exact["margin"] == 16).mean() > 0.999  # double has room to spare
        print(seed, "differ", differs.sum(), "greatest margin there", margin[differs].max(initial=0))
        greatest = margin[differs].max(initial=greatest)
    assert wrong > 20 and near > 1000 and greatest > 0.05


MIXED = {**ball_on_floor(), "depth": 3}


def test_margins_do_not_depend_on_the_tree() -> None:
    """A mesh, instances and a mirror."""
    step = np.linspace(-1, 1, 7)
    x, y = (a.ravel() for a in np.meshgrid(step, step))
    vertices = np.stack([2 * x, 2 * y, 0.3 * np.sin(3 * x) * np.cos(2 * y) - 2], 1)
    corner = np.arange(36) // 6 * 7 + np.arange(36) % 6
    triangles = np.concatenate(
        [np.stack([corner, corner + 1, corner + 8], 1), np.stack([corner, corner + 8, corner + 7], 1)]
    )
    objects = [
        *MIXED["objects"],
        {"mesh": {"vertices": vertices, "triangles": triangles}, "material": "floor"},
        *(
            {"instance": "pair", "transform": [{"rotate_y": 40 * i}, {"translate": [i - 1, 1.2, 0.5]}]}
            for i in range(3)
        ),
    ]
    pair = [{"box": {"low": [-0.3, 0, -0.2], "high": [0.1, 0.3, 0.2]}, "material": "floor"},
            {"sphere": {"centre": [0.2, 0.2, 0], "radius": 0.25}, "material": "mirror"}]  # fmt: skip
    far = {"eye": 20 * EYE, "look_at": [0, 0, 0], "fov": 2}  # where bounds are larger for the pixels' size
    scene = feeler.Scene({**MIXED, "camera": far, "objects": objects, "groups": {"pair": pair}})
    margin = scene.render(channels=["margin"]).channels["margin"]
    assert same_bits(margin, scene.render(channels=["margin"], brute_force=True).channels["margin"])
    assert 0.005 < (margin < 16).mean() < 0.9 and len(np.unique(margin)) > 100


@pytest.mark.parametrize("power", [-40, 40])
def test_margins_of_a_scaled_scene(power: int) -> None:
    def scaled(by: float) -> Any:
        far = {"eye": 40 * by * EYE, "look_at": [0, 0, 0], "fov": 1}
        scene = ball_on_floor(camera=far, lights=[{"point": by * np.array([3.0, 4, 5])}])
        scene["objects"][0]["plane"]["point"] = [0, -by, 0]
        scene["objects"][1]["sphere"]["radius"] = by
        return feeler.Scene(scene).render(channels=["margin"]).channels["margin"]

    margin = scaled(1)
    assert (margin < 16).mean() > 0.01
    assert same_bits(scaled(2.0**power), margin)


@pytest.mark.slow
def test_whole_trees_beyond_their_bounds_are_right() -> None:
    """Every primitive, light and material: where no decision is within its bounds, float and double send the same rays."""
    scene = feeler.Scene(everything())
    settings: dict[str, Any] = {"channels": "all", "size": (144, 108)}
    image, exact = scene.render(**settings), scene.render(level="reference", **settings)
    margin = image.channels["margin"]
    sure = margin > 1
    assert sure.mean() > 0.8
    for name in ("object", "material", "rays", "deepest"):
        assert np.array_equal(image.channels[name][sure], exact.channels[name][sure]), name
    assert abs(image.pixels - exact.pixels)[sure].max() < 1e-4
    assert same_bits(scene.render(brute_force=True, **settings).channels["margin"], margin)
