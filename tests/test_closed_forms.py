"""Pictures against what can be written down: the terms of (16.20), shadows, outlines, mirrors, ray trees, coverage.

Everything is evaluated in float64 from MODEL's formulas. A tolerance is the rounding of a value near 1, some times over.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pictures import render
from shapes import dot, length, unit

import feeler

SIZE = (41, 31)
TOLERANCE = {"standard": 2e-5, "reference": 1e-12}
LEVELS = list(TOLERANCE)
GREY = np.ones(3)


def eye_rays(camera: dict[str, Any], size: tuple[int, int] = SIZE) -> tuple[Any, Any]:
    """The eye and the directions (16.5, 16.6) through the pixels' centres, (height, width, 3)."""
    eye, look_at, up = (np.array(camera[key], float) for key in ("eye", "look_at", "up"))
    forward = unit(look_at - eye)
    right = unit(np.cross(forward, up))
    half = np.tan(np.radians(camera["fov"]) / 2) / size[1]
    x, y = np.meshgrid(2 * np.arange(size[0]) + 1 - size[0], size[1] - 2 * np.arange(size[1]) - 1)
    return eye, unit(forward + half * (x[..., None] * right + y[..., None] * np.cross(right, forward)))


def camera(eye: Any, look_at: Any = (0, 0, 0), up: Any = (0, 1, 0), fov: float = 30) -> dict[str, Any]:
    return {"eye": list(eye), "look_at": list(look_at), "up": list(up), "fov": fov}


# ---- local illumination (16.20)

VIEW = camera((1, 2, 4), (0.03, 0.02, 0))
NORMAL = unit(np.array([0.2, 0.1, 1.0]))
LIGHTS: list[dict[str, Any]] = [
    {"point": [1.5, 0.5, 2], "diffuse": [0.9, 0.8, 0.7], "specular": [0.5, 0.6, 0.9], "ambient": [0.1, 0, 0.05]},
    {"directional": [0.4, 0.1, -1], "diffuse": [0.2, 0.3, 0.4], "specular": 0.3},
    {"point": [0.5, -1, -2.5], "diffuse": [0.7, 0.4, 0.6], "specular": [0.8, 0.7, 0.6]},
    {"directional": [-0.3, -0.2, 1], "diffuse": 0.25, "specular": [0.3, 0.2, 0.4]},
]
TERMS: dict[str, dict[str, Any]] = {
    "ambient": {"ambient": [0.3, 0.5, 0.7]},
    "diffuse": {"diffuse": [0.3, 0.5, 0.7]},
    "specular": {"specular": [0.3, 0.5, 0.7], "shininess": 7},
    "a sharp specular": {"specular": [0.3, 0.5, 0.7], "shininess": 300},
    "diffuse_transmission": {"diffuse_transmission": [0.3, 0.5, 0.7]},
    "specular_transmission": {"specular_transmission": [0.3, 0.5, 0.7], "shininess": 9, "ior": 1.4},
    "specular_transmission into the thinner": {"specular_transmission": [0.3, 0.5, 0.7], "shininess": 9, "ior": 0.6},
    "emission": {"emission": [0.3, 2, 70]},
    "all": {"ambient": 0.2, "diffuse": [0.1, 0.3, 0.5], "specular": 0.4, "diffuse_transmission": [0.4, 0.3, 0.2],
            "specular_transmission": [0.2, 0.1, 0.6], "emission": 0.05, "shininess": 12, "ior": 1.2},
}  # fmt: skip


def refract(v: Any, n: Any, eta: float) -> tuple[Any, Any]:
    """(16.17), (16.18): whether there is a t, and it."""
    across = eta * (dot(v, n)[..., None] * n - v)
    k = 1 - dot(across, across)
    return k > 0, across - np.sqrt(np.maximum(k, 0))[..., None] * n


def illuminate(m: dict[str, Any], lights: list[dict[str, Any]], ambient: float, q: Any, n: Any, v: Any) -> Any:
    """I_local with every feeler free."""

    def colour(value: Any) -> Any:
        return GREY * value

    f, eta = m.get("shininess", 10), 1 / m.get("ior", 1)
    r = 2 * dot(v, n)[..., None] * n - v
    found, t = refract(v, n, eta)
    light_ambient = colour(ambient) + sum(colour(light.get("ambient", 0)) for light in lights)
    total = colour(m.get("ambient", 0)) * light_ambient + colour(m.get("emission", 0)) + np.zeros_like(q)
    for light in lights:
        towards = (
            unit(np.array(light["point"]) - q) if "point" in light else -unit(np.array(light["directional"], float))
        )
        i_d, i_s = colour(light.get("diffuse", 1)), colour(light.get("specular", 1))
        cosine = (towards * n).sum(-1)[..., None]
        shine = np.maximum((r * towards).sum(-1), 0)[..., None] ** f
        through = np.where(found, np.maximum((t * towards).sum(-1), 0) ** f, 0)[..., None]
        front = colour(m.get("diffuse", 0)) * i_d * cosine + colour(m.get("specular", 0)) * i_s * shine
        behind = (colour(m.get("diffuse_transmission", 0)) * i_d * -cosine
                  + colour(m.get("specular_transmission", 0)) * i_s * through)  # fmt: skip
        total = total + np.where(cosine > 0, front, behind)
    return total


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("name", TERMS)
def test_each_term(name: str, level: str) -> None:
    """On a tilted disc, lit from both sides, seen from its front."""
    disc = {"disc": {"normal": list(NORMAL), "radius": 50}, "material": TERMS[name]}
    image = render(
        {"camera": VIEW, "image": {"size": SIZE}, "ambient": 0.1, "lights": LIGHTS, "objects": [disc]}, level
    )
    eye, d = eye_rays(VIEW)
    normal = NORMAL.astype(np.float32).astype(float) if level == "standard" else NORMAL
    q = eye + d * (-dot(eye, normal) / dot(d, normal))[..., None]
    expected = illuminate(TERMS[name], LIGHTS, 0.1, q, normal + 0 * q, -d)
    assert expected.max() > 0.05
    error = abs(image.pixels[..., :3] - expected) / np.maximum(1, expected)
    print(f"{name}, {level}: {error.max():.1e}")
    assert error.max() < TOLERANCE[level] * TERMS[name].get("shininess", 1) ** 0.5
    assert image.stats["rays"]["reflection"] == image.stats["rays"]["transmission"] == 0
    # A feeler only where its term can contribute: none for ambient and emission, none behind what is opaque.
    per_pixel = {"ambient": 0, "emission": 0, "diffuse": 2, "diffuse_transmission": 2, "all": 4}
    if name in per_pixel:
        assert image.stats["rays"]["shadow"] == per_pixel[name] * SIZE[0] * SIZE[1]


@pytest.mark.parametrize("level", LEVELS)
def test_a_disc_does_not_shade_itself_at_the_origin(level: str) -> None:
    disc = {"disc": {"normal": list(NORMAL), "radius": 50}, "material": {"diffuse": 1}}
    scene = {"image": {"size": SIZE}, "lights": LIGHTS, "objects": [disc]}
    for x in range(3):
        assert render({**scene, "camera": camera((x, 2, 4))}, level).pixels[15, 20, 0] > 0.3


@pytest.mark.parametrize("level", LEVELS)
def test_a_curved_surface(level: str) -> None:
    """A sphere under a point light: what it hides from itself is dark."""
    light, material = LIGHTS[:1], {"diffuse": [0.5, 0.6, 0.7], "specular": 0.3, "shininess": 20}
    scene = {
        "camera": VIEW,
        "image": {"size": SIZE},
        "lights": light,
        "objects": [{"sphere": {"radius": 0.9}, "material": material}],
    }
    image = render(scene, level)
    eye, d = eye_rays(VIEW)
    b, c = dot(d, eye), dot(eye, eye) - 0.81
    hits = b * b > c
    q = eye - d * (b + np.sqrt(np.maximum(b * b - c, 0)))[..., None]
    expected = np.where(hits[..., None], illuminate(material, light, 0, q, q / 0.9, -d), 0)
    steep = abs(b * b - c) > 1e-3  # away from the outline, where a rounding moves the point far
    assert (image.pixels[..., 3] == hits)[steep].all()
    assert abs(image.pixels[..., :3] - expected)[steep].max() < 10 * TOLERANCE[level]


@pytest.mark.parametrize("level", LEVELS)
def test_phong_peak(level: str) -> None:
    """At the middle pixel the reflection of L meets v: c_a I_a + c_d (n·l) + c_s, whatever the shininess."""
    view = camera((-3, 0, 4), fov=1)
    material = {"ambient": 0.25, "diffuse": 0.5, "specular": 0.25, "shininess": 5000}
    scene = {"camera": view, "image": {"size": SIZE}, "ambient": 0.5, "lights": [{"point": [3, 0, 4]}],
             "objects": [{"disc": {"normal": [0, 0, 1], "radius": 50}, "material": material}]}  # fmt: skip
    pixels = render(scene, level).pixels[..., 0]
    assert (
        abs(pixels[15, 20] - (0.125 + 0.5 * 0.8 + 0.25))
        < 0.25 * 5000 * 4 * {"standard": 2.0**-24, "reference": 2.0**-53}[level]
    )
    assert pixels.argmax() == 15 * 41 + 20


def test_a_light_on_the_surface_makes_no_nan() -> None:
    material = {"diffuse": 0.5, "specular": 0.5, "diffuse_transmission": 0.5, "specular_transmission": 0.5, "ior": 1.5}
    for shadows in (True, False):
        for place in ([0, 0, 0], [1e-30, 0, 0], [0, 0, 1e-12]):
            scene = {"camera": camera((0, 0, 4)), "image": {"size": SIZE}, "lights": [{"point": place}], "shadows": shadows,
                     "objects": [{"disc": {"normal": [0, 0, 1], "radius": 5}, "material": material},
                                 {"box": {"low": [-5, -5, -1], "high": [5, 5, 0]}, "material": material}]}  # fmt: skip
            pixels = render(scene, general=not shadows).pixels
            assert np.isfinite(pixels).all()
            assert (pixels >= 0).all()


@pytest.mark.parametrize("sides", ["both", "front", "back"])
def test_a_side_that_is_not_there(sides: str) -> None:
    """A green pane whose front is above: whichever ray comes from a side that is not there passes it."""
    pane = {
        "disc": {"centre": [0, 0, 2], "normal": [0, 0, 1], "radius": 1},
        "material": {"emission": [0, 1, 0]},
        "sides": sides,
    }
    green, blue = [0, 1, 0], [0, 0, 1]
    above, below = (green if sides in ("both", side) else blue for side in ("front", "back"))

    def look_down(height: float, *others: dict[str, Any], **more: Any) -> Any:
        scene = {"camera": camera((0, 0, height), (0, 0, -9), fov=1), "image": {"size": SIZE}, "background": blue}
        return render({**scene, "objects": [pane, *others], **more}).pixels[15, 20, :3].tolist()

    def layer(z: float, **material: Any) -> dict[str, Any]:
        return {"disc": {"centre": [0, 0, z], "normal": [0, 0, 1], "radius": 1}, "material": material}

    assert look_down(5) == above
    assert look_down(5, layer(3, transmission=1)) == above
    assert look_down(1, layer(0, reflection=1)) == below
    lit = look_down(1, layer(0, diffuse=[1, 0, 0]), lights=[{"point": [0, 0, 10]}])
    assert lit == pytest.approx([0 if below == green else 1, 0, 0], abs=1e-6)


# ---- shadows and outlines


@pytest.mark.parametrize("light", [{"point": [0.4, 3, 0.2]}, {"directional": [0.5, -2, 0.3]}])
def test_the_shadow_of_a_sphere(light: dict[str, Any]) -> None:
    """An ellipse on the floor: a point is dark exactly when its way to the light passes the centre within the radius."""
    view, centre, radius = camera((0, 6, 0.1), up=(0, 0, -1), fov=40), np.array([0.1, 1, 0]), 0.5
    scene = {"camera": view, "image": {"size": (161, 161)}, "lights": [light], "objects": [
        {"disc": {"normal": [0, 1, 0], "radius": 50}, "material": {"diffuse": 1}},
        {"sphere": {"centre": list(centre), "radius": radius}, "material": {"emission": 1}}]}  # fmt: skip
    pixels = render(scene).pixels[..., 0]
    eye, d = eye_rays(view, (161, 161))
    across = length((centre - eye) - d * dot(d, centre - eye)[..., None])
    q = eye - d * (eye[1] / d[..., 1])[..., None]
    towards = (
        unit(np.array(light["point"]) - q) if "point" in light else unit(-np.array(light["directional"], float)) + 0 * q
    )
    miss = length((centre - q) - towards * dot(towards, centre - q)[..., None])
    sure = (across > radius + 1e-5) & (abs(miss - radius) > 1e-5)
    dark = miss < radius
    assert (dark & sure).sum() > 200
    assert ((pixels == 0) == dark)[sure].all()
    # The same area by NUMERICS' closed form, the light as the pinhole: a projection onto the floor at distance f.
    if "point" in light:
        place = np.array(light["point"])
        f, axis = place[1], unit(centre - place)
        cosine, sine = -axis[1], radius / np.linalg.norm(centre - place)
        area = np.pi * f**2 * sine**2 * np.sqrt(1 - sine**2) / (cosine**2 - sine**2) ** 1.5
        pixel = (2 * 6 * np.tan(np.radians(20)) / 161) ** 2
        seen = dark & (across > radius)
        assert abs(dark.sum() * pixel - area) < 0.02 * area
        assert seen.sum() > 0


def test_the_area_of_a_spheres_outline() -> None:
    """NUMERICS: pi f² sin²b cos b / (cos²a - sin²b)^(3/2), for a sphere off the axis."""
    centre, radius = np.array([1.1, 0.6, 0]), 0.8
    view = camera((0, 0, 5), fov=45)
    scene = {"camera": view, "image": {"size": (80, 60)}, "objects": [
        {"sphere": {"centre": list(centre), "radius": radius}, "material": {"emission": 1}}]}  # fmt: skip
    image = render(scene, samples=16)
    away = np.linalg.norm(centre - [0, 0, 5])
    cosine, sine = 5 / away, radius / away
    area = np.pi * sine**2 * np.sqrt(1 - sine**2) / (cosine**2 - sine**2) ** 1.5
    pixel = (2 * np.tan(np.radians(22.5)) / 60) ** 2
    found = image.pixels[..., 0].sum() * pixel
    print(f"outline's area: {found / area - 1:+.1e}")
    assert abs(found / area - 1) < 1e-3
    assert image.stats["rays"]["eye_hits"] == round(float(image.pixels[..., 3].sum(dtype=float)) * 16)


def test_coverage_of_a_half_plane() -> None:
    """The error of the edge's pixels falls as N^(-3/4), as jittered samples' does; without jitter and with one it is ½."""
    view = camera((0, 0, 1), fov=2 * np.degrees(np.arctan(0.5)))
    slope = 0.31
    half = [[-9, -9 * slope, 0], [9, 9 * slope, 0], [9, -20, 0], [-9, -20, 0]]
    scene = {
        "camera": view,
        "image": {"size": (64, 64)},
        "objects": [{"polygon": {"corners": half}, "material": {"emission": 1}}],
    }
    fine = np.linspace(-0.5, 0.5, 64 * 256 + 1)
    edge = slope * (fine[:-1] + fine[1:]) / 2
    top = 0.5 - np.arange(64)[:, None] / 64
    exact = np.clip((edge - (top - 1 / 64)) * 64, 0, 1).reshape(64, 64, 256).mean(2)
    between = (exact > 0) & (exact < 1)
    errors = {}
    for samples in (1, 4, 16, 64):
        pixels = render(scene, samples=samples).pixels[..., 0]
        assert ((pixels == exact) | between).all()
        errors[samples] = np.sqrt(np.mean((pixels - exact)[between] ** 2))
    print("edge RMSE", {n: round(float(e), 4) for n, e in errors.items()})
    for samples in (4, 16):
        assert errors[samples * 4] < errors[samples] * 4**-0.6


# ---- ray trees


def facing(k: float, depth: int, emission: float = 0.3, **more: Any) -> Any:
    mirror = {"reflection": k, "emission": emission}
    discs = [{"disc": {"centre": [0, 0, z], "normal": [0, 0, 1], "radius": 20}, "material": mirror} for z in (-1, 1)]
    return render(
        {"camera": camera((0, 0, 0.5), fov=10), "image": {"size": (9, 7)}, "depth": depth, "objects": discs, **more}
    )


@pytest.mark.parametrize("depth", [5, 8])
def test_facing_mirrors(depth: int) -> None:
    """L = E (1 - k^m) / (1 - k) after m terms; what is not sent weighs k^m."""
    for k in (0.5, 0.9):
        image = facing(k, depth)
        assert np.allclose(image.pixels[..., :3], 0.3 * (1 - k**depth) / (1 - k), rtol=1e-6)
        stats = image.stats
        assert stats["rays"]["reflection"] == 63 * (depth - 1)
        assert stats["deepest_level"] == depth
        assert stats["discarded_weight"]["max"] == pytest.approx(k**depth, rel=1e-6)
        assert stats["discarded_weight"]["mean"] == pytest.approx(k**depth, rel=1e-6)
    exact = facing(0.5, depth)
    assert exact.stats["discarded_weight"]["max"] == 0.5**depth


def test_the_cutoff_stops_light_rays() -> None:
    """Weights ½, ¼ are sent with a cutoff of 0.2, ⅛ is not, at any depth; a weight equal to the cutoff is sent."""
    image = facing(0.5, 8, cutoff=0.2)
    assert image.stats["rays"]["reflection"] == 63 * 2
    assert image.stats["discarded_weight"]["max"] == 0.125
    assert np.allclose(image.pixels[..., :3], 0.3 * 1.75, rtol=1e-6)
    assert facing(0.5, 8, cutoff=0.25).stats["rays"]["reflection"] == 63 * 2


def bound(k: float, **more: Any) -> Any:
    """Of facing mirrors alone, without the materials that `render` adds; and what the picture lacks."""
    discs = [{"disc": {"centre": [0, 0, z], "normal": [0, 0, 1], "radius": 20}, "material": {"reflection": k, "emission": 0.3}}
             for z in (-1, 1)]  # fmt: skip
    scene = {"camera": camera((0, 0, 0.5), fov=10), "image": {"size": (9, 7)}, "depth": 5, "objects": discs, **more}
    image = feeler.Scene(scene).render()
    return image.stats["truncation_bound"], 0.3 / max(1 - k, 1e-30) - image.pixels[..., :3].max()


def test_without_a_bound() -> None:
    assert bound(1.0)[0] == "unbounded"
    assert bound(0.999)[0] != "unbounded"


def test_the_tree_of_a_slab() -> None:
    """A box of two parallel faces, glass that does not bend, depth 3: every ray and weight by hand, per channel."""
    reflection, transmission = np.array([0.1, 0.2, 0.3]), np.array([0.5, 0.25, 0.6])
    material = {"reflection": list(reflection), "transmission": list(transmission), "emission": 0.1, "ior": 1}
    scene = {"camera": camera((0, 0, 5), fov=3), "image": {"size": (9, 7)}, "background": [1, 2, 3], "objects": [
        {"box": {"low": [-5, -5, -1], "high": [5, 5, 1]}, "material": material}]}  # fmt: skip
    image = render(scene, depth=5)
    # Front: reflected out, transmitted in. Back: transmitted out, reflected to the front, and so on: at depth 5, inside
    # still, both of its rays are not sent.
    inside = transmission * reflection ** np.arange(4)[:, None]  # weights of the rays within, depths 2 … 5
    emitted = 0.1 * (1 + inside.sum(0))
    out = reflection + (inside[:3] * transmission).sum(0)
    assert np.allclose(image.pixels[..., :3], emitted + out * [1, 2, 3], rtol=1e-5)
    assert image.stats["rays"] == {"eye": 63, "eye_hits": 63, "reflection": 63 * 4, "transmission": 63 * 4, "shadow": 0}
    unsent = inside[3] * (reflection + transmission)
    assert image.stats["discarded_weight"]["max"] == pytest.approx(unsent.max(), rel=1e-5)


def test_the_bound_of_what_was_not_sent() -> None:
    """Discarded weight x max(background, greatest I_local / (1 - greatest(rho_rg + rho_tg))), the worst channel."""
    # Two facing mirrors: (1/2)^5 of 0.3 / (1 - 1/2) is not sent, which is just what the infinite sum lacks.
    found, lack = bound(0.5)
    assert found == pytest.approx(0.5**5 * 0.3 / 0.5, rel=1e-6)
    assert found == pytest.approx(lack, rel=1e-5)
    # The background is brighter than anything between the mirrors.
    assert bound(0.5, background=[0, 7, 1])[0] == pytest.approx(0.5**5 * 7, rel=1e-6)
    # Every term of I_local at its greatest: per light the brighter side, c_d I_d + c_s I_s or c_td I_d + c_ts I_s.
    m = {"reflection": [0.25, 0.5, 0], "transmission": [0.25, 0, 0], "ambient": 0.5, "emission": [0.25, 1, 9], "diffuse": 0.5,
         "specular": 0.25, "diffuse_transmission": 0.125, "specular_transmission": 1}  # fmt: skip
    discs = [{"disc": {"centre": [0, 0, z], "normal": [0, 0, 1], "radius": 20}, "material": m} for z in (-1, 1)]
    lights = [
        {"point": [0, 0, 0.75], "diffuse": 1, "specular": 1, "ambient": 0.5},
        {"point": [9, 9, 0.5], "diffuse": 4, "specular": 0.5},
    ]
    scene = {"camera": camera((0, 0, 0.5), fov=10), "image": {"size": (9, 7)}, "depth": 1, "ambient": 0.25, "lights": lights,
             "objects": discs}  # fmt: skip
    # depth 1 sends nothing: weights (0.5, 0.5, 0). Light 1: max(0.75, 1.125); light 2: max(2.125, 1); ambient 0.5 x 0.75.
    local = np.array([0.25, 1]) + 0.375 + 1.125 + 2.125
    image = feeler.Scene(scene).render()
    assert image.stats["discarded_weight"]["max"] == 0.5
    assert image.stats["truncation_bound"] == pytest.approx((0.5 * local / (1 - 0.5)).max(), rel=1e-6)


# ---- what float can hardly tell apart


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("distance", [1e5, 1e6, 1e7, 4e7])
def test_far_spheres(distance: float, level: str) -> None:
    """A sphere of radius 1 as it looks to a light at the eye: L.n = sqrt(1 - x^2), x from its middle, nowhere dark."""
    view = camera((0, 0, 0), (0, 0, -distance), fov=float(np.degrees(2 * np.arctan(1.5 / distance))))
    scene = {"camera": view, "image": {"size": SIZE}, "lights": [{"directional": [0, 0, -1]}], "objects": [
        {"sphere": {"centre": [0, 0, -distance], "radius": 1}, "material": {"diffuse": 1}}]}  # fmt: skip
    pixels = render(scene, level=level).pixels
    x, y = np.meshgrid(np.arange(SIZE[0]) - SIZE[0] // 2, np.arange(SIZE[1]) - SIZE[1] // 2)
    square = (x**2 + y**2) * (3 / SIZE[1]) ** 2
    hits = pixels[..., 3] > 0
    assert np.isfinite(pixels).all()
    assert ((hits == (square < 1)) | (abs(square - 1) < 0.05)).all()
    assert (pixels[hits][:, 0] > 0).all()
    if level == "reference" or distance < 1e6:
        assert abs(pixels[..., 0] ** 2 - (1 - square))[hits].max() < (3e-5 if level == "reference" else 0.02)
