"""Charts of work groups: what is drawn, that it can be read without colours, and bad input."""

from __future__ import annotations

import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from spheres import write_spheres
from stability.__main__ import merge
from stability.study import Result

import feeler

charts = pytest.importorskip("feeler.charts", reason="needs matplotlib")


def result(x: int, y: int, *times: float, invalidity: str = "correct", mark: str = "", **other: Any) -> dict[str, Any]:
    """One result of a sweep; times in milliseconds."""
    settings = {"scene": "balls.nff", "device": "d", "level": "standard", "samples": 4, "width": 8, "height": 6}
    return {
        "configuration": {"work_group_x": x, "work_group_y": y, **settings, **other},
        "times": {"compilation_time": 3.0, "runtimes": list(times)},
        "invalidity": invalidity,
        "measurements": [{"name": mark, "value": 1, "unit": ""}] if mark else [],
    }


SWEEP = {
    "schema_version": "1.0.0",
    "results": [
        result(8, 8, 21, 20, 24, mark="default"),
        result(1, 1, 40, 41, 43),
        result(16, 4, 10, 11, 10.5),
        result(32, 32, 9, 9, 9, mark="forced"),
        result(64, 64, invalidity="runtime"),
        result(3, 99, invalidity="constraints"),
    ],
}


def texts(axes: Any) -> list[str]:
    return [text.get_text() for text in axes.texts]


def test_bars() -> None:
    """Heights are medians, lines reach from the least to the greatest, numbers stand beside."""
    bars = charts.work_groups(SWEEP).axes[0]
    ticks = [label.get_text() for label in bars.get_xticklabels()]
    assert ticks == ["1×1", "8×8", "16×4", "3×99", "32×32", "64×64"]
    assert [bar.get_height() for bar in bars.patches] == [41, 21, 10.5, 9]
    spreads = [line.get_segments()[0][:, 1].tolist() for line in bars.collections]
    assert spreads == [[40, 43], [20, 24], [10, 11], [9, 9]]
    assert texts(bars) == ["41", "21", "10.5", "invalid", "9", "crashed"]
    assert [text.get_text() for text in bars.texts if text.get_fontweight() == "bold"] == ["10.5"]
    assert [bool(bar.get_hatch()) for bar in bars.patches] == [False, True, False, True]
    assert "balls, 8×6, 4 samples, standard" in bars.get_title()


def test_map() -> None:
    """Cells stand at their sizes and hold the time relative to the default's; the slower the darker."""
    cells = charts.work_groups(SWEEP).axes[1]
    columns = [int(label.get_text()) for label in cells.get_xticklabels()]
    rows = [int(label.get_text()) for label in cells.get_yticklabels()]
    found = {(columns[int(t.get_position()[0])], rows[int(t.get_position()[1])]): t.get_text() for t in cells.texts}
    assert found == {
        (1, 1): f"{41 / 21:.2f}", (8, 8): "1.00\ndefault", (16, 4): "0.50", (32, 32): f"{9 / 21:.2f}\nrefused",
        (64, 64): "crashed", (3, 99): "invalid",
    }  # fmt: skip
    shades = {
        text.split("\n")[0]: patch.get_facecolor()[0] for text, patch in zip(found.values(), cells.patches, strict=True)
    }
    assert shades["1.95"] < shades["1.00"] < shades["0.50"] < shades["crashed"] == 1


def test_several_results_stand_side_by_side() -> None:
    other = {
        **SWEEP,
        "results": [{**result(4, 4, 5), "configuration": {**result(4, 4)["configuration"], "device": "e"}}],
    }
    figure = charts.work_groups([SWEEP, other])
    assert len(figure.axes) == 4
    titles = [axes.get_title().split("\n")[1] for axes in figure.axes[:2]]
    assert titles == ["d", "e"]
    both = {"results": SWEEP["results"] + other["results"]}
    assert len(charts.work_groups(both).axes) == 4, "the cases of one file, too"


def test_files(tmp_path: Path) -> None:
    import matplotlib.image

    figure = charts.work_groups(SWEEP, save=tmp_path / "chart.v1")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["chart.v1.png", "chart.v1.svg"]
    pixels = matplotlib.image.imread(tmp_path / "chart.v1.png")
    width, height = (round(110 * inches) for inches in figure.get_size_inches())
    assert pixels.shape[:2] == (height, width)
    assert np.ptp(pixels[..., :3], axis=-1).max() == 0, "no colours, so none that are needed"
    assert pixels[..., :3].min() == 0
    svg = ET.parse(tmp_path / "chart.v1.svg").getroot()
    assert svg.tag == "{http://www.w3.org/2000/svg}svg"
    assert svg.get("width") == f"{72 * width / 110:g}pt"
    written = {"".join(text.itertext()).strip() for text in svg.iter("{http://www.w3.org/2000/svg}text")}
    assert {"10.5", "crashed", "16×4", "render's default"} <= written
    first = (tmp_path / "chart.v1.svg").read_bytes()
    charts.work_groups(SWEEP, save=tmp_path / "chart.v1")
    assert (tmp_path / "chart.v1.svg").read_bytes() == first, "the same results make the same file"


def test_a_failure_keeps_the_old_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a chart never takes a whole one's place."""

    def save_half(figure: Any, file: Path, **_: Any) -> None:
        file.write_text("half")
        raise OSError(28, "No space left on device", str(file))

    charts.work_groups(SWEEP, save=tmp_path / "chart")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", save_half)
    with pytest.raises(OSError, match="No space") as failure:
        charts.work_groups(SWEEP, save=tmp_path / "chart")
    assert failure.value.filename == str(tmp_path / "chart.png")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_links_and_modes_stay(tmp_path: Path) -> None:
    whole, link = tmp_path / "whole.svg", tmp_path / "chart.svg"
    whole.touch(mode=0o640)
    link.symlink_to(whole)
    charts.work_groups(SWEEP, save=tmp_path / "chart")
    assert link.is_symlink()
    assert whole.stat().st_size > 0
    assert whole.stat().st_mode & 0o777 == 0o640


def test_what_bench_writes(cli: Any, tmp_path: Path) -> None:
    scene = write_spheres(tmp_path / "spheres.nff", (32, 24))
    done = cli("bench", scene, "--repeat", "2", "--work-groups", "2x2,100000x1", "--json", "a.json")
    assert done.returncode == 0, done.stderr
    figure = charts.work_groups(str(tmp_path / "a.json"), save=tmp_path / "a.png")
    assert [label.get_text() for label in figure.axes[0].get_xticklabels()] == ["2×2", "8×8", "100000×1"]
    assert (tmp_path / "a.svg").is_file()


def test_nothing_that_ran() -> None:
    figure = charts.work_groups({"results": [result(1, 1, invalidity="timeout")]})
    assert texts(figure.axes[0]) == ["too slow"]


BAD = {
    "no JSON": "{",
    "no results": "{}",
    "a list": "[]",
    "no configuration": json.dumps({"results": [{"times": {}}]}),
    "no sizes": json.dumps({"results": [{"configuration": {}, "times": {"runtimes": []}, "invalidity": "correct"}]}),
    "empty": json.dumps({"results": []}),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_results(tmp_path: Path, case: str) -> None:
    (tmp_path / "a.json").write_text(BAD[case])
    with pytest.raises(feeler.Error) as caught:
        charts.work_groups(tmp_path / "a.json")
    assert caught.value.kind == "bad input"


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(feeler.Error, match=r"a\.json: cannot be read"):
        charts.work_groups(tmp_path / "a.json")


def test_scenes_of_one_name() -> None:
    """In two folders."""
    results = [result(x, 4, x + n, scene=f"{n}/balls.nff") for n in (1, 2) for x in (2, 4)]
    figure = charts.work_groups({"results": results})
    assert len(figure.axes) == 4
    assert [texts(axes) for axes in figure.axes[:2]] == [["3", "5"], ["4", "6"]]


def study() -> dict[str, Any]:
    """Two charts of one row, as the stability laboratory writes them."""
    naive = {"name": "b² − 4ac", "kind": "naive", "values": [0, 0.1, 1], "bound": None, "fails": 0.1}
    robust = {"name": "chord", "kind": "robust", "values": [0, 0, 0], "bound": 0, "fails": None}
    errors = {**robust, "values": [1e-7, 1e-6, float("inf")], "bound": [1e-6, 1e-5, 1e-4]}
    panel = {"title": "hit or miss", "x_name": "distance", "x": [1, 10, 100], "y_name": "wrong", "tries": 200, "x_log": True,
             "y_log": True}  # fmt: skip
    cost = {"what": "one ray", "ratio": 1.25, "low": 1.2, "high": 1.3, "robust_ns": 5, "naive_ns": 4}
    panels = [{**panel, "curves": [naive, robust]},
              {**panel, "x": ["none", "some", "all"], "tries": None, "curves": [naive, errors]}]  # fmt: skip
    return {"rows": [{"row": 1, "name": "sphere", "oracle": "rationals", "panels": panels, "cost": cost}]}


def test_stability(tmp_path: Path) -> None:
    """A chart for each panel; what is 0 stands at the bottom, above nothing else, and says of how many."""
    figure = charts.stability(study(), 1, save=tmp_path / "row")
    rate, error = figure.axes
    naive, robust = rate.get_lines()
    floor = rate.get_ylim()[0]
    assert list(robust.get_ydata()) == [floor] * 3
    assert list(naive.get_ydata()) == [floor, 0.1, 1]
    assert floor < 1 / 200
    assert rate.get_yticklabels()[0].get_text() == "0 of 200"
    assert (naive.get_marker(), robust.get_marker()) == ("x", "o")
    assert [line.get_label() for line in error.get_lines()][-1] == "the bound that is claimed for it"
    assert [label.get_text() for label in error.get_xticklabels()] == ["none", "some", "all"]
    assert np.isnan(error.get_lines()[1].get_ydata()[2])
    assert "1.25 ×" in figure.get_supxlabel()
    assert (tmp_path / "row.svg").is_file()


def test_one_row_is_studied_again(tmp_path: Path) -> None:
    """The other rows of the file stay."""
    path = tmp_path / "rows.json"
    results = [Result(row, "sphere", "rationals", []) for row in (1, 2, 14, 14)]
    path.write_text(merge(path, results))
    path.write_text(merge(path, [Result(2, "ground", "rationals", [])]))
    rows = [(row["row"], row["name"]) for row in json.loads(path.read_text())["rows"]]
    assert rows == [(1, "sphere"), (2, "ground"), (14, "sphere"), (14, "sphere")]


def test_nothing_was_measured() -> None:
    data = study()
    for curve in data["rows"][0]["panels"][0]["curves"]:
        curve["values"] = [None] * 3
    assert np.isnan(charts.stability(data, 1).axes[0].get_lines()[0].get_ydata()).all()


def test_bad_stability(tmp_path: Path) -> None:
    with pytest.raises(feeler.Error, match="there is no row 27"):
        charts.stability(study(), 27)
    with pytest.raises(feeler.Error, match=r"a\.json: cannot be read"):
        charts.stability(tmp_path / "a.json", 1)
    short, unknown, empty = study(), study(), study()
    short["rows"][0]["panels"][0]["x"] = [1, 10]
    unknown["rows"][0]["panels"][0]["curves"][0]["kind"] = "magic"
    empty["rows"][0]["panels"] = []
    for bad in ({}, {"rows": [{}]}, {"rows": [{"row": 1}]}, short, unknown, empty):
        with pytest.raises(feeler.Error, match="is not what the stability laboratory writes"):
            charts.stability(bad, 1)


def test_it_is_there_when_asked_for() -> None:
    code = "import feeler, sys; assert 'matplotlib' not in sys.modules; feeler.charts.work_groups"
    subprocess.run([sys.executable, "-c", code], check=True)
