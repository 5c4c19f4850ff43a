"""Where rays go: reflection (16.9) and transmission (16.15 - 16.18) through probe, against mpmath and closed forms."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from shapes import (
    BOX,
    FLOAT_FIRST,
    LEVELS,
    REAL,
    SHAPES,
    SPHERE,
    UNIT,
    Shapes,
    cross,
    dot,
    length,
    only,
    ray,
    spawn,
    surface,
    unit,
    units,
)

import feeler

OPTICS = only("REFLECTION", "TRANSMISSION")


def probe(name: str, *arguments: Any, level: str = "standard") -> Any:
    return feeler.probe(name, *arguments, level=level, options=OPTICS)


def pairs(level: str, count: int, seed: int) -> tuple[Any, Any]:
    """Directions v and normals n with v on n's side, rounded."""
    rng = np.random.default_rng(seed)
    v, n = units(rng, count), units(rng, count)
    n = np.where(dot(v, n)[:, None] < 0, -n, n)
    return v.astype(REAL[level]), n.astype(REAL[level])


@pytest.mark.parametrize("level", LEVELS)
def test_reflection(level: str) -> None:
    v, n = pairs(level, 10_000, 51)
    found = probe("reflect", v, n, level=level)
    w, m = v.astype(np.longdouble), unit(n.astype(np.longdouble))
    exact = unit(2 * dot(w, m)[:, None] * m - w)
    error = length(found - exact)
    print(f"reflect, {level}: {error.max() / UNIT[level]:.1f} u")
    assert error.max() < 8 * UNIT[level]


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("eta", [1 / 1.5, 1.5, 0.75, 1.0, 2.4])
def test_refraction_obeys_snell(eta: float, level: str) -> None:
    v, n = pairs(level, 10_000, 52)
    found = probe("refract", v, n, eta, level=level)
    w, m, e = v.astype(np.longdouble), unit(n.astype(np.longdouble)), np.longdouble(REAL[level](eta))
    sine = length(np.cross(w, m)) / length(w) * e
    t = e * (dot(w, m)[:, None] * m - w) / length(w)[:, None]
    exact = t - np.sqrt(np.maximum(1 - sine**2, 0))[:, None] * m
    sure = abs(sine - 1) > 4 * UNIT[level]
    assert ((found.found != 0) == (sine < 1))[sure].all()
    passes = sure & (sine < 1)
    # Near the critical angle an error of the sine is 1 / cosine as large in the angle.
    error = (length(found.direction - exact) * np.sqrt(np.maximum(1 - sine**2, 1e-12)))[passes]
    print(f"refract, eta {eta:.3f}, {level}: {error.max() / UNIT[level]:.1f} u")
    assert error.max() < 12 * UNIT[level]
    residual = abs(length(np.cross(found.direction, m)) - sine)[passes]
    assert residual.max() < 12 * UNIT[level]


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize(("ior", "degrees"), [(1.5, 41.8103), (4 / 3, 48.5904)])
def test_critical_angle(ior: float, degrees: float, level: str) -> None:
    """NUMERICS row 16: decided rightly where the sine is off by more than 2 ulps."""
    real = REAL[level]
    n = np.array([0, 0, 1.0])
    eta = real(ior)
    critical = float(mpmath.asin(1 / mpmath.mpf(float(eta))))
    assert np.degrees(critical) == pytest.approx(degrees, abs=1e-4)
    sine = real(np.sin(critical))
    steps = np.arange(-200, 201)
    sines = (sine + steps * np.spacing(sine)).astype(real).astype(np.longdouble)
    v = np.stack([sines, 0 * sines, np.sqrt(1 - sines**2)], 1).astype(real)
    w = v.astype(np.longdouble)
    exact = w[:, 0] / length(w) * np.longdouble(eta)
    found = probe("refract", v, n, eta, level=level)
    sure = abs(exact - 1) > 2 * np.spacing(real(1))
    assert sure.sum() > 300
    assert ((found.found != 0) == (exact < 1))[sure].all()
    assert np.isfinite(found.direction).all()


@pytest.mark.parametrize("level", LEVELS)
def test_fresnel(level: str) -> None:
    """Born and Wolf 1.5.2, in both directions; normal incidence in closed form."""
    for n1, n2 in ((1.0, 1.5), (1.5, 1.0), (1.33, 1.6)):
        limit = 1.0 if n1 < n2 else n2 / n1
        sine = np.linspace(0, 0.999 * limit, 500)
        cos_v, cos_t = np.sqrt(1 - sine**2), np.sqrt(1 - (sine * n1 / n2) ** 2)
        across = ((n1 * cos_v - n2 * cos_t) / (n1 * cos_v + n2 * cos_t)) ** 2
        within = ((n1 * cos_t - n2 * cos_v) / (n1 * cos_t + n2 * cos_v)) ** 2
        found = probe("fresnel", cos_v, cos_t, n1 / n2, level=level)
        assert abs(found - (across + within) / 2).max() < 16 * UNIT[level]
        assert found[0] == pytest.approx(((n1 - n2) / (n1 + n2)) ** 2, rel=32 * UNIT[level])
        assert ((found >= 0) & (found <= 1)).all()


@pytest.mark.parametrize("level", LEVELS)
def test_three_mirrors_send_rays_back(level: str) -> None:
    """NUMERICS row 20: a 90° corner returns -d."""
    rng = np.random.default_rng(53)
    d = units(rng, 5000).astype(REAL[level])
    v, turn = -d, np.linalg.qr(rng.normal(size=(3, 3)))[0]
    for n in turn:
        side = np.where(dot(v, n)[:, None] < 0, -n, n)
        v = -probe("reflect", v, side, level=level)
    error = length(-v + d.astype(np.longdouble)).max()
    assert error < 24 * UNIT[level]


def pass_through(shapes: Shapes, origin: Any, direction: Any, ior: float) -> tuple[Any, Any, Any]:
    """Rays through a convex glass body, by the device's functions: where they come out, their directions, how many."""
    level, numbers = shapes.level, np.zeros(len(origin), int)
    good = np.ones(len(origin), bool)
    for eta in (1 / ior, ior):
        r = ray(level, origin, direction)
        found, c = cross(shapes, r, numbers)
        s = surface(shapes, r, c, numbers)
        side = np.where(dot(s.normal, r.direction)[:, None] < 0, s.normal, -s.normal)
        t = feeler.probe("refract", -r.direction, side, eta, level=level, options=SHAPES)
        good &= found & (t.found != 0)
        origin, direction = spawn(level, s, -side), t.direction
    return origin, direction, good


@pytest.mark.parametrize("level", FLOAT_FIRST)
def test_a_slab_moves_rays_aside(level: str) -> None:
    """By t sin(a - b) / cos b, parallel to themselves."""
    thick, ior = 0.7, 1.5
    slab = Shapes(BOX, level, None, np.array([[-50.0, -50, 0]]), np.array([[50.0, 50, thick]], REAL[level]))
    angle = np.linspace(0.01, 1.5, 200)
    d = np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], 1)
    start = np.array([0.2, 0.1, 1.5]) + 0 * d
    out, direction, good = pass_through(slab, start, d, ior)
    assert good.all()
    within = np.arcsin(np.sin(angle) / ior)
    expected = thick * np.sin(angle - within) / np.cos(within)
    aside = (out - start) - d * dot(out - start, d)[:, None]
    found = dot(aside, np.stack([-np.cos(angle), 0 * angle, -np.sin(angle)], 1))
    scale = 1 / np.cos(angle)  # the way to the slab
    assert (abs(found - expected) < 16 * UNIT[level] * scale).all()
    assert (length(direction - d) < 16 * UNIT[level] * scale).all()


@pytest.mark.parametrize("level", FLOAT_FIRST)
def test_a_lone_glass_sphere(level: str) -> None:
    """The deviation is 2 (asin h - asin(h / n)), and no ray from outside is reflected totally within."""
    ior = 1.5
    sphere = Shapes(SPHERE, level, np.array([[0, 0, 0, 1.0]]), -np.ones((1, 3)), np.ones((1, 3)))
    h = np.concatenate([np.linspace(1e-3, 0.99, 500), 1 - 10 ** np.linspace(-2, -5, 500)])
    start = np.stack([h, 0 * h, 0 * h + 3], 1).astype(REAL[level]).astype(float)
    h = start[:, 0]
    _, direction, good = pass_through(sphere, start, np.array([0, 0, -1.0]) + 0 * start, ior)
    assert good.all()
    deviation = np.arctan2(-direction[:, 0].astype(float), -direction[:, 2].astype(float))
    error = abs(deviation - 2 * (np.arcsin(h) - np.arcsin(h / ior))) * np.sqrt(1 - h * h)
    print(f"glass sphere, {level}: {error.max() / UNIT[level]:.1f} u, the outline's steepness allowed for")
    assert error.max() < 32 * UNIT[level]
