"""How far two pictures are apart: figures, FLIP, the difference picture, `feeler compare`."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exr import read_exr, write_layers
from PIL import Image
from spheres import write_spheres

import feeler


def decode_srgb(coded: Any) -> Any:
    return np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def noisy_pair(seed: int, shape: tuple[int, ...] = (37, 53, 3)) -> tuple[Any, Any]:
    """Two pictures: small differences everywhere, large ones here and there, values beyond 0 and 1."""
    random = np.random.default_rng(seed)
    a = random.uniform(-0.2, 1.3, shape)
    b = a + random.normal(0, 1e-3, shape)
    flips = random.random(shape[:2]) < 0.03
    b[flips] = random.random((flips.sum(), shape[2]))
    return a, b


# ---- figures


@pytest.mark.parametrize("seed", range(4))
def test_figures_are_numpys(seed: int) -> None:
    a, b = noisy_pair(seed)
    found = feeler.compare(a, b)
    apart = np.abs(np.clip(a, 0, 1) - np.clip(b, 0, 1))
    greatest = apart.max(axis=2)
    flips = greatest > 1 / 255
    assert found.pixels == flips.size and found.nonfinite == 0
    assert 0 < found.flips == flips.sum() < flips.size / 10
    expected = {
        "max": greatest.max(),
        "p999": np.percentile(greatest, 99.9),
        "rmse": np.sqrt((apart**2).mean()),
        "share": flips.mean(),
        "value_max": greatest[~flips].max(),
        "value_p999": np.percentile(greatest[~flips], 99.9),
        "value_rmse": np.sqrt((apart[~flips] ** 2).mean()),
    }
    for name, value in expected.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-12), name
    np.testing.assert_array_equal(found.difference.pixels[..., :3], apart)


def test_equal_pictures_do_not_differ() -> None:
    a, _ = noisy_pair(0)
    found = feeler.compare(a, a)
    assert (found.max, found.p999, found.rmse, found.flip, found.flips, found.value_max) == (0, 0, 0, 0, 0, 0)


def test_all_pixels_may_be_flips() -> None:
    found = feeler.compare(np.zeros((5, 4, 3)), np.ones((5, 4, 3)))
    assert found.flips == 20 and found.share == found.max == found.p999 == found.rmse == 1
    assert found.value_max == found.value_p999 == found.value_rmse == 0


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_as_wrong_as_can_be(wrong: float) -> None:
    a = np.full((20, 20, 3), 0.5)
    b = a.copy()
    b[3, 4, 1] = wrong
    for found in [feeler.compare(a, b), feeler.compare(b, a), feeler.compare(b, b)]:
        assert found.nonfinite == 1 and found.flips == 1 and found.max == 1
        assert found.rmse == pytest.approx(np.sqrt(1 / 400))
        assert found.flip_map.pixels[3, 4, 0] == 1
        assert np.isfinite(found.flip_map.pixels).all() and np.isfinite(found.difference.pixels).all()


def test_kinds_of_pictures(tmp_path: Path) -> None:
    a, b = noisy_pair(5)
    a, b = a.astype(np.float32), b.astype(np.float32)
    found = feeler.compare(a, b)
    alpha = np.concatenate([a, np.full((*a.shape[:2], 1), 0.3)], axis=2)
    assert feeler.compare(alpha, b) == found  # colours alone count
    assert feeler.compare(a.tolist(), b) == found
    grey = feeler.compare(a[..., 0], b[..., 0])
    assert grey == feeler.compare(a[..., [0, 0, 0]], b[..., [0, 0, 0]])
    picture = found.difference
    picture.save(tmp_path / "a.exr")
    assert feeler.compare(tmp_path / "a.exr", picture.pixels.astype(np.float32)).max == 0
    with pytest.raises(feeler.Error, match="not rendered"):
        _ = picture.stats


@pytest.mark.parametrize(
    ("a", "b", "message"),
    [
        (np.zeros((4, 5, 3)), np.zeros((5, 4, 3)), "5 x 4 and 4 x 5"),
        (np.zeros((4, 5, 2)), np.zeros((4, 5, 2)), "2 channels"),
        (np.zeros(4), np.zeros(4), "height, width"),
        (np.zeros((0, 4, 3)), np.zeros((0, 4, 3)), "height, width"),
        ("no.png", np.zeros((4, 5, 3)), "No such file"),
        ("a\0b.png", np.zeros((4, 5, 3)), "NUL"),
    ],
)
def test_bad_pictures(a: Any, b: Any, message: str) -> None:
    with pytest.raises(feeler.Error, match=message):
        feeler.compare(a, b)


# ---- FLIP


@pytest.mark.parametrize("shape", [(40, 60), (1, 1), (3, 50), (64, 9)])
@pytest.mark.parametrize("kind", ["noise", "edges", "colours"])
def test_flip_is_that_of_its_authors(shape: tuple[int, int], kind: str) -> None:
    flip = pytest.importorskip("flip_evaluator", reason="the package flip-evaluator is absent: FLIP is not compared")
    random = np.random.default_rng(7)
    a = random.random((*shape, 3)).astype(np.float32)
    b = np.clip(a + random.normal(0, 0.1, a.shape), 0, 1).astype(np.float32)
    if kind == "edges":
        a[:, : shape[1] // 2] = 0.1
        b = np.roll(a, 2, axis=1)
    if kind == "colours":
        a[:], b[:] = [0, 1, 0], [0, 0, 1]
    found = feeler.compare(b, a)
    expected, mean, _ = flip.evaluate(a, b, "LDR", inputsRGB=False, applyMagma=False)
    np.testing.assert_allclose(found.flip_map.pixels[..., 0], np.reshape(expected, shape), atol=2e-4)
    assert found.flip == pytest.approx(mean, abs=1e-4)
    assert found.flip > 0.1 or (kind == "edges" and shape[1] < 3)


def test_flip_has_its_closed_forms() -> None:
    """Flat colours are not blurred and have no features; green and blue are as far apart as colours can be."""
    flat = np.ones((12, 12, 3))
    assert feeler.compare(flat * [0, 1, 0], flat * [0, 0, 1]).flip == pytest.approx(1, abs=1e-9)
    grey, other = feeler.compare(flat * 0.2, flat * 0.21), feeler.compare(flat * 0.21, flat * 0.2)
    lightness = 116 * (0.21 ** (1 / 3) - 0.2 ** (1 / 3))
    # L*a*b* of the primaries, by their XYZ (Lindbloom), with Hunt's adjustment.
    green = np.array([87.7347, -86.1827 * 0.877347, 83.1793 * 0.877347])
    blue = np.array([32.2970, 79.1875 * 0.322970, -107.8602 * 0.322970])
    most = (abs(green[0] - blue[0]) + np.hypot(*(green - blue)[1:])) ** 0.7
    assert grey.flip == pytest.approx(other.flip, rel=1e-12)
    assert grey.flip == pytest.approx(0.95 * lightness**0.7 / (0.4 * most), rel=1e-4)


# ---- files


@pytest.fixture(scope="module")
def files(tmp_path_factory: Any) -> Path:
    """A folder with one random picture in several formats, made without feeler, and one that is near it."""
    folder = tmp_path_factory.mktemp("pictures")
    random = np.random.default_rng(3)
    coded = random.integers(0, 256, (24, 32, 4), np.uint8)
    coded[..., 3] = np.where(random.random((24, 32)) < 0.5, 255, coded[..., 3])
    Image.fromarray(coded[..., :3]).save(folder / "rgb.png")
    Image.fromarray(coded[..., :3]).save(folder / "rgb.tif")
    Image.fromarray(coded).save(folder / "rgba.png")
    for ending in ["png", "tif", "jpg"]:
        Image.fromarray(coded[..., 0]).save(folder / f"grey.{ending}", quality=100)
    for ending in ["png", "tif"]:
        Image.fromarray(coded[..., [0, 3]]).save(folder / f"grey-alpha.{ending}")
    Image.fromarray(coded[..., :3]).save(folder / "rgb.jpg", quality=100, subsampling=0)
    near = coded[..., :3].copy()
    near[5, 6] ^= 64
    Image.fromarray(near).save(folder / "near.png")
    Image.fromarray(near[:-1]).save(folder / "small.png")
    (folder / "text.png").write_text("this is no picture")
    (folder / "cut.png").write_bytes((folder / "rgb.png").read_bytes()[:700])
    (folder / "folder.png").mkdir()
    np.save(folder / "coded.npy", coded)
    return folder


def test_files_are_made_linear(files: Path) -> None:
    coded = np.load(files / "coded.npy") / 255
    linear = decode_srgb(coded[..., :3])
    for name in ["rgb.png", "rgb.tif"]:
        assert feeler.compare(files / name, linear).max < 1e-6, name
    assert feeler.compare(files / "rgba.png", linear * coded[..., 3:]).max < 1e-6  # as over black
    for ending in ["png", "tif"]:
        assert feeler.compare(files / f"grey.{ending}", linear[..., 0]).max < 1e-6, ending
        assert feeler.compare(files / f"grey-alpha.{ending}", linear[..., 0] * coded[..., 3]).max < 1e-6, ending
    assert feeler.compare(files / "grey.jpg", linear[..., 0]).rmse < 0.01
    assert 0 < feeler.compare(files / "rgb.jpg", linear).rmse < 0.1


@pytest.mark.parametrize("names", ["R G B", "R G B A", "R G B Z", "Y", "Y A", "L", "L A"])
def test_channels_by_their_names(tmp_path: Path, names: str) -> None:
    """Of colour or of grey, and then perhaps alpha: colours are as over black."""
    values = {"R": 0.5, "G": 0.25, "B": 0.75, "Y": 0.5, "L": 0.5, "A": 0.6, "Z": 9}
    write_layers(tmp_path / "a.exr", {name: np.full((6, 8), values[name]) for name in names.split()})
    expected = [0.5, 0.25, 0.75] if "R" in names else [0.5] * 3
    assert feeler.compare(tmp_path / "a.exr", np.full((6, 8, 3), expected)).max == 0


@pytest.mark.parametrize("names", ["R G", "Z", "A", "R A", "diffuse.Y", "Y RY BY"])
def test_channels_that_are_no_picture(cli: Any, tmp_path: Path, names: str) -> None:
    write_layers(tmp_path / "a.exr", {name: np.full((6, 8), 0.5) for name in names.split()})
    Image.new("L", (8, 6), 188).save(tmp_path / "b.png")
    result = cli("compare", "a.exr", "b.png")
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr == "feeler: a.exr: has no channels R, G and B, and is not grey\n"


def test_renders_in_files_are_as_in_memory(cli: Any, tmp_path: Path) -> None:
    scene = write_spheres(tmp_path / "spheres.nff")
    image = feeler.load(scene).render()
    within = {".exr": 0, ".hdr": 1 / 128, ".png": 0.005, ".tif": 0.005}
    for ending, bound in within.items():
        image.save(tmp_path / f"a{ending}")
        assert feeler.compare(tmp_path / f"a{ending}", image).max <= bound, ending
    # A region in a file that knows regions is no other region, though of the same size.
    for name, region in [("left", (0, 0, 32, 48)), ("right", (32, 0, 64, 48))]:
        feeler.load(scene).render(region=region).save(tmp_path / f"{name}.exr")
        feeler.load(scene).render(region=region).save(tmp_path / f"{name}.png")
    assert feeler.compare(tmp_path / "left.exr", image.pixels[:, :32]).max == 0
    assert feeler.compare(tmp_path / "left.exr", tmp_path / "left.png").max < 0.005
    result = cli("compare", "left.exr", "right.exr")
    assert result.returncode == 1
    assert "different regions" in result.stderr


# ---- the command


def test_table_and_json_tell_the_same(cli: Any, files: Path) -> None:
    found = feeler.compare(files / "near.png", files / "rgb.png")
    result = cli("compare", files / "near.png", files / "rgb.png")
    assert result.returncode == 0 and result.stderr == ""
    for text in [f"{found.max:.6g}", f"{found.rmse:.6g}", f"{found.flip:.6g}", "1 pixel off", "32 x 24"]:
        assert text in result.stdout
    figures = json.loads(cli("compare", files / "near.png", files / "rgb.png", "--json").stdout)
    assert set(figures) == {"pixels", "nonfinite", "max", "p99.9", "rmse", "share", "flip", "flips", "values"}
    assert figures["max"] == pytest.approx(found.max) and figures["p99.9"] == pytest.approx(found.p999)
    assert figures["share"] == pytest.approx(1 / (24 * 32)) and figures["flips"] == 1
    assert figures["values"] == {"max": 0, "p99.9": 0, "rmse": 0}


@pytest.mark.parametrize("option", ["max", "p99.9", "rmse", "share", "flip"])
def test_thresholds(cli: Any, files: Path, option: str) -> None:
    names = [files / "near.png", files / "rgb.png"]
    value = json.loads(cli("compare", *names, "--json").stdout)[option]
    assert value > 0
    assert cli("compare", *names, f"--{option}", value * 1.01).returncode == 0
    result = cli("compare", *names, f"--{option}={value * 0.99}")
    assert result.returncode == 1
    assert result.stderr.startswith(f"feeler: {option} is ") and result.stderr.count("\n") == 1
    assert "RMSE" in result.stdout
    assert cli("compare", names[0], names[0], f"--{option}=0").returncode == 0


def test_difference_picture(cli: Any, tmp_path: Path) -> None:
    Image.fromarray(np.full((24, 32, 3), 100, np.uint8)).save(tmp_path / "a.png")
    Image.fromarray(np.full((24, 32, 3), 101, np.uint8)).save(tmp_path / "b.png")
    result = cli("compare", "a.png", "b.png", "-o", "d.exr", "--json")
    told = json.loads(result.stdout)
    apart = decode_srgb(101 / 255) - decode_srgb(100 / 255)
    factor = told["picture"]["factor"]
    assert told["picture"]["file"] == "d.exr" and 0.5 <= factor * apart < 1 and np.log2(factor) % 1 == 0
    pixels, header = read_exr(tmp_path / "d.exr")
    np.testing.assert_allclose(pixels, factor * apart, rtol=1e-4)
    assert "feeler:rays" not in header
    result = cli("compare", "a.png", "b.png", "-o", "d.png")
    assert f"d.png: the difference times {factor:g}" in result.stdout
    assert np.array(Image.open(tmp_path / "d.png")).min() > 180
    assert cli("compare", "a.png", "b.png", "--map", "flip", "-o", "f.exr").returncode == 0
    np.testing.assert_allclose(read_exr(tmp_path / "f.exr")[0], told["flip"], rtol=1e-5)


def test_a_name_that_is_no_utf_8(cli: Any, files: Path, tmp_path: Path) -> None:
    """JSON cannot tell it."""
    name = os.fsdecode(b"d\xe9.png")
    assert cli("compare", files / "near.png", files / "rgb.png", "-o", name, text=False).returncode == 0
    assert (tmp_path / name).is_file()
    result = cli("compare", files / "near.png", files / "rgb.png", "-o", name, "--json")
    assert result.returncode == 1 and result.stdout == "" and "no UTF-8" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["near.png"], 2, "A B is missing"),
        (["near.png", "rgb.png", "grey.png"], 2, "is too much"),
        (["near.png", "rgb.png", "--max", "2"], 2, "from 0 to 1"),
        (["near.png", "rgb.png", "--map", "heat"], 2, "absolute|flip"),
        (["near.png", "rgb.png", "--map", "flip"], 2, "--map needs --out"),
        (["near.png", "rgb.png", "--map=absolute", "--json"], 2, "--map needs --out"),
        (["near.png", "rgb.png", "-o", "d.xyz"], 2, "unknown picture format"),
        (["near.png", "rgb.png", "-o", "none/d.png"], 1, "folder"),
        (["near.png", "none.png"], 1, "none.png: cannot read: No such file"),
        (["near.png", "folder.png"], 1, "Is a directory"),
        (["near.png", "text.png"], 1, "text.png: cannot read"),
        (["cut.png", "near.png"], 1, "cut.png: cannot read"),
        (["near.png", "small.png"], 1, "32 x 24 and 32 x 23"),
    ],
)
def test_bad_calls(cli: Any, files: Path, arguments: list[str], code: int, message: str) -> None:
    result = cli("compare", *arguments, cwd=files)
    assert (result.returncode, result.stdout) == (code, "")
    assert message in result.stderr
    # libpng has a line of its own.
    lines = [line for line in result.stderr.splitlines() if not line.startswith("libpng")]
    assert lines[0].startswith("feeler: ") and len(lines) == (2 if code == 2 and "-o" not in arguments else 1)


@pytest.mark.parametrize("out", ["a.png", "b.png", "./a.png", "link.png", "other.png"])
def test_what_is_compared_is_not_replaced(cli: Any, tmp_path: Path, out: str) -> None:
    """By whatever name."""
    for name, value in [("a.png", 100), ("b.png", 101)]:
        Image.new("RGB", (8, 6), (value,) * 3).save(tmp_path / name)
    (tmp_path / "link.png").symlink_to("b.png")
    (tmp_path / "other.png").hardlink_to(tmp_path / "a.png")
    before = [(tmp_path / name).read_bytes() for name in ["a.png", "b.png"]]
    result = cli("compare", "a.png", "b.png", "-o", out)
    assert (result.returncode, result.stdout) == (2, "")
    assert f"--out: {out} is a picture that is compared" in result.stderr
    assert [(tmp_path / name).read_bytes() for name in ["a.png", "b.png"]] == before
