"""The kernels' arithmetic against exact numbers: fractions and mpmath. Printed with -s: the greatest errors, in ulps."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from shapes import LEVELS, REAL, UNIT, dot, only, units

import feeler

NOTHING = only()


def probe(name: str, *arguments: Any, level: str = "standard") -> Any:
    return feeler.probe(name, *arguments, level=level, options=NOTHING)


def ulps(found: Any, exact: list[Any], level: str) -> Any:
    """Errors in units of the exact value's last place."""
    real = REAL[level]
    return np.array(
        [
            float(abs(mpmath.mpf(float(f)) - e) / float(np.spacing(real(abs(e)))))
            for f, e in zip(found, exact, strict=True)
        ]
    )


POWER_ULPS = {"standard": 1.5, "reference": 1.5}


@pytest.mark.parametrize("level", LEVELS)
def test_power(level: str) -> None:
    """Shininess from 0.1 to 1e6: results over the whole range of normal numbers."""
    rng = np.random.default_rng(41)
    n, real = 4000, REAL[level]
    exponent = (10 ** rng.uniform(-1, 6, n)).astype(real)
    exponent[:4] = [1, 2, 1e4, 1e6]
    least = -87 if level == "standard" else -708
    base = np.exp(rng.uniform(least, 0, n) * rng.uniform(0, 1, n) ** 3 / np.maximum(exponent, 1)).astype(real)
    base[4:8] = [1, 0.5, 1 - UNIT[level], 0.7071067811865476]
    base[8:400] = rng.uniform(0.7, 0.75, 392)  # far from powers of two, small results
    exponent[8:400] = rng.uniform(0, least / np.log(0.7), 392)
    found = probe("power", base, exponent, level=level)
    with mpmath.workdps(40):
        exact = [mpmath.power(mpmath.mpf(float(b)), mpmath.mpf(float(e))) for b, e in zip(base, exponent, strict=True)]
    normal = np.array([e >= np.finfo(real).tiny for e in exact])
    errors = np.where(normal, ulps(found, exact, level), 0)
    print(f"power, {level}: {errors.max():.2f} ulp at {base[errors.argmax()]!r}^{exponent[errors.argmax()]!r}")
    assert normal.mean() > 0.9
    assert errors.max() <= POWER_ULPS[level]


@pytest.mark.parametrize("level", LEVELS)
def test_power_at_its_ends(level: str) -> None:
    tiny, denormal = np.finfo(REAL[level]).tiny, np.finfo(REAL[level]).smallest_subnormal
    base = [0, 0, 1, 1, 1, denormal, tiny / 2, tiny, 0.5, 0.9, 1e-3]
    exponent = [0.1, 1e6, 0.1, 10, 1e6, 0.5, 1, 1, 1e6, 1e6, 1e4]
    found = probe("power", base, exponent, level=level)
    assert list(found[:8]) == [0, 0, 1, 1, 1, 0, 0, tiny]  # less than the least normal number counts as 0
    assert list(found[8:]) == [0, 0, 0]  # and so do powers below it


def test_power_falls_with_its_base() -> None:
    """No jumps between the pieces of the logarithm: a highlight has no rings."""
    base = np.arange(0x3F000000, 0x3F800001, 97, dtype=np.int32).view(np.float32)  # 0.5 … 1
    found = probe("power", base, 50).astype(float)
    assert (np.diff(found) >= -2 * np.spacing(found[1:].astype(np.float32))).all()


@pytest.mark.parametrize("level", LEVELS)
def test_differences_of_products_keep_their_sign(level: str) -> None:
    """A b - c d where c and d are a few ulps from a and b: all of the products' leading digits cancel."""
    rng = np.random.default_rng(45)
    n, real = 5000, REAL[level]
    a, b = (rng.uniform(1, 2, (2, n)) * 2.0 ** rng.integers(-30, 30, (2, n)) * rng.choice([-1, 1], (2, n))).astype(real)
    step = rng.integers(-3, 4, (2, n)).astype(real)
    c, d = (a + step[0] * np.spacing(a)).astype(real), (b + step[1] * np.spacing(b)).astype(real)
    c[:500], d[:500] = d[:500].copy(), c[:500].copy()
    found = probe("difference_of_products", a, b, c, d, level=level)
    swapped = probe("difference_of_products", c, d, a, b, level=level)
    worst = 0.0
    for i in range(n):
        exact = Fraction(float(a[i])) * Fraction(float(b[i])) - Fraction(float(c[i])) * Fraction(float(d[i]))
        assert np.sign(found[i]) == (exact > 0) - (exact < 0)
        assert np.sign(swapped[i]) == -np.sign(found[i])  # neighbours that share an edge
        if exact:
            worst = max(
                worst, float(abs(Fraction(float(found[i])) - exact) / Fraction(float(np.spacing(real(abs(exact))))))
            )
    print(f"difference of products, {level}: {worst:.2f} ulp")
    assert worst <= 1.5


@pytest.mark.parametrize("level", LEVELS)
def test_next_away(level: str) -> None:
    real = REAL[level]
    rng = np.random.default_rng(42)
    x = (10 ** rng.uniform(-20, 20, 1000) * rng.choice([-1, 1], 1000)).astype(real)
    towards = rng.choice([-1.0, 1.0, 0.0], 1000)
    found = probe("next_away", x, towards, level=level)
    up, down = np.nextafter(x, real(np.inf)), np.nextafter(x, real(-np.inf))
    assert (found == x)[towards == 0].all()
    assert (found >= up)[towards > 0].all()
    assert (found <= down)[towards < 0].all()
    assert (abs(found - x) <= 2 * np.spacing(abs(x))).all()
    assert probe("next_away", 0, 1, level=level) == 0


@pytest.mark.parametrize("level", LEVELS)
def test_a_spawned_point_is_outside_of_the_errors_box(level: str) -> None:
    """Farther along the normal than any corner of the box, exactly; and what scales, scales bit for bit."""
    rng = np.random.default_rng(43)
    n, real = 3000, REAL[level]
    p = (rng.uniform(-1, 1, (n, 3)) * 10 ** rng.uniform(-6, 6, (n, 1))).astype(real)
    error = (abs(p) * rng.uniform(0, 100, (n, 3)) * UNIT[level]).astype(real)
    normal = units(rng, n)
    normal[:300] = np.eye(3)[rng.integers(0, 3, 300)]
    normal = normal.astype(real)
    start = probe("spawn", p, error, normal, level=level)
    for i in range(n):
        moved = [Fraction(float(a)) - Fraction(float(b)) for a, b in zip(start[i], p[i], strict=True)]
        height = sum(m * Fraction(float(k)) for m, k in zip(moved, normal[i], strict=True))
        corner = sum(Fraction(float(e)) * abs(Fraction(float(k))) for e, k in zip(error[i], normal[i], strict=True))
        assert height >= corner * Fraction(999_999, 1_000_000)
    scaled = probe("spawn", p * real(2.0**-40), error * real(2.0**-40), normal, level=level)
    assert (scaled == start * real(2.0**-40)).all()


def places(*arguments: Any) -> Any:
    """Places in pixels: all x, all y."""
    return np.moveaxis(probe("place_samples", *arguments), -1, 0)


def test_whole_quotients() -> None:
    """Right while they are under 2^22, next to multiples above all."""
    rng = np.random.default_rng(45)
    b = np.concatenate([np.arange(1, 300), rng.integers(1, 2**20, 2000)])[:, None]
    q = np.concatenate([np.arange(20), rng.integers(0, 2**22, 200), [2**22 - 1]])
    a = b * q + np.stack([0 * b, b // 2, b - 1])
    fits = a < 2**32
    found = probe("divide", np.where(fits, a, 0), b, level="standard")
    assert (found == np.where(fits, q, 0)).all()


@pytest.mark.parametrize("samples", [1, 2, 3, 4, 5, 7, 12, 16, 33, 64])
def test_samples_are_one_to_a_cell(samples: int) -> None:
    """Cells of equal areas that cover the pixel, each with its sample, whatever the pixel."""
    x, y = np.meshgrid(np.arange(8), np.arange(5) * 1000)
    index = np.arange(samples)
    place_x, place_y = places(x[..., None], y[..., None], index, samples, 1.0)
    centre_x, centre_y = places(x[..., None], y[..., None], index, samples, 0.0)
    assert (np.diff(centre_x.reshape(-1, samples), axis=0) == 0).all()
    rows = int(np.sqrt(samples))
    row = (index * rows + rows - 1) // samples
    count = np.bincount(row)
    assert len(count) == rows
    first = np.concatenate([[0], np.cumsum(count)])
    low_x, width = (index - first[row]) / count[row], 1 / count[row]
    low_y, height = first[row] / samples, count[row] / samples
    assert np.allclose(width * height, 1 / samples)
    tiny = 1e-6
    assert ((place_x >= low_x - tiny) & (place_x <= low_x + width + tiny)).all()
    assert ((place_y >= low_y - tiny) & (place_y <= low_y + height + tiny)).all()
    assert abs(centre_x - (low_x + width / 2)).max() < tiny
    assert abs(centre_y - (low_y + height / 2)).max() < tiny
    if samples > 1:
        assert len(np.unique(place_x)) > 30 * samples  # jittered, pixel by pixel
    assert ((place_x >= 0) & (place_x <= 1) & (place_y >= 0) & (place_y <= 1)).all()


def test_jitter_is_uniform() -> None:
    x, y = np.meshgrid(np.arange(200), np.arange(200))
    place_x, place_y = places(x, y, 1, 4, 1.0)
    for values in (place_x % 0.5 * 2, place_y % 0.5 * 2):
        counts = np.histogram(values, 20, (0, 1))[0]
        assert abs(counts - 2000).max() < 5 * np.sqrt(2000)
    assert abs(np.corrcoef(place_x.ravel(), place_y.ravel())[0, 1]) < 0.02


@pytest.mark.parametrize("level", LEVELS)
def test_normalised_ones_have_length_one(level: str) -> None:
    """NUMERICS row 20: | |d| - 1 | <= 4 u."""
    rng = np.random.default_rng(44)
    d = probe("normalise", units(rng, 10_000) * 10 ** rng.uniform(-10, 10, (10_000, 1)), level=level).astype(
        np.longdouble
    )
    assert abs(np.sqrt(dot(d, d)) - 1).max() <= 4 * UNIT[level]
