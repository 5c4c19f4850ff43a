"""The rays that the classic databases take, against the table that came with them: no shading convention touches it."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Rays = dict[str, int]

# 513 x 513 eye rays, depth 5, as printed with the databases. The gears' refractions are counted otherwise: see below.
TABLE: dict[str, Rays] = {
    "balls": {"eye_hits": 263169, "reflection": 175095, "transmission": 0, "shadow": 954368},
    "gears": {"eye_hits": 245086, "reflection": 304643, "shadow": 2246955},
    "mount": {"eye_hits": 173125, "reflection": 354769, "transmission": 354769, "shadow": 412922},
    "rings": {"eye_hits": 263169, "reflection": 315236, "transmission": 0, "shadow": 1085002},
    "tetra": {"eye_hits": 49788, "reflection": 0, "transmission": 0, "shadow": 46112},
}
GEARS_REFRACTION = 207564
TOLERANCE = {"gears": 0.02, "rings": 0.02}  # else 1 %

TINY = "1e-6"
KS, T = 5, 7  # places in an NFF fill after its "f", from 1


def change_fills(text: str, change: Callable[[list[str]], None]) -> str:
    """The text with every fill's words ("f" is the first) as `change` leaves them."""

    def rewrite(match: re.Match[str]) -> str:
        words = match.group().split()
        change(words)
        return " ".join(words)

    return re.sub(r"^f .*", rewrite, text, flags=re.MULTILINE)


def let_glass_reflect(fill: list[str]) -> None:
    if float(fill[T]) > 0 and float(fill[KS]) == 0:
        fill[KS] = TINY


def let_mirrors_transmit(fill: list[str]) -> None:
    let_glass_reflect(fill)
    if float(fill[KS]) > 0 and float(fill[T]) == 0:
        fill[T] = TINY


@pytest.fixture(scope="module")
def count_rays(program: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Rays]:
    """Counts the rays of an NFF text at the table's size."""
    folder = tmp_path_factory.mktemp("counts")

    def count(text: str) -> Rays:
        scene = folder / "scene.nff"
        scene.write_text(text)
        options: list[str | Path] = [
            "--size",
            "513x513",
            "--samples",
            "1",
            "--depth",
            "5",
            "--cutoff",
            "0",
            "--stats",
            folder / "a.json",
        ]
        command = [program, "render", scene, "-o", folder / "a.exr", *options]
        result = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        assert result.returncode == 0, result.stderr
        rays: Rays = json.loads((folder / "a.json").read_text())["rays"]
        assert rays["eye"] == 513 * 513
        return rays

    return count


@pytest.fixture(scope="module")
def rays(spd: Path, count_rays: Callable[[str], Rays]) -> Callable[[str], Rays]:
    """The rays of a database by its name, each counted once. The gears' glass reflects a little, or it would not count."""
    known: dict[str, Rays] = {}

    def find(name: str) -> Rays:
        if name not in known:
            known[name] = count_rays(change_fills((spd / f"{name}.nff").read_text(), let_glass_reflect))
        return known[name]

    return find


@pytest.mark.parametrize("name", TABLE)
def test_the_tables_counts(rays: Callable[[str], Rays], name: str) -> None:
    counted = rays(name)
    for kind, expected in TABLE[name].items():
        print(f"{name} {kind}: {counted[kind]}, table {expected}")
        assert counted[kind] == pytest.approx(expected, rel=TOLERANCE.get(name, 0.01), abs=0), kind


@pytest.mark.xfail(reason="3.2 % fewer: the table seems to count total internal reflections too", strict=True)
def test_the_gears_refractions_in_the_table(rays: Callable[[str], Rays]) -> None:
    """As it is asked; what is thought to be counted instead is tested next."""
    assert rays("gears")["transmission"] == pytest.approx(GEARS_REFRACTION, rel=TOLERANCE["gears"])


def test_refractions_of_the_gears(spd: Path, rays: Callable[[str], Rays], count_rays: Callable[[str], Rays]) -> None:
    """The table has a refraction for every hit on the gears' glass, total internal reflections too.

    For its reflections less its refractions are the floor's alone. How often the floor reflects is counted by letting it
    transmit as well, to where there is nothing: each such hit adds one refraction. No light, so no feelers: they would
    only take time.
    """
    counted = rays("gears")
    text = re.sub(r"^l .*\n", "", (spd / "gears.nff").read_text(), flags=re.MULTILINE)
    other = count_rays(change_fills(text, let_mirrors_transmit))
    assert other["reflection"] == counted["reflection"]
    floor = other["transmission"] - counted["transmission"]
    glass = counted["reflection"] - floor
    totally_reflected = glass - counted["transmission"]
    print(f"floor {floor}, glass {glass}, totally reflected {totally_reflected}")
    assert floor == pytest.approx(TABLE["gears"]["reflection"] - GEARS_REFRACTION, rel=0.01)
    assert glass == pytest.approx(GEARS_REFRACTION, rel=0.02)
    # By a tracer on Embree's triangles, the polygons cut by clipping ears.
    assert counted["transmission"] == pytest.approx(200940, rel=0.005)
    assert totally_reflected == pytest.approx(7571, rel=0.02)
