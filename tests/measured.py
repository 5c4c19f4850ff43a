"""Results of `feeler chart` that nobody measured."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from feeler import accuracy, specialisation
from feeler.accuracy import Difference, Point, Setting


def make_point(factor: str, times: Any, error: float, method: str = "", **setting: Any) -> Point:
    """Made up: of the error half is precision's."""
    chosen = {"level": "standard", "samples": 16, "depth": 5, "cutoff": 0.01, **setting}
    parts = [Difference(e, 3 * e, 0.01 * (e > 0), e / 3) for e in (error, error / 2, 0.0, error / 4)]
    return Point(Setting(factor, method=method, **chosen), False, tuple(times), 1.5, *parts)


def made_up() -> accuracy.Accuracy:
    """The default takes 20 ms and is on the front; a method of the same error is slower."""
    points = [
        replace(make_point("level", (0.020, 0.019, 0.024), 4e-3), default=True),
        make_point("level", (0.002, 0.0021, 0.0019), 3e-2, samples=1),
        make_point("level", (0.0019, 0.0018, 0.0019), 3.1e-2, samples=1, level="draft"),
        make_point("level", (0.06, 0.061, 0.07), 3.9e-3, level="reference"),
        make_point("depth", (0.015, 0.014, 0.0151), 2e-2, depth=2),
        make_point("cutoff", (0.021, 0.022, 0.023), 4.1e-3, cutoff=0.1),
        make_point("method", (0.1, 0.11, 0.12), 4e-3, method="brute force"),
        make_point("method", (0.022, 0.023, 0.021), 4e-3, method="general"),
    ]
    truth = accuracy.Truth((121, 144), 5, 0.01 / 16, 1e-3, 1e-5)
    return accuracy.Accuracy("balls", "a device", "0.1.0", (64, 48), truth, tuple(points), {"1 lane": "too slow"})


def pairs(scene: str, *seconds: tuple[float, float, float, float]) -> specialisation.Specialisation:
    """Each: trace and compilation, specialised, then general."""
    own = tuple(specialisation.Seconds(a, b) for a, b, _, _ in seconds)
    general = tuple(specialisation.Seconds(c, d) for _, _, c, d in seconds)
    return specialisation.Specialisation(scene, "a device", "0.1.0", (64, 48), 16, ("sphere",), own, general)


def made_up_pairs() -> list[specialisation.Specialisation]:
    return [
        pairs("balls", (0.010, 2, 0.020, 4), (0.011, 2, 0.020, 5), (0.010, 3, 0.040, 4)),
        pairs("glass", (0.2, 6, 0.19, 6.5)),
    ]
