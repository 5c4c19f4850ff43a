"""Channels beside the picture: closed forms for what the centre's ray shows, and sums against the statistics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exr import read_layers
from pictures import same_bits

import feeler

SIZE = (45, 31)
EYE, OFFSET = np.array([0.3, 0.6, 6.0]), np.array([4096.0, -512.0, 1024.0])


def ball_on_floor(offset: Any = (0, 0, 0), **keys: Any) -> dict[str, Any]:
    """A mirroring ball at the origin over a floor at y = -1, all of it moved by an offset."""
    return {
        "camera": {"eye": EYE + offset, "look_at": np.asarray(offset, float), "fov": 40},
        "image": {"size": list(SIZE), "samples": 4},
        "depth": 4,
        "lights": [{"point": np.array([3, 4, 5]) + offset}],
        "materials": {"floor": {"diffuse": 0.5}, "mirror": {"diffuse": 0.2, "reflection": [0.5, 0.25, 0.75]}},
        "objects": [
            {"plane": {"point": np.array([0, -1, 0]) + offset, "normal": [0, 1, 0]}, "material": "floor"},
            {"sphere": {"centre": np.array([0, 0, 0]) + offset, "radius": 1}, "material": "mirror"},
        ],
        **keys,
    }


def directions() -> Any:
    """Of the rays through the centres of ball_on_floor's pixels, float64."""
    width, height = SIZE
    forward = -EYE / np.linalg.norm(EYE)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    half = np.tan(np.radians(20)) / height
    x = (2 * np.arange(width) + 1 - width)[None, :, None] * half
    y = (height - 2 * np.arange(height) - 1)[:, None, None] * half
    d = forward + right * x + up * y
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def closed_forms() -> tuple[Any, Any, Any, Any]:
    """Depth, position, normal and object of each pixel."""
    d = directions()
    b = -(d @ EYE)
    apart = EYE @ EYE - b * b
    ball = apart < 1
    floor = ~ball & (d[..., 1] < 0)
    with np.errstate(divide="ignore"):
        depth = np.where(
            ball, b - np.sqrt(np.maximum(1 - apart, 0)), np.where(floor, (-1 - EYE[1]) / d[..., 1], np.inf)
        )
    position = np.where((ball | floor)[..., None], EYE + d * np.where(np.isinf(depth), 0, depth)[..., None], 0)
    normal = np.where(ball[..., None], position, np.where(floor[..., None], [0.0, 1.0, 0.0], 0))
    return depth, position, normal, np.where(ball, 1, np.where(floor, 0, -1))


@pytest.mark.parametrize("offset", [np.zeros(3), OFFSET], ids=["at 0", "far from 0"])
def test_the_centre_of_a_pixel(offset: Any) -> None:
    image = feeler.Scene(ball_on_floor(offset)).render(channels=["depth", "position", "normal", "object", "material"])
    depth, position, normal, number = closed_forms()
    found = image.channels
    assert list(found) == ["depth", "position", "normal", "object", "material"]
    assert found["depth"].dtype == np.float32 and found["object"].dtype == np.int32
    assert np.array_equal(found["object"], number) and np.array_equal(found["material"], number)
    assert image.materials == ["floor", "mirror"]
    met = number >= 0
    assert np.isinf(found["depth"][~met]).all() and (found["normal"][~met] == 0).all()
    near = met & (depth < 30)
    assert abs(found["depth"][near] / depth[near] - 1).max() < 1e-5
    assert abs(found["position"] - np.where(met[..., None], position + offset, 0))[near].max() < 5e-4
    # Near the silhouette the normal goes round fast: there, the direction's rounding counts.
    assert abs(found["normal"] - normal)[met].max() < 2e-4


def test_sums_are_those_of_the_statistics() -> None:
    scene = feeler.Scene(ball_on_floor(depth=2))
    image = scene.render(channels="rays,deepest,discarded")
    rays, stats = image.stats["rays"], image.stats
    assert image.channels["rays"].sum() == rays["eye"] + rays["reflection"] + rays["transmission"] + rays["shadow"]
    assert image.channels["deepest"].max() == stats["deepest_level"] == 2
    discarded = image.channels["discarded"]
    assert discarded.shape == (SIZE[1], SIZE[0], 3) and discarded.max() == np.float32(stats["discarded_weight"]["max"])
    assert discarded.max(-1).mean(dtype=float) == pytest.approx(stats["discarded_weight"]["mean"], rel=1e-6)
    once = feeler.Scene(ball_on_floor(depth=1)).render(channels=["discarded", "object"])
    ball = np.lib.stride_tricks.sliding_window_view(
        once.channels["object"] == 1, (3, 3)
    )  # samples may be off the centre
    weight = once.channels["discarded"][1:-1, 1:-1]
    assert (weight[ball.all((2, 3))] == np.float32([0.5, 0.25, 0.75])).all() and ball.all((2, 3)).sum() > 50
    assert (weight[~ball.any((2, 3))] == 0).all()


def test_channels_change_nothing_and_nothing_changes_them() -> None:
    scene = feeler.Scene(ball_on_floor())
    whole = scene.render(channels="all")
    assert same_bits(whole.pixels, scene.render().pixels)
    assert scene.render().channels == {} and scene.render().materials == []
    part = scene.render(channels="all", region=(7, 5, 40, 22), tile=37, work_group=(4, 2), lanes=16)
    assert list(part.channels) == list(whole.channels) and len(whole.channels) == 9
    for name, plane in whole.channels.items():
        assert same_bits(part.channels[name], np.ascontiguousarray(plane[5:22, 7:40])), name


def test_ids_are_those_of_the_file() -> None:
    """A turned box is a mesh, a group's copies are instances of one another, and each has its place in the list."""
    scene = feeler.Scene({
        "camera": {"eye": [0, 0, 20], "look_at": [0, 0, 0], "fov": 4.3}, "image": {"size": [21, 3]},
        "materials": {"a": {}, "b": {}},
        "groups": {"pair": [{"sphere": {"centre": [0, 0, 0], "radius": 0.6}, "material": "b"},
                            {"sphere": {"centre": [0, 0, -3], "radius": 0.9}, "material": "a"}]},
        "objects": [
            {"instance": "pair", "transform": {"translate": [-3.5, 0, 0]}},
            {"box": {"low": [-0.7, -0.7, -0.7], "high": [0.7, 0.7, 0.7]}, "material": "b", "transform": {"rotate_z": 20}},
            {"instance": "pair", "material": "a", "transform": [{"scale": 0.8}, {"translate": [3.5, 0, 0]}]},
        ],
    })  # fmt: skip
    found = scene.render(channels=["object", "material"]).channels
    middle = list(found["object"][1])
    assert [middle[i] for i in (3, 10, 17)] == [0, 1, 2] and middle[0] == middle[20] == -1
    assert sorted(set(middle)) == [-1, 0, 1, 2]
    assert [found["material"][1][i] for i in (3, 10, 17)] == [1, 1, 0]


def test_interrupted() -> None:
    calls: list[float] = []
    image = feeler.Scene(ball_on_floor()).render(
        channels=["depth", "object", "rays"], tile=200, progress=lambda done: calls.append(done) or len(calls) > 2
    )
    assert image.interrupted
    undone = image.channels["rays"] == 0
    assert 0 < undone.sum() < undone.size
    assert (image.channels["object"][undone] == -1).all() and np.isinf(image.channels["depth"][undone]).all()


def test_build_options_of_any_length(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a user adds drops none of those that the kernels need."""
    monkeypatch.setenv("FEELER_KERNEL_OPTIONS", " ".join(f"-DUNUSED_{i}" for i in range(500)))
    scene = feeler.Scene({"camera": {"eye": [0, 0, 4], "look_at": [0, 0, 0]}, "image": {"size": [3, 3]}, "objects": [
        {"plane": {"normal": [0, 0, 1]}}]})  # fmt: skip
    assert scene.render(channels=["depth"]).channels["depth"][1, 1] == 4


# ---- files


def test_layers_of_a_file(cli: Any, tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(
        "image: {size: [20, 10]}\ncamera: {eye: [0, 0, 5], look_at: [0, 0, 0]}\nmaterials: {red: {diffuse: 1}}\n"
        "objects:\n  - {sphere: {centre: [0, 0, 0], radius: 1}, material: red}\n"
    )
    assert cli("render", "a.yaml", "-o", "a.exr", "--channels", "all", "--region", "4,2,17,9", "-q").returncode == 0
    layers, header = read_layers(tmp_path / "a.exr")
    image = feeler.load(tmp_path / "a.yaml").render(channels="all", region=(4, 2, 17, 9))
    names = {"depth": ["Z"], "position": ["P.X", "P.Y", "P.Z"], "normal": ["N.X", "N.Y", "N.Z"],
             "discarded": ["discarded.R", "discarded.G", "discarded.B"]}  # fmt: skip
    count = 3
    for name, plane in image.channels.items():
        for i, layer in enumerate(names.get(name, [name])):
            one = np.ascontiguousarray(plane[..., i] if plane.ndim == 3 else plane)
            assert layers[layer].tobytes() == one.tobytes(), layer
            assert layers[layer].dtype == (np.uint32 if plane.dtype == np.int32 else np.float32), layer
            count += 1
    assert len(layers) == count and header["feeler:materials"] == "0 red"
    assert np.stack([layers[c] for c in "RGB"], -1).tobytes() == image.pixels[..., :3].tobytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "a.png", "--channels", "depth"], "a.png: .png files keep no channels beside the picture; use .exr"),
        (["-o", "a.exr", "--channels", "depth,marginn"], "unknown channel 'marginn' (did you mean 'margin'?)"),
        (["-o", "a.exr", "--channels", "depth,"], "unknown channel ''"),
    ],
)
def test_what_cannot_be(cli: Any, scenes: Path, tmp_path: Path, arguments: list[str], message: str) -> None:
    result = cli("render", scenes / "first.yaml", *arguments)
    assert result.returncode == 2 and message in result.stderr
    assert result.stderr.count("\n") <= 2 and not list(tmp_path.iterdir())


def test_unknown_channel_in_python() -> None:
    with pytest.raises(feeler.Error, match="did you mean 'depth'"):
        feeler.Scene(ball_on_floor()).render(channels=["dept"])
    for wrong in (5, ["depth", 5]):
        with pytest.raises(feeler.Error, match="channels is a name or several, not"):
            feeler.Scene(ball_on_floor()).render(channels=wrong)
