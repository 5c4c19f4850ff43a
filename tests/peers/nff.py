"""Reads Eric Haines' Neutral File Format, as docs/scene-format.md has it, for the exporter to POV-Ray."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

Vector = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Fill:
    """A material. kd: diffuse share of the colour; ks: white highlight and mirror; t: transmitted share."""

    colour: Vector
    kd: float
    ks: float
    shine: float
    t: float
    ior: float


@dataclass(frozen=True)
class Sphere:
    fill: Fill
    centre: Vector
    radius: float


@dataclass(frozen=True)
class Cone:
    """Open at both ends."""

    fill: Fill
    base: Vector
    base_radius: float
    top: Vector
    top_radius: float


@dataclass(frozen=True)
class Polygon:
    """Planar, convex or not; normals are none, or one per corner."""

    fill: Fill
    corners: list[Vector]
    normals: list[Vector]


@dataclass
class Scene:
    """The angle, in degrees, spans the first to the last pixel's centre."""

    eye: Vector = (0, 0, 0)
    look_at: Vector = (0, 0, 0)
    up: Vector = (0, 0, 0)
    angle: float = 45
    background: Vector = (0, 0, 0)
    lights: list[tuple[Vector, Vector]] = field(default_factory=list)  # position, colour
    shapes: list[Sphere | Cone | Polygon] = field(default_factory=list)


class _Words:
    """The words of a text, without comments."""

    def __init__(self, text: str) -> None:
        self._lines: Iterator[str] = iter(text.splitlines())
        self._rest: list[str] = []

    def next(self) -> str | None:
        while not self._rest:
            line = next(self._lines, None)
            if line is None:
                return None
            self._rest = line.partition("#")[0].split()[::-1]
        return self._rest.pop()

    def number(self) -> float:
        word = self.next()
        if word is None:
            raise ValueError("the file ends where a number should be")
        return float(word)

    def vector(self) -> Vector:
        return self.number(), self.number(), self.number()

    def line_goes_on(self) -> bool:
        return bool(self._rest)


def _read_fill(words: _Words) -> Fill:
    colour = words.vector()
    kd, ks, shine, t, ior = (words.number() for _ in range(5))
    return Fill(colour, kd, ks, shine, t, ior or 1)


def _read_polygon(words: _Words, fill: Fill, smooth: bool) -> Polygon:
    corners, normals = [], []
    for _ in range(int(words.number())):
        corners.append(words.vector())
        if smooth:
            normals.append(words.vector())
    return Polygon(fill, corners, normals)


def _read_shape(words: _Words, kind: str, fill: Fill | None) -> Sphere | Cone | Polygon:
    if fill is None:
        raise ValueError(f"'{kind}' comes before the first fill")
    if kind == "s":
        return Sphere(fill, words.vector(), words.number())
    if kind == "c":
        return Cone(fill, words.vector(), words.number(), words.vector(), words.number())
    if kind in ("p", "pp"):
        return _read_polygon(words, fill, kind == "pp")
    raise ValueError(f"'{kind}' is no NFF entity")


def _read_view(words: _Words, kind: str, scene: Scene) -> bool:
    """Whether the word was one of the viewpoint's or the background."""
    if kind in ("from", "at", "up", "b"):
        name = {"from": "eye", "at": "look_at", "up": "up", "b": "background"}[kind]
        setattr(scene, name, words.vector())
    elif kind == "angle":
        scene.angle = words.number()
    elif kind == "hither":
        words.number()
    elif kind == "resolution":
        words.number(), words.number()
    return kind in ("v", "from", "at", "up", "b", "angle", "hither", "resolution")


def read_nff(path: Path) -> Scene:
    words, scene, fill = _Words(path.read_text()), Scene(), None
    lights: list[tuple[Vector, Vector | None]] = []
    while (kind := words.next()) is not None:
        if _read_view(words, kind, scene):
            continue
        if kind == "f":
            fill = _read_fill(words)
        elif kind == "l":
            lights.append((words.vector(), words.vector() if words.line_goes_on() else None))
        else:
            scene.shapes.append(_read_shape(words, kind, fill))
    share = len(lights) ** -0.5 if lights else 0
    scene.lights = [(position, colour or (share, share, share)) for position, colour in lights]
    return scene
