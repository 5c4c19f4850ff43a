"""The scenes that come with feeler: each loads, shows what it claims, and gives finite pixels that precision hardly moves."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import feeler

ROOT = Path(__file__).resolve().parent.parent

# What a scene is there to show must be in it: names of features, as `feeler info` lists them.
CLAIMS: dict[str, set[str]] = {
    "first": {"sphere", "plane", "box", "cone", "reflection", "transmission", "fresnel", "filtered_shadows"},
    "figure-16-1": {"sphere", "plane", "diffuse", "specular"},
    "figure-16-1-shadow": {"sphere", "plane", "diffuse", "specular", "shadows"},
    "still-life": {
        "diffuse", "specular", "diffuse_transmission", "specular_transmission", "reflection", "transmission", "disc",
        "total_reflection",
    },
    "water": {"cone", "transmission", "priority", "fresnel"},
    "glass-of-water": {"cone", "transmission", "priority", "fresnel", "filtered_shadows"},
    "forest": {"instance", "sphere", "cone", "plane", "reflection", "shadows", "tree"},
    "mirror-room": {"polygon", "reflection", "shadows"},
    "night": {"cone", "diffuse_transmission", "shadows"},
    "sphereflake": {"sphere", "reflection", "shadows", "tree"},
    "rings": {"sphere", "cone", "reflection", "shadows", "tree"},
    "seashell": {"triangle", "smooth", "reflection", "shadows", "tree"},
}  # fmt: skip
GENERATED = {"sphereflake": "2", "rings": "12", "seashell": "2"}  # with the level that is enough here

# One kernel per scene and level: what follows renders with these settings alone.
KERNEL: dict[str, Any] = {"samples": 1, "work_group": (8, 8), "lanes": 1}
FLIPPED = 0.02  # a pixel that moves by more saw another surface, light or branch

Pixels = NDArray[np.float64]


def generate(name: str, level: str, folder: Path) -> Path:
    """Runs a generator; the scene that it made."""
    out = folder / f"{name}.yaml"
    command = [sys.executable, str(ROOT / "scenes" / f"generate_{name}.py")]
    if name == "seashell":
        subprocess.run([*command, str(out), level], check=True)
    else:
        out.write_bytes(subprocess.run([*command, level], check=True, stdout=subprocess.PIPE).stdout)
    return out


@pytest.fixture(scope="module")
def paths(scenes: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("generated")
    found = {path.stem: path for path in scenes.glob("*.yaml")}
    return found | {name: generate(name, level, folder) for name, level in GENERATED.items()}


def render(scene: feeler.Scene, size: tuple[int, int] = (96, 72), **settings: Any) -> Pixels:
    return np.asarray(scene.render(size=size, **(KERNEL | settings)).pixels, np.float64)


def change(path: Path, folder: Path, old: str, new: str, count: int = -1) -> feeler.Scene:
    """The scene with a piece of its text replaced."""
    text = path.read_text()
    assert old in text
    changed = folder / path.name
    changed.write_text(text.replace(old, new, count))
    return feeler.load(changed)


def test_every_scene_has_its_claims(paths: dict[str, Path]) -> None:
    assert set(paths) == set(CLAIMS)
    assert len(paths) >= 8
    sheet = (ROOT / "scenes" / "contact_sheet.py").read_text()
    assert all(f'"{name}"' in sheet for name in paths)


@pytest.mark.parametrize("name", CLAIMS)
def test_a_scene_loads_and_shows_what_it_claims(name: str, paths: dict[str, Path], cli: Any) -> None:
    said = cli("info", paths[name])
    assert said.returncode == 0, said.stderr
    scene = feeler.load(paths[name])
    assert scene.warnings == []
    assert CLAIMS[name] <= set(scene.info()["features"])


@pytest.mark.parametrize("name", CLAIMS)
def test_a_scene_gives_finite_pixels(name: str, paths: dict[str, Path]) -> None:
    pixels = render(feeler.load(paths[name]), (48, 36))
    assert np.isfinite(pixels).all()
    assert (pixels >= 0).all()
    colours = pixels[..., :3]
    assert 0.02 < colours.mean() < 1.0, "neither black nor burnt out"
    assert (colours.max(axis=2) == 0).mean() < 0.02


@pytest.mark.parametrize("name", CLAIMS)
def test_float_against_double(name: str, paths: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    scene = feeler.load(paths[name])
    single, double = render(scene), render(scene, level="reference")
    error = np.abs(single - double)[..., :3].max(axis=2)
    flipped = error > FLIPPED
    rest = error[~flipped]
    with capsys.disabled():
        print(
            f"\n{name:20} flipped {flipped.mean():8.3%}   error of the others: mean {rest.mean():.1e}, "
            f"99 % below {np.quantile(rest, 0.99):.1e}, greatest {rest.max():.1e}",
            end="",
        )
    assert flipped.mean() <= 0.005
    assert rest.mean() <= 2e-5
    assert np.quantile(rest, 0.99) <= 2e-4


# ---- what one scene is there for


def test_shadows_are_the_difference_of_the_two_figures(paths: dict[str, Path]) -> None:
    bare, shadowed = (render(feeler.load(paths[name])) for name in ("figure-16-1", "figure-16-1-shadow"))
    darker = (bare - shadowed)[..., :3].max(axis=2)
    assert (shadowed <= bare).all()
    assert 0.03 < (darker > 0.05).mean() < 0.4


@pytest.mark.parametrize(
    ("old", "new"), [("ambient: 0.1\n", "ambient: 0\n"), ("emission: [1.4, 1.05, 0.6]", "emission: 0")]
)
def test_the_still_life_uses_the_terms_that_are_no_feature(
    old: str, new: str, paths: dict[str, Path], tmp_path: Path
) -> None:
    path = paths["still-life"]
    size = (192, 144)  # the flame is small
    without, whole = render(change(path, tmp_path, old, new), size), render(feeler.load(path), size)
    assert (np.abs(without - whole).max(axis=2) > 0.02).sum() >= 10


def test_the_still_life_transmits_in_colour(paths: dict[str, Path]) -> None:
    text = paths["still-life"].read_text()
    assert "transmission: [0.45, 0.95, 0.6]" in text
    assert feeler.load(paths["still-life"]).render(size=(96, 72), **KERNEL).stats["rays"]["transmission"] > 0


def test_water_reflects_totally(paths: dict[str, Path], tmp_path: Path) -> None:
    """Only where there is no transmitted direction does `total_reflection` change a picture."""
    everywhere = change(
        paths["water"], tmp_path, "ior: 1.33, fresnel: true", "ior: 1.33, fresnel: true, total_reflection: true"
    )
    changed = np.abs(render(everywhere) - render(feeler.load(paths["water"])))[..., :3].max(axis=2) > 0.02
    assert changed.mean() > 0.01
    rows, columns = np.nonzero(changed)
    assert 18 < np.median(rows) < 50, "about the water's surface"
    assert 30 < np.median(columns) < 66


def test_the_mirrors_reflect_dozens_of_times(paths: dict[str, Path]) -> None:
    stats = feeler.load(paths["mirror-room"]).render(size=(192, 144), **KERNEL).stats
    assert stats["deepest_level"] >= 30


def test_the_night_ends_with_its_lamp(paths: dict[str, Path], tmp_path: Path) -> None:
    """The shade glows by diffuse transmission: without it, it is dark."""
    path = paths["night"]
    dark = render(change(path, tmp_path, "diffuse_transmission: [0.58, 0.44, 0.26]", "diffuse_transmission: 0.001"))
    dimmer = (render(feeler.load(path)) - dark)[..., :3].max(axis=2)
    assert (dimmer > 0.2).mean() > 0.02


# ---- generators


@pytest.mark.parametrize("name", GENERATED)
def test_a_generator_is_deterministic(name: str, tmp_path: Path) -> None:
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        folder.mkdir()
        generate(name, "3", folder)
    files = [sorted(path.name for path in folder.iterdir()) for folder in folders]
    assert files[0] == files[1]
    for file in files[0]:
        assert (folders[0] / file).read_bytes() == (folders[1] / file).read_bytes()


def test_levels_of_the_sphereflake(tmp_path: Path) -> None:
    for level, spheres in enumerate((1, 10, 91, 820)):
        info = feeler.load(generate("sphereflake", str(level), tmp_path)).info()
        assert info["primitives"]["spheres"] == spheres


def test_levels_of_the_seashell(tmp_path: Path) -> None:
    counts = [
        feeler.load(generate("seashell", level, tmp_path)).info()["primitives"]["triangles"] for level in ("2", "4")
    ]
    assert counts[0] < 100_000 <= counts[1]


@pytest.mark.parametrize("name", GENERATED)
def test_a_generator_refuses_an_absurd_level(name: str, tmp_path: Path) -> None:
    arguments = [str(tmp_path / "out.yaml"), "99999"] if name == "seashell" else ["99999"]
    command = [sys.executable, str(ROOT / "scenes" / f"generate_{name}.py"), *arguments]
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    assert result.returncode != 0
    assert "must be" in result.stderr
