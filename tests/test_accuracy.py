"""Error against time: what is measured, what its numbers mean, and how it is kept."""

from __future__ import annotations

import csv
import io
import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measured import made_up, made_up_pairs

import feeler
from feeler import accuracy, specialisation, sweep
from feeler.accuracy import Difference, Point
from feeler.sweep import Method, Plan

# ---- numbers ----


@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=12))
def test_the_front_is_what_nothing_beats(points: list[tuple[int, int]]) -> None:
    def beaten(a: tuple[int, int]) -> bool:
        return any(b != a and b[0] <= a[0] and b[1] <= a[1] for b in points)

    front = accuracy.pareto_front(points)
    assert sorted(front) == [place for place, point in enumerate(points) if not beaten(point)]
    assert [points[place] for place in front] == sorted(points[place] for place in front)


def test_difference() -> None:
    """Two of 1001 pixels are off: one by 0.5 in one channel, one by a little in all."""
    one = np.full((13, 77, 4), 0.25)
    other = one.copy()
    other[3, 5, 1] += 0.5
    other[4, 6, :3] += 0.001
    other[..., 3] = 1  # alpha does not count
    found = accuracy.difference(one, other)
    assert found.rmse == pytest.approx(np.sqrt((0.25 + 3e-6) / 3003), rel=1e-12)
    assert found.flips == pytest.approx(1 / 1001)
    assert found.values == pytest.approx(np.sqrt(3e-6 / (1000 * 3)), rel=1e-9)
    assert found.p999 == pytest.approx(0.001), "one of a thousand is farther off"
    assert accuracy.difference(one, one) == Difference(0, 0, 0, 0)


def test_colours_beyond_white_are_white() -> None:
    over = np.array([[[1.5, -0.5, 0.5, 1.0]]])
    assert accuracy.difference(over, np.array([[[1.0, 0.0, 0.5, 1.0]]])).rmse == 0
    assert accuracy.difference(over, np.array([[[0.0, 0.0, 0.5, 1.0]]])).values == 0, "all have flipped"


@pytest.mark.parametrize(("samples", "expected"), [(2, (1, 4)), (5, (1, 4)), (64, (25, 36)), (256, (121, 144))])
def test_halves(samples: int, expected: tuple[int, int]) -> None:
    assert sweep.halves(samples) == expected


# ---- data ----


def test_json_round_trip(tmp_path: Path) -> None:
    results = made_up()
    (tmp_path / "a.json").write_text(results.to_json())
    assert accuracy.read(tmp_path / "a.json") == results
    assert accuracy.read(json.loads(results.to_json())) == results


def test_csv_has_the_same() -> None:
    results = made_up()
    rows = list(csv.DictReader(io.StringIO(results.to_csv())))
    assert [row["name"] for row in rows] == [
        "standard 16", "standard 1", "draft 1", "reference 16", "depth 2", "cutoff 0.1", "brute force", "general",
    ]  # fmt: skip
    assert [row["front"] for row in rows] == list("11111000")
    assert [row["default"] for row in rows] == list("10000000")
    for row, one in zip(rows, results.points, strict=True):
        assert float(row["median"]) == one.median
        assert (float(row["low"]), float(row["high"])) == one.quartiles
        for part in accuracy.PARTS:
            assert float(row[f"{part}_p999"]) == getattr(one, part).p999
    assert [float(rows[0][name]) for name in ("low", "median", "high")] == [0.0195, 0.020, 0.022]


BAD = {
    "no JSON": "{",
    "a list": "[]",
    "no points": "{}",
    "a setting too much": made_up().to_json().replace('"factor"', '"fctor"', 1),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_results(tmp_path: Path, case: str) -> None:
    (tmp_path / "a.json").write_text(BAD[case])
    with pytest.raises(feeler.Error, match=r"a\.json: no results of `feeler chart`") as caught:
        accuracy.read(tmp_path / "a.json")
    assert caught.value.kind == "bad input"


def test_results_without_times() -> None:
    content = json.loads(made_up().to_json())
    content["points"][0]["seconds"] = []
    with pytest.raises(feeler.Error, match="without times"):
        accuracy.read(content)


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(feeler.Error, match=r"a\.json: cannot be read"):
        accuracy.read(tmp_path / "a.json")


# ---- a real sweep ----

# Depth 3 and less need the same kernels; shadows would take longer to compile. Weights are 1, 0.2 and 0.04.
MIRRORS: dict[str, Any] = {
    "camera": {"eye": [0, 1, 5], "look_at": [0, 0, 0]},
    "background": [0.3, 0.5, 0.7],
    "depth": 3,
    "shadows": False,
    "lights": [{"point": [3, 5, 4]}],
    "materials": {"mirror": {"diffuse": [0.6, 0.3, 0.2], "reflection": 0.2}},
    "objects": [
        {"sphere": {"centre": [x, 0, -x], "radius": 0.9}, "material": "mirror"} for x in (-1, 1)
    ],
}  # fmt: skip
METHODS = {
    "1 lane": Method(render={"lanes": 1}),
    "no diffuse": Method(build="-DHAS_DIFFUSE=0"),
    "never": Method(build="-DNEVER", needs=("cone",)),
    "the usual": Method(render={"pixels": (1, 1)}),
}
PLAN = Plan(size=(16, 12), repeat=2, truth_samples=5, samples=(1, 4), levels=("standard", "reference"), methods=METHODS)


@pytest.fixture(scope="module")
def measured() -> tuple[accuracy.Accuracy, list[str]]:
    """The results, and what was said meanwhile."""
    said: list[str] = []
    return sweep.measure(feeler.Scene(MIRRORS), PLAN, name="mirrors", say=said.append), said


def by_name(results: accuracy.Accuracy) -> dict[str, Point]:
    return {one.setting.name: one for one in results.points}


def test_what_is_swept(measured: Any) -> None:
    results, said = measured
    assert list(by_name(results)) == [
        "standard 1", "standard 4", "reference 1", "reference 4", "depth 1", "depth 2",
        "cutoff 0.1", "cutoff 0.03", "cutoff 0.01", "cutoff 0.003", "cutoff 0.001", "1 lane", "no diffuse",
    ]  # fmt: skip
    assert [one.setting.name for one in results.points if one.default] == ["standard 1"]
    assert (results.scene, results.size, dict(results.left_out)) == ("mirrors", (16, 12), {})
    assert all(len(one.seconds) == 2 and min(one.seconds) > 0 for one in results.points)
    rounds = [text for text in said if text.startswith("round")]
    assert [text.split(": ")[1] for text in rounds] == 2 * list(by_name(results)), "all, and then all again"


def test_parts_of_the_error(measured: Any) -> None:
    """Each part is 0 where its cause is absent, and is not where it is there."""
    points = by_name(measured[0])
    nothing = Difference(0, 0, 0, 0)
    for name, one in points.items():
        assert (one.precision == nothing) == (one.setting.level == "reference"), name
        assert (one.truncation == nothing) == (name not in ("depth 1", "depth 2", "cutoff 0.1")), name
        assert one.sampling.rmse > 0, name
        total = one.precision.rmse + one.truncation.rmse + one.sampling.rmse
        assert one.error.rmse <= total * (1 + 1e-12), name
    assert points["depth 1"].truncation.rmse > points["depth 2"].truncation.rmse
    assert points["depth 1"].precision.rmse < 1e-5 < points["depth 1"].truncation.rmse
    assert points["standard 4"].sampling.rmse < points["standard 1"].sampling.rmse
    assert points["standard 1"].sampling == points["cutoff 0.1"].sampling
    assert 0 < points["standard 1"].precision.values < 1e-5


def test_methods(measured: Any) -> None:
    """Lanes change nothing; the build option reaches the kernels, and the environment is as before."""
    points = by_name(measured[0])
    assert points["1 lane"].error == points["standard 1"].error
    assert points["no diffuse"].precision.flips > 0.1
    assert "FEELER_KERNEL_OPTIONS" not in os.environ
    assert "FEELER_TUNED" not in os.environ


def test_needs_are_features() -> None:
    needs = {name for method in sweep.METHODS.values() for name in method.needs}
    assert {"tree", "shadows", "triangle"} <= needs
    assert all(f"-DHAS_{name.upper()}=1" in feeler.kernel_options() for name in needs)


def test_the_truth(measured: Any) -> None:
    """The noise is that of the mean of both: half of what lies between them."""
    truth = measured[0].truth
    assert (truth.samples, truth.depth, truth.cutoff) == ((1, 4), 3, 0)
    scene = feeler.Scene(MIRRORS)
    one, other = (scene.render(size=(16, 12), samples=n, level="reference").pixels for n in truth.samples)
    assert truth.noise == accuracy.difference(one, other).rmse / 2 > 0
    own = scene.render(size=(16, 12)).pixels
    expected = accuracy.difference(own, (one + 4 * other) / 5)
    assert by_name(measured[0])["standard 1"].error == expected


def test_what_takes_too_long_is_left_out() -> None:
    plan = replace(PLAN, size=(160, 120), repeat=1, truth_samples=2, samples=(1,), levels=(), methods={}, patience=0)
    results = sweep.measure(feeler.Scene(MIRRORS), plan)
    assert [one.setting.name for one in results.points] == ["standard 1"]
    assert results.left_out["depth 2"] == "takes more than 0 s"
    assert len(results.left_out) == 7


@pytest.mark.parametrize(
    ("renders", "expected"), [([0.01, 0.03, 0.02], 0.02), ([0.06], 0.06), ([0.004, 0.001, 0.003, 0.002, 0.005], 0.003)]
)
def test_short_renders_are_repeated(monkeypatch: pytest.MonkeyPatch, renders: list[float], expected: float) -> None:
    """Until they take 0.05 seconds together, at most five times."""
    times = iter(renders)
    monkeypatch.setattr(sweep, "kernel_seconds", lambda _image: next(times))
    monkeypatch.setattr(sweep._Sweep, "render", lambda *_: None)
    measuring = sweep._Sweep(feeler.Scene(MIRRORS), PLAN, None, print)
    assert measuring._seconds(measuring.default) == expected
    assert next(times, None) is None


def test_a_caller_keeps_kernel_options(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FEELER_KERNEL_OPTIONS", "-DMINE")
    with sweep._environment("-DOTHER"):
        assert os.environ["FEELER_KERNEL_OPTIONS"] == "-DMINE -DOTHER"
    assert os.environ["FEELER_KERNEL_OPTIONS"] == "-DMINE"


# ---- specialisation ----


def test_ratios_of_pairs() -> None:
    one = made_up_pairs()[0]
    assert one.ratios("trace") == pytest.approx([0.5, 0.55, 0.25])
    assert one.ratios("compile") == pytest.approx([0.5, 0.4, 0.75])
    assert one.medians("trace") == (0.010, 0.020)


def test_specialisation_as_data(tmp_path: Path) -> None:
    results = made_up_pairs()
    (tmp_path / "a.json").write_text(specialisation.to_json(results))
    assert specialisation.read(tmp_path / "a.json") == results
    rows = list(csv.DictReader(io.StringIO(specialisation.to_csv(results))))
    assert len(rows) == 8
    assert [float(row["compile"]) for row in rows if row["kernels"] == "general"] == [4, 5, 4, 6.5]
    content = json.loads(specialisation.to_json(results))
    content["scenes"][0]["general"].pop()
    with pytest.raises(feeler.Error, match="no pairs"):
        specialisation.read(content)


def test_a_process_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(feeler.Error, match=r"a\.yaml"):
        specialisation.measure(tmp_path / "a.yaml")
    (tmp_path / "a.yaml").write_text(json.dumps(MIRRORS))
    if sys.version_info >= (3, 11):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "json.py").write_text("raise SystemExit('from the working folder')")
    with pytest.raises(feeler.Error, match=r"process of its own failed.*no OpenCL device"):
        specialisation.measure(tmp_path / "a.yaml", device="no such device")


@pytest.mark.slow
def test_pairs_of_processes(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(json.dumps(MIRRORS))
    said: list[str] = []
    found = specialisation.measure(tmp_path / "a.yaml", size=(16, 12), repeat=2, say=said.append)
    assert said == [f"{kernels} kernels, {turn} of 2" for turn in (1, 2) for kernels in ("specialised", "general")]
    assert (found.scene, found.size, found.samples) == ("a", (16, 12), 1)
    assert set(found.features) == {"sphere", "diffuse", "reflection", "tree"}
    assert min(part for one in (*found.specialised, *found.general) for part in (one.trace, one.compile)) > 0
    assert found.general != found.specialised
