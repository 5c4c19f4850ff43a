"""Scenes that several tests share, and what compares their pictures."""

from __future__ import annotations

from typing import Any

import numpy as np

import feeler


def same_bits(a: Any, b: Any) -> bool:
    return bool(a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes())


def everything(scale: float = 1.0) -> dict[str, Any]:
    """Every primitive, light, term and extension but filtered shadows, all lengths times `scale`."""

    def at(*xyz: float) -> list[float]:
        return [scale * x for x in xyz]

    glass = {"transmission": [0.9, 0.8, 0.7], "reflection": 0.1, "specular": 0.5, "shininess": 40, "ior": 1.5}
    turn = np.linspace(0, 2 * np.pi, 8)[:7]
    return {
        "camera": {"eye": at(0.4, 2.2, 7), "look_at": at(0, 0.6, 0), "fov": 42},
        "image": {"size": [48, 36]},
        "background": [0.2, 0.3, 0.5],
        "ambient": 0.1,
        "depth": 6,
        "cutoff": 0.02,
        "lights": [{"point": at(4, 6, 5), "ambient": 0.1}, {"directional": [1, -2, -0.5], "colour": [0.4, 0.3, 0.3]}],
        "materials": {
            "glass": glass,
            "weighted": {**glass, "fresnel": True, "reflection": 1, "ior": 1.33, "priority": 2},
            "total": {**glass, "total_reflection": True, "ior": 1.7},
            "mirror": {"reflection": 0.8, "diffuse": 0.1, "specular": 0.8, "shininess": 200},
            "shade": {"diffuse": 0.3, "diffuse_transmission": [0.6, 0.5, 0.2], "specular_transmission": 0.3, "ior": 1.1},
            "matte": {"ambient": 1, "diffuse": [0.7, 0.5, 0.3]},
            "lamp": {"emission": [0.9, 0.7, 0.2]},
        },
        "objects": [
            {"plane": {"normal": [0, 1, 0], "point": at(0, -0.5, 0)}, "material": "matte"},
            {"sphere": {"centre": at(0, 0.6, 1), "radius": scale * 0.8}, "material": "glass"},
            {"sphere": {"centre": at(0.2, 0.6, 1), "radius": scale * 0.4}, "material": "weighted"},
            {"sphere": {"centre": at(-1.6, 0.4, 0), "radius": scale * 0.7}, "material": "mirror"},
            {"box": {"low": at(1, -0.5, -1), "high": at(2, 0.8, 0.4)}, "material": "total"},
            {"disc": {"centre": at(-0.5, 2, -1), "normal": [0.3, -1, 0.5], "radius": scale}, "material": "shade"},
            {"cylinder": {"base": at(-2.4, -0.5, 1.3), "top": at(-2.1, 0.7, 1.5), "radius": scale * 0.3}, "material": "glass"},
            {"cone": {"base": at(1.9, -0.5, 1.6), "top": at(1.9, 0.6, 1.6), "base_radius": scale * 0.5}, "material": "matte"},
            {"cone": {"base": at(0, 1.4, -1.5), "top": at(0, 2.4, -1.5), "base_radius": scale * 0.6, "top_radius": scale * 0.4,
                      "capped": False}, "material": "shade", "sides": "back"},
            {"polygon": {"corners": [at(2.2 + (0.3 + 0.3 * (i % 2)) * np.cos(t), 1.6 + 0.5 * np.sin(t), -0.5)
                                     for i, t in enumerate(turn)]}, "material": "lamp"},
            {"triangle": {"corners": [at(-3, 0, -2), at(-1, 0, -2.2), at(-2, 2, -2)],
                          "normals": [[-1, 0, 2], [1, 0, 2], [0, 1, 1.5]]}, "material": "mirror"},
            {"mesh": {"vertices": [at(0.6, -0.4, 2.2), at(1.2, -0.4, 2), at(0.8, -0.4, 2.7), at(0.9, 0.3, 2.3)],
                      "triangles": [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]}, "material": "glass"},
            {"sphere": {"centre": at(-0.6, -0.3, 2.5), "radius": scale * 0.2}, "material": "glass"},
            {"sphere": {"centre": at(-0.2, -0.3, 2.5), "radius": scale * 0.2}, "material": "weighted"},
        ],
    }  # fmt: skip


def render(scene: dict[str, Any], level: str = "standard", **settings: Any) -> feeler.Image:
    """Renders by the kernel of `everything`, so that tests share one: far behind the picture is a small copy of it, and
    a plane that cannot be seen from above. A scene says `depth` (4 < depth <= 8) unless it is 5.
    """
    speck = everything(1e-6)
    for item in speck["objects"]:
        item["transform"] = {"translate": [137, 211, 1e3]}
    speck["objects"][0] = {"plane": {"normal": [0, 1, 0], "point": [0, -1e3, 0]}, "material": "matte", "sides": "back"}
    materials = {**speck["materials"], **scene.get("materials", {})}
    whole = {
        "lights": [{"point": [0, 0, 5e3]}],
        **scene,
        "materials": materials,
        "objects": [*scene["objects"], *speck["objects"]],
    }
    return feeler.Scene(whole).render(level=level, **{"lanes": 1, **settings})
