"""The pictures that the program writes: formats, colours, regions, alpha, metadata, statistics."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exr import read_exr
from PIL import Image
from spheres import write_spheres


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_spheres(tmp_path / "spheres.nff")


def encode_srgb(linear: Any) -> Any:
    linear = np.clip(np.asarray(linear, np.float64), 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def test_a_render_says_what_it_took(cli: Any, scene: Path) -> None:
    result = cli("render", scene, "-o", "a.exr")
    assert result.returncode == 0
    assert result.stdout == ""
    for text in ["rays", "reflection", "Mrays/s", "seconds", "deepest level", "features", "a.exr"]:
        assert text in result.stderr
    assert "\033" not in result.stderr
    assert "\r" not in result.stderr
    assert cli("render", scene, "-o", "a.exr", "--quiet").stderr == ""


STATS_KEYS = {
    "rays": {"eye", "eye_hits", "reflection", "transmission", "shadow"},
    "seconds": {"load", "tree", "compile", "trace", "kernel", "write", "total"},
    "discarded_weight": {"max", "mean"},
}


def test_stats(cli: Any, tmp_path: Path, scene: Path) -> None:
    options = [
        "--size",
        "40x30",
        "--samples",
        "4",
        "--jitter",
        "0.5",
        "--depth",
        "3",
        "--cutoff",
        "0.01",
        "--region",
        "8,4,24,20",
        "--work-group",
        "4x2",
    ]
    result = cli("render", scene, "-o", "a.exr", "--stats", "a.json", "--quiet", *options)
    assert result.returncode == 0, result.stderr
    stats = json.loads((tmp_path / "a.json").read_text())
    assert set(stats) == {
        *STATS_KEYS,
        "device",
        "work_group",
        "work_group_from",
        "pixels",
        "level",
        "features",
        "options",
        "size",
        "samples",
        "version",
        "deepest_level",
        "lanes",
        "depth",
        "cutoff",
        "jitter",
        "truncation_bound",
        "region",
    }
    for key, inner in STATS_KEYS.items():
        assert set(stats[key]) == inner
    assert stats["size"] == [40, 30]
    assert stats["region"] == [8, 4, 24, 20]
    assert stats["work_group"] == [4, 2]
    assert stats["work_group_from"] == "given"
    assert stats["samples"] == 4
    assert stats["jitter"] == 0.5
    assert stats["depth"] == 3
    assert stats["cutoff"] == 0.01
    assert stats["level"] == "standard"
    assert 1 <= stats["deepest_level"] <= 3
    assert stats["rays"]["eye"] == 16 * 16 * 4
    assert 0 < stats["rays"]["eye_hits"] <= stats["rays"]["eye"]
    assert stats["seconds"]["write"] > 0
    seconds = stats["seconds"]
    assert seconds["total"] >= seconds["trace"] >= seconds["kernel"] > 0
    assert stats["truncation_bound"] == "unbounded" or stats["truncation_bound"] >= 0


def test_region_is_the_same_part_of_the_whole(cli: Any, tmp_path: Path, scene: Path) -> None:
    assert cli("render", scene, "-o", "whole.exr", "--quiet").returncode == 0
    assert cli("render", scene, "-o", "part.exr", "--quiet", "--region=20,10,44,37").returncode == 0
    whole, whole_header = read_exr(tmp_path / "whole.exr")
    part, header = read_exr(tmp_path / "part.exr")
    assert whole_header["dataWindow"] == whole_header["displayWindow"] == (0, 0, 63, 47)
    assert header["dataWindow"] == (20, 10, 43, 36)
    assert header["displayWindow"] == (0, 0, 63, 47)
    assert whole.shape == (48, 64, 3)
    assert part.shape == (27, 24, 3)
    np.testing.assert_array_equal(part, whole[10:37, 20:44])
    assert np.ptp(part) > 0


def test_alpha(cli: Any, tmp_path: Path, scene: Path) -> None:
    for name in ["a.exr", "a.png", "a.tif"]:
        assert cli("render", scene, "-o", name, "--alpha", "--samples", "4", "--quiet").returncode == 0
    pixels, _ = read_exr(tmp_path / "a.exr")
    assert pixels.shape == (48, 64, 4)
    alpha = pixels[..., 3:].astype(np.float64)
    assert alpha.min() == 0
    assert alpha.max() == 1
    assert ((alpha > 0) & (alpha < 1)).any()
    assert (pixels[..., :3][alpha[..., 0] == 0] == 0).all()
    # Whole-number formats keep colours that are not multiplied by alpha.
    colour = np.divide(pixels[..., :3], alpha, out=np.zeros(pixels[..., :3].shape), where=alpha > 0)
    expected = np.floor(np.concatenate([encode_srgb(colour), alpha], axis=2) * 255 + 0.5)
    for name in ["a.png", "a.tif"]:
        with Image.open(tmp_path / name) as picture:
            assert picture.mode == "RGBA"
            np.testing.assert_array_equal(np.array(picture), expected)


def test_formats_keep_the_same_picture(cli: Any, tmp_path: Path, scene: Path) -> None:
    for name in ["a.exr", "a.png", "a.tif", "a.TIFF", "a.jpg", "a.hdr"]:
        result = cli("render", scene, "-o", name, "--quiet")
        assert result.returncode == 0, (name, result.stderr)
    linear, _ = read_exr(tmp_path / "a.exr")
    expected = np.floor(encode_srgb(linear) * 255 + 0.5)
    for name in ["a.png", "a.tif", "a.TIFF"]:
        np.testing.assert_array_equal(np.array(Image.open(tmp_path / name)), expected)
    assert np.abs(np.array(Image.open(tmp_path / "a.jpg")).astype(int) - expected).mean() < 3
    header = (tmp_path / "a.hdr").read_bytes()
    assert header.startswith(b"#?RADIANCE\n")
    assert b"FORMAT=32-bit_rle_rgbe\n" in header
    assert b"-Y 48 +X 64\n" in header


def test_sixteen_bits(cli: Any, tmp_path: Path, scene: Path) -> None:
    assert cli("render", scene, "-o", "a8.png", "--quiet").returncode == 0
    assert cli("render", scene, "-o", "a16.png", "--bits=16", "--quiet").returncode == 0
    assert cli("render", scene, "-o", "a16.tif", "--bits=16", "--quiet").returncode == 0
    assert struct.unpack_from(">B", (tmp_path / "a16.png").read_bytes(), 24) == (16,)
    eight, sixteen = (np.array(Image.open(tmp_path / name)).astype(int) for name in ["a8.png", "a16.png"])
    assert np.abs(eight - sixteen).max() <= 1


def test_metadata(cli: Any, tmp_path: Path, scene: Path) -> None:
    for name in ["a.exr", "a.png", "a.jpg", "a.hdr", "a.tif"]:
        assert cli("render", scene, "-o", name, "--quiet").returncode == 0
    _, header = read_exr(tmp_path / "a.exr")
    for key in ["scene", "settings", "device", "version", "rays", "seconds"]:
        assert header[f"feeler:{key}"]
    assert header["feeler:scene"] == "spheres"
    assert "feeler:interrupted" not in header
    with Image.open(tmp_path / "a.png") as picture:
        text = picture.text["Description"]
    assert "scene: spheres" in text
    assert "samples 1" in text
    assert "eye 3072" in text
    for name in ["a.jpg", "a.hdr", "a.tif"]:
        data = (tmp_path / name).read_bytes()
        assert b"scene: spheres" in data
        assert b"eye 3072" in data


def test_discarded_weight_shrinks_with_depth(cli: Any, tmp_path: Path, scene: Path) -> None:
    discarded = []
    for depth in [1, 2, 3, 20]:
        assert cli("render", scene, "-o", "a.exr", "--depth", depth, "--stats", "a.json", "-q").returncode == 0
        discarded.append(json.loads((tmp_path / "a.json").read_text())["discarded_weight"]["max"])
    assert discarded[0] > discarded[1] > discarded[2] > discarded[3] == 0


def test_stats_to_stdout(cli: Any, scene: Path) -> None:
    result = cli("render", scene, "-o", "a.exr", "--size", "8x6", "--stats", "-", "-q")
    assert result.returncode == 0 and not result.stderr
    assert json.loads(result.stdout)["size"] == [8, 6]
