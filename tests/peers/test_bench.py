"""What `make bench` measures with: statistics, verdicts, the scenes of growth, and that its program runs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bench import format_line
from bench_pairs import Pairs, Spread, measure_pairs, spread
from bench_rows import Result, times_faster
from growth_chart import draw
from growth_scenes import write_field, write_spheres


def test_spread() -> None:
    assert spread([3, 1, 2]) == Spread(1.5, 2, 2.5)
    assert spread([4, 1, 2, 3]) == Spread(1.75, 2.5, 3.25)
    assert spread([5]) == Spread(5, 5, 5)


def test_ratios_are_of_pairs() -> None:
    """Noise that slows both of a pair does not count: the medians' quotient would be 3."""
    pairs = Pairs([1, 10, 2], [2, 20, 6])
    assert pairs.times_faster == Spread(2, 2, 2.5)


def test_pairs_are_measured_in_turn() -> None:
    order: list[str] = []

    def clock(name: str, seconds: list[float]) -> float:
        order.append(name)
        return seconds.pop(0)

    ours, theirs = [1.0, 2.0], [3.0, 4.0]
    pairs = measure_pairs(lambda: clock("A", ours), lambda: clock("B", theirs), 2)
    assert order == ["A", "B", "A", "B"]
    assert pairs == Pairs([1.0, 2.0], [3.0, 4.0])


@pytest.mark.parametrize(
    ("median", "at_least", "passes", "verdict"),
    [
        (1.4, True, False, "short"),
        (1.5, True, True, "pass, aim 2"),
        (2.0, True, True, "pass, aim reached"),
        (1.4, False, True, "pass, aim reached"),
        (1.6, False, False, "short"),
    ],
)
def test_verdicts(median: float, at_least: bool, passes: bool, verdict: str) -> None:
    result = Result("row", "case", 1, None, spread([median]), "x", 1.5, 2, at_least)
    assert result.passes is passes
    assert format_line(result).endswith(verdict)
    assert result.as_json()["passes"] is passes


def test_what_is_only_recorded_has_no_verdict() -> None:
    result = times_faster("row", "case", Pairs([1], [2]), None, None, "as it is")
    assert result.passes is None
    assert "short" not in format_line(result) and "pass" not in format_line(result)
    assert format_line(result).endswith("as it is")


def read_spheres(path: Path) -> np.ndarray:
    lines = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith("s ")]
    return np.array(lines, float)


def test_spheres_fill_the_same_share(tmp_path: Path) -> None:
    for count in (100, 3000):
        spheres = read_spheres(write_spheres(tmp_path, count).ours)
        assert len(spheres) == count
        assert spheres[:, :3].min() >= 0 and spheres[:, :3].max() <= 1
        share = (4 / 3 * np.pi * spheres[:, 3] ** 3).sum()
        assert share == pytest.approx(0.0654, rel=0.001)


def test_field_is_a_scene(tmp_path: Path, cli: Any) -> None:
    scene = write_field(tmp_path, 1000)
    assert abs(scene.primitives - 1000) < 50
    said = json.loads(cli("info", scene.ours, "--json").stdout)
    assert said["primitives"] == {"triangles": scene.primitives}
    assert not said["warnings"]


def test_chart(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    points = [
        {"kind": kind, "primitives": 10**k, "trace": [0.1 * k, 0.2, 0.3], "their_trace": 0.1 if k < 5 else None}
        for kind in ("spheres", "field")
        for k in (3, 4, 5)
    ]
    draw(points, tmp_path / "chart.svg")
    assert (tmp_path / "chart.svg").read_text().count("feeler") >= 1
    first = (tmp_path / "chart.svg").read_bytes()
    draw(points, tmp_path / "chart.svg")
    assert (tmp_path / "chart.svg").read_bytes() == first


@pytest.mark.peers
@pytest.mark.usefixtures("spd")
def test_the_program_runs(root: Path, program: Path, tmp_path: Path) -> None:
    out = tmp_path / "bench.json"
    command = [sys.executable, root / "tests" / "peers" / "bench.py", "--quick", "--repeat", "1", "--row", "start"]
    result = subprocess.run([*command, "--json", out], check=True, capture_output=True, text=True, timeout=300)
    said = json.loads(out.read_text())
    assert "first, warm" in result.stdout
    cases = {one["case"]: one for one in said["results"]}
    assert cases["first, warm"]["wanted"] == 0.4
    assert cases["first, empty"]["ours"] > cases["first, warm"]["ours"]
