"""Rows 16, 17, 20, 23 and 24: refraction, media, reflection and the highlight's power."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
from shapes import REAL, UNIT, dot, length, only, unit, units

import feeler

from .cost import LANES, Cost
from .study import DOUBLE, NAIVE, ROBUST, Curve, Panel, Study, later

OPTICS = only("REFLECTION", "TRANSMISSION", "PRIORITY")


def probe(name: str, *arguments: Any, level: str = "standard", naive: str = "") -> Any:
    return feeler.probe(name, *arguments, level=level, options=f"{OPTICS} {naive}")


# ---- row 16

ULPS = [-64, -16, -8, -4, -2, -1, 0, 1, 2, 4, 8, 16, 64]


def critical_rays(steps: int, level: str, naive: str, count: int) -> tuple[float, float]:
    """Rays whose sine times eta is so many ulps from 1, for indices from 1.05 to 2.5: the share that gives no number, and
    that of wrong decisions where the exact product is more than 2 ulps from 1.
    """
    rng = np.random.default_rng(116)
    real = REAL[level]
    eta = rng.uniform(1.05, 2.5, count).astype(real)
    sine = (1 + steps * np.spacing(real(1))) / eta.astype(np.longdouble)
    v = np.stack([sine, 0 * sine, np.sqrt(1 - sine**2)], 1).astype(real)
    t = probe("refract", v, [0, 0, 1.0], eta, level=level, naive=naive)
    w = v.astype(np.longdouble)
    exact = w[:, 0] / length(w) * eta
    sure = abs(exact - 1) > 2 * np.spacing(real(1))
    found = t.found != 0
    nothing = found & ~np.isfinite(t.direction).all(1)
    return float(np.mean(nothing)), float(np.mean(sure & (found != (exact < 1))))


def critical_angle() -> list[Panel]:
    tries = 5000
    methods = [("1 − (η sin)² under the root, float", NAIVE, "standard", "-DNAIVE_TIR"),
               ("the same, double", DOUBLE, "reference", "-DNAIVE_TIR"),
               ("|t∥|² decides, float", ROBUST, "standard", "")]  # fmt: skip
    found = {m[0]: [critical_rays(x, m[2], m[3], tries) for x in ULPS] for m in methods}
    near = [abs(s) <= 2 for s in ULPS]
    some = {"figures": [0.13 if s == 0 else None if abs(s) <= 2 else 0 for s in ULPS], "bound": 0.13 * 1.2}
    few = {"bound": [0.01 * n for n in near]}
    claims: dict[str, list[Any]] = {
        NAIVE: [some, {**few, "fails": 1e-3}],
        DOUBLE: [some, few],
        ROBUST: [{"bound": 0}] * 2,
    }
    x = [f"{s:+d}" if s else "0" for s in ULPS]
    names = ["transmitted rays without a number", "wrong decisions beyond 2 ulps"]
    return [
        Panel("rays at the critical angle", "η sin θ − 1, ulps of 1", x, names[i],
              [Curve(m[0], m[1], [f[i] for f in found[m[0]]], **claims[m[1]][i]) for m in methods], tries, x_log=False)
        for i in (0, 1)
    ]  # fmt: skip


# ---- row 17

# A glass of water with ice: the media's indices, and what a ray meets from above: material, whether it goes in. The water
# reaches a little into the glass, and the ice lies in the water.
INDICES = {"water": 1.33, "ice": 1.31, "glass": 1.5}
WAY = [("water", 1), ("ice", 1), ("ice", 0), ("glass", 1), ("water", 0), ("glass", 0)]
TRUE = [1.33, 1.31, 1.33, 1.5, 1.5, 1.0]  # glass goes before water


def layer_errors(level: str, naive: str, degrees: float) -> list[float]:
    """N sin θ in each medium of the way against that outside: relative errors."""
    names = list(INDICES)
    zero = [0, 0, 0, 0]
    priorities = {"water": 0, "ice": 1, "glass": 2}
    materials = np.array([[zero] * 8 + [[INDICES[n], priorities[n], 0, 0]] for n in names], float).reshape(3, 36)
    scene = {"materials": materials, "count": [0, 0, 0, 0]}
    angle = np.radians(degrees)
    d = np.array([np.sin(angle), 0, -np.cos(angle)])
    inside: Any = [-1] * 8
    errors = []
    for (name, entering), index in zip(WAY, TRUE, strict=True):
        b = feeler.probe("cross_boundary", scene, {"material": inside}, names.index(name), entering, level=level,
                         options=f"{OPTICS} {naive}")  # fmt: skip
        if b.visible:
            t = probe("refract", -d, [0, 0, 1.0], b.eta, level=level)
            d = t.direction.astype(float) if t.found else d * [1, 1, -1]
        inside = np.ravel(b.behind.material)
        errors.append(float(abs(index * np.hypot(d[0], d[1]) - np.sin(angle)) / np.sin(angle)))
    return errors


def nested_media() -> list[Panel]:
    def off_inside(level: str) -> dict[str, Any]:
        healed = 32 * UNIT[level]
        return {"figures": [None, 0.25, None, 0.25, None, None], "bound": [healed, None, healed, None, healed, healed]}

    kept = {"bound": 32 * UNIT["standard"], "figures": [*[None] * 5, 2.3e-7]}
    methods = [("each against air, float", NAIVE, "standard", "-DNAIVE_MEDIA", off_inside("standard")),
               ("each against air, double", DOUBLE, "reference", "-DNAIVE_MEDIA", off_inside("reference")),
               ("a list of media, float", ROBUST, "standard", "", kept)]  # fmt: skip
    steps = ["into water", "into ice", "out of ice", "into glass", "out of water", "out of glass"]
    return [
        Panel("parallel layers of water, ice, water and glass at 50°", "surface", steps, "relative error of n sin θ",
              [Curve(name, kind, layer_errors(level, naive, 50), **claim) for name, kind, level, naive, claim in methods],
              x_log=False),
    ]  # fmt: skip


# ---- row 20

BOUNCES = [1, 2, 4, 8, 16, 32, 64, 128, 256]


def drift(level: str, naive: str) -> tuple[list[float], list[float]]:
    """After so many reflections at mirrors of random normals: the greatest of 500 directions' | |d| − 1 |, and the greatest
    distance of the direction from that in extended precision.
    """
    rng = np.random.default_rng(120)
    count = 500
    v = units(rng, count).astype(REAL[level])
    exact = v.astype(np.longdouble)
    lengths, errors = [], []
    for bounce in range(1, BOUNCES[-1] + 1):
        n = units(rng, count).astype(REAL[level])
        n = np.where(dot(v, n)[:, None] < 0, -n, n)
        v = -probe("reflect", v, n, level=level, naive=naive)
        m = unit(n.astype(np.longdouble))
        exact = -(2 * dot(exact, m)[:, None] * m - exact)
        if bounce in BOUNCES:
            w = v.astype(np.longdouble)
            lengths.append(float(abs(length(w) - 1).max()))
            errors.append(float(length(unit(w) - unit(exact)).max()))
    return lengths, errors


def bounces() -> list[Panel]:
    methods = [("2 (v·n) n − v, float", NAIVE, "standard", "-DNAIVE_NORMALISE"),
               ("2 (v·n) n − v, double", DOUBLE, "reference", "-DNAIVE_NORMALISE"),
               ("made length 1 again, float", ROBUST, "standard", "")]  # fmt: skip
    found = {m[1]: drift(m[2], m[3]) for m in methods}
    roots = [UNIT["standard"] * k**0.5 for k in BOUNCES]
    claims: dict[str, list[Any]] = {
        NAIVE: [{"figures": [2e-7, *[None] * 7, 2e-6]}, {"figures": found[ROBUST][1], "bound": [4 * r for r in roots]}],
        DOUBLE: [later(values) for values in found[NAIVE]],
        ROBUST: [{"bound": 4 * UNIT["standard"]}, {"fails": roots}],  # the direction's error grows as √k
    }
    return [
        Panel("a ray among mirrors", "reflections", BOUNCES, "greatest | |d| − 1 |",
              [Curve(m[0], m[1], found[m[1]][0], **claims[m[1]][0]) for m in methods]),
        Panel("the same ray's direction", "reflections", BOUNCES, "greatest error of the direction",
              [Curve(m[0], m[1], found[m[1]][1], **claims[m[1]][1]) for m in methods]),
    ]  # fmt: skip


# ---- row 23

TILTS = [0, 5, 10, 20, 30, 45, 60]


def sunk(degrees: float, level: str, naive: str, count: int) -> float:
    """Reflections at a normal that is turned so far from the surface's own, of rays from all sides: below the surface."""
    rng = np.random.default_rng(123)
    v = units(rng, count)
    v[:, 2] = abs(v[:, 2])
    turn = rng.uniform(0, 2 * np.pi, count)
    tilt = np.radians(degrees)
    n = np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt) + 0 * turn], 1)
    n = np.where(dot(v, n)[:, None] > 0, n, unit(n - 1.001 * dot(v, n)[:, None] * v))  # kept on v's side
    r = probe("keep_above", probe("reflect", v, n, level=level), [0, 0, 1.0], level=level, naive=naive)
    return float(np.mean(r[:, 2] <= 0))


def below() -> list[Panel]:
    tries = 10_000
    methods = [("as the interpolated normal says, float", NAIVE, "standard", "-DNAIVE_SHADING"),
               ("the same, double", DOUBLE, "reference", "-DNAIVE_SHADING"),
               ("lifted above the surface, float", ROBUST, "standard", "")]  # fmt: skip
    found = {m[1]: [sunk(x, m[2], m[3], tries) for x in TILTS] for m in methods}
    few = 5 / tries  # that rounding may tell apart
    claims: dict[str, Any] = {
        NAIVE: {"figures": [x / 90 for x in TILTS]},
        DOUBLE: {"bound": [n + few for n in found[NAIVE]], "fails": [n - few for n in found[NAIVE]]},
        ROBUST: {"bound": 0},
    }
    return [
        Panel("reflection at interpolated normals", "angle between the normals, degrees", TILTS, "reflections below the surface",
              [Curve(m[0], m[1], found[m[1]], **claims[m[1]]) for m in methods], tries, x_log=False),
    ]  # fmt: skip


# ---- row 24

ANGLES = [0.5, 1, 2, 3, 4, 5, 6, 7, 7.4, 7.6, 7.8, 8, 8.2, 8.4, 9]
SHININESS = 1e4


def power_errors(level: str, naive: str) -> tuple[list[float], list[float]]:
    """cos(angle)^10000: relative error where the exact value is a normal number, and the share of results that are neither
    0 nor normal.
    """
    errors, denormal = [], []
    real, tiny = REAL[level], float(np.finfo(REAL[level]).tiny)
    for angle in ANGLES:
        base = np.cos(np.radians(angle + np.linspace(-0.05, 0.05, 200))).astype(real)
        found = probe("power", base, SHININESS, level=level, naive=naive)
        worst = None
        for b, f in zip(base, found, strict=True):
            with mpmath.workdps(40):
                exact = mpmath.power(mpmath.mpf(float(b)), SHININESS)
                if exact >= tiny:
                    worst = max(worst or 0.0, float(abs(mpmath.mpf(float(f)) - exact) / exact))
        errors.append(worst)
        denormal.append(float(np.mean((found > 0) & (found < tiny))))
    return errors, denormal


def highlights() -> list[Panel]:
    methods = [("OpenCL's pow, float", NAIVE, "standard", "-DNAIVE_POW"),
               ("OpenCL's pow, double", DOUBLE, "reference", "-DNAIVE_POW"),
               ("power, float", ROBUST, "standard", "")]  # fmt: skip
    found = {m[1]: power_errors(m[2], m[3]) for m in methods}
    within = [7.6 <= x <= 8.2 for x in ANGLES]
    accurate = [6e-8 if x <= 7.6 else None for x in ANGLES]
    claims: dict[str, list[Any]] = {
        NAIVE: [
            {"bound": [float(w) for w in within], "fails": [0.7 * w for w in within]},
            {"bound": 32 * UNIT["standard"]},
        ],
        DOUBLE: [{"bound": 0}, {"bound": 32 * UNIT["reference"]}],  # OpenCL allows pow 16 ulps
        ROBUST: [{"bound": 0}, {"bound": 4 * UNIT["standard"], "figures": accurate}],
    }
    return [
        Panel("a highlight of shininess 10⁴", "angle from its middle, degrees", ANGLES, "results under the normal range",
              [Curve(m[0], m[1], found[m[1]][1], **claims[m[1]][0]) for m in methods], 200, x_log=False),
        Panel("the same, where the exact value is a normal number", "angle from its middle, degrees", ANGLES,
              "greatest relative error", [Curve(m[0], m[1], found[m[1]][0], **claims[m[1]][1]) for m in methods], x_log=False),
    ]  # fmt: skip


def pairs(rng: np.random.Generator, count: int) -> list[Any]:
    v, n = units(rng, count), units(rng, count)
    n = np.where(dot(v, n)[:, None] < 0, -n, n)
    return [*v.T, *n.T]


REFRACT_CODE = "const refraction t = refract(IN3(0), IN3(3), splat(1.0f / 1.5f)); OUT = t.direction.x + t.direction.y + t.direction.z;"
REFLECT_CODE = "const vectors r = reflect(IN3(0), IN3(3)); OUT = r.x + r.y + r.z;"
# Of two materials, one of which may be around.
MEDIA_CODE = """
scene s;
s.materials = (global const material *)in;
media m = no_media();
m.material[0] = IN(0) > R(0.5) ? whole(0) : whole(-1);
const boundary b = cross_boundary(&s, &m, IN(1) > R(0.5) ? whole(0) : whole(1), IN(2) > R(0.5));
OUT = b.visible ? b.eta + TO_REALS(b.behind.material[0] + b.behind.material[1]) : splat(0);
"""
ABOVE_CODE = "const vectors r = keep_above(reflect(IN3(0), IN3(3)), IN3(3)); OUT = r.x + r.y + r.z;"
STUDIES = [
    Study(16, "critical angle", "Snell's law in extended precision", critical_angle,
          Cost("one refraction", "-DNAIVE_TIR", REFRACT_CODE, pairs)),
    Study(17, "media in media", "n sin θ is the same in parallel layers", nested_media,
          Cost("one boundary", "-DNAIVE_MEDIA", MEDIA_CODE,
               lambda rng, n: rng.uniform(0, 1, (3, n // LANES)).repeat(LANES, 1), ("TRANSMISSION", "PRIORITY"))),
    Study(20, "directions that drift", "reflections in extended precision", bounces,
          Cost("one reflection", "-DNAIVE_NORMALISE", REFLECT_CODE, pairs)),
    Study(23, "reflection below the surface", "n_g · r > 0", below,
          Cost("one reflection", "-DNAIVE_SHADING", ABOVE_CODE, pairs)),
    Study(24, "pow at a high shininess", "40 digits (mpmath)", highlights,
          Cost("one power at 3° … 9° and shininess 10⁴", "-DNAIVE_POW", "OUT = power(IN(0), splat(1e4f));",
               lambda rng, n: [np.cos(np.radians(rng.uniform(3, 9, n)))])),
]  # fmt: skip
