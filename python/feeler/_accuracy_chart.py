"""The chart of accuracy: error against time with the Pareto front, and what errors consist of."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from ._figure import Figure, FuncFormatter, Line2D, LogLocator, NullFormatter, number, save_figure
from ._labels import Label, place_labels
from ._library import BAD_INPUT, BAD_USAGE, Error
from .accuracy import Accuracy, Difference, Point, read

# Shapes tell what is varied; on the front they are filled.
_MARKERS = {"draft": "v", "standard": "o", "reference": "s", "depth": "^", "cutoff": "p", "method": "D"}
_LINES = {"draft": ":", "standard": "-", "reference": "--"}
_KEYS = {
    **{level: f"{level}, by samples" for level in _LINES},
    "depth": "less depth",
    "cutoff": "other cutoff",
    "method": "other method",
}
_NOISE: dict[str, Any] = {"color": "black", "linestyle": (0, (6, 4)), "linewidth": 0.7}
_BELOW: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.08), "fontsize": 8, "frameon": False}
_METRICS = {"rmse": "error: RMSE", "p999": "error of the 99.9th percentile"}


def accuracy(
    results: Accuracy | str | os.PathLike[str] | Mapping[str, Any],
    *,
    metric: str = "rmse",
    save: str | os.PathLike[str] | None = None,
) -> Figure:
    """Draws error against time, and beside it what the error consists of.

    Left: every setting is a point at the median of the kernel's time, with quartiles as bars, and its error against the
    truth; both axes are logarithmic. Lines join the numbers of samples of a level, labelled by the number. Filled
    points are on the Pareto front: nothing measured is as exact and faster. A ring marks the default. The dashed line
    is the truth's own noise: below it nothing can be told apart.

    Right: against samples, the error of having no more samples, and that of the level's arithmetic with the same
    samples; dotted without the pixels that are off by more than 1/255, whose share stands beside.

    Args:
        results: of `feeler.sweep.measure`, or the JSON that they or `feeler chart` wrote.
        metric: "rmse", or "p999": 99.9 % of the pixels are no farther off.
        save: where to write the chart, as PNG and as SVG; the endings are added, or replace each other.

    Returns:
        The matplotlib figure.
    """
    if metric not in _METRICS:
        raise Error(f"unknown metric {metric!r}: it is one of {', '.join(_METRICS)}", code=BAD_USAGE)
    measured = results if isinstance(results, Accuracy) else read(results)
    if not measured.points:
        raise Error("there are no results to draw", code=BAD_INPUT)
    figure = Figure(figsize=(13, 7), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2, 1))
    figure.suptitle(_title(measured), fontsize=10)
    _draw_parts(right, measured, metric)
    labels = _draw_points(left, measured, metric)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    place_labels(figure, left, labels, _marked(figure, left, labels))
    if save is not None:
        save_figure(figure, save)
    return figure


def _title(measured: Accuracy) -> str:
    width, height = measured.size
    truth = measured.truth
    said = (
        f"{measured.scene}, {width}×{height}; truth: reference, {truth.samples[0]} + {truth.samples[1]} samples, "
        f"depth {truth.depth}, cutoff {truth.cutoff:g}"
    )
    return "\n".join([said, *textwrap.wrap(measured.device, 100)])


# ---- error against time ----


def _kind(point: Point) -> str:
    return point.setting.level if point.setting.factor == "level" else point.setting.factor


def _label(point: Point) -> str:
    setting = point.setting
    if setting.factor == "level":
        return str(setting.samples) + f": {setting.level}, the default" * point.default
    return setting.name


def _heights(values: Sequence[float]) -> list[float]:
    """What is 0 stands a little below all else: a logarithm has no place for it."""
    least = min((value for value in values if value > 0), default=1e-6)
    return [value if value > 0 else least / 3 for value in values]


def _draw_points(axes: Any, measured: Accuracy, metric: str) -> list[Label]:
    """Points and lines; gives back what is to be written beside them, the most important first."""
    points = measured.points
    heights = _heights([getattr(point.error, metric) for point in points])
    times = [1000 * point.median for point in points]
    places = dict(zip(points, zip(times, heights, strict=True), strict=True))
    front = [points[place] for place in measured.front_by(metric)]
    axes.set_xscale("log")
    axes.set_yscale("log")
    steps = {"drawstyle": "steps-post", "color": "0.8", "linewidth": 4, "zorder": 0, "label": "Pareto front"}
    axes.plot(*zip(*(places[point] for point in front), strict=True), **steps)
    for level, style in _LINES.items():
        if by_samples := _by_samples(points, level):
            line = zip(*(places[point] for point in by_samples.values()), strict=True)
            axes.plot(*line, style, color="black", linewidth=0.8, zorder=1)
    for point in points:
        _draw_point(axes, point, places[point], point in front)
    if metric == "rmse" and measured.truth.noise > 0:
        _draw_noise(axes, measured.truth.noise)
    axes.set_xlabel("kernel time, ms (median and quartiles)")
    axes.set_ylabel(f"{_METRICS[metric]} against the truth")
    axes.margins(0.08)
    _set_ticks(axes.xaxis, number)
    _set_ticks(axes.yaxis, "{:g}".format)
    _finish(axes)
    axes.legend(handles=_keys(points, measured.truth.noise if metric == "rmse" else 0), **_BELOW, ncols=4)
    labels = [Label(*places[point], _label(point), "bold" if point.default else "normal") for point in points]
    return sorted(labels, key=lambda label: (label.weight != "bold", not label.text.isdigit()))


def _draw_point(axes: Any, point: Point, place: tuple[float, float], on_front: bool) -> None:
    low, high = (abs(1000 * end - place[0]) for end in point.quartiles)
    axes.errorbar(
        *place, xerr=[[low], [high]], fmt=_MARKERS[_kind(point)], markersize=6,
        markerfacecolor="black" if on_front else "white", markeredgecolor="black", markeredgewidth=0.9,
        ecolor="black", elinewidth=0.9, capsize=2.5, zorder=4,
    )  # fmt: skip
    if point.default:
        axes.plot(*place, "o", markersize=15, fillstyle="none", color="black", zorder=2)


def _keys(points: Sequence[Point], noise: float) -> list[Line2D]:
    """The legend's rows: only what is there."""
    style: dict[str, Any] = {"color": "black", "markerfacecolor": "white", "linewidth": 0.8, "markersize": 6}
    used = {_kind(point) for point in points}
    keys = [
        Line2D([], [], marker=_MARKERS[kind], linestyle=_LINES.get(kind, "none"), label=text, **style)
        for kind, text in _KEYS.items()
        if kind in used
    ]
    ring = {**style, "markersize": 12, "markerfacecolor": "none"}
    keys.append(Line2D([], [], marker="o", linestyle="none", label="default", **ring))
    filled = {**style, "markerfacecolor": "black"}
    keys.append(Line2D([], [], marker="o", linestyle="none", label="filled: on the Pareto front", **filled))
    if noise > 0:
        keys.append(Line2D([], [], **_NOISE, label="noise of the truth"))
    return keys


def _draw_noise(axes: Any, noise: float) -> None:
    axes.axhline(noise, **_NOISE, zorder=1)


def _set_ticks(axis: Any, write: Any) -> None:
    """Numbers at 1, 2 and 5 of each decade; the more decades, the fewer."""
    low, high = axis.get_view_interval()
    subs = (1, 2, 5) if high < 300 * low else (1, 3) if high < 30_000 * low else (1,)
    axis.set_major_locator(LogLocator(subs=subs, numticks=14))
    axis.set_major_formatter(FuncFormatter(lambda value, _place: write(value)))
    axis.set_minor_formatter(NullFormatter())


def _finish(axes: Any) -> None:
    axes.grid(color="0.93", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _marked(figure: Figure, axes: Any, labels: Sequence[Label]) -> list[tuple[float, float, float, float]]:
    """What labels must not cover: the points."""
    reach = 4.5 * figure.dpi / 72
    places = [axes.transData.transform((label.x, label.y)) for label in labels]
    return [(x - reach, y - reach, x + reach, y + reach) for x, y in places]


# ---- what errors consist of ----


def _draw_parts(axes: Any, measured: Accuracy, metric: str) -> None:
    levels = {level: _by_samples(measured.points, level) for level in _LINES}
    counts = sorted({count for points in levels.values() for count in points})
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    sampling = {count: next(p[count] for p in levels.values() if count in p).sampling for count in counts}
    _draw_curve(axes, sampling, metric, "D-", "too few samples")
    written: set[tuple[int, float]] = set()
    for level in ("standard", "draft"):
        precision = {count: point.precision for count, point in levels[level].items()}
        _draw_curve(axes, precision, metric, f"{_MARKERS[level]}-", f"{level}'s arithmetic")
        if metric == "rmse":
            _draw_flips(axes, precision, level, written)
    if metric == "rmse" and measured.truth.noise > 0:
        _draw_noise(axes, measured.truth.noise)
    axes.set_xticks(counts, [str(count) for count in counts])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("samples a pixel")
    axes.set_ylabel(_METRICS[metric])
    axes.set_title("parts of the error" + "; numbers: pixels off by > 1/255" * (metric == "rmse"), fontsize=9)
    axes.margins(0.1)
    _set_ticks(axes.yaxis, "{:g}".format)
    _finish(axes)
    if axes.lines:
        axes.legend(**_BELOW, ncols=2)


def _draw_flips(axes: Any, precision: Mapping[int, Difference], level: str, written: set[tuple[int, float]]) -> None:
    """What is left without the pixels that flipped, and their share, once where levels agree."""
    flipped = {count: part for count, part in precision.items() if part.flips}
    if flipped:
        _draw_curve(axes, precision, "values", f"{_MARKERS[level]}:", f"{level}'s without flips")
    for count, part in flipped.items():
        if (count, part.flips) not in written:
            axes.annotate(
                f"{100 * part.flips:.2g} %", (count, part.rmse), (0, 10 if level == "standard" else -10),
                textcoords="offset points", ha="center", va="center", fontsize=7,
            )  # fmt: skip
        written.add((count, part.flips))


def _by_samples(points: Sequence[Point], level: str) -> dict[int, Point]:
    found = {point.setting.samples: point for point in points if _kind(point) == level}
    return dict(sorted(found.items()))


def _draw_curve(axes: Any, parts: Mapping[int, Difference], metric: str, style: str, text: str) -> None:
    """What is not 0."""
    drawn = [(count, value) for count, part in parts.items() if (value := getattr(part, metric)) > 0]
    if drawn:
        axes.plot(
            [count for count, _ in drawn], [value for _, value in drawn], style, color="black", label=text,
            markersize=5, markerfacecolor="white", linewidth=0.9,
        )  # fmt: skip
