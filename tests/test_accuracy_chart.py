"""Charts of accuracy and of specialisation: what is drawn, and that no label covers another."""

from __future__ import annotations

import itertools
import json
import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measured import made_up, made_up_pairs, make_point

import feeler
from feeler.accuracy import Accuracy, Difference

charts = pytest.importorskip("feeler.charts", reason="needs matplotlib")
from matplotlib.container import ErrorbarContainer  # noqa: E402

LABELS = ["16: standard, the default", "1", "1", "16", "depth 2", "cutoff 0.1", "brute force", "general"]


def texts(axes: Any) -> list[str]:
    return [text.get_text() for text in axes.texts]


def containers(axes: Any) -> list[Any]:
    """Points with error bars."""
    return [container for container in axes.containers if isinstance(container, ErrorbarContainer)]


def marks(axes: Any) -> list[Any]:
    """The points' own lines: those with error bars."""
    return [container.lines[0] for container in containers(axes)]


def bars(axes: Any) -> list[list[float]]:
    return [container.lines[2][0].get_segments()[0][:, 0].tolist() for container in containers(axes)]


def crowd(count: int) -> Accuracy:
    """Many methods that have the same error and nearly the same time."""
    results = made_up()
    methods = [make_point("method", (0.02 + 1e-5 * i,) * 3, 4e-3, method=f"method {i}") for i in range(count)]
    return replace(results, points=(*results.points, *methods))


def test_points() -> None:
    """They stand at the median of the times and at the error; bars are quartiles."""
    left = charts.accuracy(made_up()).axes[0]
    assert (left.get_xscale(), left.get_yscale()) == ("log", "log")
    places = [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in marks(left)]
    assert places == pytest.approx(np.array([(1000 * p.median, p.error.rmse) for p in made_up().points]))
    assert bars(left) == pytest.approx(np.array([[1000 * end for end in p.quartiles] for p in made_up().points]))


def test_what_is_marked() -> None:
    """The front is filled and joined by a line, the default has a ring, the noise a line."""
    left = charts.accuracy(made_up()).axes[0]
    filled = [line.get_markerfacecolor() == "black" for line in marks(left)]
    assert filled == [True, True, True, True, True, False, False, False]
    front = next(line for line in left.lines if line.get_label() == "Pareto front")
    assert front.get_ydata() == pytest.approx([3.1e-2, 3e-2, 2e-2, 4e-3, 3.9e-3])
    rings = [line for line in left.lines if line.get_markersize() == 15]
    assert [(float(ring.get_xdata()[0]), float(ring.get_ydata()[0])) for ring in rings] == [(20, 4e-3)]
    assert any(list(line.get_ydata()) == [1e-3, 1e-3] for line in left.lines)
    keys = [text.get_text() for text in left.get_legend().get_texts()]
    assert keys == [
        "draft, by samples", "standard, by samples", "reference, by samples", "less depth", "other cutoff", "other method",
        "default", "filled: on the Pareto front", "noise of the truth",
    ]  # fmt: skip


def test_shapes_differ() -> None:
    left = charts.accuracy(made_up()).axes[0]
    shapes = dict(
        zip(
            (point.setting.name for point in made_up().points), (line.get_marker() for line in marks(left)), strict=True
        )
    )
    assert (
        len({shapes[name] for name in ("standard 1", "draft 1", "reference 16", "depth 2", "cutoff 0.1", "general")})
        == 6
    )
    assert shapes["general"] == shapes["brute force"]


@pytest.mark.parametrize("results", [made_up(), crowd(14)], ids=["few", "crowded"])
def test_labels_are_all_there_and_apart(results: Accuracy) -> None:
    left = charts.accuracy(results).axes[0]
    assert sorted(texts(left)) == sorted(LABELS + [f"method {i}" for i in range(len(results.points) - 8)])
    boxes = [text.get_window_extent() for text in left.texts]
    assert not [pair for pair in itertools.combinations(boxes, 2) if pair[0].overlaps(pair[1])]
    points = left.transData.transform([(1000 * p.median, p.error.rmse) for p in results.points])
    assert not any(box.contains(*point) for box in boxes for point in points)
    frame = left.get_window_extent()
    assert all(frame.contains(box.x0, box.y0) and frame.contains(box.x1, box.y1) for box in boxes)


def test_lines_lead_where_another_point_is_nearer() -> None:
    """Each label has its point near by, or a line that ends there."""
    results = crowd(14)
    left = charts.accuracy(results).axes[0]
    leads = [line for line in left.lines if line.get_linewidth() == 0.5]
    begins = {tuple(np.round(left.transData.transform(line.get_xydata()[0]), 3)) for line in leads}
    points = left.transData.transform([(1000 * p.median, p.error.rmse) for p in results.points])
    assert begins <= {tuple(np.round(point, 3)) for point in points}
    for text in left.texts:
        box, own = text.get_window_extent(), left.transData.transform(text.xy)
        far = [math.dist(point, np.clip(point, (box.x0, box.y0), (box.x1, box.y1))) for point in (own, *points)]
        assert far[0] <= min(far[1:]) + 2 or tuple(np.round(own, 3)) in begins, text.get_text()
    assert len(leads) > 5


def test_parts_by_samples() -> None:
    right = charts.accuracy(made_up()).axes[1]
    drawn = {line.get_label(): (list(line.get_xdata()), list(line.get_ydata())) for line in right.lines}
    assert drawn["too few samples"] == ([1, 16], [3.1e-2 / 4, 4e-3 / 4])
    assert drawn["standard's arithmetic"] == ([1, 16], [3e-2 / 2, 4e-3 / 2])
    assert drawn["standard's without flips"] == ([1, 16], [3e-2 / 6, 4e-3 / 6])
    assert drawn["draft's arithmetic"] == ([1], [3.1e-2 / 2])
    assert texts(right) == ["1 %", "1 %"], "once where levels agree"


def test_another_metric() -> None:
    left = charts.accuracy(made_up(), metric="p999").axes[0]
    assert [float(line.get_ydata()[0]) for line in marks(left)] == pytest.approx(
        [3 * p.error.rmse for p in made_up().points]
    )
    with pytest.raises(feeler.Error, match=r"'mean'.*rmse, p999"):
        charts.accuracy(made_up(), metric="mean")


def test_no_error_at_all() -> None:
    """A logarithm has no place for 0: below all else, and the chart is drawn."""
    nothing = Difference(0, 0, 0, 0)
    results = made_up()
    first = replace(results.points[0], error=nothing, precision=nothing, sampling=nothing)
    left = charts.accuracy(replace(results, points=(first, *results.points[1:]))).axes[0]
    heights = [float(line.get_ydata()[0]) for line in marks(left)]
    assert 0 < heights[0] < min(heights[1:])
    none = [replace(one, error=nothing, precision=nothing, sampling=nothing) for one in results.points]
    empty = replace(results, points=tuple(none), truth=replace(results.truth, noise=0.0))
    assert len(marks(charts.accuracy(empty).axes[0])) == 8
    with pytest.raises(feeler.Error, match="no results"):
        charts.accuracy(replace(results, points=()))


def check_files(folder: Path, expected: set[str]) -> None:
    """Both are there, without colours, with texts."""
    import matplotlib.image

    assert sorted(path.name for path in folder.iterdir()) == ["a.png", "a.svg"]
    pixels = matplotlib.image.imread(folder / "a.png")
    assert np.ptp(pixels[..., :3], axis=-1).max() == 0, "no colours, so none that are needed"
    assert pixels[..., :3].min() == 0
    svg = ET.parse(folder / "a.svg").getroot()
    written = {"".join(text.itertext()).strip() for text in svg.iter("{http://www.w3.org/2000/svg}text")}
    assert expected <= written


def test_files(tmp_path: Path) -> None:
    content = json.loads(made_up().to_json())
    charts.accuracy(content, save=tmp_path / "a.png")
    check_files(tmp_path, {"16: standard, the default", "brute force", "default", "too few samples"})
    first = (tmp_path / "a.svg").read_bytes()
    charts.accuracy(made_up(), save=tmp_path / "a")
    assert (tmp_path / "a.svg").read_bytes() == first, "the same results make the same file"


def test_specialisation(tmp_path: Path) -> None:
    figure = charts.specialisation(made_up_pairs(), save=tmp_path / "a")
    trace, compile_ = figure.axes
    assert [bar.get_width() for bar in trace.patches] == pytest.approx([0.5, 0.2 / 0.19])
    assert [bar.get_width() for bar in compile_.patches] == pytest.approx([0.5, 6 / 6.5])
    assert bars(trace)[0] == pytest.approx([0.25, 0.55])
    assert [label.get_text() for label in trace.get_yticklabels()] == ["balls", "glass"]
    assert [text.split() for text in texts(trace)] == [
        ["0.50", "20", "→", "10", "ms"],
        ["1.05", "190", "→", "200", "ms"],
    ]
    check_files(tmp_path, {"balls", "glass", "specialised / general"})
    with pytest.raises(feeler.Error, match="no results"):
        charts.specialisation([])
