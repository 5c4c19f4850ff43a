"""The chart of specialisation: what a scene's own kernels take, as a share of what general ones take."""

from __future__ import annotations

import os
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from ._figure import Figure, number, save_figure
from ._library import BAD_INPUT, Error
from .specialisation import Specialisation, read

_PARTS = {"trace": ("trace time", "ms", 1000.0), "compile": ("first compilation", "s", 1.0)}


def specialisation(
    results: Sequence[Specialisation] | str | os.PathLike[str] | Mapping[str, Any],
    *,
    save: str | os.PathLike[str] | None = None,
) -> Figure:
    """Draws a bar for each scene: time of specialised kernels by that of general ones, for the trace and for compiling.

    Bars are medians of the ratios of pairs, the lines on them reach from the least to the greatest; beside them stand
    the medians of both times, general → specialised.

    Args:
        results: of `feeler.specialisation.measure`, or the JSON that `feeler chart --specialised` wrote.
        save: where to write the chart, as PNG and as SVG; the endings are added, or replace each other.

    Returns:
        The matplotlib figure.
    """
    measured = read(results) if isinstance(results, (str, os.PathLike, Mapping)) else list(results)
    if not measured:
        raise Error("there are no results to draw", code=BAD_INPUT)
    figure = Figure(figsize=(11, 1.8 + 0.5 * len(measured)), layout="constrained")
    for axes, part in zip(figure.subplots(1, 2, sharey=True), _PARTS, strict=True):
        _draw(axes, measured, part)
    width, height = measured[0].size
    figure.suptitle(f"a scene's own kernels against general ones, {width}×{height}, {measured[0].device}", fontsize=9)
    if save is not None:
        save_figure(figure, save)
    return figure


def _draw(axes: Any, measured: Sequence[Specialisation], part: str) -> None:
    title, unit, scale = _PARTS[part]
    most = max(1.0, *(max(one.ratios(part)) for one in measured))
    for place, one in enumerate(measured):
        ratios, (own, general) = one.ratios(part), one.medians(part)
        middle = statistics.median(ratios)
        axes.barh(place, middle, 0.6, color="0.85", edgecolor="black")
        axes.errorbar(
            middle,
            place,
            xerr=[[middle - min(ratios)], [max(ratios) - middle]],
            color="black",
            capsize=3,
            linewidth=1.1,
        )
        text = f" {middle:.2f}   {number(scale * general)} → {number(scale * own)} {unit}"
        axes.text(most * 1.03, place, text, va="center", fontsize=8)
    axes.axvline(1, color="black", linestyle="--", linewidth=0.8)
    axes.set_yticks(range(len(measured)), [one.scene for one in measured])
    axes.set_ylim(len(measured) - 0.4, -0.6)
    axes.set_xlim(0, most * 1.6)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1])
    axes.set_xlabel("specialised / general")
    axes.set_title(title, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
