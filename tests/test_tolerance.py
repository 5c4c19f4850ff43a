"""Renders that know their error: `verify` measures it, `tolerance` finds the settings that keep it small."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler

# Mirrors and edges, and no light: few kernels to compile.
SCENE: dict[str, Any] = {
    "camera": {"eye": [0, 0.4, 6], "look_at": [0, 0, 0], "fov": 40},
    "background": [0.1, 0.2, 0.4],
    "depth": 4,
    "materials": {"lamp": {"emission": [0.9, 0.6, 0.2]}, "mirror": {"emission": 0.1, "reflection": 0.3}},
    "objects": [
        {"sphere": {"centre": [-1, 0, 0], "radius": 1}, "material": "mirror"},
        {"sphere": {"centre": [1.2, 0, 0.2], "radius": 0.9}, "material": "lamp"},
        {"sphere": {"centre": [0.2, 1.2, -0.4], "radius": 0.7}, "material": "mirror"},
    ],
}


def halves() -> dict[str, Any]:
    """Two triangles whose border goes through the middles of a square picture's pixels, from corner to corner."""
    eye, aim, up = np.array([1.3, 2.1, 4.7]), np.array([0.2, -0.1, 0.3]), np.array([0.3, 1, 0.2])
    forward = (aim - eye) / np.linalg.norm(aim - eye)
    right = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
    a, b = right + np.cross(right, forward), right - np.cross(right, forward)
    return {
        "camera": {"eye": eye, "look_at": aim, "up": up, "fov": 37},
        "materials": {"lamp": {"emission": 0.8}, "mirror": {"emission": 0.3, "reflection": 0.5}},
        "objects": [
            {"triangle": {"corners": np.array([aim - 2 * a, aim + 2 * b, aim + 2 * a])}, "material": "lamp"},
            {"triangle": {"corners": np.array([aim - 2 * a, aim + 2 * a, aim - 2 * b])}, "material": "mirror"},
        ],
    }


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    return feeler.Scene(SCENE)


@pytest.fixture(scope="module")
def truth(scene: feeler.Scene) -> Any:
    """Pictures with samples of their own, of any size."""
    return {size: scene.render(size=size, level="reference", samples=400) for size in [(60, 40), (192, 128)]}


# ---- verify


def test_verify_tells_flips_from_values() -> None:
    scene = feeler.Scene(halves())
    found = scene.verify(size=(64, 64), depth=2)
    image, precision = found.image, found.precision
    assert precision == feeler.compare(image, found.reference)
    assert found.reference.pixels.dtype == np.float64 and image.pixels.dtype == np.float32
    apart = np.abs(image.pixels - found.reference.pixels)[..., :3].max(axis=2)
    assert 0 < precision.flips == (apart > 1 / 255).sum() <= 64
    assert set(zip(*np.nonzero(apart > 1 / 255), strict=True)) <= {(i, 63 - i) for i in range(64)}
    assert 0 < precision.value_max < 1e-6 < precision.max == pytest.approx(0.5)
    told = image.stats["verification"]
    assert told["precision"]["flips"] == precision.flips and told["precision"]["max"] == pytest.approx(precision.max)
    assert told["precision"]["values"]["p99.9"] == pytest.approx(precision.value_p999)
    assert told["samples"] == 1 and told["against"] == "reference"
    assert found.truncation_bound == told["truncation_bound"] == image.stats["truncation_bound"]


def test_verify_keeps_what_was_asked(scene: feeler.Scene) -> None:
    asked: dict[str, Any] = {
        "size": (40, 30),
        "samples": 4,
        "jitter": 0.5,
        "depth": 2,
        "cutoff": 0.01,
        "region": (4, 6, 30, 20),
    }
    found = scene.verify(**asked)
    assert found.precision.pixels == 26 * 14
    assert np.array_equal(found.reference.pixels, scene.render(**asked, level="reference").pixels)
    assert 0 < found.truncation_bound < 1  # 0.3² of what mirrors show
    assert found.precision.max < found.truncation_bound


def test_verify_needs_another_level(scene: feeler.Scene) -> None:
    with pytest.raises(feeler.Error, match="level reference"):
        scene.verify(size=(8, 6), level="reference")
    with pytest.raises(feeler.Error, match="tolerance"):
        scene.verify(size=(8, 6), tolerance=0.1)


def test_verify_on_the_command_line(cli: Any, tmp_path: Path) -> None:
    spheres = tmp_path / "spheres.yaml"
    spheres.write_text(json.dumps({**SCENE, "image": {"size": [40, 30], "samples": 4}}))
    plain = cli("render", spheres, "-o", "a.exr", "-q")
    result = cli("render", spheres, "-o", "b.exr", "--verify", "--stats", "b.json")
    assert plain.returncode == result.returncode == 0
    told = json.loads((tmp_path / "b.json").read_text())["verification"]
    assert f"max {told['precision']['max']:.3g}" in result.stderr
    assert "truncation is apart; error by truncation" in result.stderr
    assert feeler.compare(tmp_path / "a.exr", tmp_path / "b.exr").max == 0
    assert "against reference, 4 samples a pixel, " in result.stderr
    result = cli("render", spheres, "-o", "b.exr", "--verify", "--samples", "1")
    assert "against reference, 1 sample a pixel, " in result.stderr
    for options, message in [
        (["--level", "reference"], "choose draft or standard"),
        (["--tolerance", "0.1"], "leave --verify away"),
    ]:
        result = cli("render", spheres, "-o", "a.exr", "--verify", *options)
        assert result.returncode == 2 and message in result.stderr


# ---- tolerance


def error_of(image: feeler.Image, truth: feeler.Image) -> float:
    return feeler.compare(image, truth).p999


@pytest.mark.parametrize(("size", "tolerance"), [((60, 40), 0.1), ((192, 128), 0.1), ((192, 128), 0.03)])
def test_the_error_is_below_the_tolerance(
    scene: feeler.Scene, truth: dict[Any, feeler.Image], size: tuple[int, int], tolerance: float
) -> None:
    image = scene.render(size=size, tolerance=tolerance)
    told = image.stats["tolerance"]
    chosen = told["chosen"]
    assert told["reached"] and told["error"] <= 0.8 * tolerance
    assert told["checked"]["whole"] == (size == (60, 40))
    assert error_of(image, truth[size]) < tolerance
    # It is the cheapest: half of the samples would not do.
    assert 1 < chosen["samples"] < 256
    fewer = scene.render(size=size, samples=chosen["samples"] // 2)
    assert error_of(fewer, truth[size]) > 0.8 * tolerance
    # Weights are spared, and so time, where they are small.
    assert chosen["cutoff"] == image.stats["cutoff"] and image.stats["samples"] == chosen["samples"]
    again = scene.render(size=size, samples=chosen["samples"], level=chosen["level"], cutoff=chosen["cutoff"])
    assert np.array_equal(again.pixels, image.pixels)
    assert any(one["error"] == told["error"] for one in told["candidates"])


def test_what_is_told_of_the_truth_is_so(scene: feeler.Scene, truth: dict[Any, feeler.Image]) -> None:
    told = scene.render(size=(60, 40), tolerance=0.05).stats["tolerance"]
    assert 0 < told["truth"]["noise"] <= 0.05 / 3
    # The error that was measured is the error against another truth, but for what both are off by.
    chosen = told["chosen"]
    image = scene.render(size=(60, 40), samples=chosen["samples"], level=chosen["level"], cutoff=chosen["cutoff"])
    assert told["error"] == pytest.approx(error_of(image, truth[60, 40]), abs=2 * told["truth"]["noise"])


def test_a_flat_picture_is_cheap() -> None:
    scene = feeler.Scene({"background": [0.3, 0.6, 0.9], "objects": [], "camera": {"eye": [0, 0, 5]}})
    image = scene.render(size=(200, 150), tolerance=1e-3)
    assert image.stats["samples"] == 1 and image.stats["level"] != "reference"
    assert image.stats["tolerance"]["error"] < 1e-6


def test_what_cannot_be_reached_is_said(cli: Any, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(json.dumps(SCENE))
    result = cli("render", "scene.yaml", "-o", "a.exr", "--size", "24x16", "--tolerance", "1e-5", "--stats", "a.json")
    told = json.loads((tmp_path / "a.json").read_text())["tolerance"]
    assert result.returncode == 1
    assert not told["reached"] and told["error"] > 1e-5
    assert told["truth"]["noise"] > 1e-5 and "known of the truth" in told["why"]
    assert f"a.exr: the tolerance of 1e-05 is not reached: the error is {told['error']:.3g}" in result.stderr
    assert "NOT reached" in result.stderr
    best = feeler.load(tmp_path / "scene.yaml").render(size=(24, 16), level="reference", samples=400)
    assert error_of_file(tmp_path / "a.exr", best) == pytest.approx(told["error"], rel=0.5)


def error_of_file(path: Path, truth: feeler.Image) -> float:
    return feeler.compare(path, truth).p999


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"samples": 1, "level": "draft"}, "sampling with 1 sample a pixel leaves an error of"),
        ({"samples": 4, "level": "standard"}, "sampling with 4 samples a pixel leaves an error of"),
        ({"samples": 64, "depth": 1}, "depth"),
    ],
)
def test_what_is_given_is_kept(
    scene: feeler.Scene, truth: dict[Any, feeler.Image], given: dict[str, Any], why: str
) -> None:
    image = scene.render(size=(60, 40), tolerance=0.02, **given)
    told = image.stats["tolerance"]
    for name, value in given.items():
        assert image.stats[name] == told["chosen"][name] == value
    assert not told["reached"] and why in told["why"]
    assert told["error"] == pytest.approx(error_of(image, truth[60, 40]), rel=0.3)


def test_what_is_given_may_just_do(scene: feeler.Scene) -> None:
    """Below the tolerance is below, if only just; the fifth to spare is for choosing."""
    error = scene.render(size=(60, 40), samples=4, tolerance=1).stats["tolerance"]["error"]
    told = scene.render(size=(60, 40), samples=4, level="standard", cutoff=0, tolerance=1.1 * error).stats["tolerance"]
    assert told["reached"] and told["error"] == pytest.approx(error, rel=0.05)
    assert "without a fifth to spare" in told["why"]


def test_cutoffs_that_spare_no_ray_are_no_candidates() -> None:
    """Weights of 0.5 alone, and tolerances below: the same picture would be chosen by chance."""
    image = feeler.Scene(halves() | {"lights": [], "depth": 2}).render(size=(60, 40), tolerance=0.1)
    assert image.stats["rays"]["reflection"] > 0
    assert {one["cutoff"] for one in image.stats["tolerance"]["candidates"]} == {image.stats["cutoff"]}


def test_what_depth_leaves_out_is_told(cli: Any, tmp_path: Path) -> None:
    """Two mirrors that shine: E ρ³ / (1 − ρ) is missing in the truth as well."""
    mirrors = [{"plane": {"point": [0, 0, z], "normal": [0, 0, 1]}, "material": "m"} for z in (-1, 1)]
    scene = {
        "camera": {"eye": [0, 0, 0], "look_at": [0, 0, -1]},
        "materials": {"m": {"emission": 0.01, "reflection": 0.9}},
        "objects": mirrors,
        "depth": 3,
    }
    (tmp_path / "scene.yaml").write_text(json.dumps(scene))
    result = cli("render", "scene.yaml", "-o", "a.exr", "--size", "16x16", "--tolerance", "0.001")
    assert result.returncode == 0, result.stderr
    assert "tolerance 0.001 reached" in result.stderr
    assert (
        "truncation is apart, for the truth has depth 3 and cutoff 0; error by truncation at most 0.0729\n"
        in result.stderr
    )


def test_a_region_has_its_own_error(scene: feeler.Scene, truth: dict[Any, feeler.Image]) -> None:
    image = scene.render(size=(192, 128), region=(100, 30, 180, 110), tolerance=0.1)
    assert image.pixels.shape == (80, 80, 4)
    part = truth[192, 128].pixels[30:110, 100:180]
    assert feeler.compare(image, part).p999 < 0.1


@pytest.mark.parametrize("tolerance", [0, -1, 1.5, float("nan"), "small", None])
def test_bad_tolerances(scene: feeler.Scene, cli: Any, tolerance: Any) -> None:
    if tolerance is None:
        result = cli("render", "a.yaml", "-o", "a.png", "--tolerance", "0")
        assert result.returncode == 2 and "--tolerance: '0'" in result.stderr
        return
    with pytest.raises(feeler.Error, match="tolerance"):
        scene.render(size=(8, 6), tolerance=tolerance)


@pytest.mark.parametrize("last", [1, 2, 3, 9, None])
def test_a_search_can_be_stopped(scene: feeler.Scene, last: int | None) -> None:
    """At any call: the last one of the search is that before the picture's own, whose first is 0 as well."""
    settings: dict[str, Any] = {"size": (60, 40), "tolerance": 0.1, "level": "standard", "cutoff": 0, "tile": 4096}
    calls: list[float] = []
    if last is None:
        scene.render(**settings, progress=calls.append)
        last = calls.count(0) - 1
        calls.clear()

    def stop(fraction: float) -> bool:
        calls.append(fraction)
        return len(calls) == last

    with pytest.raises(feeler.Error) as caught:
        scene.render(**settings, progress=stop)
    assert caught.value.kind == "interrupted" and calls == [0] * last


def test_what_stops_a_search_or_a_verification_is_raised(scene: feeler.Scene) -> None:
    def interrupt(fraction: float) -> None:
        if fraction == 1:
            return
        calls.append(fraction)
        if len(calls) == 2:
            raise KeyboardInterrupt

    calls: list[float] = []
    with pytest.raises(KeyboardInterrupt) as caught:
        scene.render(size=(60, 40), tolerance=0.1, progress=interrupt)
    assert caught.value.image is None  # type: ignore[attr-defined]
    # A picture of one tile is done when it is told so: the second call is the reference's first.
    calls.clear()
    with pytest.raises(KeyboardInterrupt):
        scene.verify(size=(16, 12), samples=4, progress=interrupt)
    assert calls == [0, 0]
